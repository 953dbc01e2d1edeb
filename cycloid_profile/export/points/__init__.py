"""Points of the tooth: grinding and CAD profile, and nominal points of measuring machines as CSV and VDA-FS."""

from cycloid_profile.export.points.layouts import chosen_points as chosen_points
from cycloid_profile.export.points.nominal_points import CmmExporter as CmmExporter
from cycloid_profile.export.points.nominal_points import VdaExporter as VdaExporter
from cycloid_profile.export.points.nominal_points import measuring_points as measuring_points
from cycloid_profile.export.points.nominal_points import read_sequences as read_sequences
from cycloid_profile.export.points.profile_file import ProfileCsvExporter as ProfileCsvExporter
from cycloid_profile.export.points.tables import POINT_RESOLUTION as POINT_RESOLUTION
from cycloid_profile.export.points.tables import Column as Column
from cycloid_profile.export.points.tables import read_table as read_table
from cycloid_profile.export.points.tables import write_table as write_table
from cycloid_profile.export.points.wheel_section import FormWheel as FormWheel
from cycloid_profile.export.points.wheel_section import form_wheel as form_wheel
