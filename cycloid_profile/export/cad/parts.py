"""The parts of a stage as plates and cylinders with their placements, without the CAD kernel.

Pose: crank at angle 0, pin 1 in a root of disc 1 on the x axis, crank holes of the discs aligned with the carrier's.
Discs are stacked along z, the first lowest. Parts without data in the spec (ring, shafts, bearings, plates) have sizes
that fit the assembly; they are not designed.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from cycloid_profile.design import bearing_radius
from cycloid_profile.geometry import Arc, Contour, Cranks, DiscOutline, Drive, circular_contour

_GAP = 0.1  # between discs, of their width
_PLATE = 0.6  # thickness of a carrier plate, of the discs' width
_RACE = 0.78  # radius of an eccentric, of the hole its bearing sits in
_SHAFT = (0.3, 0.5)  # least and largest radius of a shaft, of that hole
_CLEARANCE = 0.1  # between tooth tips and ring, of the pins' radius


@dataclass(frozen=True, slots=True)
class Placement:
    """Placement of a part: ``rotation`` about z [rad], then translation by ``shift`` x + iy and ``height`` [mm]."""

    name: str
    shift: complex = 0j
    height: float = 0.0
    rotation: float = 0.0


@dataclass(frozen=True, slots=True)
class Slab:
    """A contour with openings between two heights [mm]."""

    edge: Contour
    low: float
    high: float
    openings: tuple[Contour, ...] = ()


@dataclass(frozen=True, slots=True)
class StagePart:
    """Slabs joined to one body of a ``kind``, at each of its ``placements``."""

    kind: str
    slabs: tuple[Slab, ...]
    placements: tuple[Placement, ...]


@dataclass(frozen=True, slots=True)
class CadMaterial:
    """Material of a part as named in a CAD file."""

    name: str
    description: str


@dataclass(frozen=True, slots=True)
class Part:
    """A solid of the kernel with its ``colour`` (red, green, blue in 0…1), ``material`` and ``placements``."""

    name: str
    solid: Any
    colour: tuple[float, float, float]
    material: CadMaterial
    placements: tuple[Placement, ...] = ()


@dataclass(frozen=True, slots=True)
class Stack:
    """Heights of the discs; the ring extends from z = 0 to ``height``; all in mm."""

    drive: Drive

    @property
    def axial_clearance(self) -> float:
        """Axial clearance between neighbouring discs, and at both ends of the stack."""
        return _GAP * self.drive.disc_width

    @property
    def height(self) -> float:
        """Height of pins and ring."""
        return self.drive.discs * (self.drive.disc_width + self.axial_clearance) + self.axial_clearance

    @property
    def plate(self) -> float:
        """Thickness of a carrier plate."""
        return _PLATE * self.drive.disc_width

    def low(self, disc: int) -> float:
        """Lower face of a disc, counted from 0."""
        return self.axial_clearance + disc * (self.drive.disc_width + self.axial_clearance)

    def through_bar(self, radius: float) -> Slab:
        """A round bar through ring and plates; ``radius`` in mm."""
        return Slab(circular_contour("edge", 0j, radius), -self.plate, self.height + self.plate)


def disc_placements(drive: Drive) -> tuple[Placement, ...]:
    """Placement of each disc with the crank at angle 0: shifted by its eccentricity and rotated to match.

    Disc j leads by 2πj/n, so its teeth are rotated by −2πj/(n z_c) (docs/theory.md, Eqs. 19–20).
    """
    ahead = [2.0 * math.pi * j / drive.discs for j in range(drive.discs)]
    return tuple(
        Placement(
            f"disc {j + 1}",
            cmath.rect(drive.trochoid.eccentricity, angle),
            Stack(drive).low(j),
            -angle / drive.trochoid.lobes,
        )
        for j, angle in enumerate(ahead)
    )


def mounted(outline: DiscOutline, placement: Placement) -> DiscOutline:
    """The outline of the disc at ``placement``: openings aligned with disc 1, teeth rotated against them."""
    contours = tuple(contour.rotated(-placement.rotation, contour.name) for contour in outline.contours)
    return DiscOutline(outline.profile, contours)


def stage_parts(drive: Drive, outline: DiscOutline) -> tuple[StagePart, ...]:
    """All parts except the discs: pins, pin ring, shafts with eccentrics, bearings, output pins, carrier plates."""
    axes: list[complex] = [0j]
    if isinstance(drive.support, Cranks):
        count, circle_radius = drive.support.count, drive.support.circle_radius
        axes = [cmath.rect(circle_radius, 2.0 * math.pi * i / count) for i in range(count)]
    parts = [_pins(drive), _pin_ring(drive, outline)]
    held: list[tuple[complex, float]] = []
    hole = bearing_radius(outline)
    if hole > 0.0:
        shaft = max(_SHAFT[0] * hole, min(_SHAFT[1] * hole, _RACE * hole - drive.trochoid.eccentricity))
        parts += [_shafts(drive, axes, hole, shaft), _bearings(drive, axes, hole)]
        held += [(axis, shaft) for axis in axes]
    rings = [hole for hole in outline.holes if hole.name.startswith("output hole")]
    pin_radius = rings[0].radius - drive.trochoid.eccentricity if rings else 0.0
    if pin_radius > 0.0:
        placements = _numbered("output pin", [hole.centre for hole in rings])
        parts.append(StagePart("output pin", (Stack(drive).through_bar(pin_radius),), placements))
        held += [(placement.shift, pin_radius) for placement in placements]
    return (*parts, _plates(drive, outline, held))


def ring_bore(pins: int, pin_circle: float, pin_radius: float, inner: float) -> Contour:
    """Bore of the pin ring, with grooves of the pins' radius where they reach into it; lengths in mm."""
    if inner >= pin_circle + pin_radius:
        return circular_contour("bore", 0j, inner)
    half = math.acos((inner**2 + pin_circle**2 - pin_radius**2) / (2.0 * inner * pin_circle))
    round_pin = cmath.phase(cmath.rect(inner, half) - pin_circle)
    segments: list[Arc] = []
    for k in range(pins):
        angle, successor = 2.0 * math.pi * k / pins, 2.0 * math.pi * (k + 1) / pins
        centre = cmath.rect(pin_circle, angle)
        segments.append(Arc(centre, pin_radius, angle - round_pin, angle + round_pin))
        segments.append(Arc(0j, inner, angle + half, successor - half))
    return Contour("bore", tuple(segments))


