"""Errors of crank shafts, crank bores and planets: fixed in the carrier, multiples of z_p per turn of the output."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from cycloid_profile.arrays import ComplexArray
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.effect import Effect, Place, angle, chosen, part, size
from cycloid_profile.errors import SpecError
from cycloid_profile.geometry.drive import Cranks
from cycloid_profile.units import ARCMIN, DEGREE, UM

_CRANK = "number of the crank shaft, 1 stands at angle 0; all of them if absent"
_DISC = "number of the disc, 1 for the first; all discs if absent"


class _OnCranks(Effect):
    place: ClassVar[Place] = Place.CRANK
    crank: int | None
    disc: int | None

    def _here(self, built: Built, value: complex) -> ComplexArray:
        """``value`` at the chosen discs and cranks, 0 elsewhere."""
        if not built.cranks:
            raise SpecError(
                self.name, "given", "needs crank shafts, which this drive has not", "add [drive.cranks] or leave it out"
            )
        where = np.zeros((built.discs, built.cranks), dtype=np.complex128)
        discs = chosen(self, "disc", self.disc, built.discs)
        where[np.ix_(discs, chosen(self, "crank", self.crank, built.cranks))] = value
        return where


@dataclass(frozen=True)
class CrankEccentricityError(_OnCranks):
    """Eccentric of a crank shaft larger than drawn. Cure: sort cranks into classes, or regrind the eccentric."""

    name: ClassVar[str] = "crank_eccentricity_error"
    amount_um: float = size("eccentricity above the drawing [µm]", 3.0, -200.0, 200.0)
    crank: int | None = part(_CRANK)
    disc: int | None = part(_DISC)

    def apply(self, built: Built) -> Built:
        """The reducer with this effect."""
        return replace(built, eccentric_shift=built.eccentric_shift + self._here(built, self.amount_um * UM))


@dataclass(frozen=True)
class CrankPhaseError(_OnCranks):
    """Eccentric turned on its shaft, or planet assembled off its tooth by part of a pitch. Cure: time the cranks."""

    name: ClassVar[str] = "crank_phase_error"
    angle_arcmin: float = size("angle ahead of the drawing [arcmin]", 5.0, -300.0, 300.0)
    crank: int | None = part(_CRANK)
    disc: int | None = part(_DISC)

    def apply(self, built: Built) -> Built:
        """The reducer with this effect."""
        across = 1j * built.case.drive.trochoid.eccentricity * self.angle_arcmin * ARCMIN
        return replace(built, eccentric_shift=built.eccentric_shift + self._here(built, across))


@dataclass(frozen=True)
class CrankHoleError(_OnCranks):
    """Crank bore of a disc out of its place. Cure: bore the discs of one reducer together."""

    name: ClassVar[str] = "crank_hole_error"
    amplitude_um: float = size("distance from its place [µm]", 3.0, 0.0, 200.0)
    direction_deg: float = angle("direction in the disc, 0 outwards at crank 1 [°]")
    crank: int | None = part("number of the crank shaft, 1 stands at angle 0", 1)
    disc: int | None = part("number of the disc, 1 for the first", 1)

    def apply(self, built: Built) -> Built:
        """The reducer with this effect."""
        off = self.amplitude_um * UM * np.exp(1j * self.direction_deg * DEGREE)
        return replace(built, bore_shift=built.bore_shift + self._here(built, complex(off)))


@dataclass(frozen=True)
class CrankBearingClearance(Effect):
    """Play in the crank bearings beyond the drawing: lost motion grows by 2c/r_c, flat. Cure: a smaller class."""

    name: ClassVar[str] = "crank_bearing_clearance"
    place: ClassVar[Place] = Place.CRANK
    radial_um: float = size("radial play, half the diametral clearance [µm]", 2.0, 0.0, 200.0)

    def apply(self, built: Built) -> Built:
        """The reducer with this effect."""
        drive = built.case.drive
        looser = replace(drive.support, bearing_play=drive.support.bearing_play + self.radial_um * UM)
        return replace(built, case=replace(built.case, drive=replace(drive, support=looser)))


@dataclass(frozen=True)
class PlanetRunout(Effect):
    """Planet gear off the axis of its crank: it drives the crank ahead and behind, once per turn of the planet.

    Lead A/r with the pitch radius r = m z2/2. Cure: gear cut on the bearing seats.
    """

    name: ClassVar[str] = "planet_runout"
    place: ClassVar[Place] = Place.SENSOR
    amplitude_um: float = size("eccentricity of the pitch circle [µm]", 10.0, 0.0, 500.0)
    phase_deg: float = angle("direction at crank angle 0 [°]")
    planet: int | None = part("number of the planet, which is that of its crank", 1)

    def apply(self, built: Built) -> Built:
        """The reducer with this effect."""
        drive = built.case.drive
        stage = drive.first_stage
        if stage is None or not isinstance(drive.support, Cranks):
            raise SpecError(self.name, "given", "needs planets, which this drive has not", "add [drive.first_stage]")
        lead = self.amplitude_um * UM / (0.5 * stage.module * stage.planet_teeth)
        crank_lead = built.crank_lead.copy()
        crank_lead[list(chosen(self, "planet", self.planet, built.cranks))] += lead * np.exp(
            1j * self.phase_deg * DEGREE
        )
        return replace(built, crank_lead=crank_lead)
