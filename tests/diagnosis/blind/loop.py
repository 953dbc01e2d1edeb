"""What a bench reads with the input locked, the torque going up and down."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from .files import text
from .friction import left_over
from .hidden import Hidden, named
from .noise import Noise
from .reducer import Reducer
from .stage import Stage
from .units import ARCMIN, ARCSEC, DEGREE, NEWTON_METRE

Array = np.ndarray
# Below this share of the rated torque the stage floats and stays at the flank that it touched last.
_AFLOAT = 1e-4


def loop(
    reducer: Reducer,
    effects: Sequence[Hidden] = (),
    *,
    rows: int = 250,
    output_angle_deg: float = 0.0,
    peak_nm: float | None = None,
    friction_form: str = "coulomb",
    noise: Noise | None = None,
    seed: int = 0,
    stage: Stage | None = None,
) -> str:
    """File of kind ``hysteresis``: 0 → +T → −T → +T in even steps, noise in arc minutes.

    ``stage``, of the same reducer and effects, saves its clearances being found again.
    """
    noise = noise or Noise()
    stage = stage or Stage(reducer, tuple(effects))
    peak = reducer.rated_torque_nm if peak_nm is None else peak_nm
    torque = peak * NEWTON_METRE * _path(rows)
    left = left_over(
        torque,
        sum(one["torque_nm"] for one in named(effects, "coulomb_friction")) * NEWTON_METRE,
        sum(one["coefficient"] for one in named(effects, "load_proportional_friction")),
        friction_form,
    )
    output = output_angle_deg * DEGREE
    pressed = _pressed(left, _AFLOAT * reducer.rated_torque_nm * NEWTON_METRE, math.copysign(1.0, -peak))
    angle = stage.twist(output, pressed) + series(effects, left) + sensor(effects, np.asarray(output))
    for one in named(effects, "x_loop_creep"):
        angle = angle + one["amount_arcmin"] * ARCMIN * (1.0 - np.exp(-np.arange(torque.size) / one.get("rows", 80.0)))
    draw = np.random.default_rng(seed)
    keys: dict[str, object] = {"output_angle_deg": f"{output_angle_deg:.10g}", "input": "locked"}
    if noise.declare:
        keys["noise_arcmin"] = f"{noise.sigma:g}"
    read = noise.read(angle / ARCMIN, draw)
    return text("hysteresis", keys, {"torque_nm": torque / NEWTON_METRE, "angle_arcmin": read})


def series(effects: Sequence[Hidden], torque: Array) -> Array:
    """Twist of shafts, carrier and housing in series with the stage [rad]."""
    torque = np.asarray(torque, float)
    twist = np.zeros_like(torque)
    for one in named(effects, "series_compliance"):
        twist = twist + torque / _stiffness(one)
    for one in named(effects, "x_rate_stiffening"):
        # T = k θ (1 + (θ/θ0)²), with Cardano's root.
        bend = one["bend_arcmin"] * ARCMIN
        load = torque / _stiffness(one) / bend
        twist = twist + bend * 2.0 / math.sqrt(3.0) * np.sinh(np.arcsinh(1.5 * math.sqrt(3.0) * load) / 3.0)
    return twist


def _stiffness(one: Hidden) -> float:
    return one["stiffness_nm_per_arcmin"] * NEWTON_METRE / ARCMIN


def sensor(effects: Sequence[Hidden], output: Array) -> Array:
    """What the encoder reads too much at an output angle [rad]."""
    error = np.zeros_like(output)
    for one in named(effects, "encoder_eccentricity", "x_te_order7"):
        order = 7.0 if one.name == "x_te_order7" else 1.0
        error = error + one["amplitude_arcsec"] * ARCSEC * np.cos(order * output - one.get("phase_deg") * DEGREE)
    return error


def _path(rows: int) -> Array:
    """0 → 1 → −1 → 1 in about so many rows, each turn of the torque read once."""
    quarter = max(round((rows - 1) / 5.0), 1)
    return np.interp(np.arange(5 * quarter + 1) / quarter, [0.0, 1.0, 3.0, 5.0], [0.0, 1.0, -1.0, 1.0])


def _pressed(left: Array, least: float, before: float) -> Array:
    """The torque of the stage, or the least one on the flank of the last touch."""
    pressed, side = left.copy(), before
    for i, torque in enumerate(left):
        if abs(torque) < least:
            pressed[i] = side * least
        else:
            side = math.copysign(1.0, torque)
    return pressed
