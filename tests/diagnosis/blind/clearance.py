"""Clearance of a pin that stands on the path of pin centres, all round one ground disc.

The tooth is sampled densely, and the distance of a pin centre is the least one to the samples, with the vertex of a
parabola through the nearest three. A pin off the path, by η along the normal, has the clearance η more: parallel
curves stay parallel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from .hidden import named
from .reducer import Reducer
from .tooth import Tooth, path

Array = np.ndarray
_PER_LOBE = 512
_REACH = 0.1  # phase to either side in which the nearest sample is sought
_PER_WAVE = 20


@dataclass(frozen=True)
class Clearance:
    """Tables over evenly spaced phases, ``step`` apart: a cubic of the clearance in each cell, and the curvature."""

    step: float
    cubic: Array
    curvature: Array

    def at(self, psi: Array) -> tuple[Array, Array]:
        """Clearance on the path [mm] and its slope by phase."""
        cell, x = self._cell(psi)
        c3, c2, c1, c0 = np.moveaxis(self.cubic[cell], -1, 0)
        return ((c3 * x + c2) * x + c1) * x + c0, (3.0 * c3 * x + 2.0 * c2) * x + c1

    def curvature_at(self, psi: Array) -> Array:
        """Curvature of the tooth at the foot, convex negative [1/mm]."""
        cell, x = self._cell(psi)
        after = np.where(cell + 1 == self.curvature.size, 0, cell + 1)
        share = x / self.step
        return (1.0 - share) * self.curvature[cell] + share * self.curvature[after]

    def _cell(self, psi: Array) -> tuple[Array, Array]:
        whole = np.floor(psi / self.step)
        return whole.astype(np.intp) % self.curvature.size, psi - whole * self.step


def clearance(tooth: Tooth) -> Clearance:
    """Clearance all round a disc."""
    reducer = tooth.reducer
    count = reducer.lobes * _samples(tooth)
    psi = np.arange(count) * (reducer.period / count)
    centre_x, centre_y = path(reducer.pin_circle_radius_mm, reducer.eccentricity_mm, reducer.pins, psi)
    centre = centre_x + 1j * centre_y
    points = tooth.points(psi)
    least, nearest = np.full(count, np.inf), np.zeros(count, dtype=np.intp)
    reach = math.ceil(_REACH * count / reducer.period)
    for shift in range(-reach, reach + 1):
        square = _square(centre - np.roll(points, -shift))
        closer = square < least
        least = np.where(closer, square, least)
        nearest[closer] = shift
    foot = (np.arange(count) + nearest) % count
    vertex, offset = _vertex(*(_square(centre - points[(foot + k) % count]) for k in (-1, 0, 1)))
    gap = np.sqrt(vertex) - reducer.pin_radius_mm
    bend = _bend(points)
    curvature = np.interp(foot + offset, np.arange(-1, count + 1), np.concatenate([bend[-1:], bend, bend[:1]]))
    spline = CubicSpline(np.append(psi, reducer.period), np.append(gap, gap[0]), bc_type="periodic")
    return Clearance(reducer.period / count, np.ascontiguousarray(spline.c.T), curvature)


def _samples(tooth: Tooth) -> int:
    """Samples on a lobe; twenty on each wave of the shortest chatter."""
    waves = max((one["waves_per_turn"] for one in named(tooth.effects, "grinding_chatter")), default=0.0)
    return max(_PER_LOBE, math.ceil(_PER_WAVE * waves / tooth.reducer.lobes))


def _square(z: Array) -> Array:
    return z.real**2 + z.imag**2


def _vertex(before: Array, here: Array, after: Array) -> tuple[Array, Array]:
    """Lowest value of the parabola through three even samples, and where, in samples from the middle one."""
    slope, bend = 0.5 * (after - before), after - 2.0 * here + before
    offset = np.clip(-slope / np.where(bend > 0.0, bend, np.inf), -1.0, 1.0)
    return here + offset * (slope + 0.5 * offset * bend), offset


def _bend(points: Array) -> Array:
    """Signed curvature, of the circle through each sample and its neighbours."""
    back, ahead = points - np.roll(points, 1), np.roll(points, -1) - points
    cross = back.real * ahead.imag - back.imag * ahead.real
    return 2.0 * cross / (np.abs(back) * np.abs(ahead) * np.abs(back + ahead))


def offset_from_path(reducer: Reducer, seen: Array, psi: Array) -> tuple[Array, Array, Array, Array]:
    """Where pin centres ``seen`` from the disc stand off the path: phase, η, normal, speed of the path.

    All normals of the path pass through the instant centre of the ring's motion, a z_c from the middle.
    """
    a, lobes = reducer.eccentricity_mm, reducer.lobes
    for _ in range(3):
        slow = np.exp(-1j / lobes * psi)
        fast = slow * np.exp(-1j * psi)
        arm = reducer.pin_circle_radius_mm * slow - a * reducer.pins * fast  # from the instant centre
        length = np.abs(arm)
        normal = arm / length
        off = np.conj(normal) * (seen - a * lobes * fast)
        psi = psi - off.imag * lobes / length
    return psi, off.real - length, normal, length / lobes
