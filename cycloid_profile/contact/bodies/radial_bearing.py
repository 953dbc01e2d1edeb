"""Laws of a radial bearing: force by displacement of a linear spring or of rollers (docs/theory.md, Eqs. 105–112).

The play is radial, half the clearance between shaft and bore; rollers under preload have a negative play.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple, Protocol, TypeVar

import numpy as np

from cycloid_profile.arrays import ArrayLike, FloatArray
from cycloid_profile.contact.laws import STEEL, Material
from cycloid_profile.errors import LoadError
from cycloid_profile.geometry import CentralEccentric, Cranks

if TYPE_CHECKING:
    from cycloid_profile.contact.bodies._bearing_kernels import CompiledBearing

_Support = TypeVar("_Support", bound="Cranks | CentralEccentric")

# ISO/TS 16281:2008, 4.3: c_L of steel is this times L_we^(8/9) [N/mm^(10/9)], inner and outer contact in series.
STEEL_ROLLER_CONSTANT = 35_948.0
LINE_CONTACT_EXPONENT = 10.0 / 9.0

# ISO 5753-1:2009, cylindrical roller bearings with cylindrical bore: largest bore [mm], then least and largest radial
# internal clearance of classes C2, CN and C3 [µm].
CLEARANCE_UM = (
    (24.0, (0, 25), (20, 45), (35, 60)),
    (30.0, (0, 25), (20, 45), (35, 60)),
    (40.0, (5, 30), (25, 50), (45, 70)),
    (50.0, (5, 35), (30, 60), (50, 80)),
    (65.0, (10, 40), (40, 70), (60, 90)),
    (80.0, (10, 45), (40, 75), (65, 100)),
    (100.0, (15, 50), (50, 85), (75, 110)),
    (120.0, (15, 55), (50, 90), (85, 125)),
    (140.0, (15, 60), (60, 105), (100, 145)),
    (160.0, (20, 70), (70, 120), (115, 165)),
    (180.0, (25, 75), (75, 125), (120, 170)),
    (200.0, (35, 90), (90, 145), (140, 195)),
)
CLEARANCE_CLASSES = ("C2", "CN", "C3")


class BearingResponse(NamedTuple):
    """Force over displacement ``secant`` and dF/dr ``tangent`` [N/mm], and ``energy`` [N·mm], at displacements r.

    Across the displacement the stiffness is ``secant``. Under preload ``energy`` includes that of the bearing at rest.
    """

    secant: FloatArray
    tangent: FloatArray
    energy: FloatArray


class BearingLaw(Protocol):
    """Radial force of a bearing by the size of its radial displacement, the same in all directions."""

    @property
    def least_play(self) -> float:
        """Least play that the law allows, negative where it knows preload [mm]."""
        ...

    def response(self, displacement: ArrayLike, play: ArrayLike) -> BearingResponse:
        """Response at displacements ≥ 0 [mm], broadcast against ``play`` [mm]."""
        ...

    def displacement(self, force: ArrayLike, play: ArrayLike) -> FloatArray:
        """Displacement under forces ≥ 0 [N], the play where they are zero [mm]."""
        ...

    def softened(self, compliance: float) -> BearingLaw:
        """The same with a spring of this compliance in series [mm/N]."""
        ...

    def compiled(self) -> CompiledBearing:
        """The law in the form of the compiled search."""
        ...


@dataclass(frozen=True, slots=True)
class LinearBearing:
    """A spring of radial ``stiffness`` beyond the play [N/mm]."""

    stiffness: float

    @property
    def least_play(self) -> float:
        """See ``BearingLaw.least_play``."""
        return 0.0

    def response(self, displacement: ArrayLike, play: ArrayLike) -> BearingResponse:
        """See ``BearingLaw.response``."""
        length, free = np.broadcast_arrays(np.asarray(displacement, dtype=np.float64), play)
        beyond = np.maximum(length - free, 0.0)
        pressed = (length > free) & (length > 0.0)
        share = np.where(pressed, beyond / np.where(pressed, length, 1.0), np.equal(free, 0.0) & ~(length > 0.0))
        tangent = np.where(share > 0.0, self.stiffness, 0.0)
        return BearingResponse(self.stiffness * share, tangent, 0.5 * self.stiffness * beyond**2)

    def displacement(self, force: ArrayLike, play: ArrayLike) -> FloatArray:
        """See ``BearingLaw.displacement``."""
        return np.asarray(force, dtype=np.float64) / self.stiffness + np.asarray(play, dtype=np.float64)

    def softened(self, compliance: float) -> LinearBearing:
        """See ``BearingLaw.softened``: the compliances add."""
        return LinearBearing(1.0 / (1.0 / self.stiffness + compliance))

    def compiled(self) -> CompiledBearing:
        """See ``BearingLaw.compiled``."""
        from cycloid_profile.contact.bodies._bearing_kernels import CompiledBearing

        return CompiledBearing(float(self.stiffness), 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class RollerBearing:
    """Rollers with Q = c_L δ^(10/9) each, averaged over the angle of their cage (Eqs. 105–110).

    Parameters
    ----------
    count : number of rollers Z
    constant : c_L of one roller between both raceways, ``roller_constant`` [N/mm^(10/9)]
    compliance : of a spring in series, such as a thin ring or a soft seat [mm/N]

    Raises
    ------
    LoadError
        If ``count`` or ``constant`` is not positive, or ``compliance`` is negative.
    """

    count: int
    constant: float
    compliance: float = 0.0

    def __post_init__(self) -> None:
        for name, unit, good in (
            ("count", "", self.count >= 1),
            ("constant", " N/mm^(10/9)", 0.0 < self.constant < math.inf),
            ("compliance", " mm/N", 0.0 <= self.compliance < math.inf),
        ):
            if not good:
                value = f"{getattr(self, name)}{unit}"
                raise LoadError(f"roller bearing: {name}", value, "is out of range", "give a positive number")

    @property
    def least_play(self) -> float:
        """See ``BearingLaw.least_play``: any preload."""
        return -math.inf

    def response(self, displacement: ArrayLike, play: ArrayLike) -> BearingResponse:
        """See ``BearingLaw.response``."""
        from cycloid_profile.contact.bodies._bearing_kernels import bearing_responses

        length, free = np.broadcast_arrays(np.asarray(displacement, dtype=np.float64), np.asarray(play, np.float64))
        # Copies: numpy 2.0 warns where numba asks whether a broadcast array can be written.
        found = bearing_responses(self.compiled(), free.flatten(), length.flatten())
        return BearingResponse(*(one.reshape(length.shape) for one in found))

    def displacement(self, force: ArrayLike, play: ArrayLike) -> FloatArray:
        """See ``BearingLaw.displacement``."""
        from cycloid_profile.contact.bodies._bearing_kernels import displacements

        load, free = np.broadcast_arrays(np.asarray(force, dtype=np.float64), np.asarray(play, np.float64))
        found: FloatArray = displacements(self.compiled(), free.flatten(), load.flatten())
        return found.reshape(load.shape)

    def softened(self, compliance: float) -> RollerBearing:
        """See ``BearingLaw.softened``."""
        return replace(self, compliance=self.compliance + compliance)

    def compiled(self) -> CompiledBearing:
        """See ``BearingLaw.compiled``."""
        from cycloid_profile.contact.bodies._bearing_kernels import CompiledBearing

        return CompiledBearing(0.0, self.count * self.constant, self.compliance)

    def roller_forces(self, displacement: float, play: float, cage_angle: ArrayLike) -> FloatArray:
        """Force of each roller, the first at ``cage_angle`` from the displacement [rad]; shape (…, Z) [N] (Eq. 106).

        Without the spring in series.
        """
        at = np.asarray(cage_angle)[..., np.newaxis] + 2.0 * math.pi * np.arange(self.count) / self.count
        approach = np.maximum(displacement * np.cos(at) - play, 0.0)
        return np.asarray(self.constant * approach**LINE_CONTACT_EXPONENT)

    def passage_variation(self, displacement: float, play: float, angles: int = 64) -> float:
        """Peak-to-peak force along a held displacement while one roller pitch passes, over its mean (Eq. 111)."""
        cage = 2.0 * math.pi / self.count * np.arange(angles) / angles
        at = cage[:, np.newaxis] + 2.0 * math.pi * np.arange(self.count) / self.count
        along = np.sum(self.roller_forces(displacement, play, cage) * np.cos(at), axis=-1)
        mean = float(np.mean(along))
        return float(np.ptp(along)) / mean if mean > 0.0 else math.nan


def roller_constant(length: float, inner: Material = STEEL, outer: Material = STEEL) -> float:
    """c_L of a steel roller of effective ``length`` [mm] between raceways of these materials [N/mm^(10/9)] (Eq. 105).

    ISO/TS 16281 for steel. For others each contact's δ ∝ (Q/E*)^0.9, as in Palmgren's and Lundberg's formula.
    """
    steel = STEEL.contact_modulus(STEEL)
    softer = sum((steel / STEEL.contact_modulus(raceway)) ** 0.9 for raceway in (inner, outer))
    return float(STEEL_ROLLER_CONSTANT * length ** (8.0 / 9.0) * (0.5 * softer) ** (-LINE_CONTACT_EXPONENT))


def clearance_range(bore: float, clearance_class: str) -> tuple[float, float]:
    """Least and largest radial internal clearance by ISO 5753-1 of a ``bore`` [mm], before mounting [µm].

    It is diametral: the play is half of it. Raises ``LoadError`` for other classes or bores above 200 mm.
    """
    if clearance_class not in CLEARANCE_CLASSES:
        remedy = f"choose from {', '.join(CLEARANCE_CLASSES)}"
        raise LoadError("clearance class", clearance_class, "is not known", remedy)
    for largest, *ranges in CLEARANCE_UM:
        if bore <= largest:
            least, most = ranges[CLEARANCE_CLASSES.index(clearance_class)]
            return float(least), float(most)
    raise LoadError("clearance class: bore", f"{bore:.4g} mm", "is above 200 mm", "give the radial clearance in µm")


def bearing_law(support: Cranks | CentralEccentric) -> BearingLaw:
    """Law of the bearings of a support: its rollers, or the spring of its stiffness."""
    law: BearingLaw = support.rollers if support.rollers is not None else LinearBearing(support.bearing_stiffness)
    return law


def softened_support(support: _Support, compliance: float) -> _Support:
    """The support with a spring of this compliance in series with each bearing [mm/N]."""
    if support.rollers is not None:
        return replace(support, rollers=support.rollers.softened(compliance))
    return replace(support, bearing_stiffness=LinearBearing(support.bearing_stiffness).softened(compliance).stiffness)
