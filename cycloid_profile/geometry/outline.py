"""The outline of a disc: tooth curve and openings, and the least wall between them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile._display import Described
from cycloid_profile.geometry.contour import Contour
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.geometry.sampling import EqualArc, sample

if TYPE_CHECKING:
    from shapely import Polygon

_POINTS_PER_LOBE = 120  # chords within 3 µm on an RV-40E, far below any web width
_CHORDS = 1e-4  # mm, chord error of openings that are not round
_NODES_PER_FLANK = 200  # Gauss-Legendre; the area of the RV-40E is at rounding from 60 on
_NAMES_SHOWN = 8  # of openings in one sentence


@dataclass(frozen=True, slots=True)
class Hole:
    """A round hole: ``name``, ``centre`` x + iy in the disc frame [mm], ``radius`` [mm]."""

    name: str
    centre: complex
    radius: float


@dataclass(frozen=True, slots=True, repr=False)
class DiscOutline(Described):
    """One disc: the exact tooth curve, and closed ``contours`` of lines and arcs round its openings.

    Openings are bore, crank holes, output holes and windows.
    """

    profile: ToothProfile
    contours: tuple[Contour, ...] = ()

    def _key_figures(self) -> dict[str, str]:
        openings = ", ".join(contour.name for contour in self.contours[:_NAMES_SHOWN])
        more = len(self.contours) - _NAMES_SHOWN
        return {
            "lobes": f"{self.profile.trochoid.lobes}",
            "root radius": f"{self.root_radius:.6g} mm",
            "tip radius": f"{self.tip_radius:.6g} mm",
            "openings": (openings or "none") + (f" and {more} more" if more > 0 else ""),
        }

    @property
    def holes(self) -> tuple[Hole, ...]:
        """The round openings."""
        found = ((contour.name, contour.full_circle_arc) for contour in self.contours)
        return tuple(Hole(name, arc.centre, arc.radius) for name, arc in found if arc is not None)

    @property
    def area(self) -> float:
        """Area of the disc less its openings, by Green's theorem on the exact curves [mm²]."""
        profile = self.profile
        lobes = 1 if profile.identical_lobes else profile.trochoid.lobes
        nodes, weights = np.polynomial.legendre.leggauss(_NODES_PER_FLANK)
        teeth = 0.0
        for flank in range(2 * lobes):
            phase = math.pi * (flank + 0.5 + 0.5 * nodes)
            on = profile.at(phase, np.full(phase.shape, 1.0 if flank % 2 == 0 else -1.0))
            teeth += 0.25 * math.pi * float(np.sum(weights * (np.conj(on.position) * on.first).imag))
        # Clockwise, hence negative.
        return -teeth * profile.trochoid.lobes / lobes - sum(contour.area for contour in self.contours)

    @property
    def root_radius(self) -> float:
        """Radius of the tooth root [mm]."""
        return float(np.abs(self.profile.at(0.0).position))

    @property
    def tip_radius(self) -> float:
        """Radius of the tooth tip [mm]."""
        return float(np.abs(self.profile.at(math.pi).position))


def thinnest_web(outline: DiscOutline) -> tuple[float, str]:
    """Thinnest wall between openings, or between an opening and the teeth [mm], and its location.

    Negative by the depth of an intersection. Exact between round holes, within some µm otherwise; infinite for a
    disc without openings.
    """
    from shapely import Polygon

    disc = Polygon(sample(outline.profile, EqualArc(_POINTS_PER_LOBE)).xy)
    polygons = [Polygon(_xy(contour)) for contour in outline.contours]
    walls = [(math.inf, "no holes")]
    for i, contour in enumerate(outline.contours):
        walls.append((_wall_to_teeth(disc, contour, polygons[i]), f"{contour.name} and teeth"))
        for other, polygon in zip(outline.contours[i + 1 :], polygons[i + 1 :], strict=True):
            walls.append((_web(contour, polygons[i], other, polygon), f"{contour.name} and {other.name}"))
    return min(walls, key=lambda wall: wall[0])


def _wall_to_teeth(disc: Polygon, contour: Contour, polygon: Polygon) -> float:
    """Wall between an opening and the teeth, negative where they overlap [mm]."""
    from shapely import Point

    arc = contour.full_circle_arc
    if arc is None:
        return float(disc.exterior.distance(polygon)) if disc.contains(polygon) else -_beyond(contour, disc, False)
    centre = Point(arc.centre.real, arc.centre.imag)
    return float(disc.exterior.distance(centre)) - arc.radius if disc.contains(centre) else -arc.radius


def _web(contour: Contour, polygon: Polygon, other: Contour, other_polygon: Polygon) -> float:
    a, b = contour.full_circle_arc, other.full_circle_arc
    if a is not None and b is not None:
        return abs(a.centre - b.centre) - a.radius - b.radius
    if not polygon.intersects(other_polygon):
        return float(polygon.distance(other_polygon))
    return -max(_beyond(contour, other_polygon, True), _beyond(other, polygon, True))


def _beyond(contour: Contour, polygon: Polygon, inside: bool) -> float:
    """Depth of the contour ``inside`` the polygon, or its reach beyond it [mm]."""
    import shapely

    points: Any = shapely.points(_xy(contour))
    wrong = points[shapely.contains(polygon, points) == inside]
    return float(np.max(shapely.distance(wrong, polygon.exterior), initial=0.0))


def _xy(contour: Contour) -> Any:
    points = contour.points(_CHORDS)
    return np.stack([points.real, points.imag], axis=-1)
