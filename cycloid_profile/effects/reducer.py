"""A reducer as built: the nominal reducer with all its deviations, in one frozen value."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile._display import Described
from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.contact import LoadCase
from cycloid_profile.contact.bodies import PartDeviations, softened_support
from cycloid_profile.effects.series import SeriesTwist, transmitted_torque
from cycloid_profile.geometry import Cranks, Drive, ToothProfile
from cycloid_profile.spec.model import Quality
from cycloid_profile.units import ARCMIN, NEWTON_METRE, UM


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class AsBuiltReducer(Described):
    """The reducer that a rig measures.

    ``case`` holds the drive with its bearings and contact law, the nominal tooth and the rated torque; ``teeth`` the
    tooth of each disc. The arrays of parts are those of ``PartDeviations``.

    ``series_compliance`` of shafts, carrier and housing beyond the stage [rad/(N·mm)], and their ``further_twists``.
    Friction against motion, as a torque on the output: ``coulomb_torque`` with its ``friction_spread`` [N·mm],
    ``proportional_friction`` times the torque, and ``breakaway_torque`` more after each reversal, which falls to 1/e
    within ``breakaway_travel`` of the stage's torque [N·mm]. ``encoder``, eccentricity of the angle encoder as an
    angle amplitude, see ``encoder_error`` [rad]. ``input_error``, amplitude of the angle by which the input is ahead of
    its reading, once per turn of the input [rad]. ``quality`` of manufacture, None where the spec leaves it to the
    material.
    """

    case: LoadCase
    teeth: tuple[ToothProfile, ...]
    pin_shift: ComplexArray
    pin_oversize: FloatArray
    eccentric_shift: ComplexArray
    bore_shift: ComplexArray
    crank_lead: ComplexArray
    sun_shift: complex = 0j
    series_compliance: float = 0.0
    further_twists: tuple[SeriesTwist, ...] = ()
    coulomb_torque: float = 0.0
    friction_spread: float = 0.0
    proportional_friction: float = 0.0
    breakaway_torque: float = 0.0
    breakaway_travel: float = 0.0
    encoder: complex = 0j
    input_error: complex = 0j
    quality: Quality | None = None

    @property
    def discs(self) -> int:
        """Number of discs."""
        return self.case.drive.discs

    @property
    def cranks(self) -> int:
        """Number of crank shafts, 0 with a central eccentric."""
        support = self.case.drive.support
        return support.count if isinstance(support, Cranks) else 0

    @property
    def deviations(self) -> PartDeviations:
        """Deviations of the parts as the equilibrium of the stage needs them."""
        nominal = all(tooth is self.case.profile for tooth in self.teeth)
        cranks = self.cranks > 0
        return PartDeviations(
            pin_shift=self.pin_shift if np.any(self.pin_shift) else None,
            pin_oversize=self.pin_oversize if np.any(self.pin_oversize) else None,
            teeth=None if nominal else self.teeth,
            eccentric_shift=self.eccentric_shift if cranks else None,
            bore_shift=self.bore_shift if cranks else None,
            crank_lead=self.crank_lead if cranks else None,
            sun_shift=self.sun_shift,
        )

    @property
    def smaller_effects(self) -> str:
        """Remedy of a reducer without equilibrium: the torque, or the deviation to make smaller first."""
        parts = ("pin_shift", "pin_oversize", "eccentric_shift", "bore_shift")
        sizes = {name: float(np.max(np.abs(getattr(self, name)), initial=0.0)) for name in parts}
        largest = max(sizes, key=lambda name: sizes[name])
        if not sizes[largest]:
            return "lower the torque, or make the effects smaller"
        return f"make the effects smaller, first the {largest.replace('_', ' ')} of {sizes[largest] / UM:.4g} µm"

    def angle_error(self, output_angle: FloatArray | float) -> FloatArray:
        """Error of the output angle by encoder and input, the same at every load [rad]."""
        read = encoder_error(self.encoder, output_angle)
        return np.asarray(read + output_error_by_input(self.case.drive, self.input_error, output_angle))

    def stage_torque(self, torque: FloatArray, before: float = -1.0) -> FloatArray:
        """Torque that friction leaves to the stage along a path of load, ``before`` the sign of the load before it, in
        the shape of ``torque`` [N·mm].
        """
        return transmitted_torque(
            torque,
            self.coulomb_torque,
            self.proportional_friction,
            before,
            self.friction_spread,
            (self.breakaway_torque, self.breakaway_travel),
        )

    def series_twist(self, torque: FloatArray, applied: FloatArray | None = None) -> FloatArray:
        """Twist in series with the stage, in the shape of ``torque`` [N·mm → rad]: settled at each torque, or along the
        path of the torque ``applied`` to the output.
        """
        twists = self.further_twists
        further = (one.settled(torque) if applied is None else one.along(torque, applied) for one in twists)
        return np.asarray(sum(further, self.series_compliance * torque))

    def with_tooth(self, disc: int, tooth: ToothProfile) -> AsBuiltReducer:
        """The same with another tooth on one disc, counted from 0."""
        return replace(self, teeth=(*self.teeth[:disc], tooth, *self.teeth[disc + 1 :]))

    def with_bearings(self, softer: float = 0.0, looser: float = 0.0) -> AsBuiltReducer:
        """The same with crank bearings ``softer`` by a radial compliance in series [mm/N] and ``looser`` by a radial
        play [mm].
        """
        drive = self.case.drive
        held = softened_support(drive.support, softer) if softer else drive.support
        support = replace(held, bearing_play=held.bearing_play + looser)
        return replace(self, case=replace(self.case, drive=replace(drive, support=support)))

    def _key_figures(self) -> dict[str, str]:
        trochoid = self.case.drive.trochoid
        parts = ("pin_shift", "pin_oversize", "eccentric_shift", "bore_shift", "crank_lead")
        changed = [name for name in parts if np.any(getattr(self, name))]
        changed += ["teeth"] if any(tooth is not self.case.profile for tooth in self.teeth) else []
        changed += [name for name in ("sun_shift", "encoder", "input_error") if getattr(self, name)]
        return {
            "pins, lobes": f"{trochoid.pins}, {trochoid.lobes}",
            "discs, cranks": f"{self.discs}, {self.cranks}",
            "rated torque": f"{self.case.torque / NEWTON_METRE:.4g} N·m",
            "deviations": ", ".join(changed).replace("_", " ") or "none",
            "series compliance": f"{self.series_compliance * NEWTON_METRE / ARCMIN:.4g} ′/(N·m)",
            "friction": f"{self.coulomb_torque / NEWTON_METRE:.4g} N·m + {self.proportional_friction:.4g} · torque",
        }


def encoder_error(encoder: complex, output_angle: FloatArray | float) -> FloatArray:
    """Error of the angle read by an eccentric encoder, Re[encoder·e^{−iΘ}], once per turn of the output [rad]."""
    return np.asarray((encoder * np.exp(-1j * output_angle)).real)


def output_error_by_input(drive: Drive, ahead: complex, output_angle: FloatArray | float) -> FloatArray:
    """How far an input that is ahead by Re[ahead·e^{−iα}] at its angle α turns the output ahead [rad].

    α = i Θ with the ratio i, −z_c Θ where the eccentric is the input.
    """
    ratio = drive.reduction_ratio if drive.first_stage is not None else -drive.reduction_ratio
    return np.asarray((ahead * np.exp(-1j * ratio * output_angle)).real / ratio)


def as_drawn(case: LoadCase) -> AsBuiltReducer:
    """The nominal reducer, without any deviation."""
    drive = case.drive
    cranks = drive.support.count if isinstance(drive.support, Cranks) else 0
    return AsBuiltReducer(
        case=case,
        teeth=(case.profile,) * drive.discs,
        pin_shift=np.zeros(drive.trochoid.pins, dtype=np.complex128),
        pin_oversize=np.zeros(drive.trochoid.pins),
        eccentric_shift=np.zeros((drive.discs, cranks), dtype=np.complex128),
        bore_shift=np.zeros((drive.discs, cranks), dtype=np.complex128),
        crank_lead=np.zeros(cranks, dtype=np.complex128),
    )
