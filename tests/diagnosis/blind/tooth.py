"""The tooth of one disc as it was ground: the path of the wheel's centre, and the wheel's radius inwards from it.

Normals are those of a complex step, (x, y)(ψ + iε)/ε: nothing is derived by hand.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .hidden import Hidden, named
from .reducer import Reducer
from .removals import removal
from .units import DEGREE, UM

Array = np.ndarray
EXPANSION = 11.5e-6  # steel, 1/K
_STEP = 1e-30


def path(circle: float, eccentricity: float, pins: int, psi: Array) -> tuple[Array, Array]:
    """Centre of the generating wheel seen from the disc, x and y; real or complex phases."""
    slow, fast = psi / (pins - 1), psi * (pins / (pins - 1))
    return circle * np.cos(slow) - eccentricity * np.cos(fast), eccentricity * np.sin(fast) - circle * np.sin(slow)


@dataclass(frozen=True)
class Tooth:
    """Tooth of disc number ``disc``: its setting on the machine, what departs from it, where it was moved to."""

    reducer: Reducer
    effects: tuple[Hidden, ...]
    disc: int
    circle: float
    eccentricity: float
    wheel: float
    growth: float
    moved: complex

    def points(self, psi: Array) -> Array:
        """Points x + iy of the tooth at the phases, bore axis as origin [mm]."""
        x, y = path(self.circle, self.eccentricity, self.reducer.pins, psi + 1j * _STEP)
        tangent = (x.imag + 1j * y.imag) / np.hypot(x.imag, y.imag)
        outwards = 1j * tangent  # ψ runs clockwise
        K1 = self.eccentricity * self.reducer.pins / self.circle
        depth = self.wheel + removal(self.reducer, self.effects, self.disc, K1, psi)
        return self.growth * (x.real + 1j * y.real - depth * outwards) + self.moved


def ground(reducer: Reducer, effects: Sequence[Hidden], disc: int) -> Tooth:
    """The tooth of disc number ``disc``, counted from 1."""
    here = tuple(one for one in effects if one.on("disc", disc))

    def total(name: str, key: str) -> float:
        return sum(one[key] for one in named(here, name))

    infeed = reducer.radial_moving_um + total("radial_moving_error", "amount_um")
    moved = 0j
    for one in named(here, "disc_runout"):
        if one.get("form", 1.0) == 1.0:
            mounted = 0.0 if one.number("disc") else 2.0 * math.pi * (disc - 1) / (reducer.discs * reducer.lobes)
            moved += one["amplitude_um"] * UM * np.exp(1j * (one.get("phase_deg") * DEGREE + mounted))
    return Tooth(
        reducer,
        here,
        disc,
        reducer.pin_circle_radius_mm - infeed * UM,
        reducer.eccentricity_mm + total("generating_eccentricity_error", "amount_um") * UM,
        reducer.pin_radius_mm + (reducer.equidistant_um + total("equidistant_error", "amount_um")) * UM,
        1.0 + EXPANSION * total("thermal_growth", "temperature_k"),
        complex(moved),
    )
