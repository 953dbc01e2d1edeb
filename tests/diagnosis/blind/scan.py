"""What a measuring machine reads of one disc."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import numpy as np

from .files import text
from .hidden import Hidden
from .noise import Noise
from .reducer import Reducer
from .tooth import ground
from .units import DEGREE, UM

_PER_LOBE = 400


def scan(
    reducer: Reducer,
    effects: Sequence[Hidden] = (),
    *,
    points: int = 5000,
    disc: int = 1,
    noise: Noise | None = None,
    turn_deg: float = 0.0,
    offset_um: tuple[float, float] = (0.0, 0.0),
    datum: str = "bore",
    missing_lobes: Collection[int] = (),
    anticlockwise: bool = False,
    seed: int = 0,
) -> str:
    """File of kind ``profile_scan``: points of equal arc from the root of lobe 1, clockwise or not, in µm of noise.

    ``turn_deg`` is the angular zero and ``offset_um`` the origin of the machine, which the reader does not know.
    Lobes are counted from 1, clockwise; the missing ones were not measured.
    """
    noise = noise or Noise()
    tooth = ground(reducer, effects, disc)
    fine = np.linspace(0.0, reducer.period, _PER_LOBE * reducer.lobes + 1)
    arc = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(tooth.points(fine))))])
    psi = np.interp(np.linspace(0.0, arc[-1], points, endpoint=False), arc, fine)
    z = tooth.points(psi)
    lobe = np.mod(np.round(psi / (2.0 * math.pi)).astype(int), reducer.lobes) + 1
    z = z[~np.isin(lobe, list(missing_lobes))]
    z = z * np.exp(1j * turn_deg * DEGREE) + complex(*offset_um) * UM
    z = z[::-1] if anticlockwise else z
    draw = np.random.default_rng(seed)
    x, y = (noise.read(column, draw, UM) for column in (z.real, z.imag))
    keys: dict[str, object] = {"datum": datum, "specimen": f"disc {disc}"}
    if noise.declare:
        keys["noise_um"] = f"{noise.sigma:g}"
    return text("profile_scan", keys, {"x_mm": x, "y_mm": y})
