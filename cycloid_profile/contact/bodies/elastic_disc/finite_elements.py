"""Compliance of a disc from finite elements of its outline, computed once (docs/theory.md, Eqs. 83, 84).

A finite-element model of the outline is condensed to a matrix between points on the flanks and the bearings. Near a
contact the contact law counts the deformation down to the depth of the pin radius, the matrix counts the rest.
"""

from __future__ import annotations

import hashlib
import math
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.contact.bodies.elastic_disc.compliance import FORMAT, DiscCompliance, read_disc_compliance
from cycloid_profile.errors import GeometryError, LoadError, ResourceError
from cycloid_profile.geometry import Contour, DiscOutline
from cycloid_profile.resources import Need

# Points on a lobe: cubic interpolation between 12 errs by 0.2 %; the pin radius must span some triangles.
_PER_LOBE, _PER_PIN_RADIUS = 12, 3.6
_HOLE_POINTS = 32  # of a circle, twice as many of other openings; 64 move the compliance by 0.1 %
_LARGEST = 12.0  # triangles across the radius of the disc
_DEEPEST = 0.8  # of the wall below a flank, where its own recession is read
_CHORD = 1e-2  # mm, of openings that are not round
_SAME = 1e-4  # of the area of the openings, which differ by their chords when turned
_FINE_CHORD = 1e-4  # mm
_PAIR_BYTES, _PAIR_TIME = 64.0, 7e-6  # memory and s of one core for two flank points, measured with 550 to 3000
_DIGITS = 9  # of the sizes that name a disc in the cache


def disc_compliance(
    outline: DiscOutline,
    youngs_modulus: float,
    poisson_ratio: float,
    width: float,
    openings_turned: float = 0.0,
    depth: float | None = None,
    refinement: float = 1.0,
) -> DiscCompliance:
    """Compliance of a disc with this outline from a finite-element model in plane stress.

    Crank holes are the bearings where there are any, else the bore is, and the output holes keep the disc from turning.

    Parameters
    ----------
    outline : tooth curve and openings
    youngs_modulus, poisson_ratio : of the disc [MPa]
    width : of the disc [mm]
    openings_turned : angle by which the openings are turned against the teeth [rad]
    depth : below a flank point, where its own recession is read [mm]; the pin radius if absent. The contact law counts
        the rest, so that the result hardly depends on it
    refinement : of all sizes of the mesh

    Raises
    ------
    GeometryError
        If the openings cut into each other or the teeth, or the disc has nothing to be held by.
    ResourceError
        If the teeth need more memory or time than allowed.
    """
    unit = _of_unit_disc(_Sizes(outline, openings_turned, depth, refinement), poisson_ratio)
    return unit.scaled(1.0 / (youngs_modulus * width))


