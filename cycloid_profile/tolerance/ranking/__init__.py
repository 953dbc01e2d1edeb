"""Ranking of tolerances: derivatives, contributions and Sobol indices."""

from cycloid_profile.tolerance.ranking.contribution import Contribution as Contribution
from cycloid_profile.tolerance.ranking.contribution import Contributions as Contributions
from cycloid_profile.tolerance.ranking.contribution import Estimate as Estimate
from cycloid_profile.tolerance.ranking.contribution import contributions as contributions
from cycloid_profile.tolerance.ranking.sensitivity import Derivative as Derivative
from cycloid_profile.tolerance.ranking.sensitivity import ParameterSensitivity as ParameterSensitivity
from cycloid_profile.tolerance.ranking.sensitivity import ToleranceSensitivity as ToleranceSensitivity
from cycloid_profile.tolerance.ranking.sensitivity import scatter_sensitivities as scatter_sensitivities
from cycloid_profile.tolerance.ranking.sensitivity import sensitivities as sensitivities
from cycloid_profile.tolerance.ranking.sobol import SobolShare as SobolShare
from cycloid_profile.tolerance.ranking.sobol import SobolShares as SobolShares
from cycloid_profile.tolerance.ranking.sobol import sobol_shares as sobol_shares
