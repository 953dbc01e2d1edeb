"""Search for the effects that two measurements share and for those that changed between them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis.change._joint_model import Hypothesis, JointFit, JointModel, Sizes, summed
from cycloid_profile.diagnosis.model import evidence
from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.evidence import Library

_SINGLES, _PAIRS, _SWAPS = 3, 2, 2  # kinds of additions and exchanges fitted about an optimum
_PAIRED = 12  # single additions from which pairs are made
_GAIN = 0.5  # of log evidence: smaller ones end the search
_ROUNDS = 12
_HOPELESS = 50.0  # of log evidence: starts this much worse than what is known are not explored
_FARTHEST_START = 1.5  # prior widths
_FITS = 40  # at most from each start: two loops take half a minute
_OPEN = 8.0  # of log evidence: smaller hypotheses that lose more in linear equations are not fitted

_MACHINED = 2.0  # log odds against a change that takes machining
# Effects that run-in, wear, preload, lubrication and temperature change.
IN_SERVICE = frozenset({
    "crank_bearing_clearance", "flank_wear", "thermal_growth", "coulomb_friction", "load_proportional_friction",
    "series_compliance", "nonlinear_series_compliance", "viscoelastic_creep", "crank_bearing_compliance",
    "pin_support_compliance",
})  # fmt: skip

Move = tuple[Hypothesis, FloatArray]


@dataclass(frozen=True)
class _Term:
    """One term of a hypothesis: an effect at both times, or its change."""

    candidate: Candidate
    is_change: bool

    @property
    def kind(self) -> tuple[str, bool]:
        return self.candidate.name, self.is_change


class _Linear:
    """Equations of all amounts and all changes, linear about a fit and referred to zero, for given sizes of errors."""

    def __init__(self, search: JointSearch, fit: JointFit, equations: tuple[float, FloatArray, FloatArray]) -> None:
        _, b, self.R = equations
        self.search = search
        self.b = b + self.R[:, self._where(fit.state.hypothesis)] @ fit.state.theta

    def best(self, base: Hypothesis, added: int, most: int) -> list[Move]:
        """Best extensions of ``base`` by a number of ``added`` terms, of different kinds."""
        terms = self._terms(base)
        scored = self._scored(base, [(one,) for one in terms])
        if added > 1:
            first = [one for _, (one,), _ in sorted(scored, key=lambda s: -s[0])[:_PAIRED]]
            scored = self._scored(base, [pair for pair in combinations(first, 2) if pair[0].kind[0] != pair[1].kind[0]])
        found: dict[tuple[tuple[str, bool], ...], Move] = {}
        for gain, some, theta in sorted(scored, key=lambda s: -s[0]):
            kind = tuple(sorted(one.kind for one in some))
            if len(found) == most or gain < -_GAIN:
                break
            if kind not in found:
                found[kind] = _extended(base, some), theta
        return list(found.values())

    def others(self, base: Hypothesis, most: int) -> list[Move]:
        """Best extensions of ``base`` by an effect that both times have, and that changed."""
        pairs = [(one, replace(one, is_change=True)) for one in self._terms(base) if not one.is_change]
        scored = self._scored(base, [pair for pair in pairs if pair[0].candidate not in base.changed])
        found: dict[str, Move] = {}
        for _, some, theta in sorted(scored, key=lambda s: -s[0]):
            name = some[0].candidate.name
            if len(found) < most and name not in found:
                found[name] = _extended(base, some), theta
        return list(found.values())

    def start(self, hypothesis: Hypothesis) -> FloatArray:
        """Coordinates of a hypothesis."""
        where = self._where(hypothesis)
        return np.asarray(np.linalg.solve(np.eye(where.size) + self.R[np.ix_(where, where)], self.b[where]))

    def covariance(self, hypothesis: Hypothesis) -> FloatArray:
        """Covariance of these coordinates."""
        where = self._where(hypothesis)
        return np.asarray(np.linalg.inv(np.eye(where.size) + self.R[np.ix_(where, where)]))

    def _terms(self, base: Hypothesis) -> list[_Term]:
        """Terms that a hypothesis can get: no effect twice, except single teeth, and no two places of one."""
        names = {one.name for one in base.common | base.changed} - {"single_tooth_error"}
        library = self.search.library.candidates
        free = [one for one in library if one.name not in names]
        found = [_Term(one, change) for one in free for change in (False, True)]
        found += [_Term(one, True) for one in base.before if one not in base.changed]
        return found + [_Term(one, False) for one in base.changes if one not in base.common]

    def _scored(
        self, base: Hypothesis, additions: Sequence[tuple[_Term, ...]]
    ) -> list[tuple[float, tuple[_Term, ...], FloatArray]]:
        """Gain of log evidence by each addition to ``base``, with the coordinates; implausible ones are omitted."""
        alone = self._value(base)[0]
        found = []
        for some in additions:
            hypothesis = _extended(base, some)
            value, theta = self._value(hypothesis)
            if is_plausible(hypothesis, theta):
                found.append((value - alone, some, theta))
        return found

    def value(self, hypothesis: Hypothesis) -> float:
        """Log evidence of a hypothesis, up to a constant."""
        return self._value(hypothesis)[0]

    def _value(self, hypothesis: Hypothesis) -> tuple[float, FloatArray]:
        where = self._where(hypothesis)
        B = np.eye(where.size) + self.R[np.ix_(where, where)]
        theta = np.linalg.solve(B, self.b[where])
        value = 0.5 * float(theta @ self.b[where]) - 0.5 * float(np.linalg.slogdet(B)[1])
        return value + self.search.prior(hypothesis), theta

    def _where(self, hypothesis: Hypothesis) -> np.ndarray:
        n = len(self.search.library.candidates)
        places = [*self.search.library.places(hypothesis.before)]
        places += [n + i for i in self.search.library.places(hypothesis.changes)]
        return np.array([2 * i + c for i in places for c in range(2)], dtype=np.intp)


class JointSearch:
    """All fits of hypotheses on one joint model, with ``smooth`` errors or without; ``limited``: some were left out."""

    def __init__(
        self, model: JointModel, library: Library, progress: Callable[[str], None], smooth: bool = True
    ) -> None:
        self.model, self.library, self.progress, self._smooth = model, library, progress, smooth
        self.fits: dict[Hypothesis, JointFit] = {}
        self.limited, self._left = False, _FITS
        self._tried: set[Hypothesis] = set()

    @property
    def best(self) -> JointFit:
        """Fit with the largest evidence."""
        return max(self.fits.values(), key=lambda one: one.log_evidence)

    def fit(self, moves: Iterable[Move], sizes: tuple[Sizes, ...] | None = None, beat: float = math.inf) -> None:
        """Fit hypotheses that were not tried, and keep the plausible ones."""
        for hypothesis, start in moves:
            if hypothesis in self._tried:
                continue
            if self._left <= 0:
                self.limited = True
                break
            self._left -= 1
            self._tried.add(hypothesis)
            # Linear equations are invalid further away, and a stage with such parts may have no equilibrium.
            if math.isfinite(beat):
                start = np.clip(start, -_FARTHEST_START, _FARTHEST_START)
            found = self.model.fit(hypothesis, start, self.prior(hypothesis), sizes, beat, self._smooth)
            if found is not None and is_plausible(hypothesis, found.state.theta):
                self.fits[hypothesis] = found

    def search(self, starts: Iterable[Sequence[Move]]) -> None:
        """Explore from the best hypothesis of each group of ``starts``."""
        for some in starts:
            self._left = _FITS
            self.fit(some)
            known = [self.fits[hypothesis] for hypothesis, _ in some if hypothesis in self.fits]
            first = max(known, key=lambda one: one.log_evidence, default=None)
            if first is not None and first.log_evidence > self.best.log_evidence - _HOPELESS:
                self._explore(first)

    def _explore(self, best: JointFit) -> None:
        """Fit the neighbours of a hypothesis until none is better: larger ones first, then all others."""
        for number in range(_ROUNDS):
            names = ", ".join(one.name for one in best.state.hypothesis.changes) or "nothing"
            self.progress(f"comparing both times: {names} changed (round {number + 1})")
            linear, without = self.linear(best)
            steps = (_larger(best, without), _larger(best, linear), _smaller(best, linear), _exchanged(best, linear))
            for moves in steps:
                some = list(moves)
                self.fit(some, best.sizes, best.objective)
                known = [self.fits[hypothesis] for hypothesis, _ in some if hypothesis in self.fits]
                better = max(known, key=lambda one: one.log_evidence, default=best)
                if better.log_evidence > best.log_evidence + _GAIN:
                    best = better
                    break
            else:
                break

    def fit_alternatives(self, most: int) -> None:
        """Fit the best hypothesis with each change replaced by others."""
        best = self.best
        linear, _ = self.linear(best)
        for member in best.state.hypothesis.changes:
            self.progress(f"alternatives to a change of {member.name}")
            self._left = 2 * most
            self.fit(exchanges(best, linear, member, most), best.sizes, best.objective)

    def alternatives(self, fit: JointFit, member: Candidate, reach: float) -> tuple[str, ...]:
        """Names whose change fits as well as that of ``member`` within ``reach`` of the misfit, itself first."""
        hypothesis = fit.state.hypothesis
        rest = hypothesis.changed - {member}
        found = [member.name]
        for other, known in self.fits.items():
            more = other.changed - rest
            if rest < other.changed and len(more) == 1 and known.objective < fit.objective + reach:
                found += [one.name for one in more]
        return tuple(dict.fromkeys(found))

    def evidence_of_change(self, fit: JointFit, member: Candidate) -> float:
        """Log evidence lost without the change of ``member``: of the exact fit where there is one, else linear."""
        hypothesis = fit.state.hypothesis
        without = Hypothesis(hypothesis.common, hypothesis.changed - {member})
        if without in self.fits:
            return fit.log_evidence - self.fits[without].log_evidence
        linear, _ = self.linear(fit)
        return linear.value(hypothesis) - linear.value(without)

    def estimate(self, fit: JointFit, hypothesis: Hypothesis) -> tuple[FloatArray, FloatArray]:
        """Coordinates of another hypothesis and their covariance, from equations linear about a fit."""
        linear, _ = self.linear(fit)
        return linear.start(hypothesis), linear.covariance(hypothesis)

    def prior(self, hypothesis: Hypothesis) -> float:
        """Log prior: an effect that is there changes with even odds, a new one is as likely as any.

        The form of parts that service leaves alone changes by machining only.
        """
        machined = sum(one.name not in IN_SERVICE for one in hypothesis.changed)
        return self.library.prior(tuple(hypothesis.common | hypothesis.changed)) - _MACHINED * machined

    def linear(self, fit: JointFit) -> tuple[_Linear, _Linear]:
        """Equations of the whole library about a fit, with its sizes of the errors and without a change of the error.

        A smooth change of the error hides what an effect would explain better.
        """
        library = self.library.candidates
        products = self.model.products(fit.state, library, library)
        return (
            _Linear(self, fit, summed(products, fit.sizes)),
            _Linear(self, fit, summed(products, [replace(one, own=0) for one in fit.sizes])),
        )


def _larger(fit: JointFit, linear: _Linear) -> Iterator[Move]:
    yield from linear.best(fit.state.hypothesis, 1, _SINGLES)
    yield from linear.best(fit.state.hypothesis, 2, _PAIRS)


def _smaller(fit: JointFit, linear: _Linear) -> Iterator[Move]:
    hypothesis = fit.state.hypothesis
    smaller = [Hypothesis(hypothesis.common - {one}, hypothesis.changed - {one}) for one in hypothesis.before]
    smaller += [Hypothesis(hypothesis.common, hypothesis.changed - {one}) for one in hypothesis.changes]
    yield from ((one, linear.start(one)) for one in smaller if linear.value(one) > linear.value(hypothesis) - _OPEN)


def _exchanged(fit: JointFit, linear: _Linear) -> Iterator[Move]:
    for member in fit.state.hypothesis.changes:
        yield from exchanges(fit, linear, member, _SWAPS)


def exchanges(fit: JointFit, linear: _Linear, member: Candidate, most: int) -> list[Move]:
    """The hypothesis with the change of ``member`` replaced by others; with ``member`` itself, too, where it is known
    at both times.
    """
    hypothesis = fit.state.hypothesis
    found = linear.best(Hypothesis(hypothesis.common, hypothesis.changed - {member}), 1, most + 1)
    if member in hypothesis.common:
        found += linear.others(Hypothesis(hypothesis.common - {member}, hypothesis.changed - {member}), most + 1)
    else:
        found += linear.others(Hypothesis(hypothesis.common, hypothesis.changed - {member}), most)
    return [one for one in found if one[0] != hypothesis][: 2 * most]


def is_plausible(hypothesis: Hypothesis, theta: FloatArray) -> bool:
    """Whether all amounts are within their plausible sizes at both times, and on the permitted side of zero."""
    n = 2 * len(hypothesis.before)
    return evidence.is_plausible(hypothesis.before, theta[:n]) and evidence.is_plausible(
        hypothesis.after, hypothesis.to_after @ theta
    )


def _extended(base: Hypothesis, terms: Sequence[_Term]) -> Hypothesis:
    common = base.common | {one.candidate for one in terms if not one.is_change}
    return Hypothesis(common, base.changed | {one.candidate for one in terms if one.is_change})


def starting_sets(
    model: JointModel, before: Mapping[Candidate, FloatArray], after: Mapping[Candidate, FloatArray]
) -> Iterator[Sequence[Move]]:
    """Hypotheses to begin with: no effect, and the effects found before, after and at both times.

    ``before``, ``after``: found effects with their coordinates. A loop alone is fitted fast, so that both are tried.
    """
    nothing: frozenset[Candidate] = frozenset()
    found = before or after
    if model.only_loops or not found:
        yield [(Hypothesis(nothing, nothing), np.zeros(0))]
    if found:
        yield [move for known in ((before,), (after,), (before, after)) for move in _found(known, before, after)]


def _found(
    known: Sequence[Mapping[Candidate, FloatArray]],
    before: Mapping[Candidate, FloatArray],
    after: Mapping[Candidate, FloatArray],
) -> Iterator[Move]:
    """The effects of some diagnoses, unchanged and all changed; of two places of one effect the first stays."""
    common = frozenset({one.name: one for some in reversed(known) for one in some}.values())
    none = np.zeros(2)
    for hypothesis in (Hypothesis(common, frozenset()), Hypothesis(common, common)):
        u = [before.get(one, after.get(one, none)) for one in hypothesis.before]
        rise = [after[one] - before[one] if one in before and one in after else none for one in hypothesis.changes]
        yield hypothesis, np.concatenate([np.zeros(0), *u, *rise])
