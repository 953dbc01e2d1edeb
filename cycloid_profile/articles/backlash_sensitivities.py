"""The fifteen sensitivities of [TP]: as published, corrected, and measured on the exact model (docs/budget.md)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum

from cycloid_profile.articles.finite_difference import (
    BacklashSlope,
    DifferenceSetup,
    Method,
    WithError,
    bearing_play,
    by_effect,
    central,
    one_sided,
    scattered_pins,
    sun_play,
)
from cycloid_profile.articles.formulas import (
    InvolutePair,
    centre_distance,
    crank_bearing,
    normal_length,
    pin_circle,
    pin_circle_as_published,
    pin_position,
    pin_radius,
    sun_over_planet,
)
from cycloid_profile.catalog import tooth_profile_article
from cycloid_profile.contact import LoadCase
from cycloid_profile.effects import (
    AsBuiltReducer,
    CumulativePitchError,
    DiscRunout,
    EquidistantError,
    PinCircleRadiusError,
    PinRadiusError,
    RadialMovingError,
    as_drawn,
)
from cycloid_profile.errors import SolveError
from cycloid_profile.geometry import Cranks, Drive
from cycloid_profile.modification import Equidistant, Modification, RadialMoving, modify
from cycloid_profile.units import ARCMIN, UM


class RequiredPart(Enum):
    """The part of a drive to which an error factor belongs; the value is reported where the part is missing."""

    DISC = ""
    FIRST_STAGE = "absent: no first stage"
    CRANKS = "absent: no crank shafts"

    def is_present_in(self, drive: Drive) -> bool:
        """Whether the drive has the part."""
        if self is RequiredPart.FIRST_STAGE:
            return drive.first_stage is not None
        return self is RequiredPart.DISC or isinstance(drive.support, Cranks)


@dataclass(frozen=True)
class Factor:
    """One error factor of the article's table. ``as_published`` is the formula behind the printed number, None where
    not found; ``corrected`` is the correct formula. ``method`` measures the factor, ``symbols`` prints the published
    formula, and ``why`` explains differences.
    """

    number: int
    symbols: str
    as_published: Callable[[Drive], float] | None
    corrected: Callable[[Drive], float]
    method: Method
    why: str
    needs: RequiredPart = RequiredPart.DISC


def larger_eccentrics(case: LoadCase, amount: float) -> AsBuiltReducer:
    """Every eccentric larger by ``amount`` [mm], the teeth unchanged."""
    path = replace(case.drive.trochoid, eccentricity=case.drive.trochoid.eccentricity + amount)
    return as_drawn(replace(case, drive=replace(case.drive, trochoid=path)))


def _ground(modification: Callable[[float], Modification]) -> WithError:
    return lambda case, amount: as_drawn(replace(case, profile=modify(case.profile, modification(amount))))


def _times(share: float | Callable[[Drive], float], of: Callable[[Drive], float]) -> Callable[[Drive], float]:
    return lambda drive: (share(drive) if callable(share) else share) * of(drive)


_ROOT = "normal at ψ0 is radial by √(1−K1²); the article squares the root"
_AGREES = "agree; pins near ψ0 have a slightly shorter lever"
_EQUIDISTANT, _RADIAL = "2k/(a z_c)", "2k(1−K1²)/(a z_c)"
_CENTRES = "2k tanα/(i r_2)", _times(sun_over_planet, centre_distance), centre_distance
_STAGE_1 = "play on the pitch circle turns the sun: divide by its radius, not the planet's"
_INVOLUTE = "exact involute, through the stage model"
_NORMAL_AT_PSI0 = "amplitude along the normal at ψ0 of all discs"
_THINNER_PINS = by_effect(lambda amount: PinRadiusError(-amount))
# Pressed against its hole from any side, a pin in a clearance c is a pin thinner by c/2.
_LOOSE_PINS = by_effect(lambda clearance: PinRadiusError(-0.5 * clearance))

# fmt: off
FACTORS: tuple[Factor, ...] = (
    Factor(1, "k/(i r_2 cosα)", _times(sun_over_planet, normal_length), normal_length,
           sun_play(InvolutePair.play_of_normal_length, _INVOLUTE), _STAGE_1, RequiredPart.FIRST_STAGE),
    Factor(2, *_CENTRES, sun_play(InvolutePair.play_of_centre_distance, _INVOLUTE), _STAGE_1, RequiredPart.FIRST_STAGE),
    Factor(3, *_CENTRES,
           sun_play(InvolutePair.play_of_centre_distance,
                    f"mean over a turn of one planet per mm of offset; {_INVOLUTE}", turning=True),
           "as 2, and an offset rotates with the planet: the published number is its worst, its mean is 0",
           RequiredPart.FIRST_STAGE),
    Factor(4, _RADIAL, pin_circle_as_published, pin_circle, one_sided(by_effect(PinCircleRadiusError)), _ROOT),
    Factor(5, _EQUIDISTANT, pin_radius, pin_radius, one_sided(_THINNER_PINS), _AGREES),
    Factor(6, "k/(a z_c)", _times(0.5, pin_radius), _times(0.5, pin_radius), one_sided(_LOOSE_PINS),
           "agree; diametral clearance, half of it on either flank"),
    Factor(7, "k/(2 a z_c)", _times(0.25, pin_radius), _times(0.25, pin_radius),
           one_sided(by_effect(DiscRunout), "amplitude of all discs"),
           "moved across the crank one flank gains what the other loses: no play; "
           "of several discs the first in contact limits the rotation"),
    Factor(8, "2k K1/(a z_c)", pin_position, pin_position, scattered_pins,
           "published: both contacting pins displaced in the unfavourable direction; "
           "scatter lets the nearest pin touch, so mean backlash falls"),
    Factor(9, "k K1/(a z_c)", _times(0.5, pin_position), _times(0.5, pin_position),
           one_sided(by_effect(CumulativePitchError), _NORMAL_AT_PSI0),
           "opens one side of the disc and closes the other: mean 0 on one disc; "
           "of several discs the first in contact limits the rotation"),
    Factor(10, _EQUIDISTANT, pin_radius, pin_radius, one_sided(by_effect(EquidistantError)), _AGREES),
    Factor(11, _RADIAL, pin_circle_as_published, pin_circle, one_sided(by_effect(RadialMovingError)), _ROOT),
    Factor(12, "not found", None, lambda drive: 0.0,  # noqa: ARG005 - the same for every drive
           central(larger_eccentrics), "removal vanishes at ψ0: 0 to first order; 1.6544 could not be derived"),
    Factor(13, "k/r_c", crank_bearing, crank_bearing, bearing_play,
           "agree on three cranks, where fewer bearings carry while play is taken up; on two a disc also shifts",
           RequiredPart.CRANKS),
    Factor(14, _EQUIDISTANT, pin_radius, pin_radius, one_sided(_ground(Equidistant)), _AGREES),
    Factor(15, _RADIAL, pin_circle_as_published, pin_circle, one_sided(_ground(RadialMoving)), _ROOT),
)
# fmt: on


@dataclass(frozen=True, slots=True)
class BacklashSensitivity:
    """One row for one drive [rad/mm]: ``printed`` in the article for its own drive; its formula ``as_published`` and
    ``corrected`` for this drive; ``geometry`` measured. The last three are None where the drive lacks the part,
    the last where its tooth is so tight that the error makes it bind; ``why`` says so.
    """

    factor: Factor
    name: str
    printed: float
    printed_weight: float
    as_published: float | None
    corrected: float | None
    geometry: BacklashSlope | None
    why: str


def sensitivities(case: LoadCase, setup: DifferenceSetup | None = None) -> tuple[BacklashSensitivity, ...]:
    """The fifteen rows for the drive and tooth of ``case``; a part it lacks leaves its rows empty."""
    used = DifferenceSetup(case) if setup is None else setup
    return tuple(
        _row(factor, used, one.factor, one.arcmin_per_mm * ARCMIN, one.weight)
        for factor, one in zip(FACTORS, tooth_profile_article().sensitivities, strict=True)
    )


def _row(factor: Factor, setup: DifferenceSetup, name: str, printed: float, weight: float) -> BacklashSensitivity:
    drive = setup.case.drive
    if not factor.needs.is_present_in(drive):
        return BacklashSensitivity(factor, name, printed, weight, None, None, None, factor.needs.value)
    by_formula = None if factor.as_published is None else factor.as_published(drive)
    geometry, why = None, factor.why
    try:
        geometry = factor.method(setup)
    except SolveError:
        why = f"not measured: with {setup.step / UM:g} µm of it this tight tooth binds"
    return BacklashSensitivity(factor, name, printed, weight, by_formula, factor.corrected(drive), geometry, why)


def weights(values: tuple[float | None, ...]) -> tuple[float | None, ...]:
    """Magnitudes divided by their sum, the weights of the article. They rank sensitivities, not errors."""
    total = sum(abs(value) for value in values if value is not None)
    return tuple(None if value is None else abs(value) / total for value in values)
