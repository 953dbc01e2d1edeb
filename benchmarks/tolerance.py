"""Two hundred thousand reducers, and four thousand under load: ``python -m benchmarks.tolerance``, some minutes.

Each quantity runs in a process of its own, so that its peak memory is its own. Both sides of a ratio run in turn in one
process, three times; the plain side on fewer reducers, scaled.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np

from benchmarks.document import machine, put, table
from benchmarks.rv40e import loaded_rv40e
from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.effects import AsBuiltReducer, as_drawn
from cycloid_profile.tolerance.inputs import Tolerances, tolerances_of
from cycloid_profile.tolerance.model._crank_locked import CrankLockedBacklash
from cycloid_profile.tolerance.model.quantities import BacklashQuantities, LostMotionQuantities
from cycloid_profile.tolerance.study import Draws, Study, run
from cycloid_profile.units import ARCMIN

HEAD = ("what", "against", "figure", "measured", "target", "met", "for information")
PINS = (
    {"name": "single_pin_error", "each": "pin", "amount_um": {"plus_minus": 1.0}},
    {"name": "pin_position_error", "each": "pin", "amplitude_um": {"plus_minus": 3.0}},
)
BACKLASH, LOST_MOTION = 200_000, 4_000
LOOPED, SOLVED, REPEATS = 40, 2, 3


def study(quantity: str, samples: int) -> Study:
    """Reducers whose 40 pins each have a radius and a place of their own."""
    reducer = as_drawn(loaded_rv40e())
    chunk = 4096 if quantity == "backlash_arcmin" else 256
    return Study(reducer, Draws(tolerances_of(PINS, (), reducer)), (quantity,), samples, chunk)


def one_by_one(stage: CrankLockedBacklash, draws: Draws, z: FloatArray) -> tuple[FloatArray, float]:
    """Largest backlash at the poses of each reducer in plain numpy, one after the other [rad]; and its seconds."""
    matrix = stage.by_unit.toarray().reshape(*stage.base.shape, -1)
    begin, found = perf_counter(), np.empty(len(z))
    for i, one in enumerate(z):
        (x,) = draws.from_normals(one[np.newaxis])
        least = np.min(stage.base + matrix @ x, axis=0)
        found[i] = np.max(least[: stage.poses] + least[stage.poses :])
    return found, perf_counter() - begin


def exactly(reducer: AsBuiltReducer, tolerances: Tolerances, x: FloatArray, stage: LostMotionQuantities) -> FloatArray:
    """Largest lost motion of each reducer by the exact stage, its parts built one by one [′]."""
    found = np.empty(len(x))
    for i, one in enumerate(x):
        made, at = reducer, 0
        for scatter in tolerances.scatters:
            for choice in scatter.choices:
                own = one[at : at + scatter.axes.count]
                made = scatter.axes.effect(own, choice).apply(made)
                at += scatter.axes.count
        solved = StageEquilibrium(deviations=made.deviations).at(
            made.case, stage.stage.crank_angle, stage.stage.energy.torque
        )
        there, back = np.split(solved.rotation, 2)
        found[i] = np.max(there - back) / ARCMIN
    return found


def measured(quantity: str, samples: int) -> dict[str, list[float]]:
    """Seconds of a study with its answers on disk, and of the plain method for as many; and the peak memory."""
    whole = study(quantity, samples)
    (answers,) = whole.quantity_model.answers
    whole.values(0)  # compiled code is loaded
    x = whole.coordinates(0)
    seconds, plain, peak = [], [], 0.0
    for _ in range(REPEATS):
        begin = perf_counter()
        with tempfile.TemporaryDirectory() as folder:
            run(whole, Path(folder))
            seconds.append(perf_counter() - begin)
        # The plain method may take more memory than the study.
        peak = peak or resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (
            1e6 if sys.platform == "darwin" else 1e6 / 1024
        )
        if isinstance(answers, BacklashQuantities):
            found, took = one_by_one(answers.backlash, whole.draws, whole.draws.normals(0, whole.chunk, 0)[:LOOPED])
            # Between its poses the largest is never less.
            assert np.allclose(found, np.max(answers.backlash.by_pose(x[:LOOPED]), axis=1), atol=1e-12)
            assert np.all(answers.of(x[:LOOPED])[:, 0] > found / ARCMIN - 1e-4)
            plain.append(took * samples / LOOPED)
        else:
            assert isinstance(answers, LostMotionQuantities)
            begin = perf_counter()
            found = exactly(whole.reducer, whole.tolerances, x[:SOLVED], answers)
            plain.append((perf_counter() - begin) * samples / SOLVED)
            # The pose of largest lost motion is among the chosen ones, or close to one.
            assert np.allclose(found, answers.of(x[:SOLVED])[:, 0], atol=0.01)
    return {"seconds": seconds, "plain": plain, "megabytes": [peak]}


def main() -> None:
    rows = []
    for quantity, samples, most, against, least in (
        ("backlash_arcmin", BACKLASH, 2.0, "a plain numpy loop: sizes and touch at the poses, one by one", 50.0),
        ("lost_motion_arcmin", LOST_MOTION, 12.0, "`StageEquilibrium` at all poses, reducer by reducer", None),
    ):
        command = [sys.executable, "-m", "benchmarks.tolerance", quantity, str(samples)]
        result = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        what = f"{quantity.rsplit('_', 1)[0].replace('_', ' ')} of {samples:,} reducers, 40 pins each with 3 errors"
        seconds, (memory,) = result["seconds"], result["megabytes"]
        ratios = [plain / ours for plain, ours in zip(result["plain"], seconds, strict=True)]
        rows.append((what, "–", "time", _spread(seconds, " s"), f"≤ {most:g} s", _met(np.median(seconds) <= most),
                     "answers written as they come"))  # fmt: skip
        target, met = ("–", "–") if least is None else (f"≥ {least:g}", _met(np.median(ratios) >= least))
        note = f"{np.median(result['plain']):.0f} s, scaled from {LOOPED if least else SOLVED} reducers"
        rows.append((what, against, "plain / ours", _spread(ratios), target, met, note))
        rows.append((what, "–", "peak memory", f"**{memory:.0f} MB**", "≤ 1 GB", _met(memory <= 1000.0), ""))
    put("tolerance", f"{machine(('numpy', 'scipy', 'numba'))}\n\n{table(HEAD, rows)}")


def _spread(values: list[float], unit: str = "") -> str:
    """Median and range."""
    return f"**{np.median(values):.3g}{unit}** ({min(values):.3g} to {max(values):.3g})"


def _met(met: bool | np.bool_) -> str:
    return "yes" if met else "**no**"


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(json.dumps(measured(sys.argv[1], int(sys.argv[2]))))
    else:
        main()