@dataclass(frozen=True, slots=True)
class _Sizes:
    """What the compliance of a disc of unit width and modulus depends on, but for Poisson's ratio."""

    outline: DiscOutline
    turned: float
    depth: float | None
    refinement: float

    @property
    def per_lobe(self) -> int:
        """Flank points of a lobe."""
        tooth = self.outline.profile
        fine = tooth.at(np.linspace(0.0, 2.0 * math.pi, 200)).position
        length = float(np.sum(np.abs(np.diff(fine))))
        return math.ceil(self.refinement * max(_PER_LOBE, _PER_PIN_RADIUS * length / tooth.pin_radius))

    @property
    def need(self) -> Need:
        """What the condensation of the disc needs: every flank point is loaded, and read at all others."""
        trochoid, points = self.outline.profile.trochoid, self.per_lobe * self.outline.profile.trochoid.lobes
        return Need(
            "drive.pins", f"{trochoid.pins} of {self.outline.profile.pin_radius:g} mm radius",
            'take load.disc_body = "rigid", thicker pins or fewer',
            memory=_PAIR_BYTES * points**2, time=_PAIR_TIME * points**2,
        )  # fmt: skip

    @property
    def named(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Names of the bearings and of the openings that carry the torque."""
        names = [one.name for one in self.outline.contours]
        cranks = tuple(name for name in names if name.startswith("crank hole"))
        if cranks:
            return cranks, cranks
        return tuple(name for name in names if name == "bore"), tuple(
            name for name in names if name.startswith("output hole")
        )

    @property
    def sectors(self) -> int:
        """Number of turns of the disc that change nothing."""
        from shapely import MultiPolygon, Polygon, affinity
        from shapely.ops import unary_union

        from cycloid_profile.contact.bodies.elastic_disc._mesh import xy

        openings = unary_union(MultiPolygon([Polygon(xy(one.points(_FINE_CHORD))) for one in self.outline.contours]))
        lobes, bearings = self.outline.profile.trochoid.lobes, max(len(self.named[0]), 1)
        common = math.gcd(lobes, bearings) if bearings > 1 else lobes
        for sectors in (n for n in range(common, 1, -1) if common % n == 0):
            turned = affinity.rotate(openings, 360.0 / sectors, origin=(0.0, 0.0))
            if turned.symmetric_difference(openings).area < _SAME * openings.area:
                return sectors
        return 1

    def rings(self) -> list[ComplexArray]:
        """Points of the openings [mm]."""
        turn = np.exp(1j * self.turned)
        return [turn * _ring(one, round(_HOLE_POINTS * self.refinement)) for one in self.outline.contours]

    def key(self, poisson_ratio: float) -> str:
        """Name of the disc: equal for equal sizes."""
        flank, normal = self.flank()
        depth = -1.0 if self.depth is None else self.depth
        numbers = [flank, normal, *self.rings(), np.array([depth, self.refinement, poisson_ratio, _LARGEST])]
        text = repr((FORMAT, self.named, self.outline.profile.pin_radius))
        digest = hashlib.sha256(text.encode())
        for each in numbers:
            digest.update(np.round(each, _DIGITS).tobytes())
        return digest.hexdigest()[:32]

    def flank(self) -> tuple[ComplexArray, ComplexArray]:
        """Points and outward normals of all lobes in the frame of the disc."""
        tooth, per_lobe = self.outline.profile, self.per_lobe
        lobes = tooth.trochoid.lobes
        phase = np.tile(2.0 * math.pi * np.arange(per_lobe) / per_lobe, lobes)
        turn = np.exp(-2j * math.pi * np.repeat(np.arange(lobes), per_lobe) / lobes)
        points = tooth.at(phase)
        return points.position * turn, points.normal * turn


def _of_unit_disc(sizes: _Sizes, poisson_ratio: float) -> DiscCompliance:
    """Compliance at unit modulus and width, from memory, from the cache of the user, or computed."""
    return _remembered(sizes.key(poisson_ratio), sizes, poisson_ratio)


@lru_cache(maxsize=16)
def _remembered(key: str, sizes: _Sizes, poisson_ratio: float) -> DiscCompliance:
    path = _cache_folder() / f"{key}.npz"
    lobes, bearings = sizes.outline.profile.trochoid.lobes, len(sizes.named[0])
    # A file that is damaged, too large, or of another disc under this name is computed again.
    with suppress(LoadError, ResourceError):
        if (found := read_disc_compliance(path, lobes, bearings)).key == key:
            return found
    sizes.need.require()
    found = _computed(key, sizes, poisson_ratio)
    # A cache that cannot be written to costs time only.
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        found.save(path)
    return found


def _cache_folder() -> Path:
    from platformdirs import user_cache_path

    return user_cache_path("cycloid-profile", appauthor=False) / "disc-compliances"


def _computed(key: str, sizes: _Sizes, poisson_ratio: float) -> DiscCompliance:
    import shapely

    from cycloid_profile.contact.bodies.elastic_disc._elements import condensed
    from cycloid_profile.contact.bodies.elastic_disc._mesh import xy

    tooth = sizes.outline.profile
    names = [one.name for one in sizes.outline.contours]
    bearings, carriers = sizes.named
    flank, normal = sizes.flank()
    rings = sizes.rings()
    polygon = shapely.Polygon(xy(flank), [xy(ring) for ring in rings])
    if not bearings or not polygon.is_valid:
        raise GeometryError(
            "disc openings", ", ".join(names) or "none", "cut into each other or the teeth, or leave no bearing",
            "make the holes smaller, or take disc_body = \"rigid\"",
        )  # fmt: skip
    reference = tooth.pin_radius
    wanted = reference if sizes.depth is None else sizes.depth
    depth = np.minimum(wanted, _DEEPEST * _wall_below(polygon, flank, normal, wanted))
    largest = float(np.max(np.abs(flank))) / (_LARGEST * sizes.refinement)
    matrix, own = condensed(
        flank, normal, rings, [names.index(name) for name in bearings], [names.index(name) for name in carriers],
        depth, poisson_ratio, largest,
    )  # fmt: skip
    # The law counts the near field down to the pin radius: between there and the place of reading it is added here.
    own += 2.0 * (1.0 - poisson_ratio**2) / math.pi * np.log(depth / reference)
    found = DiscCompliance(key, tooth.trochoid.lobes, sizes.per_lobe, matrix, own, sizes.sectors)
    return _symmetric(found)


def _symmetric(disc: DiscCompliance) -> DiscCompliance:
    """The mean over all turns that change nothing; the triangles of the mesh do not know of them."""
    shift = len(disc.own) // disc.sectors
    matrix, own = np.zeros_like(disc.matrix), np.zeros_like(disc.own)
    for sector in range(disc.sectors):
        # The teeth run clockwise with the phase, the bearings are numbered anticlockwise.
        flank = (np.arange(len(disc.own)) + sector * shift) % len(disc.own)
        own += disc.own[flank] / disc.sectors
        turned = _turned_bearings(disc, sector)
        order = np.concatenate([flank, np.arange(len(disc.own), len(disc.matrix))])
        some = disc.matrix[np.ix_(order, order)]
        matrix += turned @ some @ turned.T / disc.sectors
    return replace(disc, matrix=matrix, own=own)


def _turned_bearings(disc: DiscCompliance, sector: int) -> FloatArray:
    """Matrix that takes the bearings of a disc turned by some sectors to those it had, and leaves the flanks."""
    found = np.eye(len(disc.matrix))
    if disc.bearings > 1:
        angle = 2.0 * math.pi * sector / disc.sectors
        rotation = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        points, step = len(disc.own), disc.bearings * sector // disc.sectors
        found[points:, points:] = 0.0
        for bearing in range(disc.bearings):
            to, source = points + 2 * ((bearing + step) % disc.bearings), points + 2 * bearing
            found[to : to + 2, source : source + 2] = rotation
    return found


def _wall_below(polygon: Any, flank: ComplexArray, normal: ComplexArray, reach: float) -> FloatArray:
    """Thickness of the disc below each flank point along the normal, at most twice the ``reach`` [mm]."""
    import shapely

    start, end = flank - 1e-3 * reach * normal, flank - 2.0 * reach * normal
    ways = shapely.linestrings(np.stack([np.stack([start.real, start.imag], 1), np.stack([end.real, end.imag], 1)], 1))
    inside = shapely.intersection(ways, polygon)
    first = shapely.get_geometry(inside, 0)
    thickness: FloatArray = shapely.length(np.where(shapely.get_num_geometries(inside) > 1, first, inside))
    return thickness


def _ring(contour: Contour, points: int) -> ComplexArray:
    """Points round an opening, evenly spaced; a circle of equal area where it is one."""
    arc = contour.full_circle_arc
    if arc is not None:
        step = 2.0 * math.pi / points
        radius = arc.radius * math.sqrt(step / math.sin(step))
        return np.asarray(arc.centre + radius * np.exp(1j * step * np.arange(points)))
    fine = contour.points(_CHORD)
    closed = np.append(fine, fine[0])
    at = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(closed)))])
    even = np.linspace(0.0, at[-1], 2 * points, endpoint=False)
    return np.asarray(np.interp(even, at, closed.real) + 1j * np.interp(even, at, closed.imag))
