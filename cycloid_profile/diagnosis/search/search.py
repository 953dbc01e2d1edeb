"""Search for the set of effects that explains the files: proposals about an optimum, exact fits, a beam of best sets.

Curves are searched on a subsample of rows first, then on all rows from the leading sets.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence, Set
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.model.candidate import Candidate, Variety
from cycloid_profile.diagnosis.model.evidence import Library, estimate, linear_evidence
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.optimum import Attempt, Optimum
from cycloid_profile.diagnosis.model.whitened import NormalEquations
from cycloid_profile.diagnosis.search._determined import determined, misfit_jumps
from cycloid_profile.diagnosis.search._fits import Fit, Fits, Key
from cycloid_profile.diagnosis.search._proposals import Proposal, equations_about, linear_proposals, shapes_between
from cycloid_profile.diagnosis.search._second_order import second_order
from cycloid_profile.diagnosis.search._starts import moved_nearby, of_finite_size, with_another_effect
from cycloid_profile.diagnosis.search._subsampling import screening_subsample, smallest_subsample
from cycloid_profile.diagnosis.search._waves import alternative_waves, refitted, waves_left
from cycloid_profile.diagnosis.search.lobe_index import offsets_about
from cycloid_profile.diagnosis.search.seam import SPLIT, offsets_by_seams
from cycloid_profile.diagnosis.search.symmetric_parts import on_other_parts
from cycloid_profile.measurement import HYSTERESIS

_SCREENING_STEPS = 2  # on fewer rows; most fits have ended or are abandoned by then, the others go on with all rows


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Best set, the equations linearised about it and referred to zero, and all fitted sets by decreasing evidence.

    ``model`` has the lobe index of the best set. ``limited``: the search stopped at its limit, not at its end.
    """

    best: Optimum
    model: ExactModel
    library: Library
    equations: NormalEquations
    fitted: tuple[Optimum, ...]
    limited: bool

    def evidence(self, members: Sequence[Candidate]) -> float:
        """Log evidence of a set: from the exact model where it was fitted, else linear about the best set."""
        if not members:
            return 0.0
        for optimum in self.fitted:
            if set(optimum.members) == set(members):
                return optimum.log_evidence
        best, other = (
            linear_evidence(self.equations, self.library.priors, self.library.places(some))
            for some in (self.best.members, members)
        )
        return self.best.log_evidence - best + other

    def start(self, members: Sequence[Candidate]) -> FloatArray:
        """Start of another set, from the equations about the best."""
        return estimate(self.equations, self.library.places(members))[0]


def search_effects(
    model: ExactModel,
    candidates: Sequence[Candidate],
    gain: float,
    progress: Callable[[str], None],
    starts: Sequence[tuple[Sequence[Candidate], FloatArray]] = (),
) -> SearchResult:
    """Best set of ``candidates`` and of the chatter that the files show; ``gain`` of chi² by the best single effect.

    ``starts``: sets to begin with, besides no effect, with their coordinates.
    """
    frequencies = max((r.rows.size for r in model.recordings if r.kind is not HYSTERESIS), default=2)
    library = Library(tuple(candidates), frequencies)
    few = smallest_subsample(model, gain)
    stage = _Stage(few, library, progress, tuned.BEAM, tuned.LINEAR_ERROR, tuned.FITS)
    stage.fit(Proposal(tuple(members), u, stage.fits.best.offsets) for members, u in starts)
    stage.explore(tuned.EXPANSIONS)
    if few is not model:
        progress(f"fitting {len(stage.leading)} sets of effects to all rows")
        whole = _Stage(
            model,
            stage.library,
            progress,
            tuned.BEAM_ON_ALL_ROWS,
            tuned.LINEAR_ERROR_ON_ALL_ROWS,
            tuned.FITS_ON_ALL_ROWS,
            screening_subsample(model, few),
        )
        whole.fit(Proposal(one.optimum.members, one.optimum.u, one.offsets) for one in stage.leading)
        whole.explore(tuned.EXPANSIONS_ON_ALL_ROWS)
        stage = whole
    progress("fitting the best sets of effects closely")
    stage.fits.fit_best_closely(stage.library)
    best, ranked = stage.fits.simplest(stage.library, progress)
    found = stage.fits.model(best.offsets)
    waves = [] if model.is_comparison else alternative_waves(found, best.optimum)
    library = stage.library.with_more(waves)
    fitted = tuple(one.optimum for one in ranked if one.offsets == best.offsets)
    return SearchResult(
        best.optimum, found, library, equations_about(found, library, best.optimum), fitted, stage.limited
    )


