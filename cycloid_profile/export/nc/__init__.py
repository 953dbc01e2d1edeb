"""NC programs: contour, polar grinding and wire cutting for four controls, read back by a parser."""

from cycloid_profile.export.nc.contour import GcodeExporter as GcodeExporter
from cycloid_profile.export.nc.contour import GcodePathExporter as GcodePathExporter
from cycloid_profile.export.nc.dialects import POSTS as POSTS
from cycloid_profile.export.nc.dialects import NcDialect as NcDialect
from cycloid_profile.export.nc.dialects import read_gcode as read_gcode
from cycloid_profile.export.nc.polar import AxisLimits as AxisLimits
from cycloid_profile.export.nc.polar import PolarExporter as PolarExporter
from cycloid_profile.export.nc.polar import PolarGrinding as PolarGrinding
from cycloid_profile.export.nc.polar import axis_limits as axis_limits
from cycloid_profile.export.nc.polar import feed_profile as feed_profile
from cycloid_profile.export.nc.polar import polar_grinding as polar_grinding
from cycloid_profile.export.nc.polar_motion import PolarPath as PolarPath
from cycloid_profile.export.nc.polar_motion import polar_path as polar_path
from cycloid_profile.export.nc.wheel import clearance as clearance
from cycloid_profile.export.nc.wheel import groove_stock as groove_stock
from cycloid_profile.export.nc.wheel import least_concave_radius as least_concave_radius
from cycloid_profile.export.nc.wheel import wheel_radius as wheel_radius
from cycloid_profile.export.nc.wire import WireExporter as WireExporter
