"""Sizes that measurements can detect and distinguish, before they are made."""

from cycloid_profile.diagnosis.planning.detectable import smallest_detectable as smallest_detectable
from cycloid_profile.diagnosis.planning.plan import Detectability as Detectability
from cycloid_profile.diagnosis.planning.plan import detectability as detectability
from cycloid_profile.diagnosis.planning.plan import separating_measurement as separating_measurement
