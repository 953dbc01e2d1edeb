"""Closed contours of lines and arcs, and the openings of a disc: round holes, windows, a bore with keyways."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import ComplexArray
from cycloid_profile.errors import GeometryError

_CLOSED = 1e-9  # mm, largest gap between neighbouring segments
_CIRCLE = 2.0 * math.pi
_LEAST_LENGTH = 1e-9  # mm; shorter segments, as of sharp corners, are left out


@dataclass(frozen=True, slots=True)
class Line:
    """A straight segment from ``start`` to ``end``, x + iy [mm]."""

    start: complex
    end: complex

    @property
    def length(self) -> float:
        """Length [mm]."""
        return abs(self.end - self.start)

    @property
    def area_integral(self) -> float:
        """∫ (x dy − y dx)/2 along the segment, its share of the enclosed area by Green's theorem [mm²]."""
        return 0.5 * (self.start.conjugate() * self.end).imag

    def points(self, chord_error: float) -> ComplexArray:  # noqa: ARG002 - a straight line is its own chord
        """Start and end, shape (2,) [mm]."""
        return np.array([self.start, self.end])

    def rotated(self, angle: float) -> Line:
        """The line rotated about the origin by ``angle`` [rad]."""
        turn = cmath.rect(1.0, angle)
        return Line(self.start * turn, self.end * turn)


@dataclass(frozen=True, slots=True)
class Arc:
    """A circular segment about ``centre`` [mm] with ``radius`` [mm], between two angles [rad].

    It runs counterclockwise where ``to_angle`` exceeds ``from_angle``, else clockwise; a full circle sweeps 2π.
    """

    centre: complex
    radius: float
    from_angle: float
    to_angle: float

    @property
    def start(self) -> complex:
        """First point [mm]."""
        return self.centre + cmath.rect(self.radius, self.from_angle)

    @property
    def end(self) -> complex:
        """Last point [mm]."""
        return self.start if self.full_circle else self.centre + cmath.rect(self.radius, self.to_angle)

    @property
    def sweep(self) -> float:
        """Signed angle from start to end, counterclockwise positive [rad]."""
        return self.to_angle - self.from_angle

    @property
    def full_circle(self) -> bool:
        """Whether it is a full circle."""
        return abs(self.sweep) == _CIRCLE

    @property
    def length(self) -> float:
        """Length [mm]."""
        return self.radius * abs(self.sweep)

    @property
    def area_integral(self) -> float:
        """∫ (x dy − y dx)/2 along the segment, its share of the enclosed area by Green's theorem [mm²]."""
        chord = self.end - self.start
        return 0.5 * (self.radius**2 * self.sweep + (self.centre.conjugate() * chord).imag)

    def points(self, chord_error: float) -> ComplexArray:
        """Points from start to end whose chords stay within ``chord_error`` of the arc [mm]."""
        step = 2.0 * math.acos(max(-1.0, 1.0 - chord_error / self.radius))
        count = max(2, math.ceil(abs(self.sweep) / step)) + 1
        angles = np.linspace(self.from_angle, self.to_angle, count)
        points: ComplexArray = self.centre + self.radius * np.exp(1j * angles)
        points[-1] = self.end
        return points

    def rotated(self, angle: float) -> Arc:
        """The arc rotated about the origin by ``angle`` [rad]; a full circle keeps its angles."""
        more = 0.0 if self.full_circle else angle
        centre = self.centre * cmath.rect(1.0, angle)
        return Arc(centre, self.radius, self.from_angle + more, self.to_angle + more)


@dataclass(frozen=True, slots=True)
class Contour:
    """A closed counterclockwise contour: each segment starts at the end of the previous one.

    A circle is one ``Arc``. ``name`` is the name of the opening, such as "crank hole 2".
    """

    name: str
    segments: tuple[Line | Arc, ...]

    def __post_init__(self) -> None:
        starts = [segment.start for segment in self.segments]
        ends = [self.segments[-1].end, *(segment.end for segment in self.segments[:-1])]
        gap = max(abs(a - b) for a, b in zip(starts, ends, strict=True))
        if gap > _CLOSED:
            raise ValueError(f"contour '{self.name}' is open by {gap} mm")

    @property
    def full_circle_arc(self) -> Arc | None:
        """The arc of a round contour, else None."""
        only = self.segments[0]
        return only if len(self.segments) == 1 and isinstance(only, Arc) and only.full_circle else None

    @property
    def area(self) -> float:
        """Enclosed area, exact [mm²]."""
        return sum(segment.area_integral for segment in self.segments)

    def points(self, chord_error: float) -> ComplexArray:
        """Polygon on the contour with chords within ``chord_error`` [mm], the first point not repeated [mm]."""
        return np.concatenate([segment.points(chord_error)[:-1] for segment in self.segments])

    def rotated(self, angle: float, name: str) -> Contour:
        """The contour rotated about the origin by ``angle`` [rad], under another name."""
        return Contour(name, tuple(segment.rotated(angle) for segment in self.segments))


def circular_contour(name: str, centre: complex, radius: float) -> Contour:
    """A round contour, ``centre`` and ``radius`` in mm."""
    return Contour(name, (Arc(centre, radius, 0.0, _CIRCLE),))


def ring_of_holes(name: str, count: int, circle_radius: float, radius: float) -> tuple[Contour, ...]:
    """``count`` equal round holes on a circle, the first on the x axis; lengths in mm."""
    return tuple(
        circular_contour(f"{name} {i + 1}", complex(circle_radius * np.exp(2j * math.pi * i / count)), radius)
        for i in range(count)
    )


