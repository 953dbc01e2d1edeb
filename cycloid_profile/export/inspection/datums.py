"""The datum system of a disc, one for drawing, inspection plan, DMIS program and QIF file (ISO 5459).

A is the upper face, B the axis of the bore, C the opening that gives the direction: a crank hole, else an output hole,
else a keyway. Teeth are related to A and B. Their turn about B is free; the angle from C to root 1 has its own
tolerance, because a grinder sets it apart from the form of the teeth.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.design import DesignRecord
from cycloid_profile.errors import ExportError
from cycloid_profile.geometry import Arc, Contour

FACE, AXIS, DIRECTION = "A", "B", "C"
OF_TEETH = (FACE, AXIS)
FACE_POINTS = 4  # touched on the face, one a quadrant
_SAME = 1e-6  # mm
_OUTLINE, _CHORDS = 20_000, 1e-2  # points of the teeth, and mm of chords, of the face on which places are sought
_MARGINS = (3.0, 2.0, 1.0, 0.5, 0.2)  # mm between the ball and an edge of the face, tried in order
_ROUND_DIRECTIONS = ("crank hole 1", "output hole 1")


@dataclass(frozen=True, slots=True)
class CircleDatum:
    """The axis of a circle: round an opening, or through the roots; ``centre`` and ``radius`` [mm].

    ``free`` are the angles from which to which a keyed bore is round [rad].
    """

    name: str
    centre: complex
    radius: float
    opening: bool = True
    free: tuple[tuple[float, float], ...] = ((0.0, 2.0 * math.pi),)

    @property
    def keyed(self) -> bool:
        """Whether keyways interrupt the circle."""
        return self.free[0][1] - self.free[0][0] != 2.0 * math.pi

    def angles(self, count: int, margin: float) -> list[float]:
        """``count`` angles of even steps along the round parts, ``margin`` [rad] away from the ends of each."""
        if not self.keyed:
            return [2.0 * math.pi * k / count for k in range(count)]
        starts = np.array([start + margin for start, _ in self.free])
        lengths = np.array([end - start - 2.0 * margin for start, end in self.free])
        ends = np.cumsum(lengths)
        at = (np.arange(count) + 0.5) * ends[-1] / count
        part = np.searchsorted(ends, at)
        found: list[float] = (starts[part] + at - (ends - lengths)[part]).tolist()
        return found


@dataclass(frozen=True, slots=True)
class KeywayDatum:
    """The middle plane of a keyway: ``centre`` midway between its sides, and half its width [mm]."""

    name: str
    centre: complex
    half_width: float


@dataclass(frozen=True, slots=True)
class DatumSystem:
    """Datums B and C of a disc in the frame of its teeth; A is its upper face. ``direction`` None: C is not there."""

    face: ClassVar[str] = "upper face"
    axis: CircleDatum
    direction: CircleDatum | KeywayDatum | None

    @property
    def names(self) -> dict[str, str]:
        """Names of the features by their letters."""
        found = {FACE: self.face, AXIS: self.axis.name}
        return found if self.direction is None else found | {DIRECTION: self.direction.name}

    @property
    def direction_angle(self) -> float:
        """Angle of C from the x axis, which goes through root 1 [rad]."""
        return 0.0 if self.direction is None else round(cmath.phase(self.direction.centre), 12)

    def of_holes(self, centres: Iterable[complex]) -> tuple[str, ...]:
        """Letters to which the position of equal holes is related: C cannot be related to itself."""
        c = self.direction
        with_c = c is None or any(abs(centre - c.centre) < _SAME for centre in centres)
        return OF_TEETH if with_c else (*OF_TEETH, DIRECTION)


def datum_system(record: DesignRecord) -> DatumSystem:
    """The datums of a disc; without a bore, B is the axis of the circle through the roots."""
    contours = {contour.name: contour for contour in record.outline.contours}
    bore = _bore(contours["bore"]) if "bore" in contours else None
    found = ((name, contours[name].full_circle_arc) for name in _ROUND_DIRECTIONS if name in contours)
    hole = next((CircleDatum(name, arc.centre, arc.radius) for name, arc in found if arc is not None), None)
    return DatumSystem(bore or root_circle(record), hole or (_keyway(record, bore) if bore else None))


def root_circle(record: DesignRecord) -> CircleDatum:
    """The circle through the roots."""
    radius = float(np.abs(record.profile.at(0.0).position))
    return CircleDatum("circle through the roots", 0j, radius, opening=False)


def _bore(contour: Contour) -> CircleDatum | None:
    """The round parts of a bore."""
    arcs = [arc for arc in contour.segments if isinstance(arc, Arc) and arc.centre == 0j]
    if not arcs:
        return None
    return CircleDatum("bore", 0j, arcs[0].radius, free=tuple((arc.from_angle, arc.to_angle) for arc in arcs))


def _keyway(record: DesignRecord, bore: CircleDatum) -> KeywayDatum | None:
    """The first keyway, at half the height of its sides."""
    key = record.spec.disc.keyway
    if key is None or not bore.keyed:
        return None
    half = 0.5 * key.width_mm
    shoulder, floor = math.sqrt(bore.radius**2 - half**2), bore.radius + key.depth_mm
    middle = 0.5 * (shoulder + floor - key.corner_radius_mm)
    return KeywayDatum("keyway 1", cmath.rect(middle, math.radians(key.first_at_deg) + record.openings_turn), half)


def face_points(record: DesignRecord, probe_radius: float) -> list[complex]:
    """Four places of the face, one a quadrant, far from the axis and clear of teeth and openings [mm]."""
    from shapely import Point, Polygon

    def ring(points: ComplexArray) -> FloatArray:
        return np.stack([points.real, points.imag], axis=-1)

    phase = np.linspace(0.0, record.profile.trochoid.phase_period, _OUTLINE, endpoint=False)
    holes = [ring(contour.points(_CHORDS)) for contour in record.outline.contours]
    disc = Polygon(ring(record.profile.at(phase).position), holes)
    root = float(np.min(np.abs(record.profile.at(phase).position)))
    for margin in _MARGINS:
        region = disc.buffer(-(probe_radius + margin))
        found = []
        for quadrant in range(FACE_POINTS):
            # From the middle of the quadrant outwards on both sides.
            turns = sorted(np.linspace(0.02, 0.98, 49).tolist(), key=lambda share: abs(share - 0.5))
            places = (
                radius * cmath.exp(0.5j * math.pi * (quadrant + turn))
                for turn in turns
                for radius in np.linspace(root, 0.2 * root, 60).tolist()
            )
            found += [next((z for z in places if region.contains(Point(z.real, z.imag))), None)]
        if None not in found:
            return [z for z in found if z is not None]
    raise ExportError(
        "export.inspection.probe_radius_mm", f"{probe_radius:g}", "finds no face to touch between the openings",
        "take a smaller ball",
    )  # fmt: skip
