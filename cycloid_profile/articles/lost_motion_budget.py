"""The three-part lost-motion budget of [LM]: as published, corrected, and for a given drive (docs/budget.md).

Symbols of the article, left, and names here: Δφ̄ and T_Δφ, ``mean`` and ``tolerance`` of a ``BudgetPart``, meaning
mean ± T/2; d_1, sun diameter; E_s1, E_s2, ``normal_length_upper`` and ``_lower``; Δa, ``centre_distance``; ΔF_r,
``gear_runout``; Δr, ``pin``; Δρ, ``disc``; Δ, ``bearing``; aζ, longest lever a z_c; e, short-width ratio K1; r, radius
of the crank circle; i, ratio. The article prints ′; angles here are in rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import msgspec
import numpy as np

from cycloid_profile.articles.finite_difference import (
    DifferenceSetup,
    bearing_play,
    by_effect,
    one_sided,
    output_per_sun_play,
)
from cycloid_profile.articles.formulas import PRESSURE_ANGLE, InvolutePair, pin_circle, pin_radius
from cycloid_profile.catalog import LostMotionArticle, PublishedPart, lost_motion_article
from cycloid_profile.contact import LoadCase
from cycloid_profile.effects import PinCircleRadiusError, PinRadiusError
from cycloid_profile.geometry import Cranks, Drive
from cycloid_profile.units import ARCMIN, UM

_SIGMAS = 6.0  # a tolerance T is ±3 σ wide
# Quantile of a normal distribution for a confidence of 95 %.
_CONFIDENCE = 1.959963984540054


@dataclass(frozen=True, slots=True)
class BudgetPart:
    """One part of a budget: ``mean`` and ``tolerance`` T, the whole width [rad]; the play is mean ± T/2."""

    mean: float
    tolerance: float

    @property
    def half_band(self) -> float:
        """T/2 [rad]."""
        return 0.5 * self.tolerance

    @property
    def range(self) -> tuple[float, float]:
        """Mean − T/2 and mean + T/2 [rad]."""
        return self.mean - self.half_band, self.mean + self.half_band

    def divided_by(self, ratio: float) -> BudgetPart:
        """The part referred to the output of a reduction of ``ratio``."""
        return BudgetPart(self.mean / ratio, self.tolerance / ratio)


@dataclass(frozen=True, slots=True)
class Budget:
    """The three parts, the ``involute`` stage at the sun and the others at the output; None where a drive has none.

    Division by ``ratio`` i refers the involute part to the output.
    """

    involute: BudgetPart | None
    cycloid: BudgetPart
    bearing: BudgetPart | None
    ratio: float

    @property
    def involute_at_output(self) -> BudgetPart | None:
        """The involute stage referred to the output."""
        return None if self.involute is None else self.involute.divided_by(self.ratio)

    @property
    def at_output(self) -> tuple[BudgetPart, ...]:
        """The existing parts, referred to the output."""
        return tuple(part for part in (self.involute_at_output, self.cycloid, self.bearing) if part is not None)

    @property
    def total(self) -> BudgetPart:
        """Sum of the means, root sum of squares of the tolerances (Eq. B12)."""
        return BudgetPart(
            sum(part.mean for part in self.at_output),
            math.sqrt(sum(part.tolerance**2 for part in self.at_output)),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class PartErrors:
    """Errors of the parts [µm]: upper and lower deviation of a common normal, and ± limits; means are those drawn.

    ``gear_runout_um`` is the dial indicator value, twice the offset; ``disc_um`` acts like a radial-moving amount,
    ``bearing_um`` is radial.
    """

    normal_length_upper_um: float
    normal_length_lower_um: float
    centre_distance_um: float
    gear_runout_um: float
    pin_um: float
    disc_um: float
    bearing_um: float


def printed_errors() -> PartErrors:
    """The parameter table of the article."""
    given = msgspec.structs.asdict(lost_motion_article().plus_minus)
    normal_length = given.pop("normal_length_um")
    return PartErrors(normal_length_upper_um=normal_length, normal_length_lower_um=-normal_length, **given)


def involute_stage(errors: PartErrors, sun_diameter: float) -> BudgetPart:
    """Play of the involute stage as an angle of the sun (Eqs. B8, B9)."""
    j, variances = _involute_play(errors)
    return BudgetPart(2.0 * j / sun_diameter, _SIGMAS * math.sqrt(sum(variances)) * 2.0 / sun_diameter)


def involute_stage_as_published(errors: PartErrors, sun_diameter: float) -> BudgetPart:
    """The same with the printed D(j2) and D(j3), which have the unit mm⁴, and the printed T = √ΣD/d_1. This lacks the
    factor 6 of the width and the factor 2 of the play."""
    j, (D1, _, _) = _involute_play(errors)
    F_r, tan = errors.gear_runout_um * UM, math.tan(PRESSURE_ANGLE)
    D2 = (2.0 * errors.centre_distance_um * UM * F_r * tan / 3.0) ** 2
    D3 = (F_r * F_r * tan / 3.0) ** 2
    return BudgetPart(2.0 * j / sun_diameter, math.sqrt(D1 + D2 + D3) / sun_diameter)


def _involute_play(errors: PartErrors) -> tuple[float, tuple[float, float, float]]:
    """Mean along the pitch circle, j̄ = −(E_s1 + E_s2)/(2 cosα) [mm], and D(j1), D(j2), D(j3) [mm²] (Eq. B9).

    Axes and runout have the mean 0; each limit is 3 σ.
    """
    cos, tan = math.cos(PRESSURE_ANGLE), math.tan(PRESSURE_ANGLE)
    upper, lower = errors.normal_length_upper_um, errors.normal_length_lower_um
    return -(upper + lower) * UM / (2.0 * cos), (
        ((upper - lower) * UM / (6.0 * cos)) ** 2,
        (2.0 * errors.centre_distance_um * UM * tan / 3.0) ** 2,
        (errors.gear_runout_um * UM * tan / 3.0) ** 2,
    )


def cycloid_stage(drive: Drive, errors: PartErrors, pin: float = 0.0, disc: float = 0.0) -> BudgetPart:
    """Parts A and B of the cycloid stage, for means ``pin`` Δr and ``disc`` Δρ [mm] (Eq. B10).

    C and D are printed with an ellipsis and factors that are not defined, and are left out.
    """
    A, B = pin_radius(drive), pin_circle(drive)
    return BudgetPart(A * pin + B * disc, 2.0 * math.hypot(A * errors.pin_um * UM, B * errors.disc_um * UM))


def cycloid_stage_as_published(drive: Drive, errors: PartErrors, pin: float = 0.0, disc: float = 0.0) -> BudgetPart:
    """The same with B̄ divided by √(1−K1²), and T_A = T/(aζ), without the factor 2 that the mean has."""
    A, K1 = pin_radius(drive), drive.trochoid.short_width_ratio
    B = A / math.sqrt(1.0 - K1**2)
    return BudgetPart(A * pin + B * disc, math.hypot(A * errors.pin_um * UM, B * errors.disc_um * UM))


def eccentric_bearing(
    drive: Drive, errors: PartErrors, radial_play: float = 0.0, factor: float = 1.0
) -> BudgetPart | None:
    """Play of the crank bearings, Δu = 2·radial play/K over the crank circle, K = ``factor`` (Eq. B11).

    None without crank shafts.
    """
    if not isinstance(drive.support, Cranks):
        return None
    r = drive.support.circle_radius * factor
    return BudgetPart(2.0 * radial_play / r, 2.0 * 2.0 * errors.bearing_um * UM / r)


def budget_from_geometry(
    case: LoadCase, errors: PartErrors | None = None, setup: DifferenceSetup | None = None
) -> Budget:
    """Budget of a drive, tooth modifications included: means from exact contact, tolerances from exact sensitivities.

    ``errors`` are those of the article's parameter table unless given.

    Raises
    ------
    SolveError
        If at some pose no touch or equilibrium is found.
    """
    given = printed_errors() if errors is None else errors
    used = DifferenceSetup(case) if setup is None else setup
    return budget_of_bands(used, given, parameter_bands(used, given))


def parameter_bands(setup: DifferenceSetup, errors: PartErrors) -> dict[str, float | None]:
    """Half band of the lost motion at the output that each of ``errors`` makes alone, by field [rad].

    None where the drive lacks the part. The wind-up of discs and bearings is kept out, see ``finite_difference``.

    Raises ``SolveError`` if at some pose no touch or equilibrium is found.
    """
    case = setup.case
    pin = one_sided(by_effect(lambda amount: PinRadiusError(-amount)))(setup).mean
    disc = one_sided(by_effect(PinCircleRadiusError))(setup).mean
    normal = centre = runout = bearing = None
    if case.drive.first_stage is not None:
        pair, output = InvolutePair(case.drive.first_stage), output_per_sun_play(case)
        thickest, thinnest = (
            pair.play_of_normal_length(-amount * UM)
            for amount in (errors.normal_length_upper_um, errors.normal_length_lower_um)
        )
        normal = 0.5 * output * (thinnest - thickest)
        centre, runout = (
            0.5 * output * (pair.play_of_centre_distance(offset) - pair.play_of_centre_distance(-offset))
            for offset in (errors.centre_distance_um * UM, 0.5 * errors.gear_runout_um * UM)
        )
    if isinstance(case.drive.support, Cranks):
        bearing = bearing_play(setup).mean * 2.0 * errors.bearing_um * UM
    return {
        "normal_length_um": normal,
        "centre_distance_um": centre,
        "gear_runout_um": runout,
        "pin_um": pin * errors.pin_um * UM,
        "disc_um": disc * errors.disc_um * UM,
        "bearing_um": bearing,
    }


def budget_of_bands(setup: DifferenceSetup, errors: PartErrors, bands: dict[str, float | None]) -> Budget:
    """The budget of the parts from the ``bands`` of the single errors; means are those of the drawing."""
    drive, involute, bearing = setup.case.drive, None, None

    def tolerance(*names: str) -> float:
        return 2.0 * math.hypot(*(bands[name] or 0.0 for name in names))

    if drive.first_stage is not None:
        pair = InvolutePair(drive.first_stage)
        play = pair.play_of_normal_length(-0.5 * (errors.normal_length_upper_um + errors.normal_length_lower_um) * UM)
        width = tolerance("normal_length_um", "centre_distance_um", "gear_runout_um")
        output = output_per_sun_play(setup.case)
        involute = BudgetPart(drive.reduction_ratio * output * play, drive.reduction_ratio * width)
    if isinstance(drive.support, Cranks):
        # In proportion: one slope for the play of the drawing and for its tolerance.
        # Preloaded bearings, of a negative play, have none.
        play = max(drive.support.bearing_play, 0.0)
        per_radial_play = bearing_play(setup).mean * 2.0 if play else 0.0
        bearing = BudgetPart(per_radial_play * play, tolerance("bearing_um"))
    cycloid = BudgetPart(float(np.mean(setup.nominal_backlash[0])), tolerance("pin_um", "disc_um"))
    return Budget(involute, cycloid, bearing, drive.reduction_ratio)


@dataclass(frozen=True, slots=True)
class PlusMinusConvention:
    """Meaning of a number printed after ±: ``tolerance_per_printed`` times it is the tolerance T = 2·half band."""

    name: str
    tolerance_per_printed: float

    def of(self, article: LostMotionArticle) -> Budget:
        """Budget of the published parts under this convention."""
        involute, cycloid, bearing = (self._part(one) for one in (article.involute, article.cycloid, article.bearing))
        return Budget(involute, cycloid, bearing, article.ratio)

    def _part(self, printed: PublishedPart) -> BudgetPart:
        return BudgetPart(printed.mean_arcmin * ARCMIN, self.tolerance_per_printed * printed.tolerance_arcmin * ARCMIN)


# The text prints 1.76 ± 2.05, its table T = 2.05 and 1.76 ± 1.025.
TEXT, TABLE = PlusMinusConvention("text: ± is the half band", 2.0), PlusMinusConvention("table: ± is T/2", 1.0)


def confidence_of_mean(part: BudgetPart, runs: int) -> float:
    """Half the 95 % confidence interval of the mean of ``runs`` simulated reducers, T being 6 σ [rad].

    It is the uncertainty of the mean, not the scatter of single reducers.
    """
    return _CONFIDENCE * part.tolerance / _SIGMAS / math.sqrt(runs)


def single_reducer_deviation(confidence: float, runs: int) -> float:
    """Standard deviation of single reducers, from the 95 % ``confidence`` of the mean of ``runs`` of them [rad]."""
    return confidence * math.sqrt(runs) / _CONFIDENCE
