"""Quantities of one reducer and their derivatives by its errors."""

from cycloid_profile.tolerance.model.quantities import QUANTITIES as QUANTITIES
from cycloid_profile.tolerance.model.quantities import Quantities as Quantities
from cycloid_profile.tolerance.model.quantities import QuantityModel as QuantityModel
from cycloid_profile.tolerance.model.quantities import unit_changes as unit_changes
from cycloid_profile.tolerance.model.working_point import RESPONSES as RESPONSES
from cycloid_profile.tolerance.model.working_point import PlacedEffect as PlacedEffect
from cycloid_profile.tolerance.model.working_point import WorkingPoint as WorkingPoint
