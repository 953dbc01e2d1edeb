"""Splines, arcs and chords of certified deviation from the exact tooth curve."""

from cycloid_profile.export.curves.audit import Deviation as Deviation
from cycloid_profile.export.curves.audit import deviation as deviation
from cycloid_profile.export.curves.audit import deviation_both_ways as deviation_both_ways
from cycloid_profile.export.curves.audit import distances as distances
from cycloid_profile.export.curves.biarc import Arcs as Arcs
from cycloid_profile.export.curves.biarc import disc_arcs as disc_arcs
from cycloid_profile.export.curves.biarc import lobe_arcs as lobe_arcs
from cycloid_profile.export.curves.chain import chain_of as chain_of
from cycloid_profile.export.curves.chain import distance_to_chain as distance_to_chain
from cycloid_profile.export.curves.chain import intersection as intersection
from cycloid_profile.export.curves.chain import nearest_length as nearest_length
from cycloid_profile.export.curves.chain import offset_left as offset_left
from cycloid_profile.export.curves.chain import stretch as stretch
from cycloid_profile.export.curves.curve_pieces import Piece as Piece
from cycloid_profile.export.curves.curve_pieces import ProfileSource as ProfileSource
from cycloid_profile.export.curves.curve_pieces import SpecifiedProfile as SpecifiedProfile
from cycloid_profile.export.curves.curve_pieces import chord_points as chord_points
from cycloid_profile.export.curves.curve_pieces import flanks as flanks
from cycloid_profile.export.curves.curve_pieces import pieces as pieces
from cycloid_profile.export.curves.curve_pieces import tolerance_error as tolerance_error
from cycloid_profile.export.curves.spline import FIT_SHARE as FIT_SHARE
from cycloid_profile.export.curves.spline import SplinePiece as SplinePiece
from cycloid_profile.export.curves.spline import disc_splines as disc_splines
from cycloid_profile.export.curves.spline import fitted_splines as fitted_splines
from cycloid_profile.export.curves.spline import joined as joined
from cycloid_profile.export.curves.spline import lobe_splines as lobe_splines