class _Stage:
    """Search on one selection of rows.

    ``beam``: number of leading sets whose neighbours are fitted, after those of half as many single effects. ``error``:
    share by which linear evidence may err. ``patience``: exact fits without a clearly better set, after which it
    ends. ``screening``: the same on fewer rows, where sets are fitted first. ``limited``: neighbours of a leading set
    were left out.
    """

    def __init__(
        self,
        model: ExactModel,
        library: Library,
        progress: Callable[[str], None],
        beam: int,
        error: float,
        patience: int,
        screening: ExactModel | None = None,
    ) -> None:
        self.library, self.progress, self.limited = library, progress, False
        self._beam, self._error = beam, 0.0 if model.only_scans else error
        self._patience = self._left = patience
        self._reached = 0.0
        self.fits = Fits(model)
        self._first = model
        self._screening_models = None if screening is None else Fits(screening)
        self._to_beat: tuple[Fit, float] | None = None
        self._tried: set[tuple[Key, bytes]] = set()

    @property
    def leading(self) -> list[Fit]:
        """The beam: the best sets that are not far below the best."""
        return self._best_of(self.fits.ranked, self._beam)

    def _open(self, done: Set[Key]) -> list[Fit]:
        """Sets whose neighbours are fitted next, but for ``done`` ones: friction, the best single effects of some
        varieties, then the beam.

        The best first effect of two is often not the best alone. Friction that loops show is there, even if others
        explain more alone: these have the sizes of a loop without friction.
        """
        most, friction = self._beam // 2, self._shown_friction
        keys = done - {one.key for one in friction}
        expanded = {member.variety for members, _ in keys if len(members) == 1 for member in members}
        alone = [one for one in self.fits.ranked if len(one.optimum.members) == 1]
        best: dict[Variety, Fit] = {}
        for one in self._best_of(alone, len(alone)):
            best.setdefault(one.optimum.members[0].variety, one)
        fresh = [one for variety, one in list(best.items())[:most] if variety not in expanded and one.key not in done]
        first = fresh[: max(most - len(expanded), 0)]
        return [one for one in [*friction, *first, *self.leading] if one.key not in done]

    @property
    def _shown_friction(self) -> list[Fit]:
        """The best set of friction alone, if loops show some."""
        if not misfit_jumps(self._first) or not any(one.shown_friction_nm for one in self._first.recordings):
            return []
        alone = [one for one in self.fits.ranked if {c.is_friction_torque for c in one.optimum.members} == {True}]
        return alone[:1]

    def _best_of(self, ranked: Sequence[Fit], most: int) -> list[Fit]:
        """At most ``most`` sets of different kinds, not far below the first, each clearly better than its subsets."""
        chosen: list[Fit] = []
        least = self._least_next_to(ranked[0]) if ranked else 0.0
        for one in ranked:
            # The same effects elsewhere, and more effects that gain nothing, would fill the beam with one idea.
            known = any(one.kind == other.kind for other in chosen)
            if len(chosen) < most and not known and one.evidence > least and self._gains(one):
                chosen.append(one)
        return chosen

    def _gains(self, one: Fit) -> bool:
        """Whether a set is the best, or clearly better than each of its subsets."""
        return one is self.fits.best or not any(one.adds_nothing_to(other) for other in self.fits)

    @property
    def _least(self) -> float:
        """Evidence below which a set is not pursued: linear equations of scans are exact, those of curves are not."""
        return self._least_next_to(self.fits.best)

    def _least_next_to(self, other: Fit) -> float:
        """Evidence below which a set is clearly worse than another."""
        return other.evidence - max(tuned.OPEN, self._error * other.evidence)

    def explore(self, most: int) -> None:
        """Fit the neighbours of the leading sets, until all of them are done, ``most`` were, or no fit is left."""
        done: set[Key] = set()
        while fresh := self._open(done):
            if len(done) >= most or self._left <= 0:
                self.limited = self.limited or any(one.key not in done for one in self.leading)
                break
            done.add(fresh[0].key)
            names = " + ".join(sorted(member.title for member in fresh[0].optimum.members)) or "no effect"
            self.progress(f"trying changes of {names} ({len(done)} of at most {most})")
            self.fit(self._neighbours(fresh[0]))

    def fit(self, proposals: Iterable[Proposal]) -> None:
        """Fit proposals that were not tried, and keep the plausible ones.

        They are drawn one by one, so that later ones can follow from fits of the first. Of a set with members that are
        not determined, the other members are fitted last.
        """
        waiting: list[Proposal] = []
        for one in chain(proposals, waiting):
            key = frozenset(one.members), one.offsets
            start = np.sign(np.round(one.start, 1)).tobytes()
            if (key, start) in self._tried or len(key[0]) < len(one.members) or one.promised < self._least:
                continue
            changes = sum(member.is_change for member in one.members)
            if max(changes, len(one.members) - changes) > tuned.MOST_EFFECTS:
                continue
            if self._left <= 0:
                self.limited = True
                break
            self._left -= 1
            self._tried.add((key, start))
            # Where few pins bear, linear equations promise too little to abandon the first effect of a set.
            finished = self._first.only_loops and len(one.members) == 1
            beat = math.inf if finished else self.fits.best.optimum.misfit
            begin = self._screened(one)
            if begin is None:
                continue
            attempt = Attempt(one.members, begin, beat=beat, least_gain=tuned.LEAST_GAIN)
            model = self.fits.model(one.offsets)
            optimum = model.optimum(attempt, self.library.prior(one.members))
            if optimum is None or optimum.implausible:
                continue
            rest, u = optimum.part(determined(model, optimum))
            if len(rest) == len(one.members):
                self.fits.keep(Fit(optimum, one.offsets))
                if self.fits.best.evidence > self._reached + tuned.DISTINGUISHED:
                    self._reached, self._left = self.fits.best.evidence, self._patience
            elif rest and (frozenset(rest), one.offsets) not in self.fits:
                waiting.append(Proposal(rest, u, one.offsets))

    def _screened(self, one: Proposal) -> FloatArray | None:
        """Where the fit of a proposal begins: where one to fewer rows ended; None if it is clearly worse there."""
        if self._screening_models is None:
            return one.start
        best = self.fits.best
        if self._to_beat is None or self._to_beat[0] is not best:
            there = self._screening_models.model(best.offsets).state(best.optimum.members, best.optimum.u)
            self._to_beat = best, math.inf if there is None else there.misfit_with_prior
        attempt = Attempt(one.members, one.start, _SCREENING_STEPS, self._to_beat[1], least_gain=tuned.LEAST_GAIN)
        found = self._screening_models.model(one.offsets).optimum(attempt, self.library.prior(one.members))
        if found is None or (found.ended and attempt.cannot_beat(found.misfit)):
            return None
        return found.u

    def _neighbours(self, fit: Fit) -> Iterable[Proposal]:
        """Sets to fit about an optimum."""
        model, optimum = self.fits.model(fit.offsets), fit.optimum
        if model.is_comparison:
            # Lobe index, shapes and numbers of waves are those of the diagnoses.
            return self._linear_and_finite(model, fit)
        waved = refitted(model, optimum)
        reshaped = [near for member in optimum.members for near in member.near_shapes(1.0)]
        self.library = self.library.with_more([*waves_left(model, optimum), *waved, *reshaped])
        found = self._linear_and_finite(model, fit)
        if not optimum.members:
            return chain(found, self._pairs(model, found)) if model.only_loops else found
        if set(waved) != set(optimum.members):
            found.append(Proposal(waved, optimum.u, fit.offsets))
        found += [Proposal(one.members, one.u, fit.offsets) for _, one in optimum.rotated_by_180()]
        if not model.only_scans:
            moved = on_other_parts(self.library, optimum, model.reducer)
            found += [Proposal(self.library.members(i), u, fit.offsets) for i, u in moved]
            found += self._of_opposite_sign(model, fit)
        return [*found, *self._reindexed(model, fit)]

    def _pairs(self, model: ExactModel, starts: Sequence[Proposal]) -> Iterator[Proposal]:
        """Single effects with one more, both where they start and where they were fitted.

        None if the best set so far leaves so little that no further effect can be clearly better.
        """
        best, least = self.fits.best.optimum, self._least
        if self._left <= 0 or best.chi2 - best.rows < 2.0 * tuned.OPEN:
            return
        fitted = [Proposal(one.optimum.members, one.optimum.u, one.offsets) for one in self.fits]
        single = [one for one in (*starts, *fitted) if len(one.members) == 1 and one.promised >= least]
        distinct = {(one.members, np.round(one.start, 2).tobytes()): one for one in single}
        yield from with_another_effect(model, self.library, distinct.values(), least)

    def _of_opposite_sign(self, model: ExactModel, fit: Fit) -> list[Proposal]:
        """The set with one size of opposite sign, where it explains nearly as much: cranks mirror each other."""
        found = []
        for _, other in fit.optimum.of_opposite_sign():
            state = model.state(other.members, other.u)
            if state is not None and 0.5 * (model.baseline.misfit - state.misfit) > self._least:
                found.append(Proposal(other.members, other.u, fit.offsets))
        return found

    def _linear_and_finite(self, model: ExactModel, fit: Fit) -> list[Proposal]:
        """Sets that linear equations propose about an optimum, and those that only responses of finite size show."""
        library = self.library
        jumps = misfit_jumps(model)
        equations = equations_about(model, library, fit.optimum, rest=jumps)
        found = linear_proposals(equations, library, fit.optimum, fit.offsets, keep=jumps)
        if not model.is_comparison:
            found += shapes_between(equations, library, fit.optimum, fit.offsets)
            found.sort(key=lambda one: -one.promised)
            self.library = library.with_more([member for one in found for member in one.members])
        if model.only_scans:
            return found
        finite = (
            moved_nearby(model, library, fit.optimum, fit.offsets)
            if fit.optimum.members
            else of_finite_size(model, library, equations, fit.offsets)
        )
        return [*finite, *second_order(model, library, equations, fit.optimum, fit.offsets), *found]

    def _reindexed(self, model: ExactModel, fit: Fit) -> list[Proposal]:
        """The set, and the set rotated by 180°, with the lobe index that suits it best."""
        found = []
        for one in (fit.optimum, *(other for _, other in fit.optimum.rotated_by_180())):
            if model.state(one.members, one.u) is None:
                continue
            for more in (offsets_about(model, self.library, one), offsets_by_seams(model, one)):
                if any(more):
                    found += self._with_offsets(model, fit.offsets, more, one)
        return found

    def _with_offsets(
        self, model: ExactModel, offsets: tuple[int, ...], more: tuple[int, ...], optimum: Optimum
    ) -> list[Proposal]:
        """The set with the lobe index raised by ``more``, and with its numbers of waves read there again."""
        lobes = model.reducer.case.drive.trochoid.lobes
        raised = tuple((a + b) % lobes for a, b in zip(offsets, more, strict=True))
        members = optimum.members
        if model.only_scans:
            # Scans alone keep their effects: the numbers of lobes change with the index.
            members = tuple(replace(one, choice=one.reindexed(-max(more), lobes)[0]) for one in members)
        waved = refitted(self.fits.model(raised), replace(optimum, members=members), SPLIT)
        self.library = self.library.with_more([*members, *waved])
        return [Proposal(members, optimum.u, raised), Proposal(waved, optimum.u, raised)]
