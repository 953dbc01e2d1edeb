"""A load case: drive, profile, materials, torque and line contacts."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.bodies import DiscCompliance, FaceWidth, Supports, stage_compliance
from cycloid_profile.contact.laws import STEEL, ContactLaw, LineContact, Material, Roark
from cycloid_profile.contact.mesh import Meshing, mesh_cycle
from cycloid_profile.errors import LoadError
from cycloid_profile.geometry import Cranks, Drive, ToothProfile
from cycloid_profile.units import NEWTON_METRE


@dataclass(frozen=True, slots=True)
class LoadCase:
    """Input of a load-sharing solver.

    Parameters
    ----------
    drive : the nominal drive
    profile : the disc's tooth as ground
    torque : output torque [N·mm], not zero; its sign is its direction
    disc_material, pin_material : elastic constants
    law : line-contact law
    disc_share : share of the torque that the classical scheme gives one disc
    disc_bodies : compliance of each elastic disc; empty for rigid discs
    supports : what gives way behind pins and bearings, counted by ``StageEquilibrium`` alone; rigid unless given
    width : slices over the face width with their relief; None for an even load over the width

    Raises
    ------
    LoadError
        If the torque is zero or not finite, the share outside (0, 1], ``disc_bodies`` not one a disc of this drive, or
        ``supports`` not of this drive, or ``width`` not of these discs.
    """

    drive: Drive
    profile: ToothProfile
    torque: float
    disc_material: Material = STEEL
    pin_material: Material = STEEL
    law: ContactLaw = field(default_factory=Roark)
    disc_share: float = 0.55
    disc_bodies: tuple[DiscCompliance, ...] = ()
    supports: Supports = field(default_factory=Supports)
    width: FaceWidth | None = None

    def __post_init__(self) -> None:
        if not math.isfinite(self.torque) or self.torque == 0.0:
            raise LoadError(
                "torque",
                f"{self.torque / NEWTON_METRE:g} N·m",
                "is zero or not finite",
                "give the torque the discs are designed for",
            )
        if not 0.0 < self.disc_share <= 1.0:
            raise LoadError(
                "disc_share",
                self.disc_share,
                "is outside (0, 1]",
                "two discs share ideally at 0.5, published schemes take 0.55",
            )

        bearings = self.drive.support.count if isinstance(self.drive.support, Cranks) else 1
        wanted = (self.drive.trochoid.lobes, bearings)
        if self.disc_bodies and [(one.lobes, one.bearings) for one in self.disc_bodies] != [wanted] * self.drive.discs:
            raise LoadError(
                "disc_bodies", len(self.disc_bodies), f"are not {self.drive.discs} discs of {wanted[0]} lobes and "
                f"{wanted[1]} bearings", "make one for each disc of this drive",
            )  # fmt: skip
        self.supports.check(self.drive)
        if self.width is not None and self.width.width != self.drive.disc_width:
            raise LoadError(
                "width", f"{self.width.width:g} mm", f"is not the face width, {self.drive.disc_width:g} mm",
                "slice the width of the disc",
            )  # fmt: skip

    @property
    def compliance(self) -> float:
        """C_E = Σ(1 − μ²)/E [1/MPa]."""
        return self.disc_material.compliance + self.pin_material.compliance

    @property
    def elastic(self) -> bool:
        """Whether discs or supports give way beyond contacts and bearings."""
        return bool(self.disc_bodies or self.supports)

    def body_compliance(self, meshing: Meshing) -> FloatArray:
        """Compliance of discs and supports between all forces of a stage, shape (poses, forces, forces) [mm/N].

        Order of the forces as in ``stage_compliance``; without forces where nothing is elastic. The array may be that
        of other calls, too: do not write into it.
        """
        found = stage_compliance(self.disc_bodies, meshing)
        for one in self.supports.matrices(self.drive, meshing).values():
            found = found + one if found.size else one
        return found

    def cycle(self, poses: int) -> FloatArray:
        """Crank angles over the least turn after which the load repeats, evenly spaced, shape (poses,) [rad].

        With rigid discs that is a pin pitch, see ``mesh_cycle``; with elastic discs as many pitches as a sector of the
        disc has lobes.
        """
        pitches = self.drive.trochoid.lobes // min((one.sectors for one in self.disc_bodies), default=1)
        cycle: FloatArray = mesh_cycle(self.drive.trochoid, poses) * (pitches if self.disc_bodies else 1)
        return cycle

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
