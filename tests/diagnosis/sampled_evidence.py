"""Log evidence (docs/theory.md, Eq. 53) compared with nested sampling of the exact model.

``python -m tests.diagnosis.sampled_evidence --help`` runs all cases; ``test_evidence_by_sampling.py`` the cheapest.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import Recording, Residuals
from cycloid_profile.diagnosis.data.noise import Noise
from cycloid_profile.diagnosis.data.recording import record
from cycloid_profile.diagnosis.data.repeats import with_noise_of_repeats
from cycloid_profile.diagnosis.model.candidate import Candidate, candidates, chatter, places
from cycloid_profile.diagnosis.model.evidence import (
    CHANCE,
    Library,
    Scored,
    distinct,
    estimate,
    of_different_names,
    scores,
)
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.flank_grid import FlankGrid
from cycloid_profile.diagnosis.model.optimum import Attempt, Optimum
from cycloid_profile.diagnosis.model.priors import priors_of
from cycloid_profile.diagnosis.model.whitened import NormalEquations, normal_equations
from cycloid_profile.diagnosis.search._proposals import equations_about
from cycloid_profile.diagnosis.search._subsampling import subsample
from cycloid_profile.diagnosis.search.lobe_index import index_lobes
from cycloid_profile.measurement import PROFILE_SCAN, parse_measurement
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Hidden, draw_case, spec_text
from tests.diagnosis.sampling import LIVE_POINTS, Hypothesis, local, nested


@dataclass(frozen=True)
class Question:
    """A case to draw: arguments ``asked`` of ``draw_case``, and the number of ``rows`` kept of each file."""

    label: str
    seed: int
    rows: int
    asked: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Weighed:
    """ln B of a set against no effect, including prior odds, by Eq. (53) and by sampling.

    ``nested``: over the whole prior, with the error stated by dynesty. ``local``: about the optimum only, with its
    standard error. ``one_sided``: number of members that cannot be negative. ``converged``: as stated by the optimum.
    """

    label: str
    seed: int
    kind: str
    truth: list[dict[str, Any]]
    members: list[str]
    rows: int
    free: int
    one_sided: int
    converged: bool
    laplace: float
    nested: float
    nested_error: float
    local: float
    local_error: float
    calls: int
    seconds: float


class Posed:
    """A case with its model on a subsample, the true set of hypotheses and a rival set."""

    def __init__(self, question: Question) -> None:
        self.question = question
        case = draw_case(question.seed, **question.asked)
        self.truth = case.truth
        reducer = as_built_reducer(parse_spec(spec_text(case.reducer)))
        discs = [1 if name == "scan2" else 0 for name in case.files]
        measured = [parse_measurement(text, f"{name}.csv") for name, text in case.files.items()]
        ready = with_noise_of_repeats([record(reducer, m, d) for m, d in zip(measured, discs, strict=True)])
        scanned = frozenset(r.disc for r in ready if r.kind is PROFILE_SCAN)
        self.scans_only = all(r.kind is PROFILE_SCAN for r in ready)
        listed = list(candidates(reducer, scanned, not self.scans_only))
        flank_grid = FlankGrid(reducer)
        residuals = index_lobes(reducer, [Residuals(r, reducer, flank_grid) for r in ready], listed, flank_grid)
        listed += [
            chatter(one["waves_per_turn"], one.number("disc"), priors_of(reducer))
            for one in self.truth
            if one.name == "grinding_chatter"
        ]
        self.library = Library(tuple(listed), max((r.rows.size for r in ready if r.kind is PROFILE_SCAN), default=2))
        self.model = ExactModel(reducer, [subsampled(one.recording, question.rows) for one in residuals], flank_grid)

    @cached_property
    def true_members(self) -> list[Candidate]:
        """The hidden effects."""
        return [self._candidate(one) for one in self.truth]

    @cached_property
    def true_optimum(self) -> Optimum:
        """Optimum of the true set on the exact model, started from the linear equations or from the truth."""
        equations = normal_equations(self.model.baseline.blocks, self.library.candidates)
        linear = estimate(equations, self.library.places(self.true_members))[0]
        sizes = [_size(m, one) / m.width for m, one in zip(self.true_members, self.truth, strict=True)]
        return self._best(self.true_members, [linear, np.concatenate(sizes)])

    @cached_property
    def rival_optimum(self) -> Optimum:
        """Optimum of the best set of the same size that lacks a true name, by linear evidence about the true set."""
        equations = equations_about(self.model, self.library, self.true_optimum)
        numbers = self.library.places(self.true_members)
        wanted = {m.name for m in self.true_members}
        for scored in rank_sets(equations, self.library.priors, len(numbers), keep=numbers):
            members = [self.library.candidates[i] for i in scored.members]
            if len(members) == len(numbers) and not wanted <= {m.name for m in members}:
                return self._best(members, [estimate(equations, scored.members)[0]])
        raise ValueError(f"{self.question.label}: no rival")

    def log_odds(self, members: Sequence[Candidate]) -> float:
        """ln of the prior odds of the set, which sampling over sizes does not contain."""
        count = places(self.library.candidates)
        count["grinding_chatter"] = self.library.frequencies
        return sum(math.log(CHANCE / (1.0 - CHANCE) / count[member.name]) for member in members)

    def _best(self, members: list[Candidate], starts: Iterable[FloatArray]) -> Optimum:
        found = [self.model.optimum(Attempt(tuple(members), start), self.library.prior(members)) for start in starts]
        return max((o for o in found if o is not None), key=lambda o: o.log_evidence)

    def _candidate(self, one: Hidden) -> Candidate:
        parts = dict(one.parameters)
        if self.scans_only:
            parts.setdefault("disc", 1)
        found = (
            c
            for c in self.library.candidates
            if c.name == one.name
            and all(parts.get(k, v if k in c.kind.shapes else None) == v for k, v in c.choice.items())
        )
        return next(found)


_EXTENDED_PAIRS = 40  # bounds the triples, whose number grows with pairs times candidates


def rank_sets(
    equations: NormalEquations, priors: FloatArray, deepest: int = 3, keep: Sequence[int] = ()
) -> list[Scored]:
    """All singles, all pairs, and triples that extend the best pairs, by decreasing evidence.

    Of candidates with one name and identical patterns only the first takes part, or the one in ``keep``.
    """
    visible = distinct(equations, keep)
    if not visible.size:
        return []
    singles = visible[:, np.newaxis]
    scored = scores(equations, priors, singles)
    if visible.size > 1 and deepest > 1:
        pairs = np.array(list(combinations(visible.tolist(), 2)), dtype=np.intp)
        pairs = of_different_names(equations, pairs)
        scored += scores(equations, priors, pairs)
    best = sorted(scored, key=lambda s: -s.log_evidence)
    if deepest > 2 and visible.size > 2:
        best_pairs = [s.members for s in best if len(s.members) == 2][:_EXTENDED_PAIRS]
        triples = {tuple(sorted((*pair, int(i)))) for pair in best_pairs for i in visible if i not in pair}
        if triples:
            chosen = of_different_names(equations, np.array(sorted(triples), dtype=np.intp))
            best = sorted(best + scores(equations, priors, chosen), key=lambda s: -s.log_evidence)
    return best


def subsampled(recording: Recording, rows: int) -> Recording:
    """A subsample with about ``rows`` rows to fit, for scans as well."""
    if recording.kind.is_curve:
        return subsample(recording, rows)
    fit = recording.rows[~recording.held_out]
    step = max(fit.size // rows, 1)
    noise = Noise(recording.noise.sigma, recording.noise.rho**step)
    chosen = fit[::step]
    return replace(recording, rows=chosen, held_out=np.zeros(chosen.size, dtype=bool), noise=noise)


def _size(member: Candidate, one: Hidden) -> FloatArray:
    """True coordinates in the unit of the effect, if the files agree on the angular zero."""
    size = one[member.size]
    if member.angle is None:
        return np.array([1.0 / size if member.inverse else size, 0.0])
    angle = math.radians(member.waves * one[member.angle])
    return size * np.array([math.cos(angle), math.sin(angle)])


def weighed(
    question: Question, kinds: Sequence[str] = ("true", "rival"), live_points: int = LIVE_POINTS
) -> list[Weighed]:
    """The true set and the rival of a case, by both methods."""
    posed = Posed(question)
    found = []
    for kind in kinds:
        start = time.process_time()
        optimum = posed.true_optimum if kind == "true" else posed.rival_optimum
        hypothesis = Hypothesis(posed.model, optimum.members)
        odds = posed.log_odds(optimum.members)
        over_all, error, calls = nested(hypothesis, live_points, question.seed)
        about_it, spread = local(hypothesis, optimum, question.seed)
        answer = Weighed(
            label=question.label,
            seed=question.seed,
            kind=kind,
            truth=[one.table() for one in posed.truth],
            members=[m.label for m in optimum.members],
            rows=optimum.rows,
            free=hypothesis.used.size,
            one_sided=int(np.count_nonzero(hypothesis.one_sided)),
            converged=optimum.converged,
            laplace=optimum.log_evidence,
            nested=over_all + odds,
            nested_error=error,
            local=about_it + odds,
            local_error=spread,
            calls=calls,
            seconds=time.process_time() - start,
        )
        found.append(answer)
    return found


def table(answers: Sequence[Weighed]) -> str:
    """One row for each case: ln B by (53), and its difference from sampling over the prior and about the optimum."""
    sides = [f" {side} | ln B | nested more | local more |" for side in ("true set", "competing set")]
    lines = ["| case | rows |" + "".join(sides), "|---" * 10 + "|"]
    for question in CASES:
        some = [a for a in answers if a.seed == question.seed]
        cells = [
            f"{', '.join(label.split(' (')[0] for label in a.members)} | {a.laplace:.2f} "
            f"| {a.nested - a.laplace:+.2f} ± {a.nested_error:.2f} | {a.local - a.laplace:+.2f} ± {a.local_error:.2f}"
            for a in some
        ]
        if cells:
            name = f"{question.seed % 100} {question.label}"
            lines.append(f"| {name} | {some[0].rows} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _ask(label: str, seed: int, rows: int, size: float | tuple[float, float], *names: str, count: int = 0) -> Question:
    """A case: effects of ``names``, or ``count`` random ones, on the files of ``label``; ``size`` in tolerances."""
    files = {"scan": ("scan",), "loop": ("loop",), "bench": ("te", "te_light", "lost_motion")}[label.split(",")[0]]
    sizes = size if isinstance(size, tuple) else (size, size)
    asked = {"files": files, "effects": count or len(names), "sizes": sizes, "names": names}
    return Question(label, seed, rows, asked)


CASES = (
    _ask("scan, small", 700_001, 250, 0.05, "equidistant_error"),
    _ask("scan, large", 700_002, 250, 2.0, "thermal_growth"),
    _ask("scan, small", 700_003, 250, 0.15, "disc_oval"),
    _ask("scan, small", 700_004, 250, 0.08, "cumulative_pitch_error"),
    _ask("scan, small", 700_005, 250, 0.25, "flank_wear"),
    _ask("scan, large", 700_006, 250, 2.0, "flank_wear"),
    _ask("scan, small", 700_007, 500, 0.6, "single_tooth_error"),
    _ask("scan, small", 700_008, 500, 0.35, "grinding_chatter"),
    _ask("scan, small", 700_009, 250, 0.15, "wheel_wear_drift"),
    _ask("scan, large", 700_010, 250, 2.0, "disc_runout"),
    _ask("scan, two small", 700_011, 250, (0.1, 0.3), count=2),
    _ask("scan, two small", 700_012, 250, (0.1, 0.3), count=2),
    _ask("scan, two large", 700_013, 250, (1.0, 3.0), count=2),
    _ask("scan, two large", 700_014, 250, (1.0, 3.0), "radial_moving_error", "flank_wear"),
    _ask("loop", 700_015, 60, 1.0, "crank_bearing_clearance"),
    _ask("loop", 700_016, 40, 0.1, "coulomb_friction"),
    _ask("loop", 700_017, 60, 0.5, "series_compliance"),
    _ask("loop, two small", 700_018, 40, 0.02, "crank_bearing_clearance", "load_proportional_friction"),
    _ask("loop, two", 700_019, 40, (0.5, 1.0), "pin_radius_error", "crank_bearing_compliance"),
    _ask("bench, second order", 700_020, 16, 0.5, "pin_ring_runout"),
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--live", type=int, default=LIVE_POINTS, help="live points of the nested sampling")
    parser.add_argument("--only", default="", help="cases whose label and seed contain this")
    parser.add_argument("--out", type=Path, default=None, help="JSON lines, one a set")
    arguments = parser.parse_args()
    answers = []
    for question in CASES:
        if arguments.only not in f"{question.label} {question.seed}":
            continue
        for answer in weighed(question, live_points=arguments.live):
            answers.append(answer)
            print(f"{answer.label}: {', '.join(answer.members)}", file=sys.stderr, flush=True)
            if arguments.out is not None:
                with arguments.out.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(asdict(answer)) + "\n")
    print(table(answers))


if __name__ == "__main__":
    main()
