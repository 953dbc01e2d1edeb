"""What a bench reads over a turn of the output: transmission error, lost motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .files import text
from .hidden import Hidden
from .loop import sensor, series
from .noise import Noise
from .reducer import Reducer
from .stage import Stage
from .units import ARCMIN, ARCSEC, DEGREE, NEWTON_METRE


def transmission_error(
    reducer: Reducer,
    effects: Sequence[Hidden] = (),
    *,
    torque_nm: float,
    rows: int = 3000,
    noise: Noise | None = None,
    seed: int = 0,
    stage: Stage | None = None,
) -> str:
    """File of kind ``transmission_error``, its mean taken off before the noise, in arc seconds.

    ``stage``, of the same reducer and effects, saves its clearances being found again.
    """
    noise = noise or Noise()
    stage = stage or Stage(reducer, tuple(effects))
    output = 2.0 * np.pi * np.arange(rows) / rows
    error = stage.twist(output, torque_nm * NEWTON_METRE) + sensor(effects, output)
    error = noise.read((error - np.mean(error)) / ARCSEC, np.random.default_rng(seed))
    keys: dict[str, object] = {"torque_nm": f"{torque_nm:.10g}"}
    if noise.declare:
        keys["noise_arcsec"] = f"{noise.sigma:g}"
    return text("transmission_error", keys, {"output_angle_deg": output / DEGREE, "error_arcsec": error})


def lost_motion(
    reducer: Reducer,
    effects: Sequence[Hidden] = (),
    *,
    torque_nm: float = 12.36,
    rows: int = 600,
    noise: Noise | None = None,
    seed: int = 0,
    stage: Stage | None = None,
) -> str:
    """File of kind ``lost_motion_map``: the angle at +torque minus that at −torque, noise in arc minutes."""
    noise = noise or Noise()
    stage = stage or Stage(reducer, tuple(effects))
    output = 2.0 * np.pi * np.arange(rows) / rows
    ahead, behind = (
        stage.twist(output, side * torque_nm * NEWTON_METRE) + series(effects, side * torque_nm * NEWTON_METRE)
        for side in (1.0, -1.0)
    )
    lost = noise.read((ahead - behind) / ARCMIN, np.random.default_rng(seed))
    keys: dict[str, object] = {"torque_nm": f"{torque_nm:.10g}"}
    if noise.declare:
        keys["noise_arcmin"] = f"{noise.sigma:g}"
    return text("lost_motion_map", keys, {"output_angle_deg": output / DEGREE, "lost_motion_arcmin": lost})
