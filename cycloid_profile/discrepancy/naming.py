"""Which effects explain the data best: evidence of all singles, pairs and leading triples, rescored on the exact model.

Linear evidence explains its own error with one effect more, so the search starts anew about each optimum of the exact
model until the best set stays the best.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.candidates import Candidate, chatter
from cycloid_profile.discrepancy.detection import chatter_peaks
from cycloid_profile.discrepancy.evidence import estimate, log_priors, search
from cycloid_profile.discrepancy.exact import ExactModel, Optimum, State
from cycloid_profile.discrepancy.laid import Laid
from cycloid_profile.discrepancy.normal import Normal, Whitened, coordinates, normal
from cycloid_profile.discrepancy.probes import Probes
from cycloid_profile.discrepancy.thinning import thinned
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.effect import Place

_ROUNDS = 5
# Sets that are rescored at most, on few rows and on all: a search that leaves something must come to an end.
_RESCORINGS = 40
_RESCORINGS_FULL = 8
_FINAL_ROUNDS = 2
_COARSE_ROWS = 120
_FEW_ROWS = 360
_MANY_ROWS = 10**9
# Gain in chi² above which the effects are so large that few rows name them.
_LARGE = 4000.0
_WEAK = 60.0  # below this gain everything is linear
_STARTS = 8
_LEADING = 3
_LINEAR = 0.995  # share of the gap that linear effects explain, above which none of second order is sought
_FINALISTS = 4
_LINEAR_ERROR = 0.01  # of the evidence
_FEW_VARIANTS = 12
_SWAPPED = 2  # rivals for each member
_MORE_THAN_NOISE = 3.0  # standard deviations of chi², that of the noise counted
_CLOSE = 8.0
LEAST_CONTRIBUTION = 1.0  # times the accuracy of the simulation
DISTINGUISHED = 4.5  # half chi²: three standard deviations between two explanations


@dataclass(frozen=True, eq=False)
class Named:
    """The best set with the equations linearised about it, told from zero, and all sets rescored, best first."""

    best: Optimum
    equations: Normal
    priors: FloatArray
    rescored: tuple[Optimum, ...]


class Search:
    """A search of the best set of effects for some recordings."""

    def __init__(
        self,
        built: Built,
        laid: Sequence[Laid],
        library: Sequence[Candidate],
        probes: Probes,
        tell: Callable[[str], None],
    ) -> None:
        self.tell = tell
        self._rescorings_left = _RESCORINGS
        self.recordings = tuple(one.recording for one in laid)
        self.model = ExactModel(built, self.recordings, probes, laid)
        self.built = built
        self._take([*library, *self._chatter(self.model.nothing, ())])

    def named(self) -> Named:
        """The best set."""
        equations = normal(self.model.nothing.blocks, self.library)
        first = search(equations, self.priors)
        starts = [(list(s.members), estimate(equations, s.members)[0]) for s in first[:1]]
        gain = 2.0 * first[0].log_evidence if first else 0.0
        best = self._empty(self.model)
        if gain > _WEAK:
            # Large effects are named on few rows, small ones beside them on all rows afterwards.
            few = _FEW_ROWS if gain > _LARGE else _MANY_ROWS
            coarse = ExactModel(self.built, [thinned(r, few) for r in self.recordings], self.model.probes)
            self._rescorings_left = _RESCORINGS
            climbed: dict[tuple[int, ...], Optimum] = {}
            # From single effects one after the other, and from the best linear set only if they leave something.
            for start in [*self._singles(equations, gain), *starts]:
                top = self._climbed(coarse, [start], _ROUNDS, climbed)[:1]
                if top and not _leaves_something(top[0]):
                    break
            best_first = sorted(climbed.values(), key=lambda o: -o.log_evidence)
            starts = [(self.places(o), o.u) for o in best_first[:1]]
        self.tell("rescoring on the exact model with all rows")
        self._rescorings_left = _RESCORINGS_FULL
        found = self._climbed(self.model, starts, _FINAL_ROUNDS)
        best = self._first_that_contributes(found, best)
        more = self._chatter(best.state, best.members)
        if more and best.members:
            # Waves that stood below what larger effects made of the spectrum.
            self._take([*self.library, *more])
            found = self._climbed(self.model, [(self.places(best), best.u)], _FINAL_ROUNDS)
            best = self._first_that_contributes(found, best)
        return Named(best, self._about(best), self.priors, tuple(found))

    def _starts(
        self, about: Normal, sets: Sequence[tuple[int, ...]], found: dict[tuple[int, ...], Optimum]
    ) -> list[tuple[list[int], FloatArray]]:
        """Where to begin with sets that were not rescored yet, all members contributing."""
        new = [members for members in sets if members and tuple(sorted(members)) not in found]
        starts = [(list(members), estimate(about, members)[0]) for members in new]
        return [start for start in starts if _all_contribute(about, *start)]

    def _unlike_names(self, sets: Sequence[tuple[int, ...]]) -> list[tuple[int, ...]]:
        """The first of the sets of each combination of names."""
        first: dict[tuple[str, ...], tuple[int, ...]] = {}
        for members in sets:
            first.setdefault(tuple(sorted(self.library[i].name for i in members)), members)
        return list(first.values())

    def _neighbours(self, about: Normal, places: list[int]) -> list[tuple[int, ...]]:
        """Sets with one member less, and with one member swapped for the candidates that fit best in its place."""
        sets = [tuple(p for p in places if p != place) for place in places]
        for place in places:
            # The same effect on another crank or disc looks much alike to first order.
            same = [i for i, c in enumerate(self.library) if c.name == self.library[place].name and i != place]
            if len(same) < _FEW_VARIANTS:
                sets += [(*(p for p in places if p != place), i) for i in same if about.R[2 * i, 2 * i] > 1e-2]
        for place in places:
            others = [p for p in places if p != place]
            scores = []
            for i in range(len(self.library)):
                taken = {self.library[p].name for p in others}
                if i not in places and self.library[i].name not in taken and about.R[2 * i, 2 * i] > 1e-2:
                    scores.append((linear_evidence(about, self.priors, [*others, i]), i))
            sets += [(*others, i) for _, i in sorted(scores, reverse=True)[:_SWAPPED]]
        return sets

    def _take(self, library: Sequence[Candidate]) -> None:
        self.library = tuple(library)
        rows = max((r.rows.size for r in self.recordings if r.kind == "profile_scan"), default=2)
        self.priors = log_priors(self.library, frequencies=rows)
        self._prior_of = dict(zip((id(c) for c in self.library), self.priors, strict=True))

    def _chatter(self, state: State, members: Sequence[Candidate]) -> list[Candidate]:
        """Chatter that stands out of the spectrum of any scan once ``members`` are fitted."""
        found = []
        known = [c.choice["waves_per_turn"] for c in members if c.name == "grinding_chatter"]
        for block in state.blocks:
            if block.laid.recording.kind == "profile_scan":
                z = block.projected(block.z)
                if members:
                    G = block.projected(block.columns(members))
                    z = z - G @ np.linalg.lstsq(G, z, rcond=None)[0]
                waves = chatter_peaks(block, z)
                disc = block.laid.recording.disc + 1
                found += [chatter(n, disc) for n in waves if all(abs(n - other) > 1.0 for other in known)]
        return found

    def _climbed(
        self,
        model: ExactModel,
        starts: Sequence[tuple[list[int], FloatArray]],
        rounds: int,
        found: dict[tuple[int, ...], Optimum] | None = None,
    ) -> list[Optimum]:
        """Sets rescored, best first, the search begun anew about each best set; those of ``found`` are not repeated."""
        found = {} if found is None else found
        best = self._rescored(model, starts, found, self._empty(model))
        for number in range(rounds):
            self.tell(f"search about the best set so far, round {number + 1}")
            about = self._about(best)
            proposals = search(about, self.priors, keep=self.places(best))
            if not proposals:
                break
            # What linear evidence may be wrong by grows with it.
            short = _leaves_something(best)
            reach = max(_CLOSE, _LINEAR_ERROR * proposals[0].log_evidence) if short else _CLOSE
            close = [s.members for s in proposals[:400] if s.log_evidence > proposals[0].log_evidence - reach]
            starts = self._starts(about, self._unlike_names(close), found)[:_FINALISTS]
            challenger = self._rescored(model, starts, found, best)
            if short and not challenger.log_evidence > best.log_evidence + 0.05:
                starts = self._starts(about, self._neighbours(about, self.places(best)), found)
                challenger = self._rescored(model, starts, found, best)
            if not challenger.log_evidence > best.log_evidence + 0.05:
                break
            best = challenger
        return sorted(found.values(), key=lambda o: -o.log_evidence)

    def places(self, optimum: Optimum) -> list[int]:
        """Numbers of its members in the library."""
        return [next(i for i, c in enumerate(self.library) if c is member) for member in optimum.members]

    def start(self, named: Named, members: Sequence[Candidate]) -> FloatArray:
        """Where to begin with another set, from the equations about the best."""
        places = [next(i for i, c in enumerate(self.library) if c is member) for member in members]
        return estimate(named.equations, places)[0]

    def prior(self, members: Sequence[Candidate]) -> float:
        """Sum of the log priors."""
        return float(sum(self._prior_of[id(member)] for member in members))

    def _first_that_contributes(self, found: Sequence[Optimum], otherwise: Optimum) -> Optimum:
        return next((o for o in found if o.log_evidence > 0.0 and self._contributing(o)), otherwise)

    def _contributing(self, optimum: Optimum) -> bool:
        members = [self.library[i] for i in self.places(optimum)]
        equations = normal(optimum.state.blocks, members)
        return _all_contribute(equations, list(range(len(members))), optimum.u)

    def _empty(self, model: ExactModel) -> Optimum:
        none = np.zeros(0)
        return Optimum((), none, np.zeros((0, 0)), np.zeros((0, 0)), model.nothing, 0.0, True)

    def _about(self, optimum: Optimum) -> Normal:
        return normal(optimum.state.blocks, self.library).about(self.places(optimum), optimum.u)

    def _rescored(
        self,
        model: ExactModel,
        starts: Sequence[tuple[list[int], FloatArray]],
        found: dict[tuple[int, ...], Optimum],
        best: Optimum,
    ) -> Optimum:
        for members, u in starts:
            key = tuple(sorted(members))
            if key in found:
                continue
            if self._rescorings_left <= 0:
                break
            self._rescorings_left -= 1
            beat = best.state.chi2 + float(best.u @ best.u) if best.members else np.inf
            optimum = model.optimum([self.library[i] for i in members], u, self.prior, beat=beat)
            if optimum is None or optimum.implausible:
                continue
            found[key] = optimum
            if optimum.log_evidence > best.log_evidence:
                best = optimum
        return best

    def _singles(self, equations: Normal, gain: float) -> list[tuple[list[int], FloatArray]]:
        """Starts from single effects of the leading names, on few rows of the exact model."""
        coarse = ExactModel(self.built, [thinned(r, _COARSE_ROWS) for r in self.recordings], self.model.probes)
        singles: dict[str, tuple[list[int], FloatArray]] = {}
        for scored in search(equations, self.priors, 1):
            name = self.library[scored.members[0]].name
            if name not in singles and scored.log_evidence > 0.0:
                singles[name] = (list(scored.members), estimate(equations, scored.members)[0])
        starts = list(singles.values())[:_STARTS]
        if gain < _LINEAR * (equations.chi2 - equations.rows):
            starts += self._second_order(coarse, gain)
        optima: list[tuple[float, list[int], FloatArray]] = []
        # A look at all, then the leading ones to the end.
        for steps, some in ((2, len(starts)), (4, _LEADING)):
            self.tell(f"single effects on the exact model, {some} of {len(starts)}")
            optima = []
            for members, u in starts[:some]:
                optimum = coarse.optimum([self.library[i] for i in members], u, self.prior, steps=steps)
                if optimum is not None and not optimum.implausible:
                    optima.append((optimum.log_evidence, members, optimum.u))
            optima.sort(key=lambda o: -o[0])
            starts = [(members, u) for _, members, u in optima]
        return [(members, u) for value, members, u in optima[:2] if value > 0.0]

    def _second_order(self, coarse: ExactModel, gain: float) -> list[tuple[list[int], FloatArray]]:
        """Starts for what all discs or pins share: it cancels to first order, the rest turns with twice its angle."""
        if not any(r.kind in {"transmission_error", "lost_motion_map"} for r in self.recordings):
            return []
        found = []
        nothing = coarse.nothing
        for i, candidate in enumerate(self.library):
            alike = candidate.kind.place is Place.RING or candidate.choice.get("disc", 0) is None
            if candidate.angle is None or not alike or candidate.kind.place is Place.SENSOR:
                continue
            shown = []
            for angle in np.deg2rad([0.0, 90.0, 45.0, 135.0]):
                state = coarse.state([candidate], 0.5 * np.array([np.cos(angle), np.sin(angle)]))
                if state is None:
                    break
                shown.append(
                    np.concatenate([a.residual - b.residual for a, b in zip(nothing.laid, state.laid, strict=True)])
                )
            if len(shown) < 4:
                continue
            even, first, second = 0.25 * sum(shown), 0.5 * (shown[0] - shown[1]), 0.5 * (shown[2] - shown[3])
            drop, y = _fall(nothing.blocks, np.stack([first, second, even], axis=1))
            full = sum(block.z.size for block in coarse.nothing.blocks)
            share = full / max(sum(int(np.count_nonzero(~r.held_out)) for r in self.recordings), 1)
            if drop < 0.2 * gain * share:
                continue
            size = 0.5 * min(max(float(np.hypot(y[0], y[1])), 0.05) ** 0.7, 4.0)
            angle = 0.5 * float(np.arctan2(y[1], y[0]))
            found.append((drop, [i], size * np.array([np.cos(angle), np.sin(angle)])))
        found.sort(key=lambda f: -f[0])
        return [(members, u) for _, members, u in found[:3]]


def _leaves_something(optimum: Optimum) -> bool:
    """Whether chi² says that more than noise is left."""
    rows = sum(block.z.size for block in optimum.state.blocks)
    return optimum.state.chi2 - rows > _MORE_THAN_NOISE * float(np.sqrt(8.0 * rows))


def _all_contribute(equations: Normal, members: list[int], u: FloatArray) -> bool:
    """Whether every member explains more than the simulation may err by."""
    return all(equations.contribution(members, u, i) >= LEAST_CONTRIBUTION for i in range(len(members)))


def _fall(blocks: Sequence[Whitened], columns: FloatArray) -> tuple[float, FloatArray]:
    """Fall of chi² by free amounts of ``columns`` over all rows of all recordings, and the amounts."""
    b, R, at = np.zeros(columns.shape[1]), np.zeros((columns.shape[1],) * 2), 0
    for block in blocks:
        rows = block.laid.residual.size
        G = block.white(np.nan_to_num(columns[at : at + rows]))
        at += rows
        b += block.product(G, block.z)
        R += block.product(G, G)
    amounts = np.asarray(np.linalg.lstsq(R, b, rcond=1e-9)[0], dtype=np.float64)
    return float(amounts @ b), amounts


def swaps(named: Named, search_: Search, member: int) -> list[tuple[int, float]]:
    """Candidates that could stand in place of a member of the best set, with what they fit worse (half chi²).

    Linear about the best set; those of the same name, implausible ones, and ones that fit worse by more than
    ``DISTINGUISHED`` are left out.
    """
    places = search_.places(named.best)
    mine = places[member]
    others = [p for p in places if p != mine]
    base = _fit(named.equations, places)
    found = []
    for i, candidate in enumerate(search_.library):
        if i in places or candidate.name == search_.library[mine].name:
            continue
        members = [*others, i]
        less = base - _fit(named.equations, members)
        if less < DISTINGUISHED:
            u, _ = estimate(named.equations, members)
            own = u[-2:]
            if float(np.hypot(*own)) * candidate.width <= candidate.implausible and not (
                candidate.one_sided and own[0] <= 0.0
            ):
                found.append((i, less))
    return sorted(found, key=lambda f: f[1])


def _fit(equations: Normal, members: Sequence[int]) -> float:
    """Half the fall of chi² by a set, its priors counted."""
    where = coordinates(members)
    u, _ = estimate(equations, members)
    return float(0.5 * u @ equations.b[where]) if len(members) else 0.0


def linear_evidence(equations: Normal, priors: FloatArray, members: Sequence[int]) -> float:
    """Evidence of a set from linearised equations."""
    if not members:
        return 0.0
    where = coordinates(members)
    u, _ = estimate(equations, members)
    B = np.eye(where.size) + equations.R[np.ix_(where, where)]
    return float(0.5 * u @ equations.b[where] - 0.5 * np.linalg.slogdet(B)[1] + priors[list(members)].sum())
