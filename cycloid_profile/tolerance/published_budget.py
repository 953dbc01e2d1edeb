"""The three-part lost-motion budget of [LM]: as published, corrected, and for a drive at hand (docs/budget.md).

Symbols of the article, left, and names here: Δφ̄ and T_Δφ, ``mean`` and ``tolerance`` of a ``Part``, meaning
mean ± T/2; d_1, sun diameter; E_s1, E_s2, ``normal_length_upper`` and ``_lower``; Δa, ``centre_distance``; ΔF_r,
``gear_runout``; Δr, ``pin``; Δρ, ``disc``; Δ, ``bearing``; aζ, longest lever a z_c; e, short-width ratio K1; r, radius
of the crank circle; i, ratio. The article prints ′; angles here are in rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.catalog.published import LostMotionArticle, PublishedPart, lost_motion_article
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.effects.ring import PinCircleRadiusError, PinRadiusError
from cycloid_profile.geometry.drive import Cranks, Drive
from cycloid_profile.tolerance.exact_sensitivities import BearingPlay, Bench, Opening, by_effect
from cycloid_profile.tolerance.first_stage import PRESSURE_ANGLE, InvolutePair, output_per_sun_play
from cycloid_profile.tolerance.sensitivity_formulas import pin_circle, pin_radius
from cycloid_profile.units import ARCMIN, UM

_SIGMAS = 6.0  # a tolerance T is ±3 σ wide
# Quantile of a normal distribution for a confidence of 95 %.
_CONFIDENCE = 1.959963984540054


@dataclass(frozen=True, slots=True)
class Part:
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

    def over(self, ratio: float) -> Part:
        """The part seen behind a reduction of ``ratio``."""
        return Part(self.mean / ratio, self.tolerance / ratio)


@dataclass(frozen=True, slots=True)
class Budget:
    """The three parts, the ``involute`` stage at the sun and the others at the output; None where a drive has none.

    ``ratio`` i takes the first to the output.
    """

    involute: Part | None
    cycloid: Part
    bearing: Part | None
    ratio: float

    @property
    def at_output(self) -> tuple[Part, ...]:
        """The parts there are, as they show at the output."""
        first = None if self.involute is None else self.involute.over(self.ratio)
        return tuple(part for part in (first, self.cycloid, self.bearing) if part is not None)

    @property
    def total(self) -> Part:
        """Means add up, tolerances as the root of their squares (Eq. B12)."""
        return Part(
            sum(part.mean for part in self.at_output),
            math.sqrt(sum(part.tolerance**2 for part in self.at_output)),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class PartErrors:
    """Errors of the parts [µm]: upper and lower deviation of a common normal, and ± limits; means are those drawn.

    ``gear_runout_um`` is the reading, twice the offset; ``disc_um`` acts like a radial-moving amount, ``bearing_um`` is
    radial.
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
    given = lost_motion_article().plus_minus
    return PartErrors(
        normal_length_upper_um=given.normal_length_um,
        normal_length_lower_um=-given.normal_length_um,
        centre_distance_um=given.centre_distance_um,
        gear_runout_um=given.gear_runout_um,
        pin_um=given.pin_um,
        disc_um=given.disc_um,
        bearing_um=given.bearing_um,
    )


def involute_stage(errors: PartErrors, sun_diameter: float, pressure_angle: float = PRESSURE_ANGLE) -> Part:
    """Play of the involute stage as an angle of the sun (Eqs. B8, B9)."""
    j, D = _mean_play(errors, pressure_angle), _variances(errors, pressure_angle)
    return Part(2.0 * j / sun_diameter, _SIGMAS * math.sqrt(sum(D)) * 2.0 / sun_diameter)


def involute_stage_as_published(
    errors: PartErrors, sun_diameter: float, pressure_angle: float = PRESSURE_ANGLE
) -> Part:
    """The same with the printed D(j2) and D(j3), which are mm⁴, and T = √ΣD/d_1, a sixth of the width and half of 2."""
    j, D1 = _mean_play(errors, pressure_angle), _variances(errors, pressure_angle)[0]
    F_r, tan = errors.gear_runout_um * UM, math.tan(pressure_angle)
    D2 = (2.0 * errors.centre_distance_um * UM * F_r * tan / 3.0) ** 2
    D3 = (F_r * F_r * tan / 3.0) ** 2
    return Part(2.0 * j / sun_diameter, math.sqrt(D1 + D2 + D3) / sun_diameter)


def _mean_play(errors: PartErrors, pressure_angle: float) -> float:
    """j̄ = −(E_s1 + E_s2)/(2 cosα) along the pitch circle [mm]; axes and runout have the mean 0."""
    return -(errors.normal_length_upper_um + errors.normal_length_lower_um) * UM / (2.0 * math.cos(pressure_angle))


def _variances(errors: PartErrors, pressure_angle: float) -> tuple[float, float, float]:
    """D(j1), D(j2), D(j3), each limit 3 σ [mm²] (Eq. B9)."""
    cos, tan = math.cos(pressure_angle), math.tan(pressure_angle)
    width = (errors.normal_length_upper_um - errors.normal_length_lower_um) * UM
    return (
        (width / (6.0 * cos)) ** 2,
        (2.0 * errors.centre_distance_um * UM * tan / 3.0) ** 2,
        (errors.gear_runout_um * UM * tan / 3.0) ** 2,
    )


