"""Run the benchmarks and write their figures into docs/benchmarks.md: ``python -m benchmarks.table [--long]``."""

from __future__ import annotations

import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from benchmarks.document import machine, put, table

ROOT = Path(__file__).parents[1]
MOST_MEGABYTES = 1000.0
SLOPE, SLOPE_TOLERANCE = 1.0, 0.1
MILLION = 1_000_000
HEAD = ("what", "against", "figure", "measured", "target", "met", "for information")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--long", action="store_true", help="also a million poses of the whole stage, some minutes")
    long = parser.parse_args().long
    benchmarks = _measured()
    rows = [line for each in benchmarks if "row" in each["extra_info"] for line in _ratio(each)]
    rows += _slopes([each for each in benchmarks if "linear_cost" in each["extra_info"]])
    rows.append(_memory("equilibrium", "`Equilibrium().blocks`"))
    put("compiler", f"{machine(('numpy', 'numba'))}\n\n{table(('what', 'time', 'numpy / compiled'), _compiler())}")
    put("figures", f"{machine()}\n\n{table(HEAD, rows)}")
    if long:
        put("long", f"{machine()}\n\n{table(HEAD, [_memory('stage', '`StageEquilibrium().blocks`')])}")


def _measured() -> list[dict[str, Any]]:
    """What pytest-benchmark wrote; its report and any failure go to the screen."""
    with tempfile.TemporaryDirectory() as folder:
        times = Path(folder) / "times.json"
        command = [sys.executable, "-m", "pytest", "benchmarks", "-n0", "--benchmark-only", f"--benchmark-json={times}"]
        subprocess.run(command, cwd=ROOT, check=True)
        benchmarks: list[dict[str, Any]] = json.loads(times.read_text())["benchmarks"]
        return benchmarks


def _ratio(benchmark: dict[str, Any]) -> list[tuple[str, ...]]:
    """One or two lines of the table from the two sides of one benchmark: the least time of each."""
    row, ours = benchmark["extra_info"], benchmark["stats"]["min"]
    plain = min(row["plain_seconds"])
    note = ""
    if "looped" in row:
        plain *= row["poses"] / row["looped"]
        note = f", scaled from {row['looped']} poses"
    seconds = f"{_seconds(ours)} against {_seconds(plain)}{note}"
    if "most" in row:
        ratio, target, met = ours / plain, f"≤ {row['most']:g}", ours / plain <= row["most"]
    else:
        ratio = plain / ours
        target, met = (f"≥ {row['least']:g}", ratio >= row["least"]) if "least" in row else ("–", None)
    lines = [(row["row"], row["against"], row["figure"], f"**{ratio:.3g}**", target, _met(met), seconds)]
    if "most_seconds" in row:
        limit = row["most_seconds"]
        lines.append((row["row"], "–", "time", _seconds(ours), f"≤ {limit:g} s", _met(ours <= limit), "on one thread"))
    return lines


def _slopes(benchmarks: list[dict[str, Any]]) -> list[tuple[str, ...]]:
    """Slope of log time over log poses for each solver, by least squares."""
    lines = []
    for name in dict.fromkeys(each["extra_info"]["linear_cost"] for each in benchmarks):
        times = {
            each["extra_info"]["poses"]: each["stats"]["min"]
            for each in benchmarks
            if each["extra_info"]["linear_cost"] == name
        }
        logs = ([math.log(poses) for poses in times], [math.log(seconds) for seconds in times.values()])
        slope = statistics.linear_regression(*logs).slope
        lines.append(
            (
                f"(d) cost of {min(times):,} to {max(times):,} poses, {name}",
                "–",
                "slope of log time over log poses",
                f"**{slope:.3f}**",
                f"{SLOPE:.1f} ± {SLOPE_TOLERANCE}",
                _met(abs(slope - SLOPE) <= SLOPE_TOLERANCE),
                " … ".join(f"{1e6 * seconds / poses:.0f} µs" for poses, seconds in times.items()) + " a pose",
            )
        )
    return lines


def _memory(solver: str, shown: str) -> tuple[str, ...]:
    command = [sys.executable, "-m", "benchmarks.memory", solver, str(MILLION)]
    # Started from this small process: the peak a child reports includes its parent's at the fork.
    found = json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout)
    megabytes = found["megabytes"]
    return (
        f"(d) {MILLION:,} poses through {shown}, rotations kept",
        "–",
        "peak memory",
        f"**{megabytes:.0f} MB**",
        f"< {MOST_MEGABYTES / 1000:g} GB",
        _met(megabytes < MOST_MEGABYTES),
        _seconds(found["seconds"]),
    )


def _compiler() -> list[tuple[str, ...]]:
    """An empty cache first, then the same cache again."""
    command = [sys.executable, "-m", "benchmarks.compiler"]
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "NUMBA_CACHE_DIR": cache}
        compiling, cached = (
            json.loads(
                subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True, env=environment).stdout
            )
            for _ in range(2)
        )
    return [
        ("10,000 poses × 40 pins: numpy", _seconds(cached["plain"]), ""),
        *(
            (f"compiled, {name}", _seconds(cached[key]), f"**{cached['plain'] / cached[key]:.1f}**")
            for name, key in (("one thread", "alone"), ("all cores", "together"))
        ),
        ("import of numba", _seconds(cached["import"]), ""),
        ("first call in a process, from the cache", _seconds(cached["first"]), ""),
        ("first call ever, which compiles", _seconds(compiling["first"]), ""),
    ]


def _met(met: bool | None) -> str:
    return "–" if met is None else "yes" if met else "**no**"


def _seconds(value: float) -> str:
    return f"{1e3 * value:.3g} ms" if value < 1.0 else f"{value:.3g} s"


if __name__ == "__main__":
    main()
