"""Manufacturing errors of the disc: they act on the flanks and appear in a scan.

Removal positive. ``disc`` is the number of the one disc concerned; without it all discs have the same error in the
frame of the carrier, as discs ground together through their bores do.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact import sliding_speed
from cycloid_profile.contact.disc import Equilibrium
from cycloid_profile.effects._removals import (
    BLEND,
    GENERATING_ANGLE,
    AngleAlongDisc,
    ArcLength,
    OneLobe,
    PitchDeviationWave,
    PolarAngle,
    Ramp,
    Shift,
    ToothForm,
    Wave,
)
from cycloid_profile.effects.base import (
    DISC_PART,
    LARGEST_UM,
    Effect,
    EffectLocation,
    angle_field,
    choice_field,
    part_field,
    part_indices,
    shape_field,
    size_field,
)
from cycloid_profile.effects.reducer import AsBuiltReducer
from cycloid_profile.geometry import NormalRemoval, ToothProfile, Trochoid
from cycloid_profile.modification import FlankRemoval, NormalDeviation
from cycloid_profile.units import DEGREE, UM

STEEL_EXPANSION = 11.5e-6  # 1/K
# Feet on waves shorter than this are searched on each wave, from so many points on it.
_SHORT_WAVE, _POINTS_ON_WAVE = 1.0, 8  # rad
# Feet on ends of a removal steeper than usual are searched on each of so many parts of the blend.
_POINTS_ON_BLEND = 4
# On the flank that wears with the lever: its slope jumps at the root.
_LEVER_POINTS = 361
FLANK_PART = "1: carries positive torque, 2: negative torque; both if absent"
_BLEND = "phase over which the removal ends, to either side [rad]"
# A steeper end would be a corner for every pin; a wider one reaches the flank that carries.
_BLENDS = 0.05, 1.5


class _Disc(NamedTuple):
    """A disc before the effect: its ``tooth``, its ``mounting_angle`` behind disc 1 [rad] and its ``reducer``."""

    tooth: ToothProfile
    mounting_angle: float
    reducer: AsBuiltReducer

    def with_removal(self, removal: NormalRemoval) -> ToothProfile:
        """The tooth with a further removal."""
        return replace(self.tooth, removals=(*self.tooth.removals, removal))


def _side(flank: int | None) -> int:
    """Sign of the phases on a flank, 0 for both."""
    return 0 if flank is None else 3 - 2 * flank


def _blend_spacing(blend: float) -> float | None:
    """Distance of points that finds every foot on a steep end; None where the usual search does."""
    return None if blend >= BLEND else blend / _POINTS_ON_BLEND


class _OnDiscs(Effect):
    """Effects that change the tooth of one disc or of all."""

    location = EffectLocation.FLANK
    disc: int | None

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        for j in part_indices(self, "disc", self.disc, reducer.discs):
            tooth = reducer.teeth[j]
            # Disc j is mounted at −2πj/(N z_c) to the first: a direction in the carrier has another angle in its frame.
            mounting_angle = 0.0 if self.disc is not None else 2.0 * np.pi * j / (reducer.discs * tooth.trochoid.lobes)
            reducer = reducer.with_tooth(j, self._modified_tooth(_Disc(tooth, mounting_angle, reducer)))
        return reducer

    def _modified_tooth(self, before: _Disc) -> ToothProfile:
        """The tooth with this effect."""
        raise NotImplementedError


@dataclass(frozen=True)
class EquidistantError(_OnDiscs):
    """Grinding wheel or its radius setting too large (wheel radius r_rp + amount).

    h = amount, the same everywhere. With ``flank`` on that flank alone, as of flanks ground one after the other, smooth
    at root and tip. Source: docs/theory.md, Eq. 13.
    """

    remedy = "correct the equidistant setting by the amount"
    amount_um: float = size_field("removal [µm]", 2.0, -LARGEST_UM, LARGEST_UM)
    disc: int | None = part_field(DISC_PART)
    flank: int | None = part_field(FLANK_PART, most=2)

    def _modified_tooth(self, before: _Disc) -> ToothProfile:
        amount = self.amount_um * UM
        if self.flank is not None:
            return before.with_removal(ToothForm(amount, 0, 0.0, _side(self.flank)))
        return replace(before.tooth, pin_radius=before.tooth.pin_radius + amount)


@dataclass(frozen=True)
class RadialMovingError(_OnDiscs):
    """Infeed of the grinding machine off: the pin circle of generation is too small by the amount.

    h = amount (1 − K1 cosψ) S. Looks like thermal growth of the disc. Source: docs/theory.md, Eq. 14.
    """

    remedy = "correct the infeed"
    amount_um: float = size_field("removal at root and tip [µm]", 2.0, -LARGEST_UM, LARGEST_UM)
    disc: int | None = part_field(DISC_PART)

    def _modified_tooth(self, before: _Disc) -> ToothProfile:
        path = before.tooth.trochoid
        smaller = replace(path, pin_circle_radius=path.pin_circle_radius - self.amount_um * UM)
        return replace(before.tooth, trochoid=smaller)


@dataclass(frozen=True)
class GeneratingEccentricityError(_OnDiscs):
    """Eccentricity set on the grinding machine too large by the amount.

    h = amount (cosψ − K1) S: deeper roots, higher tips, ψ0 untouched, so that backlash does not show it. Source:
    docs/theory.md, "Normal removal by cause".
    """

    remedy = "correct the eccentricity"
    amount_um: float = size_field("eccentricity above its setting [µm]", 1.0, -LARGEST_UM, LARGEST_UM)
    disc: int | None = part_field(DISC_PART)

    def _modified_tooth(self, before: _Disc) -> ToothProfile:
        path = before.tooth.trochoid
        return replace(before.tooth, trochoid=replace(path, eccentricity=path.eccentricity + self.amount_um * UM))


@dataclass(frozen=True)
class ThermalGrowth(_OnDiscs):
    """Disc warmer than the pin ring, while grinding or while running: everything grows by α·ΔT.

    h = −α ΔT Re(n̄ P), almost that of a radial-moving change of −α ΔT r_p.
    """

    remedy = "let the disc reach the temperature of the ring; scan at a second temperature to rule out a wrong infeed"
    temperature_k: float = size_field("disc above housing [K]", 3.0, -500.0, 500.0)
    disc: int | None = part_field(DISC_PART)

    def _modified_tooth(self, before: _Disc) -> ToothProfile:
        growth = 1.0 + STEEL_EXPANSION * self.temperature_k
        path = before.tooth.trochoid
        larger = replace(
            path, pin_circle_radius=path.pin_circle_radius * growth, eccentricity=path.eccentricity * growth
        )
        # Removals of micrometres would grow by picometres only.
        return replace(before.tooth, trochoid=larger, pin_radius=before.tooth.pin_radius * growth)


@dataclass(frozen=True)
class DiscRunout(_OnDiscs):
    """Tooth form ground off the axis of the bores: the disc was clamped eccentrically.

    ``form`` of the removal: 1 moves the tooth as a whole, h = −A cos(θ_n − φ) with θ_n the direction of the
    normal; 2 removes by the angle alone, h = −A cos(θ − φ), as a radial indicator would show it. φ is the polar
    angle of the largest excess of material.
    """

    remedy = "centre the fixture on the bores"
    phase_per_lobe_index = -1.0
    amplitude_um: float = size_field("amplitude, half the run-out read [µm]", 3.0, 0.0, LARGEST_UM)
    phase_deg: float = angle_field("polar angle of the high side [°]")
    disc: int | None = part_field(DISC_PART)
    form: int = part_field("1: tooth moved as a whole; 2: by the angle alone", 1, most=2)

    def _modified_tooth(self, before: _Disc) -> ToothProfile:
        phase = self.phase_deg * DEGREE + before.mounting_angle
        amount = self.amplitude_um * UM
        # The angle along the disc runs against the polar angle.
        return before.with_removal(Shift(amount, phase) if self.form == 1 else Wave(-amount, 1.0, -phase))


@dataclass(frozen=True)
class DiscOval(_OnDiscs):
    """Disc oval after hardening or clamping: twice per turn, h = −A cos(2(θ − φ))."""

    remedy = "clamp without bending; grind after a second anneal"
    phase_per_lobe_index = -2.0
    harmonic = 2
    amplitude_um: float = size_field("amplitude [µm]", 2.0, 0.0, LARGEST_UM)
    phase_deg: float = angle_field("polar angle of a high side [°]")
    disc: int | None = part_field(DISC_PART)

    def _modified_tooth(self, before: _Disc) -> ToothProfile:
        return before.with_removal(
            Wave(-self.amplitude_um * UM, 2.0, -2.0 * (self.phase_deg * DEGREE + before.mounting_angle))
        )


@dataclass(frozen=True)
class CumulativePitchError(_OnDiscs):
    """Indexing error of the workpiece spindle: lobes turned about the centre, once per turn of the disc.

    h = −A sinψ S cos(t − φ), with t the angle along the disc; A is the largest deviation along the normal, at ψ0.
    """

    remedy = "correct the index or the encoder mounting of the work spindle"
    phase_per_lobe_index = 1.0
    amplitude_um: float = size_field("amplitude along the normal at ψ0 [µm]", 3.0, 0.0, LARGEST_UM)
    phase_deg: float = angle_field("angle along the disc of the largest error [°]")
    disc: int | None = part_field(DISC_PART)

    def _modified_tooth(self, before: _Disc) -> ToothProfile:
        return before.with_removal(
            PitchDeviationWave(-self.amplitude_um * UM, 1.0, self.phase_deg * DEGREE - before.mounting_angle)
        )


@dataclass(frozen=True)
class WheelWearDrift(_OnDiscs):
    """Grinding wheel that wears during the pass: each later lobe keeps more material.

    h falls linearly from 0 where grinding began to −amount after a turn, with a step there (docs/theory.md, Eq. 128).
    """

    remedy = "dress more often, or spread the lobes over several passes"
    shapes = MappingProxyType({"start_in_lobe": (0.0, 0.25, 0.5, 0.75)})
    amount_um: float = size_field("material left on the last lobe [µm]", 1.0, -LARGEST_UM, LARGEST_UM)
    first_lobe: int = part_field("lobe ground first, 1 has its root at angle 0", 1)
    disc: int | None = part_field(DISC_PART)
    start_in_lobe: float = shape_field(
        "start of grinding within the first lobe, in pitches: 0 at the tip before it, 0.5 at its root", 0.0, -0.5, 1.0
    )
    blend_rad: float = shape_field(_BLEND, BLEND, *_BLENDS)

    def _modified_tooth(self, before: _Disc) -> ToothProfile:
        (lobe,) = part_indices(self, "first_lobe", self.first_lobe, before.tooth.trochoid.lobes)
        start = (2.0 * (lobe + self.start_in_lobe) - 1.0) * np.pi
        return before.with_removal(Ramp(self.amount_um * UM, start, self.blend_rad, _blend_spacing(self.blend_rad)))


@dataclass(frozen=True)
class GrindingChatter(_OnDiscs):
    """Vibration between wheel and disc: a wave on the flanks, any number to a turn.

    h = A cos(n t − φ). A vibration is even in time, so t is what ran at ``constant_speed``: the generating motion,
    t = ψ/z_c; the C axis of a polar machine, t the polar angle; or the surface, t the arc length over that of a turn
    times 2π (docs/theory.md, Eqs. 124 to 126).
    """

    remedy = "change speed so that n moves, balance the wheel"
    shapes = MappingProxyType({"constant_speed": ("generating", "c_axis", "surface")})
    amplitude_um: float = size_field("amplitude [µm]", 0.3, 0.0, LARGEST_UM)
    waves_per_turn: float = size_field("waves round the disc", 1000.0, 3.0, 20000.0)
    phase_deg: float = angle_field("phase of the wave at lobe 1's root [°]")
    disc: int | None = part_field(DISC_PART)
    constant_speed: str = choice_field("motion of constant speed", "generating", "c_axis", "surface")

    def _modified_tooth(self, before: _Disc) -> ToothProfile:
        by = _even_in(self.constant_speed, before.tooth.pin_radius)
        length = before.tooth.trochoid.phase_period / (self.waves_per_turn * _fastest(by, before.tooth.trochoid))
        short = length / _POINTS_ON_WAVE if length < _SHORT_WAVE else None
        phase = self.phase_deg * DEGREE - self.waves_per_turn * before.mounting_angle
        return before.with_removal(Wave(self.amplitude_um * UM, self.waves_per_turn, phase, short, by))


def chatter_angle(constant_speed: str, tooth: ToothProfile, phase: FloatArray) -> FloatArray:
    """Angle along the disc in which chatter is even, 0 at the root of lobe 1, in the shape of ``phase`` [rad].

    ``constant_speed`` as that of ``GrindingChatter``. Raises ``SpecError`` for another word.
    """
    GrindingChatter(0.0, 3.0, constant_speed=constant_speed)
    return _even_in(constant_speed, tooth.pin_radius).derivatives(phase, tooth.trochoid).value


def _even_in(constant_speed: str, radius: float) -> AngleAlongDisc:
    if constant_speed == "generating":
        return GENERATING_ANGLE
    return PolarAngle(radius) if constant_speed == "c_axis" else ArcLength(radius)


def _fastest(by: AngleAlongDisc, trochoid: Trochoid) -> float:
    """Largest rate of an angle along the disc, over its mean."""
    if by is GENERATING_ANGLE:
        return 1.0
    psi = np.linspace(0.0, np.pi, 181)
    return float(trochoid.lobes * np.max(by.derivatives(psi, trochoid).first))


@dataclass(frozen=True)
class ToothFormError(_OnDiscs):
    """The same deviation of form on every tooth: h = A cos(n ψ − φ), n whole waves from root to root.

    φ = 0 and 180° act equally on both flanks, ±90° with opposite signs. With ``flank`` the other flank is nominal.
    Several harmonics, or flanks that differ, are one effect each.
    """

    remedy = "correct the profile of the wheel, or the program of the path"
    amplitude_um: float = size_field("amplitude [µm]", 2.0, 0.0, LARGEST_UM)
    phase_deg: float = angle_field("phase of the wave at the root [°]")
    waves: int = part_field("waves from root to root", 2, most=20)
    flank: int | None = part_field(FLANK_PART, most=2)
    disc: int | None = part_field(DISC_PART)

    def _modified_tooth(self, before: _Disc) -> ToothProfile:
        length = 2.0 * np.pi / self.waves
        short = length / _POINTS_ON_WAVE if length < _SHORT_WAVE else None
        phase = self.phase_deg * DEGREE
        return before.with_removal(ToothForm(self.amplitude_um * UM, self.waves, phase, _side(self.flank), short))


@dataclass(frozen=True)
class MissingDeformationCompensation(_OnDiscs):
    """The deformation that the grinding program should add back to the flanks was left out.

    h = amount |sinψ| S. Source: docs/theory.md, Eq. 16.
    """

    remedy = "grind with the compensated program"
    amount_um: float = size_field("δmax that is missing [µm]", 2.0, -LARGEST_UM, LARGEST_UM)
    disc: int | None = part_field(DISC_PART)

    def _modified_tooth(self, before: _Disc) -> ToothProfile:
        return before.with_removal(FlankRemoval(self.amount_um * UM))


@dataclass(frozen=True)
class FlankWear(_OnDiscs):
    """Wear of the flank that carries, after Archard: depth in proportion to pressure × sliding.

    The shape is that of one disc at ``load_share`` times rated torque, ``amount`` its deepest place; ``flank`` 1
    carries a positive torque, 2 a negative one. ``by`` "lever" stands for a flank on which all pins carry and slide
    equally: the force follows the lever |sinψ| S. ``exponent`` p is that of the wear law (docs/theory.md, Eq. 127).
    Source: Archard, J. Appl. Phys. 24 (1953) 981.
    """

    remedy = "regrind, or look after lubricant and load"
    shapes = MappingProxyType({"by": ("pressure_sliding", "lever"), "exponent": (1.0, 0.5, 1.5, 2.0)})
    amount_um: float = size_field("deepest wear [µm]", 2.0, 0.0, LARGEST_UM)
    flank: int = part_field("1: carries positive torque, 2: carries negative torque", 1, most=2)
    disc: int | None = part_field(DISC_PART)
    by: str = choice_field("cause of the depth", "pressure_sliding", "lever")
    exponent: float = shape_field("exponent of the cause", 1.0, 0.3, 3.0)
    load_share: float = shape_field("torque that wore the flank, over the rated one", 1.0, 0.01, 10.0)

    def _modified_tooth(self, before: _Disc) -> ToothProfile:
        if self.by == "lever":
            phase = np.linspace(-np.pi, np.pi, _LEVER_POINTS, endpoint=False)
            depth = np.maximum(before.tooth.trochoid.lever_function(phase), 0.0)
        else:
            phase, depth = archard_depth(before.reducer, load_share=self.load_share)
        if self.exponent != 1.0:
            depth = depth**self.exponent
        if self.flank == 2:
            phase, depth = -phase[::-1], depth[::-1]
        return before.with_removal(NormalDeviation(phase, self.amount_um * UM * depth, 1))


def archard_depth(reducer: AsBuiltReducer, points: int = 121, load_share: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Phases from −π to π [rad] and the wear there, 1 at the deepest place, on the flank of positive torque.

    The wear is that of ``load_share`` times the rated torque.
    """
    case = replace(reducer.case, torque=abs(reducer.case.torque) * load_share)
    shared = Equilibrium(poses=24).solve(case)
    load = (shared.pressure * sliding_speed(case.drive, shared.phase, 1.0)).ravel()
    psi = shared.phase.ravel()
    order = np.argsort(psi)
    grid = np.linspace(-np.pi, np.pi, points, endpoint=False)
    depth = np.interp(grid, psi[order], load[order])
    return grid, depth / np.max(depth)


@dataclass(frozen=True)
class SingleToothError(_OnDiscs):
    """One lobe too low or too high: a slip of the index, a hit, a chip under the clamp.

    h = amount on both flanks of that lobe, blended at its tips.
    """

    remedy = "inspect the lobe; regrind if other lobes have material left to remove"
    amount_um: float = size_field("removal, negative where the lobe is high [µm]", 1.0, -LARGEST_UM, LARGEST_UM)
    lobe: int = part_field("number of the lobe, 1 has its root at angle 0, counted clockwise", 1)
    disc: int | None = part_field("number of the disc, 1 for the first", 1)
    blend_rad: float = shape_field(_BLEND, BLEND, *_BLENDS)

    def _modified_tooth(self, before: _Disc) -> ToothProfile:
        (lobe,) = part_indices(self, "lobe", self.lobe, before.tooth.trochoid.lobes)
        return before.with_removal(OneLobe(self.amount_um * UM, lobe, self.blend_rad, _blend_spacing(self.blend_rad)))
