"""The ring that holds the pins, by waves round its circumference (docs/theory.md, Eqs. 89–91)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.laws import Material
from cycloid_profile.errors import LoadError

_SHEAR = 5.0 / 6.0  # share of a rectangular section that carries shear


@dataclass(frozen=True, slots=True)
class RingBody:
    """Ring of rectangular section behind the pins: it stretches, bends in its plane and shears.

    ``pin_circle_radius``, where the pins press; ``inner_radius`` at the floor of the grooves, ``outer_radius`` and
    ``width`` along the axis [mm]; ``waves``, the highest number of waves counted. ``mounting``, stiffness of the mount
    in both directions of the plane per length of the circumference [N/mm²]. None: the mount holds the ring as a whole
    against shift and turn, and leaves its shape free.

    Raises
    ------
    LoadError
        If a size is impossible.
    """

    pin_circle_radius: float
    inner_radius: float
    outer_radius: float
    width: float
    material: Material
    waves: int = 6
    mounting: float | None = None

    def __post_init__(self) -> None:
        if not 0.0 < self.pin_circle_radius <= self.inner_radius < self.outer_radius < math.inf:
            raise LoadError(
                "ring: outer_radius", f"{self.outer_radius} mm", f"is not above {self.inner_radius} mm",
                "give a ring outside the grooves of the pins",
            )  # fmt: skip
        if not (math.isfinite(self.width) and self.width > 0.0):
            raise LoadError("ring: width", f"{self.width} mm", "is not above zero", "give a positive width")
        if self.waves < 0:
            raise LoadError("ring: waves", self.waves, "is below zero", "count at least the stretch, 0 waves")
        if self.mounting is not None and not (math.isfinite(self.mounting) and self.mounting > 0.0):
            raise LoadError("ring: mounting", self.mounting, "is not above zero", "leave it out for a free ring")

    @property
    def mean_radius(self) -> float:
        """Radius of the middle of the section [mm]."""
        return 0.5 * (self.inner_radius + self.outer_radius)

    def wave_compliance(self, waves: int) -> FloatArray:
        """Amplitudes (radial, tangential) at the pins by a unit load of as many waves, shape (2, 2) [mm/N] (Eq. 90).

        The load: forces with the sum of squared weights 1 on the wave, such as Σ F_k cos kα = 1 N. With a sign:
        radial outwards as cos kα, tangential anticlockwise as sin kα; for 0 waves both constant.
        """
        R, E = self.mean_radius, self.material.youngs_modulus
        h = self.outer_radius - self.inner_radius
        area, inertia = self.width * h, self.width * h**3 / 12.0
        shear = _SHEAR * E / (2.0 * (1.0 + self.material.poisson_ratio)) * area
        mount = 0.0 if self.mounting is None else self.mounting
        if waves == 0:
            turn = 0.0 if mount == 0.0 else (self.pin_circle_radius / R) ** 2 / (2.0 * math.pi * R * mount)
            return np.diag([1.0 / (2.0 * math.pi * R * (E * area / R**2 + mount)), turn])
        if waves == 1 and mount == 0.0:
            return np.zeros((2, 2))
        k = float(waves)
        stretch, slide, bend = np.array([[1.0, k, 0.0], [-k, -1.0, R], [0.0, 0.0, k]]) / R
        stiffness = E * area * np.outer(stretch, stretch) + shear * np.outer(slide, slide)
        stiffness += E * inertia * np.outer(bend, bend) + mount * np.diag([1.0, 1.0, 0.0])
        # A pin is carried by the section under it: its shift along the circle, and the turn of the section.
        at_pins = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, self.pin_circle_radius - R]])
        found: FloatArray = at_pins.T @ np.linalg.solve(math.pi * R * stiffness, at_pins)
        return found

    def influence(self, angle: FloatArray) -> FloatArray:
        """Displacement at pins by unit forces on pins at these angles, shape (2, pins, 2, pins) [mm/N] (Eq. 91).

        Direction and pin, of displacement first, then of force; directions radial outwards and tangential.
        """
        between = angle[:, np.newaxis] - angle
        found = np.zeros((2, angle.size, 2, angle.size))
        for k in range(self.waves + 1):
            A, cos, sin = self.wave_compliance(k), np.cos(k * between), np.sin(k * between)
            found[0, :, 0] += A[0, 0] * cos
            found[0, :, 1] -= A[0, 1] * sin
            found[1, :, 0] += A[1, 0] * sin
            found[1, :, 1] += A[1, 1] * cos
        return found
