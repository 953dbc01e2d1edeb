"""A reducer as built: the drawing, and all that departs from it, in one frozen value."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.contact.as_built import AsBuilt
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.geometry.drive import Cranks
from cycloid_profile.geometry.profile import ToothProfile


@dataclass(frozen=True, eq=False, kw_only=True)
class Built:
    """The reducer that a rig measures.

    ``case`` holds the drive with its bearings and contact law, the tooth of the drawing and the rated torque;
    ``teeth`` the tooth of each disc. The arrays of parts are those of ``AsBuilt``.

    ``series_compliance`` of shafts, carrier and housing beyond the stage [rad/(N·mm)]. Friction against
    motion, as a torque on the output: ``coulomb_torque`` [N·mm], and ``proportional_friction`` times the
    torque. ``encoder`` is an error of the angle read, Re[encoder·e^{−iΘ}], once per turn of the output [rad].
    """

    case: LoadCase
    teeth: tuple[ToothProfile, ...]
    pin_shift: ComplexArray
    pin_oversize: FloatArray
    eccentric_shift: ComplexArray
    bore_shift: ComplexArray
    crank_lead: ComplexArray
    series_compliance: float = 0.0
    coulomb_torque: float = 0.0
    proportional_friction: float = 0.0
    encoder: complex = 0j

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
    def parts(self) -> AsBuilt:
        """What the equilibrium of the stage needs of the parts."""
        alike = all(tooth is self.case.profile for tooth in self.teeth)
        cranks = self.cranks > 0
        return AsBuilt(
            pin_shift=self.pin_shift if np.any(self.pin_shift) else None,
            pin_oversize=self.pin_oversize if np.any(self.pin_oversize) else None,
            teeth=None if alike else self.teeth,
            eccentric_shift=self.eccentric_shift if cranks else None,
            bore_shift=self.bore_shift if cranks else None,
            crank_lead=self.crank_lead if cranks else None,
        )

    def with_tooth(self, disc: int, tooth: ToothProfile) -> Built:
        """The same with another tooth on one disc, counted from 0."""
        return replace(self, teeth=(*self.teeth[:disc], tooth, *self.teeth[disc + 1 :]))


def as_drawn(case: LoadCase) -> Built:
    """The reducer of the drawing: nothing departs."""
    drive = case.drive
    cranks = drive.support.count if isinstance(drive.support, Cranks) else 0
    return Built(
        case=case,
        teeth=(case.profile,) * drive.discs,
        pin_shift=np.zeros(drive.trochoid.pins, dtype=np.complex128),
        pin_oversize=np.zeros(drive.trochoid.pins),
        eccentric_shift=np.zeros((drive.discs, cranks), dtype=np.complex128),
        bore_shift=np.zeros((drive.discs, cranks), dtype=np.complex128),
        crank_lead=np.zeros(cranks, dtype=np.complex128),
    )
