"""From the best set to the result: acceptance, alternatives, remainder, JSON."""

from cycloid_profile.diagnosis.verdict.json_output import detectable_text as detectable_text
from cycloid_profile.diagnosis.verdict.json_output import diagnosis_to_json as diagnosis_to_json
from cycloid_profile.diagnosis.verdict.json_output import effect_tables as effect_tables
from cycloid_profile.diagnosis.verdict.json_output import effect_to_json as effect_to_json
from cycloid_profile.diagnosis.verdict.json_output import empirical_tables as empirical_tables
from cycloid_profile.diagnosis.verdict.json_output import p_value_text as p_value_text
from cycloid_profile.diagnosis.verdict.json_output import rounded_number as rounded_number
from cycloid_profile.diagnosis.verdict.nearest_effects import NearestEffect as NearestEffect
from cycloid_profile.diagnosis.verdict.remainder import Remainder as Remainder
from cycloid_profile.diagnosis.verdict.remainder import ScanResidual as ScanResidual
from cycloid_profile.diagnosis.verdict.remainder import remainder_text as remainder_text
from cycloid_profile.diagnosis.verdict.remainder import smooth_remainder as smooth_remainder
from cycloid_profile.diagnosis.verdict.rest_curves import EmpiricalFit as EmpiricalFit
from cycloid_profile.diagnosis.verdict.result import Diagnosis as Diagnosis
from cycloid_profile.diagnosis.verdict.result import FileGap as FileGap
from cycloid_profile.diagnosis.verdict.result import NamedEffect as NamedEffect
from cycloid_profile.diagnosis.verdict.result import SizedEffect as SizedEffect
from cycloid_profile.diagnosis.verdict.workflow import diagnose as diagnose
