"""Names of the room of reports; each is imported when first used."""

from . import design as design
from . import diagnosis as diagnosis
from . import tolerance as tolerance
from .design import build_package as build_package
from .design import export_package as export_package
from .diagnosis import correct_scans as correct_scans
from .diagnosis import spec_with_effects as spec_with_effects
from .diagnosis import write_diagnosis as write_diagnosis
from .inspection import inspection_table as inspection_table
from .inspection import inspection_to_json as inspection_to_json
from .inspection import write_inspection as write_inspection
from .measured import ComparedFile as ComparedFile
from .measured import comparison_table as comparison_table
from .measured import comparison_to_json as comparison_to_json
from .measured import figure_tables as figure_tables
from .measured import key_figure_table as key_figure_table
from .measured import write_comparison as write_comparison
from .measured import write_measurement as write_measurement
from .page import REPORT as REPORT
from .tolerance import write_tolerance as write_tolerance
