"""A million reducers, and twenty thousand under load: ``python -m benchmarks.tolerance``, a minute and a half.

Each study runs in a process of its own, so that its peak memory is its own. Both sides of a ratio run in turn in one
process; the plain side on fewer reducers, scaled.
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
BACKLASH, LOST_MOTION = 1_000_000, 20_000
LOOPED, SOLVED = 400, 12


def study(quantity: str, samples: int) -> Study:
    """Reducers whose 40 pins each have a radius and a place of their own."""
    reducer = as_drawn(loaded_rv40e())
    chunk = 4096 if quantity == "backlash_arcmin" else 256
    return Study(reducer, Draws(tolerances_of(PINS, (), reducer)), (quantity,), samples, chunk)


def one_by_one(stage: CrankLockedBacklash, draws: Draws, z: FloatArray) -> FloatArray:
    """Largest backlash of each reducer in plain numpy, drawn and touched one after the other [rad]."""
    matrix = stage.by_unit.toarray().reshape(*stage.base.shape, -1)
    found = np.empty(len(z))
    for i, one in enumerate(z):
        (x,) = draws.from_normals(one[np.newaxis])
        least = np.min(stage.base + matrix @ x, axis=0)
        found[i] = np.max(least[: stage.poses] + least[stage.poses :])
    return found


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


def measured(quantity: str, samples: int) -> dict[str, float]:
    """Seconds and peak memory of a study, answers on disk; and its speed against the plain method."""
    whole = study(quantity, samples)
    (answers,) = whole.quantity_model.answers
    whole.values(0)  # compiled code is loaded
    begin = perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        run(whole, Path(folder))
        seconds = perf_counter() - begin
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1e6 if sys.platform == "darwin" else 1e6 / 1024)
    x = whole.coordinates(0)
    if isinstance(answers, BacklashQuantities):
        some = x[:LOOPED]
        z = whole.draws.normals(0, whole.chunk, 0)[:LOOPED]
        begin = perf_counter()
        plain = one_by_one(answers.backlash, whole.draws, z) / ARCMIN
        each = (perf_counter() - begin) / len(some)
        assert np.allclose(plain, answers.of(some)[:, 0], atol=1e-9)
    else:
        assert isinstance(answers, LostMotionQuantities)
        some = x[:SOLVED]
        begin = perf_counter()
        plain = exactly(whole.reducer, whole.tolerances, some, answers)
        each = (perf_counter() - begin) / len(some)
        assert np.allclose(plain, answers.of(some)[:, 0], atol=1e-3)
    return {"seconds": seconds, "megabytes": peak, "ratio": each * samples / seconds, "plain": each * samples}


def main() -> None:
    rows = []
    for quantity, samples, most, against, least in (
        ("backlash_arcmin", BACKLASH, 10.0, "a plain numpy loop: sizes and touch reducer by reducer", 50.0),
        ("lost_motion_arcmin", LOST_MOTION, 60.0, "`StageEquilibrium`, reducer by reducer, all parts built", None),
    ):
        command = [sys.executable, "-m", "benchmarks.tolerance", quantity, str(samples)]
        result = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        what = f"{quantity.rsplit('_', 1)[0].replace('_', ' ')} of {samples:,} reducers, 40 pins each with 3 errors"
        note = f"{result['megabytes']:.0f} MB at most, answers written as they come"
        rows.append(
            (
                what,
                "–",
                "time",
                f"**{result['seconds']:.1f} s**",
                f"≤ {most:g} s",
                _met(result["seconds"] <= most),
                note,
            )
        )
        target, met = ("–", "–") if least is None else (f"≥ {least:g}", _met(result["ratio"] >= least))
        note = f"{result['plain']:.0f} s, scaled from {LOOPED if least else SOLVED} reducers"
        rows.append((what, against, "plain / ours", f"**{result['ratio']:.0f}**", target, met, note))
        rows.append((what, "–", "peak memory", f"**{result['megabytes']:.0f} MB**", "≤ 1 GB",
                     _met(result["megabytes"] <= 1000.0), ""))  # fmt: skip
    put("tolerance", f"{machine(('numpy', 'scipy', 'numba'))}\n\n{table(HEAD, rows)}")


def _met(met: bool) -> str:
    return "yes" if met else "**no**"


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(json.dumps(measured(sys.argv[1], int(sys.argv[2]))))
    else:
        main()
