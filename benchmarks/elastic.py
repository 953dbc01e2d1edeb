"""What elastic discs take against rigid ones: ``python -m benchmarks.elastic``, five minutes.

The same work with either body, in turn and several times. A ratio is the median of those of each round, with their
range.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import process_time

from benchmarks.document import machine, put, table
from cycloid_profile.contact.mesh import output_turn
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.design import as_built_reducer, tolerance_record, with_tolerance_values
from cycloid_profile.diagnosis import diagnose
from cycloid_profile.effects import AsBuiltReducer, effect_from_table
from cycloid_profile.rig import Settings, simulate
from cycloid_profile.spec import read_spec
from cycloid_profile.tolerance import Threads

ROOT = Path(__file__).parents[1]
HEAD = ("what", "elastic / rigid, median (range)", "target", "met", "elastic", "rigid")
BODIES = ("elastic", "rigid")
POSES = 3000
HIDDEN = {"name": "disc_runout", "amplitude_um": 3.0, "phase_deg": 40.0, "disc": 1}

Work = Callable[[], object]


def row(what: str, works: dict[str, Work], target: float, rounds: int) -> tuple[str, ...]:
    """One line of the table: each work once for its caches and compiled code, then both in turn."""
    for work in works.values():
        work()
    each = [[_seconds(works[body]) for body in BODIES] for _ in range(rounds)]
    ratios = [elastic / rigid for elastic, rigid in each]
    middle = median(ratios)
    times = (f"{median(side):.3g} s" for side in zip(*each, strict=True))
    found = f"**{middle:.2f}** ({min(ratios):.2f} to {max(ratios):.2f}, {rounds} rounds)"
    return what, found, f"≤ {target:g}", "yes" if middle <= target else "**no**", *times


def _seconds(work: Work) -> float:
    """Processor time of all threads: other work on the machine lengthens the other time several times."""
    begin = process_time()
    work()
    return process_time() - begin


def reducer(body: str) -> AsBuiltReducer:
    """The RV-40E of the examples with Weber–Banaschek's law in both bodies, so that only the body differs."""
    spec = read_spec(ROOT / "examples" / "rv40e.toml")
    return as_built_reducer(spec.replace("load.contact_law", "weber-banaschek").replace("load.disc_body", body))


def turn(body: str) -> Work:
    """A turn of the output at rated torque."""
    case = reducer(body).case
    poses = output_turn(case.drive.trochoid, POSES)
    return lambda: StageEquilibrium().at(case, poses)


def bench(body: str) -> Work:
    """A diagnosis of three files of a bench with a runout of disc 1."""
    nominal = reducer(body)
    hidden = effect_from_table(HIDDEN).apply(nominal)
    kinds = {"hysteresis": 200, "transmission_error": 600, "lost_motion_map": 300}
    files = [simulate(hidden, kind, Settings(points=points, noise=0.02)) for kind, points in kinds.items()]
    return lambda: diagnose(nominal, files)


def study(body: str) -> Work:
    """A tolerance study of a thousand loaded reducers."""
    spec = read_spec(ROOT / "examples" / "rv40e_tolerances.toml")
    spec = with_tolerance_values(spec, {"samples": 2000, "loaded_samples": 1000})
    spec = spec.replace("load.contact_law", "weber-banaschek").replace("load.disc_body", body)

    def run() -> None:
        with tempfile.TemporaryDirectory() as folder:
            tolerance_record(spec, Path(folder) / "study", Threads())

    return run


FRESH = """
from pathlib import Path
from time import perf_counter
from benchmarks.elastic import reducer
reducer("rigid")
begin = perf_counter()
reducer("elastic")
print(perf_counter() - begin)
"""


def condensation() -> tuple[str, ...]:
    """Both discs of the RV-40E in a process with an empty cache."""
    seconds = []
    for _ in range(3):
        with tempfile.TemporaryDirectory() as folder:
            environment = os.environ | {"XDG_CACHE_HOME": folder}
            run = subprocess.run([sys.executable, "-c", FRESH], cwd=ROOT, env=environment, check=True, stdout=-1)
            seconds.append(float(run.stdout))
    middle = median(seconds)
    text = f"{middle:.3g} s ({min(seconds):.3g} to {max(seconds):.3g})"
    return "condensation of both discs, empty cache", "–", "≤ 5 s", "yes" if middle <= 5.0 else "**no**", text, "–"


def memory() -> tuple[str, ...]:
    """Peak of numpy's memory for a number of poses and four times as many."""
    peaks = []
    case = reducer("elastic").case
    for poses in (POSES, 4 * POSES):
        tracemalloc.start()
        StageEquilibrium().at(case, output_turn(case.drive.trochoid, poses))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    growth = peaks[1] / peaks[0]
    what = f"memory of {4 * POSES:,} over {POSES:,} poses, results kept"
    met = "yes" if growth <= 4.0 else "**no**"
    return what, f"**{growth:.2f}**", "≤ 4", met, f"{peaks[0] / 1e6:.0f} MB, {peaks[1] / 1e6:.0f} MB", "–"


def main() -> None:
    rows = [
        row(f"whole stage, {POSES:,} poses", {body: turn(body) for body in BODIES}, 5.0, 9),
        condensation(),
        memory(),
        row("tolerance study, 1,000 loaded reducers", {body: study(body) for body in BODIES}, 1.5, 5),
        row("diagnosis of three files of a bench", {body: bench(body) for body in BODIES}, 1.5, 3),
    ]
    put("elastic", f"{machine()}\n\n{table(HEAD, rows)}", ROOT / "docs" / "benchmarks.md")


if __name__ == "__main__":
    main()
