"""Answers of the earlier search (commit 73d1516) to blind cases, frozen, and their comparison with today's answers.

``frozen/answers_0_3.json`` holds the questions, the truth, and what it answered, with rigid
discs in every spec. ``python -m tests.diagnosis.freeze OUT`` asks today's package the same cases, appends the answers
to OUT (a second call continues), and prints both by section: what the answers are worth, and the ratio of the times.
``--store IN`` writes a new frozen file from the answers in IN. It is no test: nothing passes or fails.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import statistics
import time
from collections import defaultdict
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import diagnose
from cycloid_profile.measurement import parse_measurement
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Case, Hidden, draw_case, spec_text
from tests.diagnosis.protocol import JUDGED, WIDE_GROUP, judged, score
from tests.diagnosis.workers import one_core

FROZEN = Path(__file__).parent / "frozen" / "answers_0_3.json"
_DIGITS = 5  # of the reported sizes
_QUESTION = ("section", "seed", "asked", "truth", "files")


def redrawn(row: Mapping[str, Any]) -> Case:
    """The case of a frozen row: its truth is given, all else comes from the seed."""
    truth = [Hidden(one["name"], {key: value for key, value in one.items() if key != "name"}) for one in row["truth"]]
    return draw_case(row["seed"], **row["asked"], resize=lambda *_: truth)


def digest(case: Case) -> str:
    """Short hash of all files of a case."""
    whole = "".join(case.files[name] for name in sorted(case.files))
    return hashlib.sha256(whole.encode()).hexdigest()[:12]


def ask_again(row: Mapping[str, Any]) -> dict[str, Any]:
    """Today's answer to a frozen question; ``same_files`` says whether the generator still writes the same."""
    case = redrawn(row)
    reducer = as_built_reducer(parse_spec(spec_text(case.reducer)))
    read = [parse_measurement(text, f"{name}.csv") for name, text in case.files.items()]
    discs = [int(name == "scan2") for name in case.files]
    answer = {key: row[key] for key in _QUESTION} | {"same_files": digest(case) == row["files"]}
    start = time.perf_counter(), time.process_time()
    try:
        found = diagnose(reducer, read, discs)
        answer |= {
            "verdict": found.verdict,
            "named": [{"name": one.candidate.name} | dict(one.parameters) for one in found.effects],
            "groups": [list(one.group) for one in found.effects],
            "remainder": found.unexplained,
        }
    except Exception as error:  # a crash counts as an outcome
        answer |= {"verdict": "failed", "named": [], "groups": [], "remainder": False, "error": str(error)}
    taken = time.perf_counter() - start[0], time.process_time() - start[1]
    return answer | {"seconds": taken[0], "cpu_seconds": taken[1]}


def ready() -> None:
    """One core, and all code compiled, before a worker takes the time of its first case."""
    one_core()
    asked = {"effects": 1, "files": ["scan", "te_light", "loop"], "sizes": [1.0, 1.0], "names": ["disc_runout"]}
    truth = [one.table() for one in draw_case(1, **asked).truth]
    ask_again({"section": "", "seed": 1, "asked": asked, "truth": truth, "files": ""})


def worth(row: Mapping[str, Any]) -> str:
    """What an answer is worth, by names alone: one of ``JUDGED``."""
    names = [one["name"] for one in row["truth"]]
    if row["verdict"] == "failed":
        return "failed"
    outcome = score(names, row["verdict"], row["groups"], row["remainder"])
    if outcome == "group" and any(len(group) > WIDE_GROUP for group in row["groups"]):
        outcome = "wide"
    return judged(outcome, names, row["section"])


def comparison(before: Sequence[Mapping[str, Any]], now: Sequence[Mapping[str, Any]]) -> str:
    """Table by section of the cases that have both answers: frozen → today's, and the median ratio of CPU times."""
    today = {row["seed"]: row for row in now}
    by: dict[str, list[tuple[Mapping[str, Any], Mapping[str, Any]]]] = defaultdict(list)
    for row in before:
        if row["seed"] in today:
            by[row["section"]].append((row, today[row["seed"]]))
            by["all"].append((row, today[row["seed"]]))
    lines = [f"| section | cases | {' | '.join(JUDGED)} | time, now over then |", "|---" * (len(JUDGED) + 3) + "|"]
    for section, pairs in sorted(by.items(), key=lambda item: item[0] == "all"):
        then, after = ([worth(pair[i]) for pair in pairs] for i in (0, 1))
        cells = " | ".join(_change(then.count(kind), after.count(kind)) for kind in JUDGED)
        ratio = statistics.median(new["cpu_seconds"] / old["cpu_seconds"] for old, new in pairs)
        lines.append(f"| {section} | {len(pairs)} | {cells} | {ratio:.2f} |")
    changed = sum(not new.get("same_files", True) for _, new in by["all"])
    return "\n".join([*lines, f"\nfiles that the generator now writes otherwise: {changed} of {len(by['all'])}"])


def _change(then: int, after: int) -> str:
    return f"{then} → {after}" if then or after else ""


def store(rows: Sequence[Mapping[str, Any]], path: Path = FROZEN) -> None:
    """Write a frozen file: one row a line, reported sizes rounded."""
    kept = (*_QUESTION, "verdict", "named", "groups", "remainder", "seconds", "cpu_seconds")
    lines = []
    for row in rows:
        short = {key: row[key] for key in kept}
        short["named"] = [{key: _rounded(value) for key, value in one.items()} for one in row["named"]]
        short |= {key: round(row[key], 2) for key in ("seconds", "cpu_seconds")}
        lines.append(json.dumps(short, ensure_ascii=False, separators=(",", ":")))
    path.parent.mkdir(exist_ok=True)
    path.write_text("[\n" + ",\n".join(lines) + "\n]\n", encoding="utf-8")


def _rounded(value: Any) -> Any:
    if not isinstance(value, float) or value == 0.0 or not math.isfinite(value):
        return value
    return float(f"{value:.{_DIGITS}g}")


def read(path: Path) -> list[dict[str, Any]]:
    """Answers of a frozen file or of a file of JSON lines; none if it does not exist."""
    if not path.exists():
        return []
    text = path.read_text(encoding="utf-8")
    found: list[dict[str, Any]] = (
        json.loads(text) if text.startswith("[") else [json.loads(line) for line in text.splitlines()]
    )
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path, nargs="?", help="today's answers, JSON lines")
    parser.add_argument("--only", default="", help="sections whose name contains this")
    parser.add_argument("--first", type=int, default=None, help="so many cases of each section at most")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--store", type=Path, default=None, help="freeze the answers of this file instead")
    arguments = parser.parse_args()
    if arguments.store is not None:
        store(read(arguments.store))
        return
    if arguments.out is None:
        parser.error("give a file for today's answers, for example answers.jsonl")
    frozen = [row for row in read(FROZEN) if arguments.only in row["section"]]
    if arguments.first is not None:
        sections = [row["section"] for row in frozen]
        frozen = [row for i, row in enumerate(frozen) if sections[:i].count(row["section"]) < arguments.first]
    done = {row["seed"] for row in read(arguments.out)}
    left = [row for row in frozen if row["seed"] not in done]
    # A fork after the first compiled call would end the process: OpenMP does not survive it.
    with ProcessPoolExecutor(arguments.workers, get_context("spawn"), ready) as pool:
        for answer in pool.map(ask_again, left, chunksize=1):
            with arguments.out.open("a", encoding="utf-8") as file:
                file.write(json.dumps(answer, ensure_ascii=False, default=float) + "\n")
    print(comparison(frozen, read(arguments.out)))


if __name__ == "__main__":
    main()
