"""Openings of a disc as contours: rings of round holes, windows between two radii, a bore with keyways."""

from __future__ import annotations

import cmath
import math

import numpy as np

from cycloid_profile.errors import GeometryError
from cycloid_profile.geometry.contour import Arc, Contour, Line, circle

_FULL = 2.0 * math.pi
_LEAST_LENGTH = 1e-9  # mm


def ring_of_holes(name: str, count: int, circle_radius: float, radius: float) -> tuple[Contour, ...]:
    """``count`` equal round holes on a circle, the first on the x axis; lengths in mm."""
    return tuple(
        circle(f"{name} {i + 1}", complex(circle_radius * np.exp(2j * math.pi * i / count)), radius)
        for i in range(count)
    )


def ring_of_windows(
    name: str, count: int, radii: tuple[float, float], span: float, corner_radius: float | None, first_at: float
) -> tuple[Contour, ...]:
    """``count`` equal windows between two radii, inner and outer [mm], with radial sides and round corners.

    ``span`` is the angle between the sides, the first window centred at ``first_at`` [rad]. A corner radius
    of half the width makes slots with round ends; None takes half of that, or what fits.

    Raises
    ------
    GeometryError
        If the radii are in the wrong order, the corners do not fit, or windows overlap.
    """
    inner, outer = radii
    if not inner < outer:
        raise GeometryError(
            "windows.outer_radius", f"{outer:g} mm", f"is not above inner_radius_mm = {inner:g}", "swap them"
        )
    if count * span >= _FULL:
        raise GeometryError(
            "windows.span",
            f"{math.degrees(span):g}°",
            f"leaves no web between {count} windows",
            f"take less than {360.0 / count:g}°",
        )
    largest = _largest_corner(inner, outer, span)
    corner = min(0.25 * (outer - inner), largest) if corner_radius is None else corner_radius
    if corner > largest:
        raise GeometryError(
            "windows.corner_radius",
            f"{corner:g} mm",
            f"does not fit into the window, the limit is {largest:.4g} mm",
            "take a smaller corner or a larger window",
        )
    window = Contour(name, _window(inner, outer, span, corner))
    return tuple(window.turned(first_at + _FULL * i / count, f"{name} {i + 1}") for i in range(count))


def keyed_bore(
    name: str, radius: float, count: int, width: float, depth: float, corner_radius: float, first_at: float
) -> Contour:
    """A round bore with ``count`` even keyways, sides parallel, the first at the angle ``first_at`` [rad].

    ``width`` across the key; ``depth`` from the bore's circle, at the middle of the key, to the flat floor;
    ``corner_radius`` between floor and sides; all in mm.

    Raises
    ------
    GeometryError
        If the keyways do not fit round the bore, or the corners into a keyway.
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
    if corner_radius > largest:
        raise GeometryError(
            "keyway.corner_radius",
            f"{corner_radius:g} mm",
            f"does not fit into the keyway, the limit is {largest:.4g} mm",
            "take a smaller corner",
        )
    edge, pitch = math.asin(half / radius), _FULL / count
    keyway = _keyway(half, shoulder, floor, corner_radius)
    segments: list[Line | Arc] = []
    for i in range(count):
        angle = first_at + i * pitch
        segments += [segment.turned(angle) for segment in keyway]
        segments.append(Arc(0j, radius, angle + edge, angle + pitch - edge))
    return Contour(name, tuple(segments))


def _largest_corner(inner: float, outer: float, span: float) -> float:
    """Corner radius at which sides, or the arc inside or outside, have no length left [mm]."""
    largest = 0.5 * (outer - inner)
    if span < math.pi:
        slope = math.sin(0.5 * span)
        largest = min(largest, inner * slope / (1.0 - slope), outer * slope / (1.0 + slope))
    return largest


def _window(inner: float, outer: float, span: float, corner: float) -> tuple[Line | Arc, ...]:
    """A window centred on the x axis, counterclockwise from its lower side; the arc inside runs clockwise."""
    h, quarter = 0.5 * span, 0.5 * math.pi
    # Angle between a side and the centre of a corner, and distance of the tangent point on the side.
    beside_in, beside_out = math.asin(corner / (inner + corner)), math.asin(corner / (outer - corner))
    side_in = math.sqrt(inner * (inner + 2.0 * corner))
    side_out = math.sqrt(outer * (outer - 2.0 * corner))

    def corner_arc(distance: float, angle: float, start: float, end: float) -> Arc:
        return Arc(cmath.rect(distance, angle), corner, start, end)

    segments: tuple[Line | Arc, ...] = (
        Line(cmath.rect(side_in, -h), cmath.rect(side_out, -h)),
        corner_arc(outer - corner, beside_out - h, -h - quarter, beside_out - h),
        Arc(0j, outer, beside_out - h, h - beside_out),
        corner_arc(outer - corner, h - beside_out, h - beside_out, h + quarter),
        Line(cmath.rect(side_out, h), cmath.rect(side_in, h)),
        corner_arc(inner + corner, h - beside_in, h + quarter, h - beside_in + math.pi),
        Arc(0j, inner, h - beside_in, beside_in - h),
        corner_arc(inner + corner, beside_in - h, beside_in - h + math.pi, 3.0 * quarter - h),
    )
    return tuple(segment for segment in segments if not _vanishes(segment))


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
    return tuple(segment for segment in segments if not _vanishes(segment))


def _vanishes(segment: Line | Arc) -> bool:
    """Whether a segment has no length worth writing: sharp corners, slots with round ends."""
    length = abs(segment.end - segment.start) if isinstance(segment, Line) else segment.radius * abs(segment.turn)
    return length < _LEAST_LENGTH
