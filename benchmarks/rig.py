"""What the rig takes to read a reducer, against a plain loop: ``python -m benchmarks.rig``, two minutes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np

from benchmarks.document import machine, put, table
from benchmarks.rv40e import loaded_rv40e
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.design import as_built_reducer
from cycloid_profile.effects import AsBuiltReducer, as_drawn, effect_from_table
from cycloid_profile.rig import Settings, simulate
from cycloid_profile.spec import read_spec

ROOT = Path(__file__).parents[1]
ROUNDS = 3
RUNOUT = {"name": "disc_runout", "amplitude_um": 3.0, "phase_deg": 40.0, "disc": 1}
POSES, TORQUES, POINTS = 60, 40, 500
HEAD = ("what", "aim", "as drawn", "disc 1 with runout", "compensated", "both")

Work = Callable[[], object]


def ratio(ours: Work, plain: Work, times: float) -> str:
    """Least time of a loop, run on a part and scaled, over ours; both by turns."""
    ours()
    each = [(_seconds(ours), times * _seconds(plain)) for _ in range(ROUNDS)]
    mine, loop = (min(side) for side in zip(*each, strict=True))
    return f"**{loop / mine:.0f}** ({mine:.2g} s)"


def _seconds(work: Work) -> float:
    start = perf_counter()
    work()
    return perf_counter() - start


def turn(reducer: AsBuiltReducer) -> str:
    """Transmission error at 3,000 poses."""
    rows = 3000
    crank = np.random.default_rng(1).uniform(0.0, 2.0 * np.pi, POSES) * reducer.case.drive.trochoid.lobes
    at = StageEquilibrium(deviations=reducer.deviations).at
    settings = Settings(points=rows)
    return ratio(
        lambda: simulate(reducer, "transmission_error", settings),
        lambda: [at(reducer.case, np.array([one])) for one in crank],
        rows / POSES,
    )


def loop(reducer: AsBuiltReducer) -> str:
    """A hysteresis loop of 400 points."""
    rows = 400
    torques = np.random.default_rng(2).uniform(0.05, 1.0, TORQUES) * reducer.case.torque
    at = StageEquilibrium(deviations=reducer.deviations).at
    settings = Settings(points=rows)
    return ratio(
        lambda: simulate(reducer, "hysteresis", settings),
        lambda: [at(replace(reducer.case, torque=float(one)), np.zeros(1)) for one in torques],
        rows / TORQUES,
    )


def scan(reducer: AsBuiltReducer) -> str:
    """A scan of 5,000 points."""
    rows = 5000
    tooth = reducer.teeth[0]
    psi = np.random.default_rng(3).uniform(-np.pi, np.pi, (POINTS, 1))
    lobe = None if tooth.identical_lobes else np.zeros(1)
    settings = Settings(points=rows)
    return ratio(
        lambda: simulate(reducer, "profile_scan", settings), lambda: [tooth.at(one, None, lobe) for one in psi],
        rows / POINTS,
    )  # fmt: skip


def main() -> None:
    drawn = as_drawn(loaded_rv40e())
    compensated = as_built_reducer(read_spec(ROOT / "examples" / "rv40e.toml"))
    runout = effect_from_table(RUNOUT)
    reducers = [drawn, runout.apply(drawn), compensated, runout.apply(compensated)]
    rows = [
        (what, aim, *(measured(reducer) for reducer in reducers))
        for what, aim, measured in (
            ("transmission error, 3,000 poses", "≤ 2 s", turn),
            ("hysteresis loop, 400 points", "≤ 0.2 s", loop),
            ("profile scan, 5,000 points", "≤ 0.05 s", scan),
        )
    ]
    put("time", f"{machine()}\n\n{table(HEAD, rows)}", ROOT / "docs" / "rig.md")


if __name__ == "__main__":
    main()
