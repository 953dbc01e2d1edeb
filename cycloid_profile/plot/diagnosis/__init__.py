"""Figures of a diagnosis, of a measurement plan and of a correction."""

from cycloid_profile.plot.diagnosis.change_views import change_pictures as change_pictures
from cycloid_profile.plot.diagnosis.change_views import changes as changes
from cycloid_profile.plot.diagnosis.correction_views import correction as correction
from cycloid_profile.plot.diagnosis.overview import diagnosis_summary as diagnosis_summary
from cycloid_profile.plot.diagnosis.overview import file_residuals as file_residuals
from cycloid_profile.plot.diagnosis.overview import measurement_plan as measurement_plan
from cycloid_profile.plot.diagnosis.overview import pictures as pictures
