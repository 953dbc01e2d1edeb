"""Reports of a diagnosis and of a correction."""

from cycloid_profile.report.diagnosis.correction_package import correct_scans as correct_scans
from cycloid_profile.report.diagnosis.correction_package import write_correction as write_correction
from cycloid_profile.report.diagnosis.package import diagnosis_report as diagnosis_report
from cycloid_profile.report.diagnosis.package import save_plan_plot as save_plan_plot
from cycloid_profile.report.diagnosis.package import with_effects as with_effects
from cycloid_profile.report.diagnosis.package import write_diagnosis as write_diagnosis
from cycloid_profile.report.diagnosis.package import write_json as write_json
from cycloid_profile.report.diagnosis.tables import VERDICTS as VERDICTS
from cycloid_profile.report.diagnosis.tables import correction_sentences as correction_sentences
from cycloid_profile.report.diagnosis.tables import correction_tables as correction_tables
from cycloid_profile.report.diagnosis.tables import diagnosis_tables as diagnosis_tables
from cycloid_profile.report.diagnosis.tables import plan_tables as plan_tables
from cycloid_profile.report.diagnosis.text import describe_effect as describe_effect
from cycloid_profile.report.diagnosis.text import headline as headline
from cycloid_profile.report.diagnosis.text import odds as odds
from cycloid_profile.report.diagnosis.text import p_text as p_text
from cycloid_profile.report.diagnosis.text import remedy_of as remedy_of
from cycloid_profile.report.diagnosis.text import with_uncertainty as with_uncertainty
