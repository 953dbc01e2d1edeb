"""Search from the effects that scans show, with every lobe index and every disc that the bench files permit.

A scan identifies its effects best, but neither the lobe index nor the state of the other discs. The bench files decide
both, with the exact effect: on the bench, effects common to all discs cancel to first order.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.evidence import Scored, best_extension_or_self, estimate, rank_sets
from cycloid_profile.diagnosis.model.exact_model import ExactModel, State
from cycloid_profile.diagnosis.model.library import Library
from cycloid_profile.diagnosis.model.lobe_index import has_free_index, reindexed_by, reindexed_equations, rotation
from cycloid_profile.diagnosis.model.normal_equations import NormalEquations, normal_equations
from cycloid_profile.diagnosis.model.optimum import Attempt, Optimum
from cycloid_profile.diagnosis.search.chatter_candidates import significant_chatter
from cycloid_profile.diagnosis.search.local_search import LocalSearch
from cycloid_profile.diagnosis.search.seam import indexed_from_seams
from cycloid_profile.diagnosis.search.subsampling import smallest_subsample
from cycloid_profile.measurement import PROFILE_SCAN

# A scan is nearly linear in its effects: few exact fits and rounds suffice.
_RESCORINGS, _ROUNDS = 12, 3
# Hypotheses rated with the exact effect, fitted to all files, and the steps of such a fit.
_MAX_CANDIDATES, _FITTED, _STEPS = 8, 4, 4
_LEAST_EVIDENCE = 5.0  # odds of 150 to 1 against no effect, as for an accepted set


@dataclass(frozen=True, eq=False)
class _Hypothesis:
    """Effects of the scans, ``members`` at ``u``, with the lobe index raised by ``lobes``."""

    lobes: int
    members: tuple[Candidate, ...]
    u: FloatArray


@dataclass(frozen=True, eq=False)
class _ScoredHypothesis:
    """A hypothesis with its best extension by at most one effect, and the equations of all files."""

    hypothesis: _Hypothesis
    best: Scored
    equations: NormalEquations

    @property
    def value(self) -> float:
        """Log likelihood of all files, up to a constant."""
        return self.best.log_evidence - 0.5 * self.equations.chi2


class _BenchFiles:
    """The bench files on the ``subsampled`` model, combined with the effects ``shown`` by the scans alone."""

    def __init__(self, subsampled: ExactModel, scans: ExactModel, library: Library, shown: Optimum) -> None:
        self._few, self._library = subsampled, library
        self._lobes = subsampled.reducer.case.drive.trochoid.lobes
        blocks = subsampled.baseline.blocks
        self._columns = [block.columns(library.candidates) for block in blocks]
        self._flat = normal_equations(blocks, library.candidates)
        of_scans = normal_equations(scans.at(shown).blocks, library.candidates)
        self._of_scans = of_scans.about(library.places(shown.members), shown.u)

    def approximate(self, one: _Hypothesis) -> _ScoredHypothesis | None:
        """Rating from the exact effect, with the linear response about no effect."""
        state = self._few.state(one.members, one.u)
        return None if state is None else self._rated(one, self._with_slopes_of_nothing(state))

    def exact(self, one: _Hypothesis) -> _ScoredHypothesis | None:
        """Rating from the exact effect and the linear response about it."""
        state = self._few.state(one.members, one.u)
        return None if state is None else self._rated(one, normal_equations(state.blocks, self._library.candidates))

    def _rated(self, one: _Hypothesis, curves: NormalEquations) -> _ScoredHypothesis:
        places = self._library.places(one.members)
        both = curves.about(places, one.u).plus(reindexed_equations(self._of_scans, one.lobes, self._lobes))
        return _ScoredHypothesis(one, best_extension_or_self(both, self._library.priors, places), both)

    def _with_slopes_of_nothing(self, state: State) -> NormalEquations:
        b, chi2 = np.zeros_like(self._flat.b), 0.0
        for G, block, one in zip(self._columns, self._few.baseline.blocks, state.residuals, strict=True):
            z = block.white(np.nan_to_num(one.residual))
            b += block.product(G, z)
            chi2 += float(block.product(z, z))
        return replace(self._flat, b=b, chi2=chi2)


def indexed_from_scans(model: ExactModel, candidates: Sequence[Candidate]) -> ExactModel:
    """The model with the lobe index fixed by the seam of the chatter found in its scans alone, without bench files."""
    if not any(has_free_index(model.reducer, recording) for recording in model.recordings):
        return model
    scans = model.scans_alone()
    waves = significant_chatter(scans)
    if not waves:
        return model
    shown = _fitted_to_scans(scans, Library((*candidates, *waves), max(r.rows.size for r in scans.recordings)))
    return indexed_from_seams(model, shown)


def search_led_by_scans(
    model: ExactModel, library: Library, gain: float, progress: Callable[[str], None]
) -> tuple[ExactModel, Optimum | None]:
    """Best set that starts from the effects of the scans, with at most one more, and the model with its lobe index.

    None if scans or bench files show nothing. The set is fitted on a subsample of rows, large enough to detect the
    ``gain`` in chi². The lobe index is decided on a subsample that preserves the smaller gain of the bench files.
    """
    scans, others = model.scans_alone(), model.without_scans()
    if not scans.recordings or not others.recordings:
        return model, None
    progress("lobe index and disc of the effects in the scans")
    shown = _fitted_to_scans(scans, library)
    if shown.log_evidence < _LEAST_EVIDENCE:
        return model, None
    bench = _BenchFiles(smallest_subsample(others, _gain(others, library)), scans, library, shown)
    rough = [bench.approximate(one) for one in _hypotheses(model, library, shown)]
    rated = [bench.exact(one.hypothesis) for one in _best(rough)[:_MAX_CANDIDATES]]
    found, best = model, None
    for one in _best(rated)[:_FITTED]:
        reindexed = reindexed_by(model, one.hypothesis.lobes)
        members = library.members(one.best.members)
        attempt = Attempt(members, estimate(one.equations, one.best.members)[0], _STEPS)
        optimum = smallest_subsample(reindexed, gain).optimum(attempt, library.prior(members))
        if optimum is not None and (best is None or optimum.log_evidence > best.log_evidence):
            found, best = reindexed, optimum
    return found, best


def _gain(model: ExactModel, library: Library) -> float:
    """Gain in chi² of the best set of linear equations about no effect."""
    found = rank_sets(normal_equations(model.baseline.blocks, library.candidates), library.priors)
    return 2.0 * max((one.log_evidence for one in found[:1]), default=0.0)


def _best(rated: list[_ScoredHypothesis | None]) -> list[_ScoredHypothesis]:
    return sorted((one for one in rated if one is not None), key=lambda one: -one.value)


def _fitted_to_scans(scans: ExactModel, library: Library) -> Optimum:
    """Optimum of the scans alone."""
    equations = normal_equations(scans.baseline.blocks, library.candidates)
    starts = [(list(s.members), estimate(equations, s.members)[0]) for s in rank_sets(equations, library.priors)[:1]]
    return LocalSearch(scans, library, _RESCORINGS, lambda _: None).run(starts, _ROUNDS)


def _hypotheses(model: ExactModel, library: Library, shown: Optimum) -> Iterator[_Hypothesis]:
    """The set on each disc and on all discs, with each lobe index that makes a difference."""
    lobes = model.reducer.case.drive.trochoid.lobes
    open_ = all(has_free_index(model.reducer, r) for r in model.recordings if r.kind is PROFILE_SCAN)
    offsets = range(lobes) if open_ and any(_depends_on_index(member, lobes) for member in shown.members) else range(1)
    for count in offsets:
        u, choices = shown.u.copy(), []
        for i, member in enumerate(shown.members):
            # Raising the index by ``count`` lowers the number of each lobe in the effect.
            choice, turn = member.reindexed(-count, lobes)
            u[2 * i : 2 * i + 2] = rotation(turn) @ u[2 * i : 2 * i + 2]
            choices.append(_on_any_disc(model, library, replace(member, choice=choice)))
        for members in product(*choices):
            yield _Hypothesis(count, members, u)


def _depends_on_index(member: Candidate, lobes: int) -> bool:
    choice, turn = member.reindexed(1, lobes)
    return choice != member.choice or turn != 0.0


def _on_any_disc(model: ExactModel, library: Library, member: Candidate) -> list[Candidate]:
    """Candidates that differ in the disc only and act on the same scanned discs."""
    scanned = {r.disc for r in model.recordings if r.kind is PROFILE_SCAN}
    discs = [None, *range(1, model.reducer.discs + 1)] if "disc" in member.choice else [None]
    own = dict(member.choice)
    known = [library.where(member.name, own | {"disc": disc} if "disc" in own else own) for disc in discs]
    shows = [model.flank_grid.touches(member, j) for j in scanned]
    return [c for c in known if c is not None and [model.flank_grid.touches(c, j) for j in scanned] == shows]
