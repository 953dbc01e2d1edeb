"""Peak memory of poses streamed in blocks, only the rotation kept: ``python -m benchmarks.memory stage 1000000``.

A process of its own, because the peak of a process never comes down again.
"""

from __future__ import annotations

import json
import resource
import sys
from time import perf_counter

import numpy as np

import cycloid_profile as cp
from benchmarks.rv40e import loaded_rv40e

SOLVERS: dict[str, cp.Equilibrium | cp.StageEquilibrium] = {
    "equilibrium": cp.Equilibrium(),
    "stage": cp.StageEquilibrium(),
}


def main(solver: str, poses: int) -> None:
    case = loaded_rv40e()
    begin = perf_counter()
    crank_angle = cp.output_turn(case.drive.trochoid, poses)
    rotation = np.concatenate([block.rotation for block in SOLVERS[solver].blocks(case, crank_angle)])
    seconds = perf_counter() - begin
    assert rotation.shape == (poses,)
    assert np.all(np.isfinite(rotation))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss  # KiB; bytes on macOS
    megabytes = peak / (1e6 if sys.platform == "darwin" else 1e6 / 1024)
    print(json.dumps({"seconds": seconds, "megabytes": megabytes}))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
