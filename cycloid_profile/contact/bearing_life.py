"""Rating life of roller bearings after ISO 281:2007, and of the bearings between cranks and discs.

Docs: docs/theory.md, Eqs. 61–65.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import ArrayLike, ComplexArray, FloatArray
from cycloid_profile.contact.result import LoadSharing
from cycloid_profile.errors import LoadError

# ISO 281:2007, 7.3: life exponent of roller bearings.
LIFE_EXPONENT = 10.0 / 3.0
# ISO/TR 1281-1:2008: Weibull slope of roller bearings.
WEIBULL_SLOPE = 9.0 / 8.0
# ISO 281:2007, Table 6: cylindrical and needle roller bearings with machined raceways.
RATING_FACTOR = 1.1
# ISO 281:2007, Table 7 ends at these ratios of roller diameter and pitch diameter.
LEAST_ROLLER_RATIO, LARGEST_ROLLER_RATIO = 0.01, 0.30
# ISO 281:2007, 9.3.3: below a viscosity ratio of 0.1 there is no life factor; above 4 it no longer rises, nor above 50.
LEAST_VISCOSITY_RATIO, LARGEST_VISCOSITY_RATIO, LARGEST_LIFE_FACTOR = 0.1, 4.0, 50.0


@dataclass(frozen=True, slots=True)
class RollerSet:
    """One row of rollers between two cylindrical raceways, contact angle zero.

    Parameters
    ----------
    count : number of rollers Z
    diameter : of a roller, D_we [mm]
    length : effective, without chamfers, L_we [mm]
    pitch_diameter : of the circle through the middles of the rollers, D_pw [mm]

    Raises
    ------
    LoadError
        If a size is not positive, neighbouring rollers overlap, or D_we/D_pw is outside 0.01 to 0.30.
    """

    count: int
    diameter: float
    length: float
    pitch_diameter: float

    def __post_init__(self) -> None:
        for name in ("diameter", "length"):
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) > 0.0):
                value = f"{getattr(self, name)} mm"
                raise LoadError(f"rollers: {name}", value, "is not positive", "give the size of the rollers")
        least, largest = (ratio * self.pitch_diameter for ratio in (LEAST_ROLLER_RATIO, LARGEST_ROLLER_RATIO))
        if not least <= self.diameter <= largest:
            limit = f"is outside {LEAST_ROLLER_RATIO:g} to {LARGEST_ROLLER_RATIO:g} of the pitch diameter"
            raise LoadError("rollers: diameter", f"{self.diameter:.4g} mm", limit, "give another roller diameter")
        room = math.pi / math.asin(self.diameter / self.pitch_diameter)
        if not 1 <= self.count <= room:
            limit = f"is outside 1 to {int(room)}, which the pitch circle holds"
            raise LoadError("rollers: count", self.count, limit, "take fewer or thinner rollers")

    @property
    def inner_raceway_radius(self) -> float:
        """Radius of the shaft that the rollers run on [mm]."""
        return 0.5 * (self.pitch_diameter - self.diameter)

    @property
    def dynamic_load_rating(self) -> float:
        """C = b_m f_c L_we^(7/9) Z^(3/4) D_we^(29/27), ISO 281:2007, 7.1 (Eq. 61) [N].

        f_c is the formula behind Table 7, ISO/TR 1281-1:2008 with λν = 0.83; it returns the table to its last digit.
        """
        gamma = self.diameter / self.pitch_diameter
        closeness = (1.0 - gamma) / (1.0 + gamma)
        both_rings = (1.0 + (1.04 * closeness ** (143.0 / 108.0)) ** 4.5) ** (-2.0 / 9.0)
        f_c = 207.9 * 0.83 * gamma ** (2.0 / 9.0) * (1.0 - gamma) ** (29.0 / 27.0) / (1.0 + gamma) ** 0.25 * both_rings
        rollers = self.length ** (7.0 / 9.0) * self.count**0.75 * self.diameter ** (29.0 / 27.0)
        return float(RATING_FACTOR * f_c * rollers)

    @property
    def static_load_rating(self) -> float:
        """C_0 = 44 (1 − D_we/D_pw) Z L_we D_we, ISO 76:2006 [N]."""
        return 44.0 * (1.0 - self.diameter / self.pitch_diameter) * self.count * self.length * self.diameter

    @property
    def fatigue_load_limit(self) -> float:
        """C_u = C_0/8.2, ISO 281:2007, Eqs. (B.20) and (B.21): less by √(100 mm/D_pw) for larger bearings [N]."""
        return self.static_load_rating / 8.2 * math.sqrt(100.0 / max(self.pitch_diameter, 100.0))


def equivalent_load(force: ComplexArray | FloatArray) -> FloatArray:
    """Mean of |force| over the first axis with the exponent 10/3 of the life, at constant speed (Eq. 62) [N]."""
    mean: FloatArray = np.mean(np.abs(force) ** LIFE_EXPONENT, axis=0) ** (1.0 / LIFE_EXPONENT)
    return mean


def basic_rating_life(load_rating: float, load: ArrayLike) -> FloatArray:
    """L10 = 10⁶ (C/P)^(10/3), the revolutions that 90 % of the bearings reach, ISO 281:2007, 7.3 (Eq. 63)."""
    with np.errstate(divide="ignore"):  # without load a bearing lives for ever
        life: FloatArray = 1e6 * (load_rating / np.asarray(load, dtype=np.float64)) ** LIFE_EXPONENT
    return life


def life_of_all(lives: ArrayLike) -> float:
    """Life that a set of bearings reaches in 90 % of all sets, (Σ L^(−9/8))^(−8/9), in the unit of ``lives``."""
    each = np.asarray(lives, dtype=np.float64)
    with np.errstate(divide="ignore"):  # at rest all of them live for ever
        return float(np.sum(each**-WEIBULL_SLOPE) ** (-1.0 / WEIBULL_SLOPE))


def reference_viscosity(speed_rpm: float, pitch_diameter: float) -> float:
    """Viscosity ν1 at which a film parts the surfaces, ISO 281:2007, Eqs. (28) and (29) [mm²/s] (Eq. 65)."""
    if speed_rpm < 1000.0:
        return float(45_000.0 * speed_rpm**-0.83 * pitch_diameter**-0.5)
    return float(4_500.0 * speed_rpm**-0.5 * pitch_diameter**-0.5)


def life_factor(viscosity_ratio: float, load_ratio: float) -> float:
    """a_ISO of radial roller bearings, ISO 281:2007, Eqs. (34) to (36) (Eq. 65).

    ``viscosity_ratio`` κ = ν/ν1; ``load_ratio`` e_C C_u/P. NaN below κ = 0.1, where the standard ends.
    """
    if viscosity_ratio < LEAST_VISCOSITY_RATIO:
        return math.nan
    kappa = min(viscosity_ratio, LARGEST_VISCOSITY_RATIO)
    if kappa < 0.4:
        film = 1.5859 - 1.3993 / kappa**0.054381
    else:
        film = 1.5859 - 1.2348 / kappa ** (0.19087 if kappa < 1.0 else 0.071739)
    damage = 1.0 - film * load_ratio**0.4
    least = (0.1 / LARGEST_LIFE_FACTOR) ** (1.0 / 9.185)
    return float(0.1 * max(damage, least) ** -9.185)


@dataclass(frozen=True, eq=False, slots=True)
class BearingLife:
    """Life of the bearings between cranks and discs under a load.

    ``load_rating`` C of each bearing [N]; ``equivalent_load`` P, shape (discs, bearings of a disc) [N]; ``speed_rpm``
    of the crank against the disc; ``life_h``, basic rating life L10 in the same shape [h], infinite at rest.
    """

    load_rating: float
    equivalent_load: FloatArray
    speed_rpm: float
    life_h: FloatArray

    @property
    def least_life_h(self) -> float:
        """L10 of the most loaded bearing [h]."""
        return float(np.min(self.life_h))

    @property
    def life_of_all_h(self) -> float:
        """L10 of all these bearings together: the first that fails counts [h]."""
        return life_of_all(self.life_h)


def crank_bearing_life(
    sharing: LoadSharing, output_speed: float, load_rating: float, equal_bearings: bool = False
) -> BearingLife:
    """Basic rating life from the bearing forces of ``sharing``, its poses spread evenly over a turn (Eqs. 62–64).

    Parameters
    ----------
    sharing : whole stage; poses over a turn of the output, or over one turn of the crank if ``equal_bearings``
    output_speed : Ω [rad/s]
    load_rating : C of each bearing [N]
    equal_bearings : whether all bearings pass through the same loads in a turn of the output, as those of nominal
        parts do; one turn of the crank then holds these loads, spread over the bearings

    Raises
    ------
    LoadError
        If ``sharing`` has no bearing forces, as of a disc on a held crank, or C is not positive.
    """
    if sharing.stage is None:
        raise LoadError("bearing forces", sharing.solver, "does not compute them", "use StageEquilibrium", " by ")
    if not (math.isfinite(load_rating) and load_rating > 0.0):
        raise LoadError("load_rating", f"{load_rating} N", "is not positive", "give the dynamic load rating C")
    load = equivalent_load(sharing.stage.bearing_force)
    if equal_bearings:
        load = np.full_like(load, equivalent_load(load.ravel()))
    # A crank turns z_p times as fast against the disc as the output against the housing.
    speed_rpm = abs(output_speed) * sharing.case.drive.trochoid.pins * 30.0 / math.pi
    hours = basic_rating_life(load_rating, load) / (60.0 * speed_rpm) if speed_rpm else np.full_like(load, math.inf)
    return BearingLife(load_rating, load, speed_rpm, hours)
