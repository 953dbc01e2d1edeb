"""The whole disc: tooth curve and openings, and how much material is left between them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.geometry.contour import Contour
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.geometry.sampling import EqualArc, sample

if TYPE_CHECKING:
    from shapely import Polygon

_POINTS_PER_LOBE = 120  # chords within 3 µm on an RV-40E, far below any web width
_CHORDS = 1e-4  # mm, of openings that are not round; round ones are measured exactly


@dataclass(frozen=True, slots=True)
class Hole:
    """A round hole: ``name``, ``centre`` x + iy in the disc frame [mm], ``radius`` [mm]."""

    name: str
    centre: complex
    radius: float


@dataclass(frozen=True, slots=True)
class DiscOutline:
    """One disc, which every writer takes its lines from: the exact tooth curve, and closed ``contours`` of
    lines and arcs round the openings: bore, crank holes, output holes, windows.
    """

    profile: ToothProfile
    contours: tuple[Contour, ...] = ()

    @property
    def holes(self) -> tuple[Hole, ...]:
        """The round openings."""
        found = ((contour.name, contour.circle) for contour in self.contours)
        return tuple(Hole(name, arc.centre, arc.radius) for name, arc in found if arc is not None)

    @property
    def root_radius(self) -> float:
        """Radius of the tooth root [mm]."""
        return float(np.abs(self.profile.at(0.0).position))

    @property
    def tip_radius(self) -> float:
        """Radius of the tooth tip [mm]."""
        return float(np.abs(self.profile.at(math.pi).position))


def least_web(outline: DiscOutline) -> tuple[float, str]:
    """Thinnest wall between openings, or between one and the teeth, with its place [mm].

    Negative where they cut, by how far. Between round holes exact; else within some µm, from polygons.
    Returns infinity for a disc without openings.
    """
    from shapely import Polygon

    disc = Polygon(sample(outline.profile, EqualArc(_POINTS_PER_LOBE)).xy)
    polygons = [Polygon(_xy(contour)) for contour in outline.contours]
    least, place = math.inf, "no holes"
    for i, contour in enumerate(outline.contours):
        rim = _rim(disc, contour, polygons[i])
        if rim < least:
            least, place = rim, f"{contour.name} and teeth"
        for j in range(i + 1, len(polygons)):
            web = _web(contour, polygons[i], outline.contours[j], polygons[j])
            if web < least:
                least, place = web, f"{contour.name} and {outline.contours[j].name}"
    return float(least), place


def _rim(disc: Polygon, contour: Contour, polygon: Polygon) -> float:
    from shapely import Point

    arc = contour.circle
    if arc is None:
        return float(disc.exterior.distance(polygon)) if disc.contains(polygon) else -_beyond(contour, disc, False)
    centre = Point(arc.centre.real, arc.centre.imag)
    return float(disc.exterior.distance(centre)) - arc.radius if disc.contains(centre) else -arc.radius


def _web(contour: Contour, polygon: Polygon, other: Contour, other_polygon: Polygon) -> float:
    a, b = contour.circle, other.circle
    if a is not None and b is not None:
        return abs(a.centre - b.centre) - a.radius - b.radius
    if not polygon.intersects(other_polygon):
        return float(polygon.distance(other_polygon))
    return -max(_beyond(contour, other_polygon, True), _beyond(other, polygon, True))


def _beyond(contour: Contour, polygon: Polygon, inside: bool) -> float:
    """How far the contour reaches into the polygon, or out of it [mm]."""
    import shapely

    points: Any = shapely.points(_xy(contour))
    wrong = points[shapely.contains(polygon, points) == inside]
    return float(np.max(shapely.distance(wrong, polygon.exterior), initial=0.0))


def _xy(contour: Contour) -> Any:
    points = contour.points(_CHORDS)
    return np.stack([points.real, points.imag], axis=-1)
