"""Elastic supports of a stage: pin seats, ring and carrier pillars (docs/theory.md, Eqs. 85–93).

Each adds a matrix to the compliance of the discs, between the forces of all pins and bearings. Pins and ring belong to
all discs: a force of one disc on a pin also moves it against the others.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.contact.bodies.bearings import support_model
from cycloid_profile.contact.bodies.pin_seats import PinSeats
from cycloid_profile.contact.bodies.ring_body import RingBody
from cycloid_profile.contact.laws import Material
from cycloid_profile.contact.mesh import Meshing
from cycloid_profile.errors import LoadError
from cycloid_profile.geometry import Cranks, Drive

_SHEAR = 0.9  # share of a round section that carries shear, Timoshenko


@dataclass(frozen=True, slots=True)
class Pillars:
    """Round pillars between the two flanges of the carrier; the output is at one of them.

    ``count`` pillars of ``radius`` and free ``length`` on a circle of ``circle_radius`` [mm]; ``hinged`` where a
    joint at one end keeps no angle. ``far_share`` of the torque enters at the far flange and passes the pillars.

    Raises
    ------
    LoadError
        If a size is impossible.
    """

    count: int
    circle_radius: float
    radius: float
    length: float
    material: Material
    hinged: bool = False
    far_share: float = 0.5

    def __post_init__(self) -> None:
        for name in ("count", "circle_radius", "radius", "length"):
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) > 0.0):
                raise LoadError(f"pillars: {name}", getattr(self, name), "is not above zero", "give a positive size")
        if not 0.0 <= self.far_share <= 1.0:
            raise LoadError("pillars: far_share", self.far_share, "is outside [0, 1]", "give 0.5 for two flanges")

    @property
    def torsional_stiffness(self) -> float:
        """Torque between the flanges per turn: bending with shear, and torsion, of each pillar (Eq. 92) [N·mm/rad]."""
        E, r, L = self.material.youngs_modulus, self.radius, self.length
        shear_modulus = E / (2.0 * (1.0 + self.material.poisson_ratio))
        area, inertia = math.pi * r**2, math.pi * r**4 / 4.0
        across = L**3 / ((3.0 if self.hinged else 12.0) * E * inertia) + L / (_SHEAR * shear_modulus * area)
        twist = 0.0 if self.hinged else 2.0 * shear_modulus * inertia / L
        return self.count * (self.circle_radius**2 / across + twist)

    @property
    def compliance(self) -> float:
        """Turn of the output per torque on it, Eq. 93 [rad/(N·mm)]."""
        return self.far_share**2 / self.torsional_stiffness


@dataclass(frozen=True, slots=True)
class Supports:
    """Elastic supports of the stage; None for rigid ones.

    Raises
    ------
    LoadError
        From ``check`` if a part does not belong to a drive.
    """

    seats: PinSeats | None = None
    ring: RingBody | None = None
    pillars: Pillars | None = None

    def __bool__(self) -> bool:
        """Whether anything gives way."""
        return bool(self.names)

    @property
    def names(self) -> tuple[str, ...]:
        """Parts that give way."""
        parts = {"pin seats": self.seats, "ring": self.ring, "pillars": self.pillars}
        return tuple(name for name, part in parts.items() if part is not None)

    def check(self, drive: Drive) -> None:
        """Raise ``LoadError`` unless the parts belong to this drive."""
        if self.seats is not None and len(self.seats.places) != drive.discs:
            raise LoadError(
                "pin seats", f"{len(self.seats.places)} places", f"are not the {drive.discs} discs", "give one a disc"
            )
        if self.pillars is not None and not isinstance(drive.support, Cranks):
            raise LoadError(
                "pillars", self.pillars.count, "join no flanges of a drive with a central eccentric",
                "leave drive.pillars out",
            )  # fmt: skip
        highest = drive.trochoid.pins // 2
        if self.ring is not None and self.ring.waves > highest:
            raise LoadError("ring: waves", self.ring.waves, f"are more than {highest} for its pins", "count fewer")

    def matrices(self, drive: Drive, meshing: Meshing) -> dict[str, FloatArray]:
        """Compliance of each part, by name, shape (poses, forces, forces) [mm/N].

        Forces of the pins, disc by disc, then both components of each bearing, as in ``stage_compliance``.
        """
        poses, discs, pins = meshing.phase.shape
        bearings = discs * (drive.support.count if isinstance(drive.support, Cranks) else 1)
        size = discs * pins + 2 * bearings
        normal = pin_normals(meshing)
        found = {}
        for name in self.names:
            found[name] = np.zeros((poses, size, size))
            on_pins = found[name][:, : discs * pins, : discs * pins]
            if name == "pin seats" and self.seats is not None:
                between = self.seats.compliance()
                for i in range(discs):
                    for j in range(discs):
                        pin_i, pin_j = (np.arange(pins) + one * pins for one in (i, j))
                        along = (np.conj(normal[:, i]) * normal[:, j]).real
                        on_pins[:, pin_i, pin_j] = between[i, j] * along
            elif name == "ring" and self.ring is not None:
                on_pins[:] = _ring_matrix(self.ring, normal)
            elif self.pillars is not None:
                # Forces times these arms are the torque on the carrier: the pillars turn all eccentrics by its share.
                arm = support_model(drive, meshing.crank_angle).spring_stretch[..., 0].reshape(poses, -1)
                turned = self.pillars.compliance * arm[:, :, np.newaxis] * arm[:, np.newaxis]
                found[name][:, discs * pins :, discs * pins :] = turned
        return found


def pin_normals(meshing: Meshing) -> ComplexArray:
    """Normal of each pin contact, outwards from the disc in its nominal place, in the frame of the pin: real part
    radial, imaginary part tangential, shape (poses, discs, pins).

    All normals pass the pitch point, at a z_p on the line of the crank.
    """
    trochoid, pins = meshing.trochoid, meshing.phase.shape[-1]
    outwards = np.exp(2j * math.pi * np.arange(pins) / pins)
    pitch_point = trochoid.eccentricity * trochoid.pins * np.exp(1j * meshing.crank_angle)
    from_there = trochoid.pin_circle_radius - pitch_point[..., np.newaxis] * np.conj(outwards)
    return np.asarray(from_there / np.abs(from_there))


def _ring_matrix(ring: RingBody, normal: ComplexArray) -> FloatArray:
    """Compliance of the ring between the forces of the pins of all discs, shape (poses, forces, forces) [mm/N]."""
    poses, discs, pins = normal.shape
    influence = _influence(ring, pins)
    flat = normal.reshape(poses, discs * pins)
    parts = flat.real, flat.imag
    found = np.zeros((poses, discs * pins, discs * pins))
    for a, here in enumerate(parts):
        for b, there in enumerate(parts):
            between = np.tile(influence[a, :, b], (discs, discs))
            found += here[:, :, np.newaxis] * between * there[:, np.newaxis]
    return found


@lru_cache(maxsize=64)
def _influence(ring: RingBody, pins: int) -> FloatArray:
    return ring.influence(2.0 * math.pi * np.arange(pins) / pins)
