"""The drive as drawn: pins, disc, and how the disc is held. Base units throughout."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cycloid_profile.errors import GeometryError
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.geometry.trochoid import Trochoid


@dataclass(frozen=True, slots=True)
class Cranks:
    """Crank shafts of an RV reducer: ``count`` eccentrics on a circle of the carrier.

    ``circle_radius`` [mm]; of each crank bearing against a disc ``bearing_stiffness``, radial [N/mm], and
    ``bearing_play``, radial, half the diametral clearance [mm].
    """

    count: int
    circle_radius: float
    bearing_stiffness: float
    bearing_play: float = 0.0

    def __post_init__(self) -> None:
        if self.count < 1:
            raise GeometryError("cranks.count", self.count, "is below 1", "give 2 or 3 crank shafts")
        _refuse_not_positive("cranks.circle_radius", self.circle_radius, "mm")
        _refuse_not_positive("bearing_stiffness", self.bearing_stiffness, "N/mm")
        _refuse_negative_play(self.bearing_play)


@dataclass(frozen=True, slots=True)
class CentralEccentric:
    """One eccentric bearing in the disc's centre; the disc turns the output through pins in holes.

    Of the eccentric bearing ``bearing_stiffness``, radial [N/mm], and ``bearing_play``, radial [mm].
    """

    bearing_stiffness: float
    bearing_play: float = 0.0

    def __post_init__(self) -> None:
        _refuse_not_positive("bearing_stiffness", self.bearing_stiffness, "N/mm")
        _refuse_negative_play(self.bearing_play)


@dataclass(frozen=True, slots=True)
class InvoluteStage:
    """First stage: a sun of ``sun_teeth`` drives planets of ``planet_teeth``; ``module`` [mm]."""

    sun_teeth: int
    planet_teeth: int
    module: float

    def __post_init__(self) -> None:
        _refuse_not_positive("sun_teeth", self.sun_teeth, "teeth")
        _refuse_not_positive("planet_teeth", self.planet_teeth, "teeth")
        _refuse_not_positive("module", self.module, "mm")

    @property
    def tooth_ratio(self) -> float:
        """z1/z2, sun over planet."""
        return self.sun_teeth / self.planet_teeth


@dataclass(frozen=True, slots=True)
class Drive:
    """Nominal cycloid stage with its support (docs/conventions.md).

    Parameters
    ----------
    trochoid : pins, pin circle and eccentricity
    pin_radius : r_rp [mm]
    disc_width : width b of one disc [mm]
    discs : number of discs, evenly phased
    support : what carries the discs
    first_stage : involute stage, or None when the eccentric is the input

    Raises
    ------
    GeometryError
        If pins overlap, the pin undercuts the tooth, or a length is not positive.
    """

    trochoid: Trochoid
    pin_radius: float
    disc_width: float
    discs: int
    support: Cranks | CentralEccentric
    first_stage: InvoluteStage | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.disc_width) and self.disc_width > 0.0):
            raise GeometryError(
                "disc_width", f"{self.disc_width} mm", "is not a positive length", "give the face width of one disc"
            )
        if self.discs < 1:
            raise GeometryError("discs", self.discs, "is below 1", "give at least one disc")
        if self.first_stage is not None and isinstance(self.support, CentralEccentric):
            raise GeometryError(
                "first_stage",
                f"{self.first_stage.sun_teeth}/{self.first_stage.planet_teeth} teeth",
                "drives planets, which a central eccentric has not",
                "add [drive.cranks] or leave [drive.first_stage] out",
            )
        self.theoretical_profile  # noqa: B018 - refuses a pin radius that is not positive or undercuts
        room = self.trochoid.pin_circle_radius * math.sin(math.pi / self.trochoid.pins)
        if self.pin_radius >= room:
            raise GeometryError(
                "pin_radius",
                f"{self.pin_radius:.7g} mm",
                f"makes neighbouring pins overlap, the limit is {room:.4f} mm",
                "take thinner or fewer pins, or a larger pin circle",
            )

    @property
    def theoretical_profile(self) -> ToothProfile:
        """The unmodified tooth: exact, with no clearance anywhere."""
        return ToothProfile(self.trochoid, self.pin_radius)

    @property
    def reduction_ratio(self) -> float:
        """Input turns per output turn, housing fixed: 1 + z_p·z2/z1, or z_c when the eccentric is the input."""
        if self.first_stage is None:
            return float(self.trochoid.lobes)
        return 1.0 + self.trochoid.pins / self.first_stage.tooth_ratio


def set_up_amounts(drive: Drive, profile: ToothProfile) -> tuple[float, float]:
    """Equidistant and radial-moving amounts of a ground tooth, read against the nominal drive [mm, mm].

    Their sum is the radial clearance at root and tip: removals on the flanks vanish there.
    """
    equidistant = profile.pin_radius - drive.pin_radius
    return equidistant, drive.trochoid.pin_circle_radius - profile.trochoid.pin_circle_radius


def _refuse_not_positive(name: str, value: float, unit: str) -> None:
    if not (math.isfinite(value) and value > 0.0):
        raise GeometryError(name, f"{value} {unit}", "is not positive", f"give a {name} above zero")


def _refuse_negative_play(play: float) -> None:
    if not (math.isfinite(play) and play >= 0.0):
        raise GeometryError(
            "bearing_play", f"{play} mm", "is negative or not finite", "give half the diametral clearance, 0 for none"
        )
