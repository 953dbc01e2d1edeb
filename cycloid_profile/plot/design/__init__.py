"""Figures of a design."""

from cycloid_profile.plot.design.loads import load_map as load_map
from cycloid_profile.plot.design.loads import load_sharing as load_sharing
from cycloid_profile.plot.design.loads import pressure_over_width as pressure_over_width
from cycloid_profile.plot.design.loads import rotation_by_part as rotation_by_part
from cycloid_profile.plot.design.loads import stage_load as stage_load
from cycloid_profile.plot.design.polar_path_views import polar_path as polar_path
from cycloid_profile.plot.design.program_view import nc_program as nc_program
from cycloid_profile.plot.design.solutions import accuracy as accuracy
from cycloid_profile.plot.design.solutions import convergence as convergence
from cycloid_profile.plot.design.teeth import deformation as deformation
from cycloid_profile.plot.design.teeth import disc as disc
from cycloid_profile.plot.design.teeth import profile_comparison as profile_comparison
from cycloid_profile.plot.design.teeth import tooth as tooth
