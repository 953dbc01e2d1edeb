"""Compliance beyond the stage model: of shafts and housing, of bearings, of the seats of the pins."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from cycloid_profile.arrays import ArrayLike, BoolArray, FloatArray
from cycloid_profile.contact.hertz import ContactLaw, LineContact, PreparedLaw, Response
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.effect import Effect, Place, size
from cycloid_profile.units import ARCMIN, NEWTON_METRE, UM

_NEWTON_STEPS = 40


@dataclass(frozen=True)
class SeriesCompliance(Effect):
    """Shafts, carrier, main bearings and housing give way in series with the stage: Θ gains T/k.

    Torsional rigidity falls at every torque alike. Cure: nothing on the machine; it belongs to the model.
    """

    name: ClassVar[str] = "series_compliance"
    place: ClassVar[Place] = Place.COMPLIANCE
    stiffness_nm_per_arcmin: float = size("stiffness in series [N·m/′]", 150.0, 0.1, 1e6)

    def apply(self, built: Built) -> Built:
        """The reducer with this effect."""
        stiffness = self.stiffness_nm_per_arcmin * NEWTON_METRE / ARCMIN
        return replace(built, series_compliance=built.series_compliance + 1.0 / stiffness)


@dataclass(frozen=True)
class CrankBearingCompliance(Effect):
    """Crank bearings softer than the drawing has them: their compliance grows by the amount.

    Cure: check preload and fits of the crank bearings.
    """

    name: ClassVar[str] = "crank_bearing_compliance"
    place: ClassVar[Place] = Place.COMPLIANCE
    added_um_per_kn: float = size("added radial compliance of each bearing [µm/kN]", 1.0, 0.0, 1000.0)

    def apply(self, built: Built) -> Built:
        """The reducer with this effect."""
        drive = built.case.drive
        softer = 1.0 / (1.0 / drive.support.bearing_stiffness + self.added_um_per_kn * UM / 1e3)
        support = replace(drive.support, bearing_stiffness=softer)
        return replace(built, case=replace(built.case, drive=replace(drive, support=support)))


@dataclass(frozen=True)
class PinSupportCompliance(Effect):
    """Pins that give way in their seats, or bend between them: δ gains c·F.

    Cure: half-bores over the whole length, thicker ring.
    """

    name: ClassVar[str] = "pin_support_compliance"
    place: ClassVar[Place] = Place.COMPLIANCE
    added_um_per_kn: float = size("added compliance of each pin [µm/kN]", 1.0, 0.0, 1000.0)

    def apply(self, built: Built) -> Built:
        """The reducer with this effect."""
        law = OnSpring(built.case.law, self.added_um_per_kn * UM / 1e3)
        return replace(built, case=replace(built.case, law=law))


@dataclass(frozen=True, slots=True)
class OnSpring:
    """A law of approach in series with a linear spring of ``compliance`` c [mm/N]: δ(F) + c F."""

    law: ContactLaw
    compliance: float

    @property
    def name(self) -> str:
        """Name of the law with what it stands on."""
        return f"{self.law.name} on springs"

    @property
    def source(self) -> str:
        """That of the law."""
        return self.law.source

    @property
    def validity(self) -> str:
        """That of the law."""
        return self.law.validity

    def approach(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.approach``."""
        both: FloatArray = self.law.approach(force, contact) + self.compliance * np.asarray(force, dtype=np.float64)
        return both

    def force(self, approach: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.force``; Newton for the share of the approach that the contact takes."""
        total = np.asarray(approach, dtype=np.float64)
        F, _ = self._solved(np.maximum(total, 1e-30), contact)
        carried: FloatArray = np.where(total > 0.0, F, 0.0)
        return carried

    def stiffness(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.stiffness``."""
        k = self.law.stiffness(force, contact)
        series: FloatArray = k / (1.0 + self.compliance * k)
        return series

    def prepare(self, contact: LineContact) -> PreparedLaw:
        """See ``ContactLaw.prepare``."""
        return _PreparedOnSpring(self, contact)

    def response(self, approach: FloatArray, contact: LineContact) -> tuple[FloatArray, FloatArray, FloatArray]:
        """See ``ContactLaw.response``."""
        F, own = self._solved(approach, contact)
        _, k, energy = self.law.response(own, contact)
        return F, k / (1.0 + self.compliance * k), energy + 0.5 * self.compliance * F * F

    def _solved(self, approach: FloatArray, contact: LineContact) -> tuple[FloatArray, FloatArray]:
        """Force, and the approach of the contact alone, δ + c F(δ) = ``approach``."""
        # F is convex in δ: Newton from the whole approach descends without overshoot.
        own = approach + np.zeros_like(contact.curvature)
        for _ in range(_NEWTON_STEPS):
            F, k, _ = self.law.response(own, contact)
            step = (own + self.compliance * F - approach) / (1.0 + self.compliance * k)
            own = np.maximum(own - step, 1e-6 * own)
            if not np.any(np.abs(step) > 1e-15 * approach):
                break
        return self.law.force(own, contact), own

    def within_range(self, force: ArrayLike, contact: LineContact) -> BoolArray:
        """See ``ContactLaw.within_range``."""
        return self.law.within_range(force, contact)

    def half_width(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.half_width``."""
        return self.law.half_width(force, contact)

    def peak_pressure(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.peak_pressure``."""
        return self.law.peak_pressure(force, contact)

    def subsurface_shear(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.subsurface_shear``."""
        return self.law.subsurface_shear(force, contact)


@dataclass(frozen=True, slots=True)
class _PreparedOnSpring:
    """``OnSpring`` at given contacts."""

    law: OnSpring
    contact: LineContact

    def response(self, approach: FloatArray, start: FloatArray | None = None) -> Response:
        """See ``PreparedLaw.response``; no start is used."""
        force, stiffness, energy = self.law.response(approach, self.contact)
        return Response(force, stiffness, energy, force if start is None else start)
