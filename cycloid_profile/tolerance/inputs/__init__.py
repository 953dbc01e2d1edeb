"""Inputs of a study: distributions, correlations, costs and limits."""

from cycloid_profile.tolerance.inputs.distribution import Distribution as Distribution
from cycloid_profile.tolerance.inputs.distribution import Normal as Normal
from cycloid_profile.tolerance.inputs.distribution import Rayleigh as Rayleigh
from cycloid_profile.tolerance.inputs.distribution import Triangular as Triangular
from cycloid_profile.tolerance.inputs.distribution import Uniform as Uniform
from cycloid_profile.tolerance.inputs.limits import NO_SOLUTION_MARGIN as NO_SOLUTION_MARGIN
from cycloid_profile.tolerance.inputs.limits import Ends as Ends
from cycloid_profile.tolerance.inputs.limits import Limit as Limit
from cycloid_profile.tolerance.inputs.limits import WorstMargin as WorstMargin
from cycloid_profile.tolerance.inputs.limits import limits_of as limits_of
from cycloid_profile.tolerance.inputs.limits import within as within
from cycloid_profile.tolerance.inputs.scatter import PARTS as PARTS
from cycloid_profile.tolerance.inputs.scatter import Correlation as Correlation
from cycloid_profile.tolerance.inputs.scatter import Cost as Cost
from cycloid_profile.tolerance.inputs.scatter import Scatter as Scatter
from cycloid_profile.tolerance.inputs.scatter import Tolerances as Tolerances
from cycloid_profile.tolerance.inputs.tables import tolerances_of as tolerances_of
from cycloid_profile.tolerance.inputs.tables import typical_tolerances as typical_tolerances
