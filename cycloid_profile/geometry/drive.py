"""The nominal drive: pins, disc and support of the disc. Base units throughout."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from cycloid_profile.errors import GeometryError
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.geometry.trochoid import Trochoid, require_positive

if TYPE_CHECKING:  # the drive holds its rollers; their force is a matter of contact
    from cycloid_profile.contact.bodies import RollerBearing


@dataclass(frozen=True, slots=True)
class Cranks:
    """Crank shafts of an RV reducer: ``count`` eccentrics on a circle of the carrier.

    ``circle_radius`` [mm]; radial ``bearing_stiffness`` [N/mm] of each crank bearing against a disc, and its radial
    ``bearing_play``, half the diametral clearance [mm]. ``rollers`` take the place of the spring of that stiffness;
    with them the play is negative under preload.
    """

    count: int
    circle_radius: float
    bearing_stiffness: float
    bearing_play: float = 0.0
    rollers: RollerBearing | None = None

    def __post_init__(self) -> None:
        if self.count < 1:
            raise GeometryError("cranks.count", self.count, "is below 1", "give 2 or 3 crank shafts")
        require_positive("cranks.circle_radius", self.circle_radius, "mm")
        require_positive("bearing_stiffness", self.bearing_stiffness, "N/mm")
        _require_play(self.bearing_play, self.rollers)


@dataclass(frozen=True, slots=True)
class CentralEccentric:
    """Support by one eccentric bearing in the disc's centre; the disc drives the output through pins in holes.

    ``bearing_stiffness`` [N/mm] and ``bearing_play`` [mm] of the eccentric bearing, both radial, and ``rollers`` as in
    ``Cranks``.
    """

    bearing_stiffness: float
    bearing_play: float = 0.0
    rollers: RollerBearing | None = None

    def __post_init__(self) -> None:
        require_positive("bearing_stiffness", self.bearing_stiffness, "N/mm")
        _require_play(self.bearing_play, self.rollers)


@dataclass(frozen=True, slots=True)
class InvoluteStage:
    """First stage: a sun of ``sun_teeth`` drives planets of ``planet_teeth``; ``module`` [mm]."""

    sun_teeth: int
    planet_teeth: int
    module: float

    def __post_init__(self) -> None:
        require_positive("sun_teeth", self.sun_teeth, "teeth")
        require_positive("planet_teeth", self.planet_teeth, "teeth")
        require_positive("module", self.module, "mm")

    @property
    def tooth_ratio(self) -> float:
        """z1/z2, sun over planet."""
        return self.sun_teeth / self.planet_teeth

    @property
    def planet_radius(self) -> float:
        """Pitch radius of a planet, m·z2/2 [mm]."""
        return 0.5 * self.module * self.planet_teeth


@dataclass(frozen=True, slots=True)
class Drive:
    """Nominal cycloid stage with its support (docs/conventions.md).

    Parameters
    ----------
    trochoid : pins, pin circle and eccentricity
    pin_radius : r_rp [mm]
    disc_width : width b of one disc [mm]
    discs : number of discs, evenly phased
    support : bearing of the discs
    first_stage : involute stage, or None when the eccentric is the input

    Raises ``GeometryError`` if pins overlap, the pin undercuts the tooth, or a length is not positive.
    """

    trochoid: Trochoid
    pin_radius: float
    disc_width: float
    discs: int
    support: Cranks | CentralEccentric
    first_stage: InvoluteStage | None = None

    def __post_init__(self) -> None:
        require_positive("disc_width", self.disc_width, "mm", "give the face width of one disc")
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
            limit = f"makes neighbouring pins overlap, the limit is {room:.4f} mm"
            remedy = "take thinner or fewer pins, or a larger pin circle"
            raise GeometryError("pin_radius", f"{self.pin_radius:.7g} mm", limit, remedy)

    @property
    def theoretical_profile(self) -> ToothProfile:
        """The unmodified tooth, exact and without clearance."""
        return ToothProfile(self.trochoid, self.pin_radius)

    @property
    def reduction_ratio(self) -> float:
        """Input turns per output turn, housing fixed: 1 + z_p·z2/z1, or z_c when the eccentric is the input."""
        if self.first_stage is None:
            return float(self.trochoid.lobes)
        return 1.0 + self.trochoid.pins / self.first_stage.tooth_ratio


def modification_sizes(drive: Drive, profile: ToothProfile) -> tuple[float, float]:
    """Equidistant and radial-moving modification of a ground tooth relative to the nominal drive [mm, mm].

    Their sum is the radial clearance at root and tip, where removals on the flanks vanish.
    """
    equidistant = profile.pin_radius - drive.pin_radius
    return equidistant, drive.trochoid.pin_circle_radius - profile.trochoid.pin_circle_radius


def _require_play(play: float, rollers: RollerBearing | None) -> None:
    if not (math.isfinite(play) and (play >= 0.0 or rollers is not None)):
        raise GeometryError(
            "bearing_play", f"{play} mm", "is negative or not finite", "give half the diametral clearance, 0 for none"
        )
