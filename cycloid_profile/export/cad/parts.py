"""The parts of a stage as plates and cylinders with their placements, without the CAD kernel.

Pose at crank angle 0: pin 1 in a root of disc 1 on the x axis, crank holes of the discs aligned with the carrier's. At
the angle φ the cranks are turned by φ, the carrier by −φ/z_c against the pins, which stay.
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
class PrintOffsets:
    """Material removed from flanks, round holes and openings, and seats of printed parts [mm]."""

    flank: float = 0.0
    hole: float = 0.0
    seat: float = 0.0


AS_DESIGNED = PrintOffsets()


@dataclass(frozen=True, slots=True)
class OutputPins:
    """Pins of the output: ``roller_radius`` of what runs in the holes of the discs, and ``pin_radius`` of the pin
    inside the roller, None for a plain pin [mm]."""

    roller_radius: float
    pin_radius: float | None = None


@dataclass(frozen=True, slots=True)
class CadMaterial:
    """Material of a part as named in a CAD file."""

    name: str
    description: str


@dataclass(frozen=True, slots=True)
class CadPart:
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


def disc_placements(drive: Drive, crank_angle: float = 0.0) -> tuple[Placement, ...]:
    """Placement of each disc at ``crank_angle`` [rad]: shifted by its eccentricity and rotated to match.

    Disc j leads by 2πj/n, so its teeth are rotated by −2πj/(n z_c) (docs/theory.md, Eqs. 19–20).
    """
    ahead = [crank_angle + 2.0 * math.pi * j / drive.discs for j in range(drive.discs)]
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
    """The outline of the disc at ``placement`` of crank angle 0: openings aligned with disc 1, teeth rotated against
    them."""
    contours = tuple(contour.rotated(-placement.rotation, contour.name) for contour in outline.contours)
    return DiscOutline(outline.profile, contours)


def stage_parts(
    drive: Drive,
    outline: DiscOutline,
    crank_angle: float = 0.0,
    offsets: PrintOffsets = AS_DESIGNED,
    output: OutputPins | None = None,
) -> tuple[StagePart, ...]:
    """All parts except the discs at ``crank_angle`` [rad]: pins, pin ring, shafts with eccentrics, bearings, output
    rollers and pins, carrier plates.

    ``offsets`` are removed from seats and holes; ``output`` sizes default to plain pins that fill the output holes.
    """
    axes: list[complex] = [0j]
    if isinstance(drive.support, Cranks):
        count, circle_radius = drive.support.count, drive.support.circle_radius
        axes = [cmath.rect(circle_radius, 2.0 * math.pi * i / count) for i in range(count)]
    parts = [_pins(drive), _pin_ring(drive, outline, offsets.seat)]
    carrier = -crank_angle / drive.trochoid.lobes
    held: list[tuple[complex, float]] = []
    hole = bearing_radius(outline)
    if hole > 0.0:
        shaft = max(_SHAFT[0] * hole, min(_SHAFT[1] * hole, _RACE * hole - drive.trochoid.eccentricity))
        parts += [
            _shafts(drive, axes, hole, shaft, crank_angle),
            _bearings(drive, axes, hole, crank_angle, offsets.hole),
        ]
        held += [(axis, shaft) for axis in axes]
    rings = [hole for hole in outline.holes if hole.name.startswith("output hole")]
    if output is None and rings and rings[0].radius > drive.trochoid.eccentricity:
        output = OutputPins(rings[0].radius - drive.trochoid.eccentricity)
    if output is not None:
        centres = [hole.centre for hole in rings]
        if output.pin_radius is not None:
            parts.append(_rollers(drive, centres, output, carrier, offsets.hole))
        pin_radius = output.roller_radius if output.pin_radius is None else output.pin_radius
        placements = _numbered("output pin", centres, carrier)
        parts.append(StagePart("output pin", (Stack(drive).through_bar(pin_radius),), placements))
        held += [(centre, pin_radius) for centre in centres]
    return (*parts, _plates(drive, outline, held, carrier, offsets.seat))


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


def _numbered(name: str, centres: Sequence[complex], turn: float = 0.0, own: float = 0.0) -> tuple[Placement, ...]:
    """Placements at ``centres`` turned about the origin by ``turn``, each turned by ``own`` about itself [rad]."""
    spots = [centre * cmath.rect(1.0, turn) for centre in centres]
    return tuple(Placement(f"{name} {i + 1}", spot, rotation=own) for i, spot in enumerate(spots))


def _pins(drive: Drive) -> StagePart:
    count, radius = drive.trochoid.pins, drive.trochoid.pin_circle_radius
    placements = _numbered("pin", [cmath.rect(radius, 2.0 * math.pi * k / count) for k in range(count)])
    return StagePart(
        "pin", (Slab(circular_contour("edge", 0j, drive.pin_radius), 0.0, Stack(drive).height),), placements
    )


def _pin_ring(drive: Drive, outline: DiscOutline, seat_offset: float) -> StagePart:
    """A ring with a groove for each pin, clear of the orbiting discs."""
    pin_circle, radius = drive.trochoid.pin_circle_radius, drive.pin_radius
    inner = max(pin_circle, outline.tip_radius + drive.trochoid.eccentricity + _CLEARANCE * radius)
    bore = ring_bore(drive.trochoid.pins, pin_circle, radius + seat_offset, inner)
    outer = circular_contour("edge", 0j, 1.1 * max(pin_circle + radius, inner))
    return StagePart("pin ring", (Slab(outer, 0.0, Stack(drive).height, (bore,)),), (Placement("pin ring"),))


def _shafts(drive: Drive, axes: Sequence[complex], hole: float, radius: float, crank_angle: float) -> StagePart:
    stack = Stack(drive)
    eccentrics = (
        Slab(circular_contour("edge", disc.shift, _RACE * hole), disc.height, disc.height + drive.disc_width)
        for disc in disc_placements(drive)
    )
    placements = _numbered("crank shaft", axes, -crank_angle / drive.trochoid.lobes, crank_angle)
    return StagePart("crank shaft", (stack.through_bar(radius), *eccentrics), placements)


def _rollers(
    drive: Drive, centres: Sequence[complex], output: OutputPins, carrier: float, hole_offset: float
) -> StagePart:
    bore = circular_contour("bore", 0j, (output.pin_radius or 0.0) + hole_offset)
    ring = Slab(circular_contour("edge", 0j, output.roller_radius), 0.0, drive.disc_width, (bore,))
    placements = tuple(
        Placement(f"output roller {i + 1}.{j + 1}", centre * cmath.rect(1.0, carrier), Stack(drive).low(j))
        for i, centre in enumerate(centres)
        for j in range(drive.discs)
    )
    return StagePart("output roller", (ring,), placements)


def _bearings(drive: Drive, axes: Sequence[complex], hole: float, crank_angle: float, hole_offset: float) -> StagePart:
    bore = circular_contour("bore", 0j, _RACE * hole + hole_offset)
    ring = Slab(circular_contour("edge", 0j, hole), 0.0, drive.disc_width, (bore,))
    carrier = cmath.rect(1.0, -crank_angle / drive.trochoid.lobes)
    placements = tuple(
        Placement(f"crank bearing {i + 1}.{j + 1}", axis * carrier + disc.shift, disc.height)
        for i, axis in enumerate(axes)
        for j, disc in enumerate(disc_placements(drive, crank_angle))
    )
    return StagePart("crank bearing", (ring,), placements)


def _plates(
    drive: Drive, outline: DiscOutline, held: Sequence[tuple[complex, float]], turn: float, seat_offset: float
) -> StagePart:
    """Round plates at both ends of the stack, bored for the shafts and pins they hold."""
    stack = Stack(drive)
    openings = tuple(
        circular_contour(f"seat {i + 1}", centre, radius + seat_offset) for i, (centre, radius) in enumerate(held)
    )
    reach = max((abs(centre) + 1.2 * radius for centre, radius in held), default=0.0)
    edge = circular_contour("edge", 0j, max(outline.root_radius - drive.trochoid.eccentricity, reach))
    slab = Slab(edge, 0.0, stack.plate, openings)
    placements = (
        Placement("carrier plate 1", height=-stack.plate, rotation=turn),
        Placement("carrier plate 2", height=stack.height, rotation=turn),
    )
    return StagePart("carrier plate", (slab,), placements)
