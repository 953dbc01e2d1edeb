"""A removal given by points, measured or computed (docs/theory.md, Eq. 42)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from cycloid_profile._display import Described
from cycloid_profile.arrays import FloatArray
from cycloid_profile.errors import GeometryError
from cycloid_profile.geometry import RemovalDerivatives, ToothProfile, Trochoid
from cycloid_profile.units import UM

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

_LEAST_POINTS = 4  # of a periodic cubic spline


@dataclass(frozen=True, eq=False, repr=False)
class NormalDeviation(Described):
    """h(ψ) through given points by a periodic cubic spline.

    Parameters
    ----------
    phase : phases of the points, rising, shape (points,) [rad]
    removal : material removed along the normal, positive into the disc, shape (points,) [mm]
    lobes : period in lobes: 1 for a form common to all lobes, z_c for a scan once round the disc

    Raises ``GeometryError`` if there are fewer than 4 points, a value is not finite, or the phases do not rise
    within one period.
    """

    phase: FloatArray
    removal: FloatArray
    lobes: int

    def __post_init__(self) -> None:
        psi, h = np.asarray(self.phase, dtype=np.float64), np.asarray(self.removal, dtype=np.float64)
        what = "normal deviation"
        if psi.ndim != 1 or psi.shape != h.shape or psi.size < _LEAST_POINTS:
            limit = f"is no curve of at least {_LEAST_POINTS} points"
            shapes = f"phases {psi.shape} and removals {h.shape}"
            raise GeometryError(what, shapes, limit, "give one removal for each phase")
        if not np.all(finite := np.isfinite(psi) & np.isfinite(h)):
            bad = int(np.argmin(finite))
            point = f"point {bad + 1} of {psi.size}: {psi[bad]} rad, {h[bad]} mm"
            raise GeometryError(what, point, "is not finite", "leave such points out")
        if not (np.all(np.diff(psi) > 0.0) and psi[-1] - psi[0] < self.period):
            limit = f"does not rise within one period of {self.period:.6g} rad"
            remedy = "sort the points and leave the repeated first one out"
            raise GeometryError(f"phase of the {what}", f"{psi[0]:.6g} to {psi[-1]:.6g} rad", limit, remedy)
        object.__setattr__(self, "phase", psi)
        object.__setattr__(self, "removal", h)

    def _key_figures(self) -> dict[str, str]:
        return {
            "points": f"{self.phase.size}",
            "period": f"{self.lobes} lobes" if self.whole_disc else "1 lobe",
            "removal": f"{np.min(self.removal) / UM:.4g} to {np.max(self.removal) / UM:.4g} µm",
        }

    @property
    def period(self) -> float:
        """Phase after which the curve repeats [rad]."""
        return 2.0 * math.pi * self.lobes

    @property
    def whole_disc(self) -> bool:
        """Whether its period exceeds one lobe."""
        return self.lobes != 1

    @property
    def corners(self) -> tuple[float, ...]:
        """None: a cubic spline is smooth."""
        return ()

    @property
    def point_spacing(self) -> float:
        """Least distance between points [rad]."""
        return float(min(np.min(np.diff(self.phase)), self.period - (self.phase[-1] - self.phase[0])))

    @cached_property
    def _spline(self) -> CubicSpline:
        # Imported here: it takes longer to load than the rest of the package, and few profiles need it.
        from scipy.interpolate import CubicSpline

        closed = np.append(self.phase, self.phase[0] + self.period)
        return CubicSpline(closed, np.append(self.removal, self.removal[0]), bc_type="periodic")

    def derivatives(self, phase: FloatArray, side: FloatArray, trochoid: Trochoid) -> RemovalDerivatives:
        """Removal and derivatives, in the shape of ``phase``; independent of ``side`` and ``trochoid``."""
        del side, trochoid
        psi = self.phase[0] + np.mod(phase - self.phase[0], self.period)
        return RemovalDerivatives(self._spline(psi), self._spline(psi, 1), self._spline(psi, 2))


@dataclass(frozen=True, eq=False)
class MeasuredDeviation:
    """Modification that removes material by a measured ``curve`` of normal deviation."""

    curve: NormalDeviation

    def apply(self, profile: ToothProfile) -> ToothProfile:
        """The tooth with the deviation. Raises ``GeometryError`` unless ``curve.lobes`` is 1 or the disc's z_c."""
        if self.curve.lobes not in (1, profile.trochoid.lobes):
            raise GeometryError(
                "lobes of the normal deviation",
                self.curve.lobes,
                f"is neither 1 nor the {profile.trochoid.lobes} of the disc",
                "give a curve over one lobe or over the whole disc",
            )
        return replace(profile, removals=(*profile.removals, self.curve))
