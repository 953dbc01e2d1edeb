"""Evidence of one set of effects on the exact model by sampling: over the whole prior, and about an optimum."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from dynesty import NestedSampler
from scipy.special import logsumexp, ndtri
from scipy.stats import multivariate_t, norm

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.optimum import Optimum

LIVE_POINTS = 100
_LOCAL_DRAWS = 400
# Log likelihood without equilibrium; it falls with the distance, because nested sampling must not meet a plateau.
_IMPOSSIBLE = -1e9


class Hypothesis:
    """A set of ``members`` on the exact model: likelihood and prior over its active coordinates."""

    def __init__(self, model: ExactModel, members: Sequence[Candidate]) -> None:
        self.model, self.members = model, tuple(members)
        self.used = np.array([2 * i + c for i, m in enumerate(self.members) for c in range(m.coordinates)])
        self.one_sided = np.array([m.one_sided for m in self.members for _ in range(m.coordinates)])

    def log_likelihood(self, x: FloatArray) -> float:
        """Log likelihood of coordinates in prior widths, against no effect."""
        u = np.zeros(2 * len(self.members))
        u[self.used] = x
        state = self.model.state(self.members, u)
        if state is None:
            return _IMPOSSIBLE * (1.0 + float(x @ x))
        return 0.5 * (self.model.baseline.chi2 - state.chi2)

    def from_unit_cube(self, v: FloatArray) -> FloatArray:
        """Coordinates from the prior: normal, or half-normal for one-sided effects."""
        found: FloatArray = ndtri(np.where(self.one_sided, 0.5 + 0.5 * v, v))
        return found

    def log_prior(self, x: FloatArray) -> float:
        """Log density of the same prior."""
        if np.any(self.one_sided & (x <= 0.0)):
            return -math.inf
        return float(np.sum(norm.logpdf(x)) + math.log(2.0) * np.count_nonzero(self.one_sided))


def nested(hypothesis: Hypothesis, live_points: int = LIVE_POINTS, seed: int = 0) -> tuple[float, float, int]:
    """Log evidence over the whole prior, its stated error, and the number of model calls."""
    sampler = NestedSampler(
        hypothesis.log_likelihood,
        hypothesis.from_unit_cube,
        hypothesis.used.size,
        nlive=live_points,
        bound="multi",
        sample="unif",
        # A model call is more expensive than new bounds: a quarter of the calls of the default settings, with the same
        # error.
        bootstrap=0,
        enlarge=1.5,
        update_interval=live_points // 2,
        first_update={"min_ncall": live_points, "min_eff": 40.0},
        rstate=np.random.default_rng(seed),
    )
    sampler.run_nested(dlogz=0.1, print_progress=False)
    found = sampler.results
    return float(found.logz[-1]), float(found.logzerr[-1]), int(np.sum(found.ncall))


def local(hypothesis: Hypothesis, optimum: Optimum, seed: int = 0, draws: int = _LOCAL_DRAWS) -> tuple[float, float]:
    """Log evidence about one optimum by importance sampling, and its standard error."""
    used = hypothesis.used
    shape = 1.5 * optimum.covariance[np.ix_(used, used)]
    about_it = multivariate_t(optimum.u[used], shape, df=4, seed=np.random.default_rng(seed))
    points = np.reshape(about_it.rvs(draws), (draws, used.size))
    weight = np.full(draws, -math.inf)
    for i, x in enumerate(points):
        prior = hypothesis.log_prior(x)
        if math.isfinite(prior):
            weight[i] = hypothesis.log_likelihood(x) + prior - float(about_it.logpdf(x))
    total = float(logsumexp(weight))
    share = np.exp(weight - total)
    return total - math.log(draws), math.sqrt(max(float(np.sum(share**2)) - 1.0 / draws, 0.0))