def _numbered(name: str, centres: Sequence[complex]) -> tuple[Placement, ...]:
    return tuple(Placement(f"{name} {i + 1}", centre) for i, centre in enumerate(centres))


def _pins(drive: Drive) -> StagePart:
    count, radius = drive.trochoid.pins, drive.trochoid.pin_circle_radius
    placements = _numbered("pin", [cmath.rect(radius, 2.0 * math.pi * k / count) for k in range(count)])
    return StagePart(
        "pin", (Slab(circular_contour("edge", 0j, drive.pin_radius), 0.0, Stack(drive).height),), placements
    )


def _pin_ring(drive: Drive, outline: DiscOutline) -> StagePart:
    """A ring with a groove for each pin, clear of the orbiting discs."""
    pin_circle, radius = drive.trochoid.pin_circle_radius, drive.pin_radius
    inner = max(pin_circle, outline.tip_radius + drive.trochoid.eccentricity + _CLEARANCE * radius)
    bore = ring_bore(drive.trochoid.pins, pin_circle, radius, inner)
    outer = circular_contour("edge", 0j, 1.1 * max(pin_circle + radius, inner))
    return StagePart("pin ring", (Slab(outer, 0.0, Stack(drive).height, (bore,)),), (Placement("pin ring"),))


def _shafts(drive: Drive, axes: Sequence[complex], hole: float, radius: float) -> StagePart:
    stack = Stack(drive)
    eccentrics = (
        Slab(circular_contour("edge", disc.shift, _RACE * hole), disc.height, disc.height + drive.disc_width)
        for disc in disc_placements(drive)
    )
    return StagePart("crank shaft", (stack.through_bar(radius), *eccentrics), _numbered("crank shaft", axes))


def _bearings(drive: Drive, axes: Sequence[complex], hole: float) -> StagePart:
    ring = Slab(
        circular_contour("edge", 0j, hole), 0.0, drive.disc_width, (circular_contour("bore", 0j, _RACE * hole),)
    )
    placements = tuple(
        Placement(f"crank bearing {i + 1}.{j + 1}", axis + disc.shift, disc.height)
        for i, axis in enumerate(axes)
        for j, disc in enumerate(disc_placements(drive))
    )
    return StagePart("crank bearing", (ring,), placements)


def _plates(drive: Drive, outline: DiscOutline, held: Sequence[tuple[complex, float]]) -> StagePart:
    """Round plates at both ends of the stack, bored for the shafts and pins they hold."""
    stack = Stack(drive)
    openings = tuple(circular_contour(f"seat {i + 1}", centre, radius) for i, (centre, radius) in enumerate(held))
    reach = max((abs(centre) + 1.2 * radius for centre, radius in held), default=0.0)
    edge = circular_contour("edge", 0j, max(outline.root_radius - drive.trochoid.eccentricity, reach))
    slab = Slab(edge, 0.0, stack.plate, openings)
    placements = (Placement("carrier plate 1", height=-stack.plate), Placement("carrier plate 2", height=stack.height))
    return StagePart("carrier plate", (slab,), placements)
