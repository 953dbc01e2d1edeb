"""Names of the room of reports; each is imported when first used."""

from . import design as design
from . import diagnosis as diagnosis
from . import tolerance as tolerance
from .design import build_package as build_package
from .design import export_package as export_package
from .diagnosis import correct_scans as correct_scans
from .diagnosis import with_effects as with_effects
from .diagnosis import write_diagnosis as write_diagnosis
from .page import REPORT as REPORT
from .tolerance import write_tolerance as write_tolerance
