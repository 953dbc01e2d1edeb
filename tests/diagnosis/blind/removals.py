"""Removals along the normal, h(ψ) [mm], that do not come from the setting of the machine.

Parameters that begin with ``x_`` give a removal another shape than the package's; without them it has that one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from .hidden import Hidden
from .reducer import Reducer
from .units import DEGREE, UM
from .wear import wear_shape

Array = np.ndarray
# A lobe that differs from its neighbours runs into them round the tips, over so many rad of ψ to either side.
TIP_BLEND = 0.5


@dataclass(frozen=True)
class Blank:
    """What a removal is made on: disc ``mounted`` so far behind the first [rad], of short-width ratio ``K1``."""

    reducer: Reducer
    mounted: float
    K1: float

    def along(self, psi: Array) -> Array:
        """Angle along the disc from where disc 1 has its first root, clockwise [rad]."""
        return psi / self.reducer.lobes + self.mounted

    def flank(self, sine: Array, psi: Array) -> Array:
        """sinψ S, the motion of the flank along its normal as the disc turns, 1 at its most."""
        return sine / np.sqrt(1.0 + self.K1 * self.K1 - 2.0 * self.K1 * np.cos(psi))

    def clock(self, kind: str, psi: Array) -> Array:
        """``along`` by another clock of the machine: "generating" angle, "polar" angle or "arc" length of the tooth."""
        if kind == "generating":
            return self.along(psi)
        x = np.linspace(-math.pi, math.pi, 2001)
        ahead = _gained(self.reducer, kind, x)
        return self.along(psi) + np.interp(_wrapped(psi, 2.0 * math.pi), x, ahead)


def removal(reducer: Reducer, effects: Iterable[Hidden], disc: int, K1: float, psi: Array) -> Array:
    """All removals of disc number ``disc`` at the phases ``psi``, the compensation of the drawing included."""
    h = -reducer.compensation_um * UM * Blank(reducer, 0.0, K1).flank(np.abs(np.sin(psi)), psi)
    for one in effects:
        if one.name in SHAPES and one.on("disc", disc):
            # An effect of all discs is equal in the frame of the carrier.
            mounted = 0.0 if one.number("disc") else 2.0 * math.pi * (disc - 1) / (reducer.discs * reducer.lobes)
            h = h + SHAPES[one.name](Blank(reducer, mounted, K1), one, psi)
    return h


def _wrapped(x: Array, period: float) -> Array:
    """x brought between −period/2 and period/2."""
    return x - period * np.round(x / period)


def _gained(reducer: Reducer, kind: str, psi: Array) -> Array:
    """How far polar angle or arc length of the drawn tooth, scaled to a turn, is ahead of ψ/z_c within a lobe [rad]."""
    r = reducer
    slow, fast = psi / r.lobes, psi * (r.pins / r.lobes)
    centre = r.pin_circle_radius_mm * np.exp(-1j * slow) - r.eccentricity_mm * np.exp(-1j * fast)
    # The normal points from the instant centre, a z_c from the middle.
    normal = centre - r.eccentricity_mm * r.lobes * np.exp(-1j * fast)
    z = centre - r.pin_radius_mm * normal / np.abs(normal)
    if kind == "polar":
        return -np.unwrap(np.angle(z)) - slow
    if kind == "arc":
        arc = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(z)))])
        return (arc / arc[-1] - 0.5) * 2.0 * math.pi / r.lobes - slow
    raise ValueError(f"clock '{kind}' is not known; choose generating, polar or arc")


def _smooth(x: Array) -> Array:
    """From 0 below −1 to 1 above 1, smoothly to the second derivative."""
    x = np.clip(x, -1.0, 1.0)
    return 0.5 + x * (15.0 - 10.0 * x**2 + 3.0 * x**4) / 16.0


def _runout_by_angle(blank: Blank, one: Hidden, psi: Array) -> Array:
    if one.get("form", 1.0) == 1.0:  # the tooth is moved as a whole, see tooth.py
        return np.zeros_like(psi)
    return -one["amplitude_um"] * UM * np.cos(blank.along(psi) + one.get("phase_deg") * DEGREE)


def _oval(blank: Blank, one: Hidden, psi: Array) -> Array:
    return -one["amplitude_um"] * UM * np.cos(2.0 * (blank.along(psi) + one.get("phase_deg") * DEGREE))


def _pitch(blank: Blank, one: Hidden, psi: Array) -> Array:
    wave = np.cos(blank.along(psi) - one.get("phase_deg") * DEGREE)
    return -one["amplitude_um"] * UM * blank.flank(np.sin(psi), psi) * wave


def _wheel_wear(blank: Blank, one: Hidden, psi: Array) -> Array:
    # The tip before the first lobe, or beyond it where the wheel came to the disc elsewhere.
    start = 2.0 * math.pi * (one.number("first_lobe") - 1) - math.pi + one.get("x_start_rad")
    ground = np.mod(psi - start, blank.reducer.period) / blank.reducer.period
    past = _wrapped(psi - start, blank.reducer.period)
    # The saw jumps at the tip; a blended step takes the place of the sharp one.
    jump = _smooth(past / one.get("x_blend_rad", TIP_BLEND)) - (past >= 0.0)
    return -one["amount_um"] * UM * (ground - jump)


def _chatter(blank: Blank, one: Hidden, psi: Array) -> Array:
    # A number of waves that does not come out even: the last one gives way to the first round the tip before lobe 1.
    period = blank.reducer.period
    past = _wrapped(psi + math.pi, period)
    new = _smooth(past / one.get("x_blend_rad", TIP_BLEND))
    clock = str(one.parameters.get("x_clock", "generating"))
    waves = 0.0
    for share, at in ((new, past - math.pi), (1.0 - new, past - math.pi + period)):
        turned = one["waves_per_turn"] * blank.clock(clock, at) - one.get("phase_deg") * DEGREE
        waves = waves + share * np.cos(turned)
    return one["amplitude_um"] * UM * waves


def _no_compensation(blank: Blank, one: Hidden, psi: Array) -> Array:
    return one["amount_um"] * UM * blank.flank(np.abs(np.sin(psi)), psi)


def _flank_wear(blank: Blank, one: Hidden, psi: Array) -> Array:
    side = 1.0 if one.get("flank", 1.0) == 1.0 else -1.0
    if "x_exponent" in one.parameters:
        lever = np.maximum(blank.flank(side * np.sin(psi), psi), 0.0)
        return one["amount_um"] * UM * lever ** one["x_exponent"]
    where, depth = wear_shape(blank.reducer)
    return one["amount_um"] * UM * np.interp(side * _wrapped(psi, 2.0 * math.pi), where, depth)


def _one_tooth(blank: Blank, one: Hidden, psi: Array) -> Array:
    from_root = np.abs(_wrapped(psi - 2.0 * math.pi * (one.number("lobe") - 1), blank.reducer.period))
    return one["amount_um"] * UM * _smooth((math.pi - from_root) / one.get("x_blend_rad", TIP_BLEND))


def _pit(blank: Blank, one: Hidden, psi: Array) -> Array:
    """A hole on one flank of one lobe, round as a Gaussian."""
    past = _wrapped(psi - 2.0 * math.pi * (one.number("lobe") - 1) - one["psi_rad"], blank.reducer.period)
    return one["depth_um"] * UM * np.exp(-0.5 * (past / one["width_rad"]) ** 2)


def _flat_band(blank: Blank, one: Hidden, psi: Array) -> Array:
    """A band of ψ, on one flank of all lobes, that is low by the amount; its edges are a fifth of its width."""
    del blank
    past = np.abs(_wrapped(psi - one["psi_rad"], 2.0 * math.pi))
    return one["amount_um"] * UM * _smooth((0.5 * one["width_rad"] - past) / (0.1 * one["width_rad"]))


def _three_waves(blank: Blank, one: Hidden, psi: Array) -> Array:
    """Three waves round the disc, as of a three-jaw chuck."""
    return -one["amplitude_um"] * UM * np.cos(3.0 * (blank.along(psi) + one.get("phase_deg") * DEGREE))


def _tooth_to_tooth(blank: Blank, one: Hidden, psi: Array) -> Array:
    """Lobes high and low in turn, the first one low; an odd number leaves two low neighbours."""
    lobe = np.mod(np.round(psi / (2.0 * math.pi)), blank.reducer.lobes)
    from_root = np.abs(_wrapped(psi, 2.0 * math.pi))
    sign = np.where(lobe % 2.0 == 0.0, 1.0, -1.0)
    return one["amount_um"] * UM * sign * (2.0 * _smooth((math.pi - from_root) / TIP_BLEND) - 1.0)


def _scratch_step(blank: Blank, one: Hidden, psi: Array) -> Array:
    """A step at one ψ on one flank of all lobes, low from there to the tip."""
    del blank
    at, edge = one["psi_rad"], 0.03
    side = math.copysign(1.0, at)
    x = side * _wrapped(psi, 2.0 * math.pi)
    return one["amount_um"] * UM * _smooth((x - abs(at)) / edge) * _smooth((math.pi - 0.3 - x) / 0.3)


SHAPES: dict[str, Callable[[Blank, Hidden, Array], Array]] = {
    "disc_runout": _runout_by_angle,
    "disc_oval": _oval,
    "cumulative_pitch_error": _pitch,
    "wheel_wear_drift": _wheel_wear,
    "grinding_chatter": _chatter,
    "missing_deformation_compensation": _no_compensation,
    "flank_wear": _flank_wear,
    "single_tooth_error": _one_tooth,
    "x_pit": _pit,
    "x_flat_band": _flat_band,
    "x_three_waves": _three_waves,
    "x_tooth_to_tooth": _tooth_to_tooth,
    "x_scratch_step": _scratch_step,
}
