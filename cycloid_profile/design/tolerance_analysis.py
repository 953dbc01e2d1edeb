"""Tolerance analysis of a spec: distributions, yield, contributions of each tolerance and the cheapest tolerances."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from cycloid_profile._display import Described, figure_text, finite, frame
from cycloid_profile.design.from_spec import as_built_reducer, drive_of
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.errors import SpecError
from cycloid_profile.resources import Need
from cycloid_profile.spec import format_spec, parse_spec
from cycloid_profile.spec.model import Spec
from cycloid_profile.tolerance.allocation import Allocation, SampleSizes, allocate
from cycloid_profile.tolerance.inputs import Limit, Tolerances, limits_of, tolerances_of, typical_tolerances
from cycloid_profile.tolerance.model import QUANTITIES, QuantityModel, WorkingPoint
from cycloid_profile.tolerance.ranking import (
    Contributions,
    SobolShares,
    ToleranceSensitivity,
    contributions,
    scatter_sensitivities,
    sobol_shares,
)
from cycloid_profile.tolerance.study import (
    SEQUENCES,
    Comparison,
    Draws,
    ParallelQuantities,
    QuantitySummary,
    Store,
    Study,
    StudySummary,
    Workers,
    Yield,
    compare_designs,
    require_equilibria,
    run,
    summarise,
)
from cycloid_profile.units import sign_of

Progress = Callable[[str], None]
BACKLASH = "backlash_arcmin"
LEAST_BACKLASH = "least_backlash_arcmin"
PERCENTS = (50.0, 95.0, 99.0, 99.73)
# Reducers of one chunk, where each has to be loaded.
_LEAST_LOADED = 8  # reducers; a deviation and its jackknife error exist from three on
_CHUNK_LOADED = 256
# Reducers of a comparison of two designs: the ratio of standard deviations is accurate to 1 %.
_COMPARED_BACKLASH, _COMPARED_LOADED = 16_384, 512
# Reducers of the search for the cheapest tolerances and of its confirmation, where each has to be loaded.
_ALLOCATED_LOADED = (1024, 4096)
# Reducers of the contributions, for backlash and under load; each tolerance costs two more runs.
_RANKED = (4096, 512)
# s of one core for the backlash of one reducer and for its loads, a pin each; bytes of its row on disk and of its file.
_BACKLASH_TIME, _LOADED_TIME = 5e-6, 2.3e-4
_BACKLASH_BYTES, _LOADED_BYTES = 16.0, 48.0


@dataclass(frozen=True)
class Ranked:
    """The tolerances ranked by their contributions to the quantities of one study: ``found`` and ``shares``."""

    found: Contributions
    shares: SobolShares


@dataclass(frozen=True)
class TighteningAdvice:
    """``sensitivities`` of every quantity to every size; ``ranked``, first backlash and then all quantities loaded."""

    sensitivities: tuple[ToleranceSensitivity, ...]
    ranked: tuple[Ranked, ...]

    def of(self, quantity: str) -> Ranked:
        """The ranking for a quantity with the largest number of reducers."""
        return next(one for one in self.ranked if quantity in one.found.quantities)

    @property
    def quantities(self) -> tuple[str, ...]:
        """Quantities for which the tolerances are ranked, without repetition."""
        return tuple(name for name in QUANTITIES if any(name in one.found.quantities for one in self.ranked))

    @property
    def last(self) -> Contributions:
        """The contributions that cover the largest number of limits."""
        return self.ranked[-1].found


@dataclass(frozen=True, repr=False)
class ToleranceRecord(Described):
    """All results of a tolerance analysis.

    ``backlash`` of many reducers; ``loaded``, all quantities of fewer reducers, None if not requested; ``drawn``,
    each quantity with nominal parts; ``compared``, the same reducers without and with deformation compensation, empty
    without compensation; ``advice``, which tolerance to tighten; ``allocation``, the cheapest tolerances or None.
    """

    spec: Spec
    reducer: AsBuiltReducer
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
        """The studies of backlash and, if any, under load."""
        return (self.backlash,) if self.loaded is None else (self.backlash, self.loaded)

    @cached_property
    def quantities(self) -> tuple[QuantitySummary, ...]:
        """Each quantity once, from the study with the largest number of reducers."""
        found = {one.name: one for summary in reversed(self.summaries) for one in summary.quantities}
        return tuple(found[name] for name in QUANTITIES if name in found)

    @cached_property
    def yields(self) -> dict[str, Yield]:
        """Yield of each limited quantity, from the study with the largest number of reducers."""
        every = (one for summary in reversed(self.summaries) for one in summary.yields)
        return {one.limit.quantity: one for one in every if one.limit is not None}

    def columns(self) -> dict[str, list[Any]]:
        """One row for each quantity: mean, standard deviation, percentiles, limits and yield; None for no limit."""
        rows = []
        for one in self.quantities:
            limited = self.yields.get(one.name)
            limit, share = (None, None) if limited is None else (limited.limit, limited.share)
            rows.append(
                {
                    "quantity": one.name,
                    "reducers": one.spread.count,
                    "drawn": self.drawn[one.name],
                    "mean": one.mean.value,
                    "deviation": one.spread.deviation,
                    "least": one.spread.low,
                    **{f"p{p:g}".replace(".", "_"): one.percentiles[p].value for p in PERCENTS},
                    "greatest": one.spread.high,
                    "at_least": None if limit is None else finite(limit.at_least),
                    "at_most": None if limit is None else finite(limit.at_most),
                    "yield_percent": None if share is None else 100.0 * share.value,
                    "yield_low": None if share is None else 100.0 * share.low,
                    "yield_high": None if share is None else 100.0 * share.high,
                }
            )
        return {name: [row[name] for row in rows] for name in rows[0]}

    def to_frame(self) -> Any:
        """The table of ``columns``; needs pandas."""
        return frame(self.columns())

    def _key_figures(self) -> dict[str, str]:
        figures = {"name": self.spec.name, "tolerances": str(len(self.tolerances.scatters))}
        for one in self.quantities:
            unit, label = sign_of(one.name), one.name.rsplit("_", 1)[0].replace("_", " ")
            values = (
                f"mean {figure_text(one.mean.value, unit)}, 99.73 % {figure_text(one.percentiles[99.73].value, unit)}"
            )
            figures[label] = f"{values}, {one.spread.count:,} reducers"
            if one.name in self.yields:
                figures[f"{label}, yield"] = figure_text(100.0 * self.yields[one.name].share.value, "%")
        return figures | {"tolerance to tighten first": self.advice.last.ranked()[0].label}


def spec_tolerances(spec: Spec, reducer: AsBuiltReducer) -> Tolerances:
    """Tolerances of a spec; ordinary manufacturing tolerances where it has none.

    Raises ``SpecError`` for an impossible table.
    """
    if not spec.tolerance.effects and not spec.tolerance.correlations:
        return typical_tolerances(reducer)
    return tolerances_of(spec.tolerance.effects, spec.tolerance.correlations, reducer)


def spec_limits(spec: Spec) -> tuple[Limit, ...]:
    """Limits of a spec in the order of the quantities: a lower one of the least backlash, upper ones of all others."""
    given = msgspec.structs.asdict(spec.tolerance.limits)
    ends = {name: (given[name], None) if name == LEAST_BACKLASH else given[name] for name in QUANTITIES
            if given.get(name) is not None}  # fmt: skip
    return limits_of(ends, tuple(QUANTITIES)) if ends else ()


def with_tolerance_values(spec: Spec, changed: Mapping[str, object]) -> Spec:
    """The spec with some values of ``[tolerance]`` replaced; None keeps a value.

    Raises ``SpecError`` where a value exceeds its limits.
    """
    given = {key: value for key, value in changed.items() if value is not None}
    if not given:
        return spec
    grown = msgspec.structs.replace(spec, tolerance=msgspec.structs.replace(spec.tolerance, **given))
    return parse_spec(format_spec(grown))


def tolerance_record(
    spec: Spec, folder: Path, workers: Workers, allocated: bool = False, progress: Progress = lambda _: None
) -> ToleranceRecord:
    """Run the tolerance analysis of a spec; ``folder`` keeps its samples, and an interrupted run resumes from them.

    ``allocated``: find the cheapest tolerances that reach the required yield, too.

    Raises
    ------
    SpecError, GeometryError, LoadError
        If the drive or a tolerance is impossible.
    SolveError
        If more than 1 % of the reducers drawn have no equilibrium.
    AllocationError
        If no tolerances within their bounds reach the yield.
    ToleranceError
        If the folder cannot be written to, or the workers cannot compute.
    ResourceError
        If the samples need more time or disk than allowed.
    """
    if 0 < spec.tolerance.loaded_samples < _LEAST_LOADED:
        limit = f"reducers have no statistics, which need {_LEAST_LOADED}"
        raise SpecError("tolerance.loaded_samples", spec.tolerance.loaded_samples, limit, "give 0, or more of them")
    if allocated and not spec_limits(spec):
        raise SpecError("tolerance.limits", "none", "leave nothing to reach", "give at least one limit", " ")
    for need in study_needs(spec):
        need.require()
    progress("building the reducer")
    reducer = as_built_reducer(spec)
    tolerances, limits, t = spec_tolerances(spec, reducer), spec_limits(spec), spec.tolerance
    draws = Draws(tolerances, t.seed, SEQUENCES[t.sequence], t.batch_size)
    many = Study(reducer, draws, (BACKLASH,), t.samples)
    stores = [run(many, folder / "backlash", workers, lambda text: progress(f"backlash: {text}"))]
    summaries = [_summary(stores[0], limits)]
    if t.loaded_samples:
        fewer = Study(reducer, draws, tuple(QUANTITIES), t.loaded_samples, _CHUNK_LOADED)
        stores.append(run(fewer, folder / "loaded", workers, lambda text: progress(f"under load: {text}")))
        summaries.append(_summary(stores[1], limits))
    study = stores[-1].study
    nominal = study.quantity_model.of(np.zeros((1, len(study.changes))))[0]
    return ToleranceRecord(
        spec=spec,
        reducer=reducer,
        tolerances=tolerances,
        limits=limits,
        backlash=summaries[0],
        loaded=summaries[1] if len(summaries) > 1 else None,
        drawn=dict(zip(study.quantity_model.names, nominal.tolist(), strict=True)),
        compared=_compensation_comparison(spec, stores, progress),
        advice=tightening_advice([store.study for store in stores], limits, progress, (t.sobol_samples, t.sobol_width)),
        allocation=_allocated(spec, many, limits, progress) if allocated else None,
    )


def _summary(store: Store, limits: Sequence[Limit]) -> StudySummary:
    found = summarise(store, limits)
    require_equilibria(max(one.spread.lost for one in found.quantities), found.samples)
    return found


def study_needs(spec: Spec) -> tuple[Need, ...]:
    """What the reducers of a study need: for the backlash, under load, and for the Sobol indices."""
    t, pins = spec.tolerance, drive_of(spec).trochoid.pins
    fewer = "take fewer"
    sobol = t.sobol_samples * (len(t.effects) + 2) // 4
    return (
        Need("tolerance.samples", f"{t.samples:,}", fewer, disk=_BACKLASH_BYTES * t.samples,
             time=_BACKLASH_TIME * pins * t.samples),
        Need("tolerance.loaded_samples", f"{t.loaded_samples:,}", fewer, disk=_LOADED_BYTES * t.loaded_samples,
             time=_LOADED_TIME * pins * t.loaded_samples),
        Need("tolerance.sobol_samples", f"{t.sobol_samples:,}", fewer, time=_LOADED_TIME * pins * sobol),
    )  # fmt: skip


def tightening_advice(
    studies: Sequence[Study],
    limits: Sequence[Limit],
    progress: Progress = lambda _: None,
    sobol: tuple[int, float] = (512, 0.1),
) -> TighteningAdvice:
    """Rank the tolerances from studies of the same reducers: of backlash and, if any, under load.

    ``sobol``: cap on the samples of the Sobol indices, and the width of their intervals at which sampling ends.

    Raises ``SolveError`` if the nominal reducer, or too many of the reducers, have no equilibrium.
    """
    progress("derivatives of every quantity by every size")
    first = studies[0]
    point = WorkingPoint.of(first.reducer, first.tolerances)
    slopes = scatter_sensitivities(first.tolerances, point)
    ranked: list[Ranked] = []
    for study, reducers in zip(studies, _RANKED, strict=False):
        names = study.quantity_model.names
        progress(f"every tolerance halved: {', '.join(name.rsplit('_', 1)[0].replace('_', ' ') for name in names)}")
        known = [limit for limit in limits if limit.quantity in names]
        found = contributions(replace(study, samples=min(reducers, study.samples)), known)
        progress("shares in the variance")
        gradients = {name: point.gradients[name] for name in names}
        # A reducer under load takes ten times as long as one whose backlash alone is computed.
        cap = max(sobol[0] // (4 if ranked else 1), 2)
        cap = 1 << (cap.bit_length() - 1)
        shares = sobol_shares(study, cap, gradients, width=sobol[1])
        progress(f"shares in the variance: {shares.ending}")
        ranked.append(Ranked(found, shares))
    return TighteningAdvice(slopes, tuple(ranked))


def _allocated(spec: Spec, study: Study, limits: tuple[Limit, ...], progress: Progress) -> Allocation:
    quantities = tuple(limit.quantity for limit in limits)
    quantity_model = QuantityModel(study.reducer, study.changes, quantities)
    # Computed once here, before the threads share it.
    assert quantity_model.answers
    loaded = any("backlash" not in quantity for quantity in quantities)
    effort = SampleSizes(*_ALLOCATED_LOADED) if loaded else SampleSizes()
    return allocate(
        study.draws, ParallelQuantities(quantity_model), limits, spec.tolerance.yield_percent / 100.0, effort, progress
    )


def _compensation_comparison(spec: Spec, stores: Sequence[Store], progress: Progress) -> tuple[Comparison, ...]:
    """The same reducers, error by error, without and with deformation compensation."""
    if spec.modification.deformation_compensation in (False, 0.0):
        return ()
    progress("the same reducers without deformation compensation")
    modification = msgspec.structs.replace(spec.modification, deformation_compensation=False)
    plain = as_built_reducer(msgspec.structs.replace(spec, modification=modification))
    found: dict[str, Comparison] = {}
    for store, reducers in zip(stores, (_COMPARED_BACKLASH, _COMPARED_LOADED), strict=False):
        chunks = min(store.study.chunks, -(-reducers // store.study.chunk))
        other = replace(store.study, reducer=plain)
        values = np.concatenate([other.values(number) for number in range(chunks)])
        known = np.concatenate(list(islice(store.tables(), chunks)))
        for one in compare_designs(store.names, values, known):
            found.setdefault(one.quantity, one)
    # The least backlash shows which reducers bind; the width of its distribution is meaningless.
    return tuple(one for one in found.values() if one.quantity != LEAST_BACKLASH)
