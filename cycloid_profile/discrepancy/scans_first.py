"""What the scans show alone, tried from every lobe on and on every disc that the other files leave it.

A scan names what it shows better than any other file, but neither which lobe is the first nor whether a disc that was
not scanned has it too. The other files say that, beside the exact effect: what all discs share cancels there to first
order.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.candidates import Candidate
from cycloid_profile.discrepancy.chatter_candidates import standing_out
from cycloid_profile.discrepancy.climbing import Climb
from cycloid_profile.discrepancy.evidence import Scored, estimate, search, with_one_more
from cycloid_profile.discrepancy.exact import ExactModel, State
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.lobes import counted_by, is_countable, moved, rotation
from cycloid_profile.discrepancy.normal import Normal, normal
from cycloid_profile.discrepancy.optimum import Attempt, Optimum
from cycloid_profile.discrepancy.seam import counted_from_seams
from cycloid_profile.discrepancy.thinning import fewest

_RESCORINGS, _ROUNDS = 12, 3
_LOOKED_AT, _FITTED, _STEPS = 8, 4, 4
_LEAST_EVIDENCE = 5.0


@dataclass(frozen=True, eq=False)
class _Hypothesis:
    """What the scans show as ``members`` at ``u``, their lobes counted ``lobes`` further."""

    lobes: int
    members: tuple[Candidate, ...]
    u: FloatArray


@dataclass(frozen=True, eq=False)
class _Judged:
    """How likely a hypothesis makes all files with at most one effect more: the ``best`` set, and the equations."""

    hypothesis: _Hypothesis
    best: Scored
    equations: Normal

    @property
    def value(self) -> float:
        """ln of how likely, but for a constant."""
        return self.best.log_evidence - 0.5 * self.equations.chi2


class _Bench:
    """The other files, on ``few`` rows, beside what the scans have ``shown`` alone."""

    def __init__(self, few: ExactModel, scans: ExactModel, library: Library, shown: Optimum) -> None:
        self._few, self._library = few, library
        self._lobes = few.built.case.drive.trochoid.lobes
        blocks = few.nothing.blocks
        self._columns = [block.columns(library.candidates) for block in blocks]
        self._flat = normal(blocks, library.candidates)
        of_scans = normal(scans.at(shown).blocks, library.candidates)
        self._of_scans = of_scans.about(library.places(shown.members), shown.u)

    def roughly(self, one: _Hypothesis) -> _Judged | None:
        """Judged by the exact effect, what else there may be with the slopes beside no effect."""
        state = self._few.state(one.members, one.u)
        return None if state is None else self._judged(one, self._with_slopes_of_nothing(state))

    def exactly(self, one: _Hypothesis) -> _Judged | None:
        """Judged by the exact effect and the slopes beside it."""
        state = self._few.state(one.members, one.u)
        return None if state is None else self._judged(one, normal(state.blocks, self._library.candidates))

    def _judged(self, one: _Hypothesis, curves: Normal) -> _Judged:
        places = self._library.places(one.members)
        both = curves.about(places, one.u).plus(moved(self._of_scans, one.lobes, self._lobes))
        return _Judged(one, with_one_more(both, self._library.priors, places), both)

    def _with_slopes_of_nothing(self, state: State) -> Normal:
        b, chi2 = np.zeros_like(self._flat.b), 0.0
        for G, block, one in zip(self._columns, self._few.nothing.blocks, state.laid, strict=True):
            z = block.white(np.nan_to_num(one.residual))
            b += block.product(G, z)
            chi2 += float(block.product(z, z))
        return replace(self._flat, b=b, chi2=chi2)


def counted_as_scans_show(model: ExactModel, candidates: Sequence[Candidate]) -> ExactModel:
    """The model with its lobes counted from where waves begin that its scans show alone."""
    if not any(is_countable(model.built, recording) for recording in model.recordings):
        return model
    scans = model.scans_alone()
    waves = standing_out(scans)
    if not waves:
        return model
    shown = _shown(scans, Library((*candidates, *waves), max(r.rows.size for r in scans.recordings)))
    return counted_from_seams(model, shown)


def led_by_scans(
    model: ExactModel, library: Library, gain: float, tell: Callable[[str], None]
) -> tuple[ExactModel, Optimum | None]:
    """The likeliest set that begins with what the scans show alone, with at most one effect more, and the model with
    its lobes counted as that set has them; None where the scans or the other files show nothing.

    Fitted on so few rows that a ``gain`` in chi² shows; the count of lobes is judged on as many as show what the other
    files gain, which may be much less.
    """
    scans, others = model.scans_alone(), model.without_scans()
    if not scans.recordings or not others.recordings:
        return model, None
    tell("which lobe is the first, on which disc: beside what the scans show alone")
    shown = _shown(scans, library)
    if shown.log_evidence < _LEAST_EVIDENCE:
        return model, None
    bench = _Bench(fewest(others, _gain(others, library)), scans, library, shown)
    rough = [bench.roughly(one) for one in _hypotheses(model, library, shown)]
    judged = [bench.exactly(one.hypothesis) for one in _best(rough)[:_LOOKED_AT]]
    found, leading = model, None
    for one in _best(judged)[:_FITTED]:
        counted = counted_by(model, one.hypothesis.lobes)
        members = library.members(one.best.members)
        attempt = Attempt(members, estimate(one.equations, one.best.members)[0], _STEPS)
        optimum = fewest(counted, gain).optimum(attempt, library.prior(members))
        if optimum is not None and (leading is None or optimum.log_evidence > leading.log_evidence):
            found, leading = counted, optimum
    return found, leading


def _gain(model: ExactModel, library: Library) -> float:
    """Of chi², by the best set of linear equations about no effect."""
    found = search(normal(model.nothing.blocks, library.candidates), library.priors)
    return 2.0 * max((one.log_evidence for one in found[:1]), default=0.0)


def _best(judged: list[_Judged | None]) -> list[_Judged]:
    return sorted((one for one in judged if one is not None), key=lambda one: -one.value)


def _shown(scans: ExactModel, library: Library) -> Optimum:
    """What the scans show alone."""
    equations = normal(scans.nothing.blocks, library.candidates)
    starts = [(list(s.members), estimate(equations, s.members)[0]) for s in search(equations, library.priors)[:1]]
    return Climb(scans, library, _RESCORINGS, lambda _: None).up(starts, _ROUNDS)


def _hypotheses(model: ExactModel, library: Library, shown: Optimum) -> Iterator[_Hypothesis]:
    """The set on every disc or all where the scans show it alike, each with every count of lobes that differs."""
    lobes = model.built.case.drive.trochoid.lobes
    open_ = all(is_countable(model.built, r) for r in model.recordings if r.kind == "profile_scan")
    counts = range(lobes) if open_ and any(_counts_lobes(member, lobes) for member in shown.members) else range(1)
    for count in counts:
        u, choices = shown.u.copy(), []
        for i, member in enumerate(shown.members):
            # To scans that count so many further, the effect is so much nearer.
            choice, turn = member.turned(-count, lobes)
            u[2 * i : 2 * i + 2] = rotation(turn) @ u[2 * i : 2 * i + 2]
            choices.append(_on_any_disc(model, library, replace(member, choice=choice)))
        for members in product(*choices):
            yield _Hypothesis(count, members, u)


def _counts_lobes(member: Candidate, lobes: int) -> bool:
    choice, turn = member.turned(1, lobes)
    return choice != member.choice or turn != 0.0


def _on_any_disc(model: ExactModel, library: Library, member: Candidate) -> list[Candidate]:
    """The candidates that differ from one in their discs only, and that the scans show alike."""
    scanned = {r.disc for r in model.recordings if r.kind == "profile_scan"}
    discs = [None, *range(1, model.built.discs + 1)] if "disc" in member.choice else [None]
    own = dict(member.choice)
    known = [library.where(member.name, own | {"disc": disc} if "disc" in own else own) for disc in discs]
    shows = [model.probes.touches(member, j) for j in scanned]
    return [c for c in known if c is not None and [model.probes.touches(c, j) for j in scanned] == shows]
