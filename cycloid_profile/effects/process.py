"""Errors of making the disc: they act on the flanks, and a scan shows them.

Removal positive. ``disc`` is the number of the one disc concerned; without it all discs are alike, in the
frame of the carrier, which is how discs ground together through their bores come out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple

import numpy as np

from cycloid_profile.contact.equilibrium import Equilibrium
from cycloid_profile.contact.running import sliding_speed
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.effect import Effect, Place, angle, chosen, part, size
from cycloid_profile.effects.removals import Index, OneLobe, Ramp, Shift, Wave
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.geometry.removal import NormalRemoval
from cycloid_profile.modification.deviation import NormalDeviation
from cycloid_profile.modification.flank import FlankRemoval
from cycloid_profile.units import DEGREE, UM

STEEL_EXPANSION = 11.5e-6  # 1/K
# Feet on waves shorter than this are sought one by one, from so many points on each.
_SHORT_WAVE, _POINTS_ON_WAVE = 1.0, 8  # rad
_DISC = "number of the disc, 1 for the first; all discs if absent"


class _Blank(NamedTuple):
    """A disc about to get an effect: its ``tooth``, how far it is ``mounted`` behind the first [rad], whose it is."""

    tooth: ToothProfile
    mounted: float
    built: Built


class _OnDiscs(Effect):
    """Effects that change the tooth of one disc or of all."""

    place: ClassVar[Place] = Place.FLANK
    disc: int | None

    def apply(self, built: Built) -> Built:
        """The reducer with this effect."""
        for j in chosen(self, "disc", self.disc, built.discs):
            # Disc j is mounted turned by −2πj/(N z_c) against the first: its own angle of a common direction.
            mounted = 0.0 if self.disc is not None else 2.0 * np.pi * j / (built.discs * built.teeth[j].trochoid.lobes)
            built = built.with_tooth(j, self._ground(_Blank(built.teeth[j], mounted, built)))
        return built

    def _ground(self, blank: _Blank) -> ToothProfile:
        """The tooth with this effect."""
        raise NotImplementedError


def _with(tooth: ToothProfile, removal: NormalRemoval) -> ToothProfile:
    return replace(tooth, removals=(*tooth.removals, removal))


@dataclass(frozen=True)
class EquidistantError(_OnDiscs):
    """Grinding wheel or its radius setting too large (wheel radius r_rp + amount).

    h = amount, the same everywhere. Cure: correct the equidistant setting by the amount.
    Source: docs/theory.md, Eq. 13.
    """

    name: ClassVar[str] = "equidistant_error"
    amount_um: float = size("removal [µm]", 2.0, -200.0, 200.0)
    disc: int | None = part(_DISC)

    def _ground(self, blank: _Blank) -> ToothProfile:
        return replace(blank.tooth, pin_radius=blank.tooth.pin_radius + self.amount_um * UM)


@dataclass(frozen=True)
class RadialMovingError(_OnDiscs):
    """Infeed of the grinding machine off: the pin circle of generation is too small by the amount.

    h = amount (1 − K1 cosψ) S. Cure: correct the infeed. Looks like thermal growth of the disc.
    Source: docs/theory.md, Eq. 14.
    """

    name: ClassVar[str] = "radial_moving_error"
    amount_um: float = size("removal at root and tip [µm]", 2.0, -200.0, 200.0)
    disc: int | None = part(_DISC)

    def _ground(self, blank: _Blank) -> ToothProfile:
        moved = replace(
            blank.tooth.trochoid, pin_circle_radius=blank.tooth.trochoid.pin_circle_radius - self.amount_um * UM
        )
        return replace(blank.tooth, trochoid=moved)


@dataclass(frozen=True)
class GeneratingEccentricityError(_OnDiscs):
    """Eccentricity set on the grinding machine too large by the amount.

    h = amount (cosψ − K1) S: deeper roots, higher tips, ψ0 untouched, so that backlash does not show it.
    Cure: correct the eccentricity. Source: docs/theory.md, "Normal removal by cause".
    """

    name: ClassVar[str] = "generating_eccentricity_error"
    amount_um: float = size("eccentricity above its setting [µm]", 1.0, -100.0, 100.0)
    disc: int | None = part(_DISC)

    def _ground(self, blank: _Blank) -> ToothProfile:
        wider = replace(blank.tooth.trochoid, eccentricity=blank.tooth.trochoid.eccentricity + self.amount_um * UM)
        return replace(blank.tooth, trochoid=wider)


@dataclass(frozen=True)
class ThermalGrowth(_OnDiscs):
    """Disc warmer than the pin ring, while grinding or while running: everything grows by α·ΔT.

    h = −α ΔT Re(n̄ P), almost that of a radial-moving change of −α ΔT r_p. Cure: let the disc reach the
    temperature of the ring; a scan at a second temperature tells it from a wrong infeed.
    """

    name: ClassVar[str] = "thermal_growth"
    temperature_k: float = size("disc above housing [K]", 3.0, -100.0, 100.0)
    disc: int | None = part(_DISC)

    def _ground(self, blank: _Blank) -> ToothProfile:
        growth = 1.0 + STEEL_EXPANSION * self.temperature_k
        path = blank.tooth.trochoid
        larger = replace(
            path, pin_circle_radius=path.pin_circle_radius * growth, eccentricity=path.eccentricity * growth
        )
        # Removals of micrometres grow by picometres: left as they are.
        return replace(blank.tooth, trochoid=larger, pin_radius=blank.tooth.pin_radius * growth)


@dataclass(frozen=True)
class DiscRunout(_OnDiscs):
    """Tooth form ground off the axis of the bores: the disc was clamped eccentrically.

    ``form`` of the removal: 1 moves the tooth as a whole, h = −A cos(θ_n − φ) with θ_n the direction of the
    normal; 2 removes by the angle alone, h = −A cos(θ − φ), as a radial indicator would show it. φ is the polar
    angle towards which material stands out. Cure: centre the fixture on the bores.
    """

    name: ClassVar[str] = "disc_runout"
    amplitude_um: float = size("amplitude, half the run-out read [µm]", 3.0, 0.0, 200.0)
    phase_deg: float = angle("polar angle of the high side [°]")
    disc: int | None = part(_DISC)
    form: int = part("1: tooth moved as a whole; 2: by the angle alone", 1, most=2)

    def _ground(self, blank: _Blank) -> ToothProfile:
        phase = self.phase_deg * DEGREE + blank.mounted
        amount = self.amplitude_um * UM
        # The angle along the disc runs against the polar angle.
        return _with(blank.tooth, Shift(amount, phase) if self.form == 1 else Wave(-amount, 1.0, -phase))


@dataclass(frozen=True)
class DiscOval(_OnDiscs):
    """Disc oval after hardening or clamping: twice per turn, h = −A cos(2(θ − φ)).

    Cure: clamp without bending; grind after a second anneal.
    """

    name: ClassVar[str] = "disc_oval"
    amplitude_um: float = size("amplitude [µm]", 2.0, 0.0, 200.0)
    phase_deg: float = angle("polar angle of a high side [°]")
    disc: int | None = part(_DISC)

    def _ground(self, blank: _Blank) -> ToothProfile:
        return _with(blank.tooth, Wave(-self.amplitude_um * UM, 2.0, -2.0 * (self.phase_deg * DEGREE + blank.mounted)))


@dataclass(frozen=True)
class CumulativePitchError(_OnDiscs):
    """Indexing error of the workpiece spindle: lobes turned about the centre, once per turn of the disc.

    h = −A sinψ S cos(t − φ), with t the angle along the disc; A is the largest deviation along the normal, at ψ0. Cure:
    correct the index or the encoder mounting of the work spindle.
    """

    name: ClassVar[str] = "cumulative_pitch_error"
    amplitude_um: float = size("amplitude along the normal at ψ0 [µm]", 3.0, 0.0, 200.0)
    phase_deg: float = angle("angle along the disc of the largest error [°]")
    disc: int | None = part(_DISC)

    def _ground(self, blank: _Blank) -> ToothProfile:
        return _with(blank.tooth, Index(-self.amplitude_um * UM, 1.0, self.phase_deg * DEGREE - blank.mounted))


@dataclass(frozen=True)
class WheelWearDrift(_OnDiscs):
    """Grinding wheel that wears during the pass: each later lobe keeps more material.

    h falls linearly from 0 on the first lobe to −amount on the last, with a step between them. Cure: dress more
    often, or spread the lobes over several passes.
    """

    name: ClassVar[str] = "wheel_wear_drift"
    amount_um: float = size("material left on the last lobe [µm]", 1.0, -100.0, 100.0)
    first_lobe: int = part("lobe ground first, 1 has its root at angle 0", 1)
    disc: int | None = part(_DISC)

    def _ground(self, blank: _Blank) -> ToothProfile:
        (lobe,) = chosen(self, "first_lobe", self.first_lobe, blank.tooth.trochoid.lobes)
        return _with(blank.tooth, Ramp(self.amount_um * UM, lobe))


@dataclass(frozen=True)
class GrindingChatter(_OnDiscs):
    """Vibration between wheel and disc: a wave on the flanks, any number to a turn.

    h = A cos(n t − φ) by the angle t along the disc. Cure: change speed so that n moves, balance the wheel.
    """

    name: ClassVar[str] = "grinding_chatter"
    amplitude_um: float = size("amplitude [µm]", 0.3, 0.0, 50.0)
    waves_per_turn: float = size("waves round the disc", 1000.0, 3.0, 20000.0)
    phase_deg: float = angle("phase of the wave at lobe 1's root [°]")
    disc: int | None = part(_DISC)

    def _ground(self, blank: _Blank) -> ToothProfile:
        length = blank.tooth.trochoid.phase_period / self.waves_per_turn
        short = length / _POINTS_ON_WAVE if length < _SHORT_WAVE else None
        phase = self.phase_deg * DEGREE - self.waves_per_turn * blank.mounted
        return _with(blank.tooth, Wave(self.amplitude_um * UM, self.waves_per_turn, phase, short))


@dataclass(frozen=True)
class MissingDeformationCompensation(_OnDiscs):
    """The deformation that the grinding program should add back to the flanks was left out.

    h = amount |sinψ| S. Cure: grind with the compensated program. Source: docs/theory.md, Eq. 16.
    """

    name: ClassVar[str] = "missing_deformation_compensation"
    amount_um: float = size("δmax that is missing [µm]", 2.0, -50.0, 50.0)
    disc: int | None = part(_DISC)

    def _ground(self, blank: _Blank) -> ToothProfile:
        return _with(blank.tooth, FlankRemoval(self.amount_um * UM))


@dataclass(frozen=True)
class FlankWear(_OnDiscs):
    """Wear of the flank that carries, after Archard: depth in proportion to pressure × sliding.

    The shape is that of one disc at rated torque, ``amount`` its deepest place; ``flank`` 1 carries a positive
    torque, 2 a negative one. Cure: regrind, or look after lubricant and load.
    Source: Archard, J. Appl. Phys. 24 (1953) 981.
    """

    name: ClassVar[str] = "flank_wear"
    amount_um: float = size("deepest wear [µm]", 2.0, 0.0, 100.0)
    flank: int = part("1: carries positive torque, 2: carries negative torque", 1, most=2)
    disc: int | None = part(_DISC)

    def _ground(self, blank: _Blank) -> ToothProfile:
        phase, depth = archard_depth(blank.built)
        if self.flank == 2:
            phase, depth = -phase[::-1], depth[::-1]
        return _with(blank.tooth, NormalDeviation(phase, self.amount_um * UM * depth, 1))


def archard_depth(built: Built, points: int = 121) -> tuple[np.ndarray, np.ndarray]:
    """Phases from −π to π [rad] and the wear there, 1 at the deepest place, on the flank of positive torque."""
    case = replace(built.case, torque=abs(built.case.torque))
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

    h = amount on both flanks of that lobe. Cure: look at the lobe; regrind if low on material elsewhere.
    """

    name: ClassVar[str] = "single_tooth_error"
    amount_um: float = size("removal, negative where the lobe is high [µm]", 1.0, -200.0, 200.0)
    lobe: int = part("number of the lobe, 1 has its root at angle 0, counted clockwise", 1)
    disc: int | None = part("number of the disc, 1 for the first", 1)

    def _ground(self, blank: _Blank) -> ToothProfile:
        (lobe,) = chosen(self, "lobe", self.lobe, blank.tooth.trochoid.lobes)
        return _with(blank.tooth, OneLobe(self.amount_um * UM, lobe))
