"""Sensitivity of the diagnosis to its tuned numbers: each halved and doubled, the same questions asked again.

``python -m tests.diagnosis.sensitivity`` prints the table of docs/diagnosis-validation.md. A question is asked again
only if its answer read the number.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from types import ModuleType
from typing import Any

from cycloid_profile.diagnosis import _tuned
from tests.diagnosis.protocol import Question, ask, questions
from tests.diagnosis.workers import one_core

FACTORS = (0.5, 2.0)
# Cases of each section of the protocol that are asked: scans take a second or two, loops with an effect half a minute.
ASKED = {
    "wide, clean, scan": 4,
    "wide, one, scan": 10,
    "wide, two, scan": 6,
    "wide, outside, scan": 4,
    "wide, clean, loop": 20,
    "wide, one, loop": 2,
}


@dataclass(frozen=True)
class Reply:
    """What one answer is worth, with the tuned numbers that it read; ``name`` times ``factor``, or all as they are."""

    seed: int
    name: str
    factor: float
    judged: str
    read: tuple[str, ...]


def tuned_names() -> list[str]:
    """Names of all tuned numbers, in the order of their table."""
    return [name for name in vars(_tuned) if name.isupper()]


def scaled(value: Any, factor: float) -> Any:
    """A tuned number times ``factor``: a count stays whole and at least 1, a mapping scales each value."""
    if isinstance(value, Mapping):
        return {key: scaled(one, factor) for key, one in value.items()}
    return max(round(value * factor), 1) if isinstance(value, int) else value * factor


class _Recorded(ModuleType):
    """The module of tuned numbers, which keeps a list of those that were read."""

    def __getattribute__(self, name: str) -> Any:
        if name.isupper():
            super().__getattribute__("__dict__")["_read"].add(name)
        return super().__getattribute__(name)


@contextmanager
def recorded(name: str, factor: float) -> Iterator[set[str]]:
    """One number times ``factor``, and the set of those that are read meanwhile."""
    space = vars(_tuned)
    read = set[str]()
    changed = {name: scaled(space[name], factor)} if name else {}
    before = {one: space[one] for one in changed}
    try:
        space["_read"], _tuned.__class__ = read, _Recorded
        space.update(changed)
        yield read
    finally:
        _tuned.__class__ = ModuleType
        space.pop("_read", None)
        space.update(before)


def reply(question: Question, name: str = "", factor: float = 1.0) -> Reply:
    """The answer to a question with one number times ``factor``."""
    with recorded(name, factor) as read:
        answer = ask(question)
    return Reply(question.seed, name, factor, answer.judged, tuple(sorted(read)))


def chosen(seed: int, counts: Mapping[str, int] = ASKED) -> list[Question]:
    """The first cases of each section."""
    every = questions(seed)
    return [one for section, count in counts.items() for one in [q for q in every if q.section == section][:count]]


def replies(asked: Sequence[Question], names: Sequence[str], workers: int, out: Path | None = None) -> list[Reply]:
    """First with the numbers as they are, then with each of ``names`` scaled, where an answer read it."""
    known = [] if out is None or not out.exists() else [_of_json(line) for line in out.read_text().splitlines()]
    done = {(one.seed, one.name, one.factor) for one in known}
    with ProcessPoolExecutor(workers, get_context("spawn"), one_core) as pool:

        def all_of(some: Sequence[tuple[Question, str, float]]) -> None:
            left = [one for one in some if (one[0].seed, one[1], one[2]) not in done]
            for number, future in enumerate(as_completed([pool.submit(reply, *one) for one in left]), 1):
                known.append(future.result())
                print(f"\r{number} of {len(left)}", end="", file=sys.stderr, flush=True)
                if out is not None:
                    with out.open("a", encoding="utf-8") as file:
                        file.write(json.dumps(vars(known[-1])) + "\n")
            print(file=sys.stderr)

        all_of([(one, "", 1.0) for one in asked])
        read = {one.seed: one.read for one in known if not one.name}
        all_of([(q, name, factor) for name in names for factor in FACTORS for q in asked if name in read[q.seed]])
    return known


def _of_json(line: str) -> Reply:
    values = json.loads(line)
    return Reply(**{**values, "read": tuple(values["read"])})


def table(known: Sequence[Reply], names: Sequence[str]) -> str:
    """Right answers of all questions with each number halved, as it is and doubled; wrong: misnamed, false alarms,
    failed.
    """
    base = {one.seed: one.judged for one in known if not one.name}
    lines = ["| number | value | read by | right if halved | as it is | if doubled | wrong |", "|---" * 7 + "|"]
    for name in names:
        read = sum(name in one.read for one in known if not one.name)
        cells = []
        for factor in (FACTORS[0], 1.0, FACTORS[1]):
            other = {one.seed: one.judged for one in known if (one.name, one.factor) == (name, factor)}
            cells.append(Counter((base | other).values()))
        right = " | ".join(str(one["right"]) for one in cells)
        wrong = ", ".join(str(one["misnamed"] + one["false alarm"] + one["failed"]) for one in cells)
        value = getattr(_tuned, name)
        shown = ", ".join(f"{v:g}" for v in value.values()) if isinstance(value, Mapping) else f"{value:g}"
        lines.append(f"| `{name}` | {shown} | {read} of {len(base)} | {right} | {wrong} |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description="The diagnosis with each tuned number halved and doubled.")
    parser.add_argument("--seed", type=int, default=10_010_000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--only", nargs="*", choices=tuned_names(), help="names of the numbers; all if not given")
    parser.add_argument(
        "--out", type=Path, default=None, help="JSON lines, one an answer; those in it are not repeated"
    )
    arguments = parser.parse_args()
    names = arguments.only or tuned_names()
    print(table(replies(chosen(arguments.seed), names, arguments.workers, arguments.out), names))


if __name__ == "__main__":
    main()
