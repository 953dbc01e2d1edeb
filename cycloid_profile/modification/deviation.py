"""A removal given by points: what a measuring machine found, or any other curve (docs/theory.md, Eq. 42)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.errors import GeometryError
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.geometry.removal import RemovalJet
from cycloid_profile.geometry.trochoid import Trochoid

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

_LEAST_POINTS = 4


@dataclass(frozen=True, eq=False)
class NormalDeviation:
    """h(ψ) through given points by a periodic cubic spline.

    Parameters
    ----------
    phase : phases of the points, rising, shape (points,) [rad]
    removal : material missing there along the normal, positive into the disc, shape (points,) [mm]
    lobes : how many lobes the curve runs over before it repeats: 1 for a form all lobes share, z_c for a scan
        once round the disc

    Raises
    ------
    GeometryError
        If there are fewer than 4 points, a value is not finite, or the phases do not rise within one period.
    """

    phase: FloatArray
    removal: FloatArray
    lobes: int

    def __post_init__(self) -> None:
        psi, h = np.asarray(self.phase, dtype=np.float64), np.asarray(self.removal, dtype=np.float64)
        if psi.ndim != 1 or psi.shape != h.shape or psi.size < _LEAST_POINTS:
            raise GeometryError(
                "normal deviation",
                f"phases {psi.shape} and removals {h.shape}",
                f"is no curve of at least {_LEAST_POINTS} points",
                "give one removal for each phase",
            )
        if not (np.all(np.isfinite(psi)) and np.all(np.isfinite(h))):
            bad = int(np.argmin(np.isfinite(psi) & np.isfinite(h)))
            raise GeometryError(
                "normal deviation",
                f"point {bad + 1} of {psi.size}: {psi[bad]} rad, {h[bad]} mm",
                "is not finite",
                "leave such points out",
            )
        if not (np.all(np.diff(psi) > 0.0) and psi[-1] - psi[0] < self.period):
            raise GeometryError(
                "phase of the normal deviation",
                f"{psi[0]:.6g} to {psi[-1]:.6g} rad",
                f"does not rise within one period of {self.period:.6g} rad",
                "sort the points and leave the repeated first one out",
            )
        object.__setattr__(self, "phase", psi)
        object.__setattr__(self, "removal", h)

    @property
    def period(self) -> float:
        """Phase after which the curve repeats [rad]."""
        return 2.0 * math.pi * self.lobes

    @property
    def whole_disc(self) -> bool:
        """Whether it runs over more than one lobe."""
        return self.lobes != 1

    @property
    def corners(self) -> tuple[float, ...]:
        """None: a cubic spline is smooth."""
        return ()

    @property
    def spacing(self) -> float:
        """Least distance between points [rad]."""
        return float(min(np.min(np.diff(self.phase)), self.period - (self.phase[-1] - self.phase[0])))

    @cached_property
    def _spline(self) -> CubicSpline:
        # Imported here: it takes longer than the rest of the package, and few profiles need it.
        from scipy.interpolate import CubicSpline

        closed = np.append(self.phase, self.phase[0] + self.period)
        return CubicSpline(closed, np.append(self.removal, self.removal[0]), bc_type="periodic")

    def jet(self, phase: FloatArray, side: FloatArray, trochoid: Trochoid) -> RemovalJet:
        """Removal and derivatives; smooth, so that ``side`` does not matter, and ``trochoid`` is not needed."""
        del side, trochoid
        psi = self.phase[0] + np.mod(phase - self.phase[0], self.period)
        return RemovalJet(self._spline(psi), self._spline(psi, 1), self._spline(psi, 2))


@dataclass(frozen=True, eq=False)
class MeasuredDeviation:
    """Takes a measured ``curve`` of normal deviation off the tooth."""

    curve: NormalDeviation

    def apply(self, profile: ToothProfile) -> ToothProfile:
        """The tooth with the deviation; ``GeometryError`` where the curve does not fit its number of lobes."""
        if self.curve.lobes not in (1, profile.trochoid.lobes):
            raise GeometryError(
                "lobes of the normal deviation",
                self.curve.lobes,
                f"is neither 1 nor the {profile.trochoid.lobes} of the disc",
                "give a curve over one lobe or over the whole disc",
            )
        return replace(profile, removals=(*profile.removals, self.curve))
