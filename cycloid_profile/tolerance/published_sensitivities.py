"""The fifteen sensitivities of [TP]: as published, corrected, and measured on the exact model (docs/budget.md)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum

from cycloid_profile.catalog.published import tooth_profile_article
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.effects.built import Built, as_drawn
from cycloid_profile.effects.process import CumulativePitchError, DiscRunout, EquidistantError, RadialMovingError
from cycloid_profile.effects.ring import PinCircleRadiusError, PinRadiusError
from cycloid_profile.errors import SolveError
from cycloid_profile.geometry.drive import Cranks, Drive
from cycloid_profile.modification.setup import Equidistant, Modification, RadialMoving, modify
from cycloid_profile.tolerance.exact_sensitivities import (
    BearingPlay,
    Bench,
    Directed,
    Measure,
    Opening,
    ScatteredPins,
    Slope,
    SunPlay,
    TwoSided,
    by_effect,
)
from cycloid_profile.tolerance.first_stage import InvolutePair
from cycloid_profile.tolerance.sensitivity_formulas import (
    centre_distance,
    centre_distance_as_published,
    crank_bearing,
    normal_length,
    normal_length_as_published,
    part_of,
    pin_circle,
    pin_circle_as_published,
    pin_position,
    pin_radius,
)
from cycloid_profile.units import ARCMIN, UM


class Needs(Enum):
    """The part of a drive a factor is an error of; the value is said where it is missing."""

    DISC = ""
    FIRST_STAGE = "absent: no first stage"
    CRANKS = "absent: no crank shafts"

    def met_by(self, drive: Drive) -> bool:
        """Whether the drive has the part."""
        if self is Needs.FIRST_STAGE:
            return drive.first_stage is not None
        return self is Needs.DISC or isinstance(drive.support, Cranks)


def _off_crank(case: LoadCase, amount: float) -> Built:
    """Every eccentric larger by ``amount`` [mm], the teeth as they are."""
    path = replace(case.drive.trochoid, eccentricity=case.drive.trochoid.eccentricity + amount)
    return as_drawn(replace(case, drive=replace(case.drive, trochoid=path)))


def _ground(modification: Callable[[float], Modification]) -> Callable[[LoadCase, float], Built]:
    return lambda case, amount: as_drawn(replace(case, profile=modify(case.profile, modification(amount))))


@dataclass(frozen=True)
class Factor:
    """One of the fifteen: its formula as the article's number has it (None where not found) and as it should be, the
    way to measure it, the ``symbols`` of the published formula, and why the columns differ.
    """

    number: int
    symbols: str
    as_published: Callable[[Drive], float] | None
    corrected: Callable[[Drive], float]
    measure: Measure
    why: str
    needs: Needs = Needs.DISC


_ROOT = "normal at ψ0 is radial by √(1−K1²); the article squares the root"
_AGREES = "agree; pins beside ψ0 have a little less lever"
_EQUIDISTANT, _RADIAL = "2k/(a z_c)", "2k(1−K1²)/(a z_c)"
_STAGE_1 = "play on the pitch circle turns the sun: divide by its radius, not the planet's"

FACTORS: tuple[Factor, ...] = (
    Factor(
        1,
        "k/(i r_2 cosα)",
        normal_length_as_published,
        normal_length,
        SunPlay(InvolutePair.play_of_normal_length, "exact involute, through the stage model"),
        _STAGE_1,
        Needs.FIRST_STAGE,
    ),
    Factor(
        2,
        "2k tanα/(i r_2)",
        centre_distance_as_published,
        centre_distance,
        SunPlay(InvolutePair.play_of_centre_distance, "exact involute, through the stage model"),
        _STAGE_1,
        Needs.FIRST_STAGE,
    ),
    Factor(
        3,
        "2k tanα/(i r_2)",
        centre_distance_as_published,
        centre_distance,
        SunPlay(
            InvolutePair.play_of_centre_distance,
            "mean over a turn of one planet per mm of offset; exact involute, through the stage model",
            comes_round=True,
        ),
        "as 2, and an offset comes round: the published number is its worst, its mean is 0",
        Needs.FIRST_STAGE,
    ),
    Factor(
        4,
        _RADIAL,
        pin_circle_as_published,
        pin_circle,
        Opening(by_effect(PinCircleRadiusError)),
        _ROOT,
    ),
    Factor(
        5,
        _EQUIDISTANT,
        pin_radius,
        pin_radius,
        Opening(by_effect(lambda amount: PinRadiusError(-amount))),
        _AGREES,
    ),
    Factor(
        6,
        "k/(a z_c)",
        part_of(0.5, pin_radius),
        part_of(0.5, pin_radius),
        # Pressed against its hole from any side, a pin in a clearance c is a pin thinner by c/2.
        Opening(by_effect(lambda clearance: PinRadiusError(-0.5 * clearance))),
        "agree; diametral clearance, half of it on either flank",
    ),
    Factor(
        7,
        "k/(2 a z_c)",
        part_of(0.25, pin_radius),
        part_of(0.25, pin_radius),
        Directed(DiscRunout, "amplitude of all discs"),
        "moved across the crank one flank gains what the other loses: no play; of several discs the nearer stops",
    ),
    Factor(
        8,
        "2k K1/(a z_c)",
        pin_position,
        pin_position,
        ScatteredPins(),
        "published: both touching pins off the bad way; scatter lets the nearest pin touch, so mean backlash falls",
    ),
    Factor(
        9,
        "k K1/(a z_c)",
        part_of(0.5, pin_position),
        part_of(0.5, pin_position),
        Directed(CumulativePitchError, "amplitude along the normal at ψ0 of all discs"),
        "opens one side of the disc and closes the other: mean 0 on one disc; of several discs the nearer stops",
    ),
    Factor(
        10,
        _EQUIDISTANT,
        pin_radius,
        pin_radius,
        Opening(by_effect(EquidistantError)),
        _AGREES,
    ),
    Factor(
        11,
        _RADIAL,
        pin_circle_as_published,
        pin_circle,
        Opening(by_effect(RadialMovingError)),
        _ROOT,
    ),
    Factor(
        12,
        "not found",
        None,
        lambda drive: 0.0,  # noqa: ARG005 - the same for every drive
        TwoSided(_off_crank),
        "removal vanishes at ψ0: 0 to first order; 1.6544 could not be derived",
    ),
    Factor(
        13,
        "k/r_c",
        crank_bearing,
        crank_bearing,
        BearingPlay(),
        "agree on three cranks, where fewer bearings carry while play is taken up; on two a disc also shifts",
        Needs.CRANKS,
    ),
    Factor(14, _EQUIDISTANT, pin_radius, pin_radius, Opening(_ground(Equidistant)), _AGREES),
    Factor(15, _RADIAL, pin_circle_as_published, pin_circle, Opening(_ground(RadialMoving)), _ROOT),
)


@dataclass(frozen=True, slots=True)
class Sensitivity:
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
    geometry: Slope | None
    why: str


def sensitivities(case: LoadCase, bench: Bench | None = None) -> tuple[Sensitivity, ...]:
    """The fifteen rows for the drive and tooth of ``case``; a part it lacks leaves its rows empty."""
    used = Bench(case) if bench is None else bench
    return tuple(
        _row(factor, used, one.factor, one.arcmin_per_mm * ARCMIN, one.weight)
        for factor, one in zip(FACTORS, tooth_profile_article().sensitivities, strict=True)
    )


def _row(factor: Factor, bench: Bench, name: str, printed: float, weight: float) -> Sensitivity:
    drive = bench.case.drive
    if not factor.needs.met_by(drive):
        return Sensitivity(factor, name, printed, weight, None, None, None, factor.needs.value)
    by_formula = None if factor.as_published is None else factor.as_published(drive)
    geometry, why = None, factor.why
    try:
        geometry = factor.measure.slope(bench)
    except SolveError:
        why = f"not measured: with {bench.step / UM:g} µm of it this tight tooth binds"
    return Sensitivity(factor, name, printed, weight, by_formula, factor.corrected(drive), geometry, why)


def weights(values: tuple[float | None, ...]) -> tuple[float | None, ...]:
    """Sizes over the sum of sizes: how the article weighs. They rank sensitivities, not errors."""
    total = sum(abs(value) for value in values if value is not None)
    return tuple(None if value is None else abs(value) / total for value in values)
