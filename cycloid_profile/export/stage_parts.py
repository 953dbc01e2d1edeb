"""The parts of a stage as plain plates and cylinders in their places; no CAD kernel here.

Pose: crank at angle 0, so that pin 1 stands in a root of disc 1 on the x axis; the discs' crank holes stand
where the carrier's are. Discs are stacked along z, the first lowest. What the spec does not know (ring, shafts,
bearings, plates) is sized from what it knows: to show and to fit, not designed.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass

from cycloid_profile.design.from_spec import bearing_radius
from cycloid_profile.geometry.contour import Arc, Contour, circle
from cycloid_profile.geometry.drive import Cranks, Drive
from cycloid_profile.geometry.outline import DiscOutline

_GAP = 0.1  # between discs, of their width
_PLATE = 0.6  # thickness of a carrier plate, of the discs' width
_RACE = 0.78  # radius of an eccentric, of the hole its bearing sits in
_SHAFT = (0.3, 0.5)  # least and largest radius of a shaft, of that hole
_CLEARANCE = 0.1  # between tooth tips and ring, of the pins' radius


@dataclass(frozen=True, slots=True)
class Place:
    """Where a part stands: turned by ``turn`` about z [rad], then moved by ``shift`` x + iy and ``height`` [mm]."""

    name: str
    shift: complex = 0j
    height: float = 0.0
    turn: float = 0.0


@dataclass(frozen=True, slots=True)
class Slab:
    """A contour with openings between two heights [mm]."""

    edge: Contour
    low: float
    high: float
    openings: tuple[Contour, ...] = ()


@dataclass(frozen=True, slots=True)
class StagePart:
    """Slabs joined to one body, called ``kind``, at each of its ``places``."""

    kind: str
    slabs: tuple[Slab, ...]
    places: tuple[Place, ...]


@dataclass(frozen=True, slots=True)
class Stack:
    """Heights of the discs in the ring, which reaches from 0 to ``height``; all in mm."""

    drive: Drive

    @property
    def gap(self) -> float:
        """Between discs, and beyond the last ones."""
        return _GAP * self.drive.disc_width

    @property
    def height(self) -> float:
        """Of pins and ring."""
        return self.drive.discs * (self.drive.disc_width + self.gap) + self.gap

    @property
    def plate(self) -> float:
        """Thickness of a carrier plate."""
        return _PLATE * self.drive.disc_width

    def low(self, disc: int) -> float:
        """Where a disc begins, counted from 0."""
        return self.gap + disc * (self.drive.disc_width + self.gap)

    def through(self, radius: float) -> Slab:
        """A round bar through ring and plates."""
        return Slab(circle("edge", 0j, radius), -self.plate, self.height + self.plate)


def disc_places(drive: Drive) -> tuple[Place, ...]:
    """Where each disc stands with the crank at angle 0: moved by its eccentricity, and rolled back to match.

    Disc j runs 2πj/n ahead, so its teeth are turned by −2πj/(n z_c) (docs/theory.md, Eqs. 19–20).
    """
    ahead = [2.0 * math.pi * j / drive.discs for j in range(drive.discs)]
    return tuple(
        Place(
            f"disc {j + 1}",
            cmath.rect(drive.trochoid.eccentricity, angle),
            Stack(drive).low(j),
            -angle / drive.trochoid.lobes,
        )
        for j, angle in enumerate(ahead)
    )


def mounted(outline: DiscOutline, place: Place) -> DiscOutline:
    """The disc that stands at ``place``: its openings where those of disc 1 are, its teeth turned against them."""
    contours = tuple(contour.turned(-place.turn, contour.name) for contour in outline.contours)
    return DiscOutline(outline.profile, contours)


def stage_parts(drive: Drive, outline: DiscOutline) -> tuple[StagePart, ...]:
    """Everything but the discs: pins, pin ring, shafts with eccentrics, bearings, output pins, carrier plates."""
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
        places = tuple(Place(f"output pin {i + 1}", hole.centre) for i, hole in enumerate(rings))
        parts.append(StagePart("output pin", (Stack(drive).through(pin_radius),), places))
        held += [(place.shift, pin_radius) for place in places]
    return (*parts, _plates(drive, outline, held))


def ring_bore(pins: int, pin_circle: float, pin_radius: float, inner: float) -> Contour:
    """Bore of the pin ring, with grooves of the pins' radius where they reach into it; lengths in mm."""
    if inner >= pin_circle + pin_radius:
        return circle("bore", 0j, inner)
    half = math.acos((inner**2 + pin_circle**2 - pin_radius**2) / (2.0 * inner * pin_circle))
    round_pin = cmath.phase(cmath.rect(inner, half) - pin_circle)
    segments: list[Arc] = []
    for k in range(pins):
        angle, following = 2.0 * math.pi * k / pins, 2.0 * math.pi * (k + 1) / pins
        centre = cmath.rect(pin_circle, angle)
        segments.append(Arc(centre, pin_radius, angle - round_pin, angle + round_pin))
        segments.append(Arc(0j, inner, angle + half, following - half))
    return Contour("bore", tuple(segments))


