"""Extremes over a turn against 4,999 poses: ``python -m benchmarks.extremes [SPEC] [REDUCERS]``, some minutes.

The same reducers twice: as a study computes them, and at 4,999 poses one after the other. Under load a fiftieth of the
reducers, at 1,567 poses.
"""

from __future__ import annotations

import sys

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.design.from_spec import as_built_reducer
from cycloid_profile.design.tolerance_analysis import spec_limits, spec_tolerances
from cycloid_profile.spec import read_spec
from cycloid_profile.tolerance.inputs import Limit, within
from cycloid_profile.tolerance.model import QUANTITIES, QuantityModel, unit_changes
from cycloid_profile.tolerance.model._crank_locked import crank_locked_backlash
from cycloid_profile.tolerance.model._loaded import loaded_stage
from cycloid_profile.tolerance.model.quantities import lost_motion_loads, rated_loads
from cycloid_profile.tolerance.study import Draws
from cycloid_profile.units import ARCMIN, ARCSEC

POSES, LOADED_POSES, BLOCK = 4999, 1567, 64


def main(path: str, reducers: int) -> None:
    spec = read_spec(path)
    reducer = as_built_reducer(spec)
    tolerances, limits = spec_tolerances(spec, reducer), spec_limits(spec)
    changes = unit_changes(reducer, tolerances)
    draws = Draws(tolerances, spec.tolerance.seed)
    x = np.concatenate([draws.coordinates(n, 4096, 4096 * n) for n in range(-(-reducers // 4096))])[:reducers]
    names = ("backlash_arcmin", "least_backlash_arcmin")
    dense = crank_locked_backlash(reducer, changes, POSES)
    wanted = np.empty((reducers, 2))
    for at in range(0, reducers, BLOCK):
        poses = dense.by_pose(x[at : at + BLOCK]) / ARCMIN
        wanted[at : at + BLOCK] = np.stack([np.max(poses, axis=1), np.min(poses, axis=1)], axis=1)
    compared(names, limits, QuantityModel(reducer, changes, names).of(x), wanted)
    some, names = x[: reducers // 50], tuple(QUANTITIES)[2:]
    light = loaded_stage(reducer, changes, *lost_motion_loads(reducer, LOADED_POSES))
    there, back = np.split(light.answers(some)[0], 2, axis=1)
    rotation, pressure = loaded_stage(reducer, changes, *rated_loads(reducer, LOADED_POSES)).answers(some)
    loaded = np.stack(
        [np.max(there - back, axis=1) / ARCMIN, np.ptp(rotation, axis=1) / ARCSEC, np.max(pressure, axis=1)], axis=1
    )
    compared(names, limits, QuantityModel(reducer, changes, names).of(some), loaded)


def compared(names: tuple[str, ...], limits: tuple[Limit, ...], found: FloatArray, wanted: FloatArray) -> None:
    """Print means, differences and yields."""
    for name, ours, dense in zip(names, found.T, wanted.T, strict=True):
        off = ours - dense
        print(f"{name}: mean {np.mean(ours):.4f}, dense {np.mean(dense):.4f}, off {np.mean(off):+.4f}, "
              f"rms {np.sqrt(np.mean(off**2)):.4f}, at most {np.max(np.abs(off)):.4f}")  # fmt: skip
    known = [limit for limit in limits if limit.quantity in names]
    for some in [*([one] for one in known), known]:
        shares = [100.0 * np.mean(within(values, names, some)) for values in (found, wanted)]
        print(f"{', '.join(map(str, some))}: {shares[0]:.2f} %, dense {shares[1]:.2f} % ({len(found)} reducers)")


if __name__ == "__main__":
    main(
        sys.argv[1] if len(sys.argv) > 1 else "examples/rv40e_tolerances.toml",
        int(sys.argv[2]) if len(sys.argv) > 2 else 10_000,
    )
