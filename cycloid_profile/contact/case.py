"""A load case: drive, profile, materials and torque, and the line contacts it makes."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.hertz import STEEL, ContactLaw, LineContact, Material
from cycloid_profile.contact.laws import Roark
from cycloid_profile.errors import LoadError
from cycloid_profile.geometry.drive import Drive
from cycloid_profile.geometry.profile import ToothProfile


@dataclass(frozen=True, slots=True)
class LoadCase:
    """What a load-sharing solver needs.

    Parameters
    ----------
    drive : the nominal drive
    profile : the disc's tooth as ground
    torque : output torque [N·mm], not zero; its sign is its direction
    disc_material, pin_material : elastic constants
    law : line-contact law
    disc_share : share of the torque that the classical scheme gives one disc

    Raises
    ------
    LoadError
        If the torque is zero or not finite, or the share outside (0, 1].
    """

    drive: Drive
    profile: ToothProfile
    torque: float
    disc_material: Material = STEEL
    pin_material: Material = STEEL
    law: ContactLaw = field(default_factory=Roark)
    disc_share: float = 0.55

    def __post_init__(self) -> None:
        if not math.isfinite(self.torque) or self.torque == 0.0:
            raise LoadError(
                "torque", f"{self.torque} N·mm", "is zero or not finite", "give the torque the discs are designed for"
            )
        if not 0.0 < self.disc_share <= 1.0:
            raise LoadError(
                "disc_share",
                self.disc_share,
                "is outside (0, 1]",
                "two discs share ideally at 0.5, published schemes take 0.55",
            )

    @property
    def compliance(self) -> float:
        """C_E = Σ(1 − μ²)/E [1/MPa]."""
        return self.disc_material.compliance + self.pin_material.compliance

    def line_contact(self, curvature: FloatArray) -> LineContact:
        """Contacts of the pins with a tooth of the given curvature [1/mm]."""
        return LineContact(
            width=self.drive.disc_width,
            pin_radius=self.drive.pin_radius,
            curvature=curvature,
            disc=self.disc_material,
            pin=self.pin_material,
            radius_cap=self.drive.trochoid.pin_circle_radius,
        )
