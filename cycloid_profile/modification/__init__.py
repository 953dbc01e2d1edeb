"""Changes of the grinding set-up and measured deviations; positive removes material."""

from cycloid_profile.modification.deviation import MeasuredDeviation as MeasuredDeviation
from cycloid_profile.modification.deviation import NormalDeviation as NormalDeviation
from cycloid_profile.modification.setup import DeformationCompensation as DeformationCompensation
from cycloid_profile.modification.setup import Equidistant as Equidistant
from cycloid_profile.modification.setup import FlankRemoval as FlankRemoval
from cycloid_profile.modification.setup import FlankRotation as FlankRotation
from cycloid_profile.modification.setup import FlankStock as FlankStock
from cycloid_profile.modification.setup import Modification as Modification
from cycloid_profile.modification.setup import RadialMoving as RadialMoving
from cycloid_profile.modification.setup import RootAndTipRelief as RootAndTipRelief
from cycloid_profile.modification.setup import conjugate_pair as conjugate_pair
from cycloid_profile.modification.setup import modify as modify
from cycloid_profile.modification.setup import pair_ratios as pair_ratios
from cycloid_profile.modification.setup import rotation_to_backlash as rotation_to_backlash
from cycloid_profile.modification.setup import zero_backlash_pair as zero_backlash_pair
