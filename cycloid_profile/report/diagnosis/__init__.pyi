"""Names of the room; each is imported when first used."""

from .correction_package import correct_scans as correct_scans
from .correction_package import corrected_disc as corrected_disc
from .correction_package import write_correction as write_correction
from .package import diagnosis_report as diagnosis_report
from .package import save_plan_plot as save_plan_plot
from .package import spec_with_effects as spec_with_effects
from .package import write_diagnosis as write_diagnosis
from .package import write_json as write_json
from .tables import VERDICTS as VERDICTS
from .tables import change_tables as change_tables
from .tables import correction_sentences as correction_sentences
from .tables import correction_tables as correction_tables
from .tables import diagnosis_tables as diagnosis_tables
from .tables import plan_tables as plan_tables
from .text import describe_effect as describe_effect
from .text import headline as headline
from .text import odds as odds
from .text import p_text as p_text
from .text import remedy_of as remedy_of
from .text import with_uncertainty as with_uncertainty
