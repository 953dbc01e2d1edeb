"""Which tolerance to tighten: derivatives, contributions with each tolerance halved, and shares in the variance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from cycloid_profile.tolerance.contributions import Contributions, contributions
from cycloid_profile.tolerance.limits import Limit
from cycloid_profile.tolerance.quantities import QUANTITIES
from cycloid_profile.tolerance.sensitivity import PartsSensitivity, scatter_sensitivities
from cycloid_profile.tolerance.sobol import SobolShares, sobol_shares
from cycloid_profile.tolerance.study import Study
from cycloid_profile.tolerance.working_point import WorkingPoint

# Reducers for each; a tolerance costs two more runs of the first and one more of the second.
_BACKLASH, _LOADED = (8192, 1024), (512, 128)


@dataclass(frozen=True)
class Ranked:
    """The tolerances by what they contribute to the quantities of one study: ``found`` and ``shares``."""

    found: Contributions
    shares: SobolShares


@dataclass(frozen=True)
class TighteningAdvice:
    """``sensitivities`` of every quantity by every size; ``ranked``, backlash first and then all under load."""

    sensitivities: tuple[PartsSensitivity, ...]
    ranked: tuple[Ranked, ...]

    def of(self, quantity: str) -> Ranked:
        """The ranking that knows a quantity, with most reducers."""
        return next(one for one in self.ranked if quantity in one.found.quantities)

    @property
    def quantities(self) -> tuple[str, ...]:
        """All quantities that are ranked, each once."""
        return tuple(name for name in QUANTITIES if any(name in one.found.quantities for one in self.ranked))

    @property
    def last(self) -> Contributions:
        """The contributions that know most limits."""
        return self.ranked[-1].found


def tightening_advice(
    studies: Sequence[Study], limits: Sequence[Limit], tell: Callable[[str], None] = lambda _: None
) -> TighteningAdvice:
    """Advice from some studies of the same reducers: backlash, and under load.

    Raises ``SolveError`` if the drawing, or too many of the reducers, have no answer.
    """
    tell("derivatives of every quantity by every size")
    first = studies[0]
    point = WorkingPoint.of(first.built, first.tolerances)
    slopes = scatter_sensitivities(first.tolerances, point)
    ranked = []
    for study, (reducers, samples) in zip(studies, (_BACKLASH, _LOADED), strict=False):
        names = study.measures.names
        tell(f"every tolerance halved: {', '.join(name.rsplit('_', 1)[0].replace('_', ' ') for name in names)}")
        known = [limit for limit in limits if limit.quantity in names]
        found = contributions(replace(study, samples=min(reducers, study.samples)), known)
        tell("shares in the variance")
        gradients = {name: point.gradients[name] for name in names}
        ranked.append(Ranked(found, sobol_shares(study, samples, gradients)))
    return TighteningAdvice(slopes, tuple(ranked))
