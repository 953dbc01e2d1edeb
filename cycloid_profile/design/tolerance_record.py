"""A whole tolerance study of a spec, from what scatters to which tolerance to tighten: plain calls of the steps."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from cycloid_profile.design.ground import built_reducer
from cycloid_profile.design.tolerance_ranking import TighteningAdvice, tightening_advice
from cycloid_profile.design.tolerancing import (
    backlash_study,
    beside,
    limits_in,
    loaded_study,
    tolerances_in,
    without_compensation,
)
from cycloid_profile.effects.built import Built
from cycloid_profile.errors import SpecError
from cycloid_profile.spec.model import Spec
from cycloid_profile.tolerance.allocated import Allocation
from cycloid_profile.tolerance.allocation import Effort, allocate
from cycloid_profile.tolerance.comparison import Comparison, compare_designs
from cycloid_profile.tolerance.limits import Limit
from cycloid_profile.tolerance.quantities import Measures
from cycloid_profile.tolerance.run import run
from cycloid_profile.tolerance.scatter import Tolerances
from cycloid_profile.tolerance.store import Store
from cycloid_profile.tolerance.study import Study
from cycloid_profile.tolerance.summary import StudySummary, summarise
from cycloid_profile.tolerance.workers import SideBySide, Workers

Tell = Callable[[str], None]
# Reducers that two designs are compared by: a ratio of deviations to a hundredth.
_COMPARED_BACKLASH, _COMPARED_LOADED = 16_384, 512
# Reducers to search the cheapest tolerances with and to confirm them with, where each has to be loaded.
_ALLOCATED_LOADED = (1024, 4096)


@dataclass(frozen=True)
class ToleranceRecord:
    """All that a study found.

    ``backlash`` of many reducers; ``loaded``, all quantities of fewer, None where none were asked for; ``drawn``, each
    quantity of the drawing; ``compared``, the same reducers ground without and with deformation compensation, empty
    without one; ``advice``, which tolerance to tighten; ``allocation``, the cheapest ones, None where not asked for.
    """

    spec: Spec
    built: Built
    tolerances: Tolerances
    limits: tuple[Limit, ...]
    backlash: StudySummary
    loaded: StudySummary | None
    drawn: Mapping[str, float]
    compared: tuple[Comparison, ...]
    advice: TighteningAdvice
    allocation: Allocation | None

    @property
    def summaries(self) -> tuple[StudySummary, ...]:
        """Both studies, where there are two."""
        return (self.backlash,) if self.loaded is None else (self.backlash, self.loaded)


def tolerance_record(
    spec: Spec, folder: Path, workers: Workers, allocated: bool = False, tell: Tell = lambda _: None
) -> ToleranceRecord:
    """Run the study of a spec; its samples are kept in ``folder``, and found again after a break.

    ``allocated``: find the cheapest tolerances that reach the yield asked for, too.

    Raises
    ------
    SpecError, GeometryError, LoadError
        If the drive or a tolerance cannot be.
    AllocationError
        If no tolerances within their bounds reach the yield.
    ToleranceError
        If the folder cannot be written to, or the workers cannot compute.
    """
    tell("building the reducer")
    built = built_reducer(spec)
    tolerances, limits = tolerances_in(spec, built), limits_in(spec)
    many = backlash_study(spec, built, tolerances)
    unloaded = run(many, folder / "backlash", workers, _titled(tell, "backlash"))
    loaded = None
    if spec.tolerance.loaded_samples:
        fewer = loaded_study(spec, built, tolerances)
        loaded = run(fewer, folder / "loaded", workers, _titled(tell, "under load"))
    study = unloaded.study if loaded is None else loaded.study
    nothing = np.zeros((1, len(study.changes)))
    drawn = dict(zip(study.measures.names, study.measures.of(nothing)[0].tolist(), strict=True))
    return ToleranceRecord(
        spec=spec,
        built=built,
        tolerances=tolerances,
        limits=limits,
        backlash=summarise(unloaded, limits),
        loaded=None if loaded is None else summarise(loaded, limits),
        drawn=drawn,
        compared=_compared(spec, unloaded, loaded, tell),
        advice=tightening_advice([store.study for store in (unloaded, loaded) if store is not None], limits, tell),
        allocation=_allocated(spec, many, limits, tell) if allocated else None,
    )


def _allocated(spec: Spec, study: Study, limits: tuple[Limit, ...], tell: Tell) -> Allocation:
    if not limits:
        raise SpecError("tolerance.limits", "none", "leave nothing to reach", "give at least one limit", " ")
    quantities = tuple(limit.quantity for limit in limits)
    measures = Measures(study.built, study.changes, quantities)
    # What all reducers share is made before the threads ask for it.
    assert measures.answers
    loaded = any("backlash" not in quantity for quantity in quantities)
    effort = Effort(*_ALLOCATED_LOADED) if loaded else Effort()
    return allocate(study.draws, SideBySide(measures), limits, spec.tolerance.yield_percent / 100.0, effort, tell)


def _compared(spec: Spec, backlash: Store, loaded: Store | None, tell: Tell) -> tuple[Comparison, ...]:
    plain = without_compensation(spec)
    if plain is None:
        return ()
    tell("the same reducers without deformation compensation")
    found: dict[str, Comparison] = {}
    for store, reducers in ((backlash, _COMPARED_BACKLASH), (loaded, _COMPARED_LOADED)):
        if store is not None:
            chunks = min(store.study.chunks, -(-reducers // store.study.chunk))
            other = beside(store.study, plain)
            values = np.concatenate([other.values(number) for number in range(chunks)])
            known = np.concatenate(list(islice(store.tables(), chunks)))
            for one in compare_designs(store.names, values, known):
                found.setdefault(one.quantity, one)
    # The least backlash is there to tell who binds; its width says nothing.
    return tuple(one for one in found.values() if one.quantity != "least_backlash_arcmin")


def _titled(tell: Tell, title: str) -> Tell:
    return lambda text: tell(f"{title}: {text}")
