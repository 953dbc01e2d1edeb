"""How far points of a file lie from the exact tooth curve."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.contact.gap import nearest_foot
from cycloid_profile.geometry.profile import ToothProfile

_TABLE = 4001


@dataclass(frozen=True, slots=True)
class Deviation:
    """Largest and root-mean-square distance from the exact curve [mm], with the polar angle of the worst [rad]."""

    largest: float
    rms: float
    worst_angle: float
    points: int


def deviation(profile: ToothProfile, points: ComplexArray) -> Deviation:
    """Deviation of ``points`` [mm, complex] from the tooth curve."""
    off = np.abs(distances(profile, points))
    worst = int(np.argmax(off))
    return Deviation(
        largest=float(off[worst]),
        rms=float(np.sqrt(np.mean(off**2))),
        worst_angle=float(np.angle(points[worst])),
        points=off.size,
    )


def distances(profile: ToothProfile, points: ComplexArray) -> FloatArray:
    """Signed distance of each point along the outward normal, in the shape of ``points`` [mm]; exact feet.

    Points must lie near the curve: each is first matched by its polar angle, and so to its lobe where lobes differ.
    """
    lobe_angle = 2.0 * math.pi / profile.trochoid.lobes
    # A lobe is centred on its root at polar angle 0 and is run through clockwise.
    lobe = np.round(-np.angle(points) / lobe_angle)
    in_lobe = points * np.exp(1j * lobe * lobe_angle)
    psi = np.linspace(-math.pi, math.pi, _TABLE)
    angle = np.angle(profile.at(psi).position)
    start = np.interp(-np.angle(in_lobe), -angle, psi)
    which = None if profile.lobes_alike else np.mod(lobe, profile.trochoid.lobes)
    foot, side = nearest_foot(profile, in_lobe, start, which)
    on_curve = profile.at(foot, side, which)
    offset: FloatArray = (np.conj(on_curve.normal) * (in_lobe - on_curve.position)).real
    return offset
