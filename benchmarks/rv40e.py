"""The drive of all benchmarks."""

from __future__ import annotations

import cycloid_profile as cp
from cycloid_profile.contact.laws import STEEL, ContactLaw

EQUIDISTANT = 0.006  # mm
TORQUE = 412e3  # N·mm


def loaded_rv40e(law: ContactLaw | None = None, steel: cp.Material = STEEL) -> cp.LoadCase:
    """RV-40E: 40 pins, two discs, three cranks, equidistant 6 µm, rated torque; Roark's law if none is given."""
    drive = cp.Drive(
        trochoid=cp.Trochoid(pins=40, pin_circle_radius=64.0, eccentricity=1.3),
        pin_radius=3.0,
        disc_width=11.5,
        discs=2,
        support=cp.Cranks(count=3, circle_radius=36.0, bearing_stiffness=4e5),
        first_stage=cp.InvoluteStage(sun_teeth=12, planet_teeth=36, module=1.5),
    )
    profile = cp.modify(drive.theoretical_profile, cp.Equidistant(EQUIDISTANT))
    return cp.LoadCase(drive, profile, TORQUE, disc_material=steel, pin_material=steel, law=law or cp.Roark())
