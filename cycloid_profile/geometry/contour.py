"""Closed contours of lines and arcs: the edge of every hole in a disc."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import ComplexArray

_CLOSED = 1e-9  # mm, the most by which one segment may miss the start of the next


@dataclass(frozen=True, slots=True)
class Line:
    """A straight segment from ``start`` to ``end``, x + iy [mm]."""

    start: complex
    end: complex

    @property
    def area_integral(self) -> float:
        """∫ (x dy − y dx)/2 along the segment, its share of the enclosed area by Green's theorem [mm²]."""
        return 0.5 * (self.start.conjugate() * self.end).imag

    def points(self, chord_error: float) -> ComplexArray:  # noqa: ARG002 - a straight line is its own chord
        """Start and end, shape (2,) [mm]."""
        return np.array([self.start, self.end])

    def turned(self, angle: float) -> Line:
        """The line turned about the origin by ``angle`` [rad]."""
        turn = cmath.rect(1.0, angle)
        return Line(self.start * turn, self.end * turn)


@dataclass(frozen=True, slots=True)
class Arc:
    """A circular segment about ``centre`` [mm] with ``radius`` [mm], between two angles [rad].

    It runs counterclockwise where ``to_angle`` is the larger, clockwise where it is the smaller; a whole
    circle turns by 2π.
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
        return self.start if self.whole else self.centre + cmath.rect(self.radius, self.to_angle)

    @property
    def turn(self) -> float:
        """Signed angle from start to end, counterclockwise positive [rad]."""
        return self.to_angle - self.from_angle

    @property
    def whole(self) -> bool:
        """Whether it is a whole circle."""
        return abs(self.turn) == 2.0 * math.pi

    @property
    def area_integral(self) -> float:
        """∫ (x dy − y dx)/2 along the segment, its share of the enclosed area by Green's theorem [mm²]."""
        chord = self.end - self.start
        return 0.5 * (self.radius**2 * self.turn + (self.centre.conjugate() * chord).imag)

    def points(self, chord_error: float) -> ComplexArray:
        """Points from start to end whose chords stay within ``chord_error`` of the arc [mm]."""
        step = 2.0 * math.acos(max(-1.0, 1.0 - chord_error / self.radius))
        count = max(2, math.ceil(abs(self.turn) / step)) + 1
        angles = np.linspace(self.from_angle, self.to_angle, count)
        points: ComplexArray = self.centre + self.radius * np.exp(1j * angles)
        points[-1] = self.end
        return points

    def turned(self, angle: float) -> Arc:
        """The arc turned about the origin by ``angle`` [rad]; a circle stays whole to the last bit."""
        more = 0.0 if self.whole else angle
        centre = self.centre * cmath.rect(1.0, angle)
        return Arc(centre, self.radius, self.from_angle + more, self.to_angle + more)


@dataclass(frozen=True, slots=True)
class Contour:
    """A closed contour, run through counterclockwise: each segment starts where the one before it ended.

    A circle is one whole ``Arc``. ``name`` tells what the contour is the edge of, such as "crank hole 2".
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
    def circle(self) -> Arc | None:
        """The one whole arc of a round contour, None of any other."""
        only = self.segments[0]
        return only if len(self.segments) == 1 and isinstance(only, Arc) and only.whole else None

    @property
    def area(self) -> float:
        """Enclosed area, exact [mm²]."""
        return sum(segment.area_integral for segment in self.segments)

    def points(self, chord_error: float) -> ComplexArray:
        """Corners of a polygon on the contour, chords within ``chord_error``, first not repeated [mm]."""
        return np.concatenate([segment.points(chord_error)[:-1] for segment in self.segments])

    def turned(self, angle: float, name: str) -> Contour:
        """The contour turned about the origin by ``angle`` [rad], under another name."""
        return Contour(name, tuple(segment.turned(angle) for segment in self.segments))


def circle(name: str, centre: complex, radius: float) -> Contour:
    """A round contour, ``centre`` and ``radius`` in mm."""
    return Contour(name, (Arc(centre, radius, 0.0, 2.0 * math.pi),))
