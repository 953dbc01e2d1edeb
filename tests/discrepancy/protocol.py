"""The blind test: hidden effects from the independent generator against the diagnosis, scored and counted.

``python -m tests.discrepancy.protocol --help`` runs all of it; ``test_blind_cases.py`` runs a small part.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from cycloid_profile.design.ground import built_reducer
from cycloid_profile.discrepancy.diagnosis import diagnose
from cycloid_profile.effects.built import Built
from cycloid_profile.measurement.files import parse_measurement
from cycloid_profile.spec.read import parse_spec
from tests.discrepancy.baseline import named_by_bic
from tests.discrepancy.blind import Reducer, draw_case, spec_text

# Pairs that no ordinary measurement tells apart: naming one with the other in its group is right.
ALIASES = ({"radial_moving_error", "thermal_growth"},)
BENCH = ("te", "te_light", "lost_motion")
FIVE = ("scan", "te", "te_light", "lost_motion", "loop")
# The size parameter comes first in the tables of the generator.
GROUP_MAY_HAVE = 2  # beyond true aliases


@dataclass(frozen=True)
class Question:
    """A case to draw: a ``section`` of the protocol, and what ``draw_case`` is asked for."""

    section: str
    seed: int
    asked: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Answer:
    """What came out: ``outcome`` is one of ``OUTCOMES``; ``z``, errors of sizes over their stated uncertainty."""

    section: str
    seed: int
    truth: list[dict[str, Any]]
    verdict: str
    named: list[dict[str, Any]]
    groups: list[list[str]]
    outcome: str
    z: list[float]
    held_out: float
    closure: float
    seconds: float
    error: str = ""
    baseline: str = ""


OUTCOMES = ("exact", "group", "remainder", "subset", "more", "wrong", "unknown", "agrees", "failed")


def ask(question: Question) -> Answer:
    """Draw, diagnose, score."""
    case = draw_case(question.seed, **question.asked)
    baseline = ""
    truth = [one.table() for one in case.truth]
    start = time.perf_counter()
    try:
        measured = [parse_measurement(text, f"{name}.csv") for name, text in case.files.items()]
        discs = [1 if name == "scan2" else 0 for name in case.files]
        built = _reducer(spec_text(case.reducer))
        names = named_by_bic(built, measured, discs)
        verdict = "effects_found" if names else "agrees"
        baseline = score([t["name"] for t in truth], verdict, [[n] for n in names], False)
        start = time.perf_counter()
        found = diagnose(built, measured, discs)
    except Exception as error:  # a crash is an outcome, to be counted
        return Answer(
            question.section, question.seed, truth, "", [], [], "failed", [], math.nan, math.nan,
            time.perf_counter() - start, f"{type(error).__name__}: {error}", baseline,
        )  # fmt: skip
    named = [{"name": e.candidate.name} | e.parameters for e in found.effects]
    groups = [list(e.group) for e in found.effects]
    outcome = score([t["name"] for t in truth], found.verdict, groups, found.remainder is not None)
    worst = max((g.held_out_after / g.noise for g in found.gaps if math.isfinite(g.held_out_after)), default=math.nan)
    closures = [g.closure for g in found.gaps if g.closure is not None]
    z = _errors(truth, found.effects) if outcome in {"exact", "group"} else []
    return Answer(
        question.section, question.seed, truth, found.verdict, named, groups, outcome, z, worst,
        min(closures, default=math.nan), time.perf_counter() - start, "", baseline,
    )  # fmt: skip


def score(truth: Sequence[str], verdict: str, groups: Sequence[Sequence[str]], remainder: bool) -> str:
    """How right an answer is; true aliases count as one name."""
    known = [_alias(name) for name in truth if not name.startswith("x_")]
    outside = len(known) < len(truth)
    if verdict == "agrees":
        return "exact" if not truth else "agrees"
    if verdict == "unknown_effect":
        return "exact" if outside else "unknown"
    told = [list(dict.fromkeys(_alias(name) for name in group)) for group in groups]
    left = list(known)
    wrong = []
    wide = False
    for group in told:
        match = next((name for name in left if name in group), None)
        if match is None:
            wrong.append(group)
            continue
        left.remove(match)
        wide |= len(group) > 1
    if outside:
        return "remainder" if remainder else "wrong"
    if wrong:
        return "more" if not left and truth else "wrong"
    if left:
        return "subset"
    if remainder:
        return "remainder"
    return "group" if wide else "exact"


def _alias(name: str) -> str:
    for pair in ALIASES:
        if name in pair:
            return min(pair)
    return name


def _errors(truth: Sequence[dict[str, Any]], effects: Iterable[Any]) -> list[float]:
    """Error of every size over its uncertainty, where the named effect is of the very name and parts."""
    found = []
    for effect in effects:
        for one in truth:
            size = effect.candidate.size
            if one["name"] == effect.candidate.name and size in one:
                found.append((effect.parameters[size] - one[size]) / effect.uncertainty[size])
    return found


@lru_cache(maxsize=4)
def _reducer(text: str) -> Built:
    return built_reducer(parse_spec(text))


def clopper_pearson(hits: int, of: int, level: float = 0.95) -> tuple[float, float]:
    """Interval of a rate."""
    from scipy.stats import beta

    if of == 0:
        return 0.0, 1.0
    tail = 0.5 * (1.0 - level)
    low = 0.0 if hits == 0 else float(beta.ppf(tail, hits, of - hits + 1))
    high = 1.0 if hits == of else float(beta.ppf(1.0 - tail, hits + 1, of - hits))
    return low, high


def questions(seed: int, share: float = 1.0) -> list[Question]:
    """The protocol; ``share`` of its cases, at least one of each kind."""
    found: list[Question] = []

    def add(section: str, count: int, **asked: Any) -> None:
        for _ in range(max(1, round(count * share))):
            found.append(Question(section, seed + len(found), asked))

    add("clean, scan", 300, effects=0, files=("scan",))
    add("clean, loop", 100, effects=0, files=("loop",))
    add("clean, bench", 60, effects=0, files=BENCH)
    add("clean, five files", 40, effects=0, files=FIVE)
    add("one, scan", 150, effects=1, files=("scan",), sizes=(0.2, 2.0))
    add("one, loop", 60, effects=1, files=("loop",), sizes=(0.5, 2.0))
    add("one, bench", 80, effects=1, files=BENCH, sizes=(0.3, 1.5))
    add("one, five files", 40, effects=1, files=FIVE, sizes=(0.3, 1.5))
    add("two, scan", 100, effects=2, files=("scan",), sizes=(0.5, 2.0))
    add("two, bench", 40, effects=2, files=BENCH, sizes=(0.5, 1.5))
    add("two, five files", 40, effects=2, files=FIVE, sizes=(0.5, 1.5))
    add("three, scan", 30, effects=3, files=("scan",), sizes=(0.5, 2.0))
    add("outside, scan", 60, effects=0, outside=1, files=("scan",), sizes=(0.7, 2.0))
    # What a single loop shows of a form error every compliance shows too: only what is of the loop itself is outside.
    of_loops = ("x_loop_creep", "x_rate_stiffening")
    add("outside, loop", 20, effects=0, outside=1, files=("loop",), sizes=(0.7, 2.0), names=of_loops)
    of_benches = ("x_three_waves", "x_tooth_to_tooth", "x_te_order7")
    add("outside, bench", 20, effects=0, outside=1, files=BENCH, sizes=(0.7, 2.0), names=of_benches)
    return found


def run(asked: Sequence[Question], workers: int, out: Path | None = None) -> list[Answer]:
    """All answers, in order; each is written to ``out`` as it comes."""
    answers = []
    with ProcessPoolExecutor(workers) as pool:
        for number, answer in enumerate(pool.map(ask, asked, chunksize=1), 1):
            answers.append(answer)
            print(f"\r{number} of {len(asked)}", end="", file=sys.stderr, flush=True)
            if out is not None:
                with out.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(asdict(answer), default=float) + "\n")
    print(file=sys.stderr)
    return answers


def table(answers: Sequence[Answer], baseline: bool = False) -> str:
    """Counts by section and outcome, with the interval of the share that is right; of the ``baseline`` if wanted."""
    by: dict[str, Counter[str]] = defaultdict(Counter)
    for answer in answers:
        by[answer.section][answer.baseline if baseline else answer.outcome] += 1
    head = "| section | cases | " + " | ".join(OUTCOMES) + " | right, 95 % interval |"
    lines = [head, "|---" * (len(OUTCOMES) + 3) + "|"]
    for section, counts in by.items():
        total = sum(counts.values())
        right = counts["exact"] + counts["group"] + (counts["remainder"] if section.startswith("outside") else 0)
        low, high = clopper_pearson(right, total)
        cells = " | ".join(str(counts[o] or "") for o in OUTCOMES)
        lines.append(f"| {section} | {total} | {cells} | {right / total:.2f}, {low:.2f} to {high:.2f} |")
    return "\n".join(lines)


def calibration(answers: Sequence[Answer]) -> str:
    """Intervals, held-out rows, closure and time in a sentence each."""
    z = [value for answer in answers for value in answer.z]
    inside = sum(abs(value) < 1.96 for value in z)
    # What no effect of the library explains is left as it is, on purpose.
    named = [a for a in answers if a.outcome in {"exact", "group"} and not a.section.startswith("outside")]
    held = [a.held_out for a in named if math.isfinite(a.held_out)]
    good = sum(value <= 1.1 for value in held)
    closures = [a.closure for a in named if math.isfinite(a.closure)]
    closed = sum(value >= 0.9 for value in closures)
    seconds = sorted(a.seconds for a in answers)
    return "\n".join(
        [
            f"95 % intervals hold the true size in {inside} of {len(z)}",
            f"worst file's held-out rms within 1.1 of the noise in {good} of {len(held)}",
            f"at least 90 % of the gap closed in {closed} of {len(closures)}",
            f"seconds: median {seconds[len(seconds) // 2]:.1f}, longest {seconds[-1]:.1f}",
        ]
    )


def main() -> None:
    parser = argparse.ArgumentParser(description="Blind test of the diagnosis; for example --share 0.1 --workers 2.")
    parser.add_argument("--seed", type=int, default=100_000)
    parser.add_argument("--share", type=float, default=1.0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--only", default="", help="sections whose name contains this")
    parser.add_argument("--out", type=Path, default=None, help="JSON lines, one a case")
    arguments = parser.parse_args()
    asked = [q for q in questions(arguments.seed, arguments.share) if arguments.only in q.section]
    answers = run(asked, arguments.workers, arguments.out)
    print(table(answers))
    print("\nleast squares and BIC on the same cases\n" + table(answers, baseline=True))
    print("\n" + calibration(answers) + "\n")
    for answer in answers:
        if answer.outcome not in {"exact", "group"}:
            truth = ", ".join(str(t) for t in answer.truth)
            print(f"{answer.section} {answer.seed}: {answer.outcome}; truth {truth}")
            print(f"    told {answer.named} {answer.groups} {answer.error}")


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
    assert Reducer
    main()
