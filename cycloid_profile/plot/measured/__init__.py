"""Figures of measured files and of their difference to the prediction."""

from cycloid_profile.plot.measured.compared_views import comparison as comparison
from cycloid_profile.plot.measured.inspection import inspection_chart as inspection_chart
from cycloid_profile.plot.measured.measured import angle_map as angle_map
from cycloid_profile.plot.measured.measured import hysteresis_loop as hysteresis_loop
from cycloid_profile.plot.measured.measured import measurement as measurement
from cycloid_profile.plot.measured.measured import measurement_residual as measurement_residual
from cycloid_profile.plot.measured.measured import transmission_error as transmission_error
from cycloid_profile.plot.measured.panels import cell_means as cell_means
from cycloid_profile.plot.measured.panels import cells_of_a_lobe as cells_of_a_lobe
from cycloid_profile.plot.measured.panels import deviation_scale as deviation_scale
from cycloid_profile.plot.measured.panels import draw_deviation_rings as draw_deviation_rings
from cycloid_profile.plot.measured.panels import draw_lobe_image as draw_lobe_image
from cycloid_profile.plot.measured.panels import draw_orders as draw_orders
from cycloid_profile.plot.measured.panels import draw_residual as draw_residual
from cycloid_profile.plot.measured.panels import no_points_marks as no_points_marks
from cycloid_profile.plot.measured.panels import noise_mark as noise_mark
from cycloid_profile.plot.measured.panels import order_namer as order_namer
from cycloid_profile.plot.measured.panels import turn_ticks as turn_ticks
from cycloid_profile.plot.measured.panels import widened as widened