def ring_of_windows(
    name: str, count: int, radii: tuple[float, float], span: float, corner_radius: float | None, first_at: float
) -> tuple[Contour, ...]:
    """``count`` equal windows between two radii, inner and outer [mm], with radial sides and round corners.

    ``span`` is the angle between the sides, the first window centred at ``first_at`` [rad]. A corner radius of half
    the width makes slots with round ends; None takes a quarter of the width, or the largest that fits.

    Raises ``GeometryError`` if the radii are in the wrong order, the corners do not fit, or windows overlap.
    """
    inner, outer = radii
    if not inner < outer:
        raise GeometryError(
            "windows.outer_radius", f"{outer:g} mm", f"is not above inner_radius_mm = {inner:g}", "swap them"
        )
    if count * span >= _CIRCLE:
        limit, remedy = f"leaves no web between {count} windows", f"take less than {360.0 / count:g}°"
        raise GeometryError("windows.span", f"{math.degrees(span):g}°", limit, remedy)
    largest = _largest_corner(inner, outer, span)
    corner = min(0.25 * (outer - inner), largest) if corner_radius is None else corner_radius
    _require_corner("windows", "window", corner, largest, "take a smaller corner or a larger window")
    window = Contour(name, _window(inner, outer, span, corner))
    return tuple(window.rotated(first_at + _CIRCLE * i / count, f"{name} {i + 1}") for i in range(count))


def keyed_bore(
    name: str, radius: float, count: int, width: float, depth: float, corner_radius: float, first_at: float
) -> Contour:
    """A round bore with ``count`` even keyways, sides parallel, the first at the angle ``first_at`` [rad].

    ``width`` across the key; ``depth`` from the bore's circle, at the middle of the key, to the flat floor;
    ``corner_radius`` between floor and sides; all in mm.

    Raises ``GeometryError`` if the keyways do not fit round the bore, or the corners into a keyway.
    """
    room = 2.0 * radius * math.sin(math.pi / max(count, 2))
    if width >= room:
        raise GeometryError(
            "keyway.width", f"{width:g} mm", f"is not below the limit {room:.4g} mm of the bore", "take narrower keys"
        )
    half = 0.5 * width
    shoulder = math.sqrt(radius**2 - half**2)
    floor = radius + depth
    largest = min(half, floor - shoulder)
    _require_corner("keyway", "keyway", corner_radius, largest, "take a smaller corner")
    edge, pitch = math.asin(half / radius), _CIRCLE / count
    keyway = _keyway(half, shoulder, floor, corner_radius)
    segments: list[Line | Arc] = []
    for i in range(count):
        angle = first_at + i * pitch
        segments += [segment.rotated(angle) for segment in keyway]
        segments.append(Arc(0j, radius, angle + edge, angle + pitch - edge))
    return Contour(name, tuple(segments))


def _require_corner(key: str, opening: str, corner: float, largest: float, remedy: str) -> None:
    if corner > largest:
        limit = f"does not fit into the {opening}, the limit is {largest:.4g} mm"
        raise GeometryError(f"{key}.corner_radius", f"{corner:g} mm", limit, remedy)


def _largest_corner(inner: float, outer: float, span: float) -> float:
    """Corner radius at which a side or the inner arc has zero length [mm]; the outer arc never has it before them."""
    largest = 0.5 * (outer - inner)
    if span < math.pi:
        slope = math.sin(0.5 * span)
        largest = min(largest, inner * slope / (1.0 - slope))
    return largest


def _window(inner: float, outer: float, span: float, corner: float) -> tuple[Line | Arc, ...]:
    """A window centred on the x axis, counterclockwise from its lower side; its inner arc runs clockwise."""
    h, quarter = 0.5 * span, 0.5 * math.pi
    # Angle between a side and the centre of a corner, and distance of the tangent point on the side.
    angle_in, angle_out = math.asin(corner / (inner + corner)), math.asin(corner / (outer - corner))
    side_in = math.sqrt(inner * (inner + 2.0 * corner))
    side_out = math.sqrt(outer * (outer - 2.0 * corner))

    def corner_arc(distance: float, angle: float, start: float, end: float) -> Arc:
        return Arc(cmath.rect(distance, angle), corner, start, end)

    segments: tuple[Line | Arc, ...] = (
        Line(cmath.rect(side_in, -h), cmath.rect(side_out, -h)),
        corner_arc(outer - corner, angle_out - h, -h - quarter, angle_out - h),
        Arc(0j, outer, angle_out - h, h - angle_out),
        corner_arc(outer - corner, h - angle_out, h - angle_out, h + quarter),
        Line(cmath.rect(side_out, h), cmath.rect(side_in, h)),
        corner_arc(inner + corner, h - angle_in, h + quarter, h - angle_in + math.pi),
        Arc(0j, inner, h - angle_in, angle_in - h),
        corner_arc(inner + corner, angle_in - h, angle_in - h + math.pi, 3.0 * quarter - h),
    )
    return _without_vanishing(segments)


def _keyway(half: float, shoulder: float, floor: float, corner: float) -> tuple[Line | Arc, ...]:
    """A keyway along the x axis, from the bore's edge below it to the edge above."""
    quarter, c = 0.5 * math.pi, corner
    segments: tuple[Line | Arc, ...] = (
        Line(complex(shoulder, -half), complex(floor - c, -half)),
        Arc(complex(floor - c, c - half), c, -quarter, 0.0),
        Line(complex(floor, c - half), complex(floor, half - c)),
        Arc(complex(floor - c, half - c), c, 0.0, quarter),
        Line(complex(floor - c, half), complex(shoulder, half)),
    )
    return _without_vanishing(segments)


def _without_vanishing(segments: tuple[Line | Arc, ...]) -> tuple[Line | Arc, ...]:
    return tuple(segment for segment in segments if segment.length >= _LEAST_LENGTH)
