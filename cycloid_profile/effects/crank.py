"""Errors of crank shafts and their bores: fixed in discs and carrier, multiples of z_p per turn of the output."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.arrays import ComplexArray
from cycloid_profile.contact.bodies import crank_turn_per_carrier_turn
from cycloid_profile.effects.base import (
    DISC_PART,
    LARGEST_UM,
    Effect,
    EffectLocation,
    angle_field,
    part_field,
    part_indices,
    size_field,
)
from cycloid_profile.effects.reducer import AsBuiltReducer
from cycloid_profile.errors import SpecError
from cycloid_profile.geometry import Cranks
from cycloid_profile.units import ARCMIN, DEGREE, UM

_CRANK = "number of the crank shaft, 1 at angle 0; all of them if absent"


class _OnCranks(Effect):
    location = EffectLocation.CRANK
    crank: int | None
    disc: int | None

    def _at_parts(self, reducer: AsBuiltReducer, value: complex) -> ComplexArray:
        """``value`` at the chosen discs and cranks, 0 elsewhere."""
        if not reducer.cranks:
            raise SpecError(
                self.name, "given", "needs crank shafts, which this drive has not", "add [drive.cranks] or leave it out"
            )
        where = np.zeros((reducer.discs, reducer.cranks), dtype=np.complex128)
        discs = part_indices(self, "disc", self.disc, reducer.discs)
        where[np.ix_(discs, part_indices(self, "crank", self.crank, reducer.cranks))] = value
        return where


@dataclass(frozen=True)
class CrankEccentricityError(_OnCranks):
    """Eccentric of a crank shaft larger than drawn."""

    remedy = "sort cranks into classes, or regrind the eccentric"
    amount_um: float = size_field("eccentricity above the drawing [µm]", 3.0, -LARGEST_UM, LARGEST_UM)
    crank: int | None = part_field(_CRANK)
    disc: int | None = part_field(DISC_PART)

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        return replace(reducer, eccentric_shift=reducer.eccentric_shift + self._at_parts(reducer, self.amount_um * UM))


@dataclass(frozen=True)
class CrankPhaseError(_OnCranks):
    """Eccentric turned on its shaft, or planet assembled with an angular offset of a fraction of a pitch."""

    remedy = "time the cranks"
    angle_arcmin: float = size_field("angle ahead of the drawing [arcmin]", 5.0, -10800.0, 10800.0)
    crank: int | None = part_field(_CRANK)
    disc: int | None = part_field(DISC_PART)

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        across = 1j * reducer.case.drive.trochoid.eccentricity * self.angle_arcmin * ARCMIN
        return replace(reducer, eccentric_shift=reducer.eccentric_shift + self._at_parts(reducer, across))


@dataclass(frozen=True)
class CrankHoleError(_OnCranks):
    """Crank bore of a disc out of its place."""

    remedy = "bore the discs of one reducer together"
    amplitude_um: float = size_field("distance from its place [µm]", 3.0, 0.0, LARGEST_UM)
    direction_deg: float = angle_field("direction in the disc, 0 outwards at crank 1 [°]")
    crank: int | None = part_field("number of the crank shaft, 1 at angle 0", 1)
    disc: int | None = part_field("number of the disc, 1 for the first", 1)

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        off = self.amplitude_um * UM * np.exp(1j * self.direction_deg * DEGREE)
        return replace(reducer, bore_shift=reducer.bore_shift + self._at_parts(reducer, complex(off)))


@dataclass(frozen=True)
class CrankBearingClearance(Effect):
    """Play in the crank bearings beyond the drawing: lost motion grows by 2c/r_c, equally at all poses."""

    remedy = "a smaller class"
    location = EffectLocation.CRANK
    radial_um: float = size_field("radial play, half the diametral clearance [µm]", 2.0, 0.0, LARGEST_UM)

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        return reducer.with_bearings(looser=self.radial_um * UM)


@dataclass(frozen=True)
class CarrierBoreError(_OnCranks):
    """Bore of a crank shaft in the carrier out of its place: the shaft and its planet move with it.

    Relative to the discs it acts as an equal and opposite shift of this bore in every disc. The planet rolls on the
    sun: a shift A_t along the circle turns the crank ahead by (1 + z1/z2) A_t/r_c.
    """

    remedy = "bore carrier and discs on one coordinate table"
    amplitude_um: float = size_field("distance from its place [µm]", 3.0, 0.0, LARGEST_UM)
    direction_deg: float = angle_field("direction in the carrier, 0 outwards (radial), 90 along the circle [°]")
    crank: int | None = part_field("number of the crank shaft, 1 at angle 0", 1)
    disc = None

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        drive = reducer.case.drive
        outwards = self._at_parts(reducer, np.exp(1j * self.direction_deg * DEGREE) * self.amplitude_um * UM)
        assert isinstance(drive.support, Cranks)
        crank_direction = np.exp(2j * np.pi * np.arange(reducer.cranks) / reducer.cranks)
        lead = crank_turn_per_carrier_turn(drive) * outwards.imag / drive.support.circle_radius
        return replace(
            reducer,
            bore_shift=reducer.bore_shift - outwards * crank_direction,
            eccentric_shift=reducer.eccentric_shift + 1j * drive.trochoid.eccentricity * lead,
        )
