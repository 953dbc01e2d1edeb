"""What changed between two measurements of one specimen."""

from cycloid_profile.diagnosis.change.amounts import AmountChange as AmountChange
from cycloid_profile.diagnosis.change.amounts import ParameterChange as ParameterChange
from cycloid_profile.diagnosis.change.comparison import Comparison as Comparison
from cycloid_profile.diagnosis.change.comparison import FilePair as FilePair
from cycloid_profile.diagnosis.change.comparison import compare_diagnoses as compare_diagnoses
from cycloid_profile.diagnosis.change.comparison import comparison_to_json as comparison_to_json
from cycloid_profile.diagnosis.change.loop_figures import FigureChange as FigureChange
