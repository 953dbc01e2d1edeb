"""Blind test: effects hidden by the independent generator, diagnosed and scored.

``python -m tests.diagnosis.protocol --help`` runs all of it; ``test_blind_cases.py`` runs a small part. Sections that
begin with ``wide`` draw everything: drive, contact law, elastic or rigid disc, friction, shapes, sizes, noise, and how
the files were measured. Only ``diagnose`` of the package is asked.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import Diagnosis, diagnose
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.measurement import Measurement, parse_measurement
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Case, draw_case, draw_wide, spec_text
from tests.diagnosis.blind.cases import measured
from tests.diagnosis.separable import Scaled, inseparable, seen, strength, view_of
from tests.diagnosis.workers import one_core

# Pairs that no ordinary measurement separates: either name is correct if the group contains the other.
ALIASES = ({"radial_moving_error", "thermal_growth"},)
# Not in the library, but near enough to an effect of it: a spring of rising stiffness is no power law.
NAMED_TOO = {"x_rate_stiffening": "nonlinear_series_compliance"}
BENCH = ("te", "te_light", "lost_motion")
FIVE = ("scan", "te", "te_light", "lost_motion", "loop")
GROUP_MAY_HAVE = 2  # beyond true aliases
# On few lobes, and on single files of a drive with other physics, more shapes are parallel.
WIDE_GROUP = 5  # names in all
# λ of an effect that a test at a level of 0.001 finds four times of five.
DETECTED = math.sqrt(17.07)
# Files of the wide sections; cases with nothing hidden, one effect, two, and one that is not in the library.
WIDE = (
    ("scan", ("scan",), (100, 150, 80, 60)),
    ("loop", ("loop",), (60, 80, 30, 30)),
    ("bench", BENCH, (40, 60, 30, 20)),
    ("five files", FIVE, (10, 20, 20, 10)),
)
# Generator names of the measurements proposed to separate rivals.
PROPOSED = {
    "profile_scan": "scan",
    "transmission_error at rated torque": "te",
    "transmission_error at 3 % torque": "te_light",
    "lost_motion_map": "lost_motion",
    "hysteresis": "loop",
}


@dataclass(frozen=True)
class Question:
    """A case to draw: a ``section`` of the protocol and the arguments of ``draw_case``.

    ``scale``: range of λ_sep of the sizes. ``rerun``: repeat with the proposed measurement. ``wide``: by ``draw_wide``.
    """

    section: str
    seed: int
    asked: dict[str, Any] = field(default_factory=dict)
    scale: tuple[float, float] | None = None
    rerun: bool = False
    wide: bool = False

    def case(self) -> Case:
        """The case, drawn."""
        if self.wide:
            return draw_wide(self.seed, **self.asked)
        resize = None if self.scale is None else Scaled(tuple(self.asked["files"]), *self.scale)
        return draw_case(self.seed, **self.asked, resize=resize)


@dataclass(frozen=True)
class Answer:
    """Scored result: ``outcome`` is one of ``OUTCOMES``; ``z``: errors of sizes over their stated uncertainty.

    ``again``: outcome with the proposed measurement; empty if none was proposed or possible. ``forms`` of the case.
    """

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
    again: str = ""
    forms: dict[str, str] = field(default_factory=dict)

    @property
    def judged(self) -> str:
        """One of ``JUDGED``."""
        return judged(self.outcome, [one["name"] for one in self.truth], self.section)


OUTCOMES = (
    "exact", "group", "below", "wide", "remainder", "subset", "more", "wrong", "unknown", "within limit", "agrees",
    "failed",
)  # fmt: skip
RIGHT_NAMES = ("exact", "group", "wide")
JUDGED = ("right", "within limit", "misnamed", "false alarm", "missed", "unknown", "failed")


def judged(outcome: str, truth: Sequence[str], section: str) -> str:
    """What an outcome is worth.

    Effects too small for the files may be missed ("below"). Outside the library, unknown or a remainder is right. Where
    the physics is foreign, or aliases are asked for, right names with a remainder, or in a larger group, are right.
    Anything reported of a clean reducer is a false alarm. Agreement with a stated limit above what is hidden counts by
    itself: it is true, and names nothing.
    """
    if outcome in {"exact", "group", "below"}:
        return "right"
    if outcome in {"failed", "within limit"}:
        return outcome
    if not truth:
        return "false alarm"
    if outcome == "remainder" and (any(name.startswith("x_") for name in truth) or section.startswith("wide")):
        return "right"
    if outcome == "wide" and section.startswith("aliases"):
        return "right"
    if outcome in {"wrong", "more"}:
        return "misnamed"
    return "missed" if outcome in {"agrees", "subset"} else "unknown"


def ask(question: Question) -> Answer:
    """Draw, diagnose, score."""
    files = question.asked["files"]
    case = question.case()
    truth = [one.table() for one in case.truth]
    names = [one.name for one in case.truth]
    again = ""
    start = time.perf_counter()
    try:
        reducer = _reducer(spec_text(case.reducer))
        read = _read(case.files)
        start = time.perf_counter()
        found = diagnose(reducer, *read)
        seconds = time.perf_counter() - start
        outcome = _outcome(names, found)
        if outcome == "group" and _wide(case, files, found, question.wide):
            outcome = "wide"
        if outcome in {"agrees", "subset"} and not _shows(case, found):
            outcome = "below"
        elif outcome == "agrees" and _within_limits(case, found):
            outcome = "within limit"
        if question.rerun:
            again = _again(case, files, found)
    except Exception as error:  # a crash counts as an outcome
        return Answer(
            question.section, question.seed, truth, "", [], [], "failed", [], math.nan, math.nan,
            time.perf_counter() - start, f"{type(error).__name__}: {error}", forms=case.forms,
        )  # fmt: skip
    named = [{"name": e.candidate.name} | e.parameters for e in found.effects]
    worst = max((g.held_out_after / g.noise for g in found.gaps if math.isfinite(g.held_out_after)), default=math.nan)
    closures = [g.closure for g in found.gaps if g.closure is not None]
    z = _errors(truth, found.effects) if outcome in RIGHT_NAMES else []
    return Answer(
        question.section, question.seed, truth, found.verdict, named, [list(e.group) for e in found.effects], outcome,
        z, worst, min(closures, default=math.nan), seconds, "", again, case.forms,
    )  # fmt: skip


def _read(files: Mapping[str, str]) -> tuple[list[Measurement], list[int]]:
    """The files and the disc of each."""
    return [parse_measurement(text, f"{name}.csv") for name, text in files.items()], [int(n == "scan2") for n in files]


def _outcome(names: Sequence[str], found: Diagnosis) -> str:
    return score(names, found.verdict, [list(e.group) for e in found.effects], found.unexplained)


def _wide(case: Case, files: Sequence[str], found: Diagnosis, any_drive: bool) -> bool:
    """Whether an ambiguity group has too many names beyond true aliases."""
    groups = [set(effect.group) for effect in found.effects]
    if any_drive:
        wide = set().union(*(group for group in groups if len(group) > WIDE_GROUP))
        same = set().union(*(inseparable(case, one, wide) for one in case.truth)) if wide else set()
        return any(len(group - same) > WIDE_GROUP for group in groups)
    if all(len(group) <= GROUP_MAY_HAVE + 1 for group in groups):
        return False
    aliases = {one.name: {one.name} for one in case.truth}
    for one, shown in zip(case.truth, seen(case.truth, view_of(files, case.hidden_settings)), strict=True):
        aliases[one.name] |= shown.aliases
    return any(
        min(len(group - same) for name, same in aliases.items() if name in group) > GROUP_MAY_HAVE
        for group in groups
        if aliases.keys() & group
    )


def _shows(case: Case, found: Diagnosis) -> bool:
    """Whether the files show an effect that is not among those named."""
    reported = {_alias(name) for effect in found.effects for name in effect.group}
    return any(strength(case, one) > DETECTED for one in case.truth if _alias(one.name) not in reported)


def _within_limits(case: Case, found: Diagnosis) -> bool:
    """Whether the answer states a limit above the size of each hidden effect."""
    for one in case.truth:
        limit, parameter = found.not_seen.get(one.name, (0.0, ""))
        size = abs(one.get(parameter))
        # The limit of a stiffness is that of its compliance. Without a limit the files say nothing.
        if not 0.0 < (1.0 / size if parameter.endswith("_per_arcmin") and size else size) < limit < math.inf:
            return False
    return True


def _again(case: Case, files: Sequence[str], found: Diagnosis) -> str:
    """Outcome with the proposed measurement."""
    proposed = {PROPOSED[e.separate_by] for e in found.effects if e.separate_by in PROPOSED} - set(files)
    if not proposed:
        return ""
    more = measured(case.reducer, case.truth, sorted(proposed), case.hidden_settings, seed=case.seed)
    both = diagnose(_reducer(spec_text(case.reducer)), *_read({**case.files, **more}))
    return _outcome([one.name for one in case.truth], both)


def score(truth: Sequence[str], verdict: str, groups: Sequence[Sequence[str]], remainder: bool) -> str:
    """Outcome of an answer; true aliases count as one name."""
    reported_names = {name for group in groups for name in group}
    truth = [NAMED_TOO[name] if NAMED_TOO.get(name) in reported_names else name for name in truth]
    known = [_alias(name) for name in truth if not name.startswith("x_")]
    outside = len(known) < len(truth)
    if verdict == "agrees":
        return "exact" if not truth else "agrees"
    if verdict == "unknown_effect":
        return "exact" if outside else "unknown"
    reported = [list(dict.fromkeys(_alias(name) for name in group)) for group in groups]
    left = list(known)
    wrong = []
    wide = False
    for group in reported:
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
    """Error of every size over its uncertainty, for effects of the true name, at the true location if listed."""
    found = []
    for effect in effects:
        for one in truth:
            size = effect.candidate.size
            if one["name"] == effect.candidate.name and size in one:
                reported = next((p for p in (effect, *effect.other_locations) if _at(p.candidate.choice, one)), effect)
                found.append((reported.parameters[size] - one[size]) / reported.uncertainty[size])
    return found


def _at(choice: Mapping[str, Any], one: Mapping[str, Any]) -> bool:
    return all(one.get(key) == value for key, value in choice.items() if key != "waves_per_turn")


@lru_cache(maxsize=4)
def _reducer(text: str) -> AsBuiltReducer:
    return as_built_reducer(parse_spec(text))


def clopper_pearson(hits: int, of: int, level: float = 0.95) -> tuple[float, float]:
    """Clopper–Pearson interval of a rate."""
    from scipy.stats import beta

    if of == 0:
        return 0.0, 1.0
    tail = 0.5 * (1.0 - level)
    low = 0.0 if hits == 0 else float(beta.ppf(tail, hits, of - hits + 1))
    high = 1.0 if hits == of else float(beta.ppf(1.0 - tail, hits + 1, of - hits))
    return low, high


def questions(seed: int, share: float = 1.0) -> list[Question]:
    """Cases of the protocol; ``share`` of them, at least one of each kind."""
    found: list[Question] = []

    def add(section: str, count: int, scale: tuple[float, float] | None = None, rerun: bool = False, **a: Any) -> None:
        for _ in range(max(1, round(count * share))):
            found.append(Question(section, seed + len(found), a, scale, rerun, section.startswith("wide")))

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
    # On a single loop every compliance imitates a form error: only loop-specific effects are outside the library.
    of_loops = ("x_loop_creep", "x_rate_stiffening")
    add("outside, loop", 20, effects=0, outside=1, files=("loop",), sizes=(0.7, 2.0), names=of_loops)
    of_benches = ("x_three_waves", "x_tooth_to_tooth", "x_te_order7")
    add("outside, bench", 20, effects=0, outside=1, files=BENCH, sizes=(0.7, 2.0), names=of_benches)
    for name, files, count in (("scan", ("scan",), 100), ("loop", ("loop",), 60), ("bench", BENCH, 40)):
        add(f"λ_sep 6 to 60, one, {name}", count, (6.0, 60.0), effects=1, files=files)
        add(f"λ_sep 3 to 6, one, {name}", count // 2, (3.0, 6.0), effects=1, files=files)
    add("λ_sep 8 to 60, two, scan", 60, (8.0, 60.0), effects=2, files=("scan",))
    add("λ_sep 8 to 60, two, bench", 20, (8.0, 60.0), effects=2, files=BENCH)
    confusable = (
        "equidistant_error",
        "pin_radius_error",
        "pin_circle_radius_error",
        "missing_deformation_compensation",
    )
    add("aliases, loop", 20, None, True, effects=1, files=("loop",), sizes=(0.5, 2.0), names=confusable)
    add("aliases, bench", 20, None, True, effects=1, files=BENCH, sizes=(0.5, 1.5), names=confusable[:2])
    for name, files, counts in WIDE:
        for hidden, count in zip(("clean", "one", "two"), counts[:3], strict=True):
            add(f"wide, {hidden}, {name}", count, effects=("clean", "one", "two").index(hidden), files=files)
        names = {"loop": of_loops, "bench": of_benches}.get(name, ())
        add(f"wide, outside, {name}", counts[3], effects=0, outside=1, files=files, names=names)
    return found


def run(asked: Sequence[Question], workers: int, out: Path | None = None) -> list[Answer]:
    """All answers, in order; each is appended to ``out``."""
    answers = []
    # A fork after the first compiled call would end the process: OpenMP does not survive it.
    with ProcessPoolExecutor(workers, get_context("spawn"), one_core) as pool:
        for number, answer in enumerate(pool.map(ask, asked, chunksize=1), 1):
            answers.append(answer)
            print(f"\r{number} of {len(asked)}", end="", file=sys.stderr, flush=True)
            if out is not None:
                with out.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(asdict(answer), default=float) + "\n")
    print(file=sys.stderr)
    return answers


def table(answers: Sequence[Answer]) -> str:
    """Counts by section and outcome, with the interval of the correct share."""
    by: dict[str, list[Answer]] = defaultdict(list)
    for answer in answers:
        by[answer.section].append(answer)
    head = "| section | cases | " + " | ".join(OUTCOMES) + " | right, 95 % interval |"
    lines = [head, "|---" * (len(OUTCOMES) + 3) + "|"]
    for section, of in by.items():
        counts = Counter(answer.outcome for answer in of)
        cells = " | ".join(str(counts[o] or "") for o in OUTCOMES)
        lines.append(f"| {section} | {len(of)} | {cells} | {_right([answer.judged for answer in of])} |")
    return "\n".join(lines)


def table_of_forms(answers: Sequence[Answer]) -> str:
    """What the answers are worth by drive, class of noise and form of the model; a case counts in several rows."""
    by: dict[tuple[str, str], list[str]] = defaultdict(list)
    for answer in answers:
        for kind, form in (*answer.forms.items(), ("all", answer.section.split(",")[0])):
            by[kind, form].append(answer.judged)
    lines = [f"| form | cases | {' | '.join(JUDGED)} | right, 95 % interval |", "|---" * (len(JUDGED) + 3) + "|"]
    for (kind, form), of in sorted(by.items()):
        cells = " | ".join(str(of.count(worth) or "") for worth in JUDGED)
        lines.append(f"| {kind}: {form} | {len(of)} | {cells} | {_right(of)} |")
    return "\n".join(lines)


def _right(of: Sequence[str]) -> str:
    """Share of right answers with its interval."""
    right = list(of).count("right")
    low, high = clopper_pearson(right, len(of))
    return f"{right / len(of):.2f}, {low:.2f} to {high:.2f}"


def calibration(answers: Sequence[Answer]) -> str:
    """One sentence each on intervals, held-out rows, closure and time."""
    z = [value for answer in answers for value in answer.z]
    inside = sum(abs(value) < 1.96 for value in z)
    # Effects outside the library leave a residual by design.
    named = [a for a in answers if a.outcome in RIGHT_NAMES and not a.section.startswith("outside")]
    held = [a.held_out for a in named if math.isfinite(a.held_out)]
    good = sum(value <= 1.1 for value in held)
    closures = [a.closure for a in named if math.isfinite(a.closure)]
    closed = sum(value >= 0.9 for value in closures)
    seconds = sorted(a.seconds for a in answers)
    again = [a.again for a in answers if a.again]
    return "\n".join(
        [
            f"the proposed measurement separated it from its alternatives in {again.count('exact')} of {len(again)}",
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
    parser.add_argument("--first", type=int, default=None, help="so many cases of each section at most")
    parser.add_argument("--out", type=Path, default=None, help="JSON lines, one a case")
    parser.add_argument("--read", type=Path, nargs="*", default=[], help="print what such files hold, run nothing")
    arguments = parser.parse_args()
    asked = [q for q in questions(arguments.seed, arguments.share) if arguments.only in q.section]
    if arguments.first is not None:
        sections = [q.section for q in asked]
        asked = [q for i, q in enumerate(asked) if sections[:i].count(q.section) < arguments.first]
    lines = [line for path in arguments.read for line in path.read_text(encoding="utf-8").splitlines()]
    answers = [Answer(**json.loads(line)) for line in lines] or run(asked, arguments.workers, arguments.out)
    print(table(answers))
    print("\n" + table_of_forms(answers))
    print("\n" + calibration(answers) + "\n")
    for answer in answers:
        if answer.outcome not in {"exact", "group"}:
            truth = ", ".join(str(t) for t in answer.truth)
            print(f"{answer.section} {answer.seed}: {answer.outcome}; truth {truth}")
            print(f"    reported {answer.named} {answer.groups} {answer.error}")


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
    main()