def _pins(drive: Drive) -> StagePart:
    count, radius = drive.trochoid.pins, drive.trochoid.pin_circle_radius
    places = (Place(f"pin {k + 1}", cmath.rect(radius, 2.0 * math.pi * k / count)) for k in range(count))
    return StagePart("pin", (Slab(circle("edge", 0j, drive.pin_radius), 0.0, Stack(drive).height),), tuple(places))


def _pin_ring(drive: Drive, outline: DiscOutline) -> StagePart:
    """A ring with a groove for each pin, clear of the discs wherever they run."""
    pin_circle, radius = drive.trochoid.pin_circle_radius, drive.pin_radius
    inner = max(pin_circle, outline.tip_radius + drive.trochoid.eccentricity + _CLEARANCE * radius)
    bore = ring_bore(drive.trochoid.pins, pin_circle, radius, inner)
    outer = circle("edge", 0j, 1.1 * max(pin_circle + radius, inner))
    return StagePart("pin ring", (Slab(outer, 0.0, Stack(drive).height, (bore,)),), (Place("pin ring"),))


def _shafts(drive: Drive, axes: Sequence[complex], hole: float, radius: float) -> StagePart:
    stack = Stack(drive)
    eccentrics = (
        Slab(circle("edge", place.shift, _RACE * hole), place.height, place.height + drive.disc_width)
        for place in disc_places(drive)
    )
    places = tuple(Place(f"crank shaft {i + 1}", axis) for i, axis in enumerate(axes))
    return StagePart("crank shaft", (stack.through(radius), *eccentrics), places)


def _bearings(drive: Drive, axes: Sequence[complex], hole: float) -> StagePart:
    ring = Slab(circle("edge", 0j, hole), 0.0, drive.disc_width, (circle("bore", 0j, _RACE * hole),))
    places = tuple(
        Place(f"crank bearing {i + 1}.{j + 1}", axis + place.shift, place.height)
        for i, axis in enumerate(axes)
        for j, place in enumerate(disc_places(drive))
    )
    return StagePart("crank bearing", (ring,), places)


def _plates(drive: Drive, outline: DiscOutline, held: Sequence[tuple[complex, float]]) -> StagePart:
    """Round plates at both ends of the stack, bored for what they hold."""
    stack = Stack(drive)
    openings = tuple(circle(f"seat {i + 1}", centre, radius) for i, (centre, radius) in enumerate(held))
    reach = max((abs(centre) + 1.2 * radius for centre, radius in held), default=0.0)
    edge = circle("edge", 0j, max(outline.root_radius - drive.trochoid.eccentricity, reach))
    slab = Slab(edge, 0.0, stack.plate, openings)
    places = (Place("carrier plate 1", height=-stack.plate), Place("carrier plate 2", height=stack.height))
    return StagePart("carrier plate", (slab,), places)