def cycloid_stage(drive: Drive, errors: PartErrors, pin: float = 0.0, disc: float = 0.0) -> Part:
    """Parts A and B of the cycloid stage, for means ``pin`` Δr and ``disc`` Δρ [mm] (Eq. B10).

    C and D are printed with an ellipsis and factors that are not defined, and are left out.
    """
    A, B = pin_radius(drive), pin_circle(drive)
    return Part(A * pin + B * disc, 2.0 * math.hypot(A * errors.pin_um * UM, B * errors.disc_um * UM))


def cycloid_stage_as_published(drive: Drive, errors: PartErrors, pin: float = 0.0, disc: float = 0.0) -> Part:
    """The same with B̄ divided by √(1−K1²), and T_A = T/(aζ), half of what the mean's factor 2 would make it."""
    A, K1 = pin_radius(drive), drive.trochoid.short_width_ratio
    B = A / math.sqrt(1.0 - K1**2)
    return Part(A * pin + B * disc, math.hypot(A * errors.pin_um * UM, B * errors.disc_um * UM))


def eccentric_bearing(drive: Drive, errors: PartErrors, radial_play: float = 0.0, factor: float = 1.0) -> Part | None:
    """Play of the crank bearings, Δu = 2·radial play/K over the crank circle, K = ``factor`` (Eq. B11).

    None without crank shafts.
    """
    if not isinstance(drive.support, Cranks):
        return None
    r = drive.support.circle_radius * factor
    return Part(2.0 * radial_play / r, 2.0 * 2.0 * errors.bearing_um * UM / r)


def budget_from_geometry(case: LoadCase, errors: PartErrors | None = None, bench: Bench | None = None) -> Budget:
    """The budget of a drive with its tooth as ground: means from exact contact, tolerances by exact sensitivities.

    ``errors`` are those of the article's parameter table unless given.

    Raises
    ------
    SolveError
        If at some pose no touch or equilibrium is found.
    """
    given = printed_errors() if errors is None else errors
    used = Bench(case) if bench is None else bench
    drive = case.drive
    pin = Opening(by_effect(lambda amount: PinRadiusError(-amount))).slope(used).mean
    disc = Opening(by_effect(PinCircleRadiusError)).slope(used).mean
    cycloid = Part(
        float(np.mean(used.as_drawn.reducer)), 2.0 * math.hypot(pin * given.pin_um * UM, disc * given.disc_um * UM)
    )
    return Budget(
        _involute_from_geometry(case, given), cycloid, _bearing_from_geometry(used, given), drive.reduction_ratio
    )


def _involute_from_geometry(case: LoadCase, errors: PartErrors) -> Part | None:
    """By exact involutes and the stage model, as an angle of the sun that kinematics bring to the output."""
    stage = case.drive.first_stage
    if stage is None:
        return None
    pair = InvolutePair(stage)
    upper, lower = (-amount * UM for amount in (errors.normal_length_upper_um, errors.normal_length_lower_um))
    limits = [pair.play_of_normal_length(lower) - pair.play_of_normal_length(upper)]
    for offset in (errors.centre_distance_um * UM, 0.5 * errors.gear_runout_um * UM):
        limits.append(pair.play_of_centre_distance(offset) - pair.play_of_centre_distance(-offset))
    by_model = output_per_sun_play(case) * case.drive.reduction_ratio
    return Part(by_model * pair.play_of_normal_length(0.5 * (upper + lower)), by_model * math.hypot(*limits))


def _bearing_from_geometry(bench: Bench, errors: PartErrors) -> Part | None:
    support = bench.case.drive.support
    if not isinstance(support, Cranks):
        return None
    slope = BearingPlay().slope(bench).mean
    return Part(slope * 2.0 * support.bearing_play, slope * 2.0 * 2.0 * errors.bearing_um * UM)


@dataclass(frozen=True, slots=True)
class Reading:
    """How to read the number after the ± of the article: ``width`` times it is the tolerance T = 2·half band."""

    name: str
    width: float

    def of(self, article: LostMotionArticle) -> Budget:
        """The published parts so read."""
        involute, cycloid, bearing = (self._part(one) for one in (article.involute, article.cycloid, article.bearing))
        return Budget(involute, cycloid, bearing, article.ratio)

    def _part(self, printed: PublishedPart) -> Part:
        return Part(printed.mean_arcmin * ARCMIN, self.width * printed.tolerance_arcmin * ARCMIN)


# The text prints 1.76 ± 2.05, its table T = 2.05 and 1.76 ± 1.025.
TEXT, TABLE = Reading("text: ± is the half band", 2.0), Reading("table: ± is T/2", 1.0)


def confidence_of_mean(part: Part, runs: int) -> float:
    """Half the 95 % confidence interval of the mean of ``runs`` simulated reducers, T being 6 σ [rad].

    Says how well the mean is known, not how reducers scatter.
    """
    return _CONFIDENCE * part.tolerance / _SIGMAS / math.sqrt(runs)


def scatter_behind(confidence: float, runs: int) -> float:
    """Standard deviation of single reducers that leaves the mean of ``runs`` known to ± ``confidence`` at 95 %."""
    return confidence * math.sqrt(runs) / _CONFIDENCE
