"""Elastic discs: how far flanks and bearing holes give way under the forces on a disc (docs/theory.md, Eqs. 81–84).

A finite-element model of the outline is condensed once to a matrix between points on the flanks and the bearings. Near
a contact the contact law counts the deformation down to the depth of the pin radius, the matrix counts the rest.
"""

from __future__ import annotations

import hashlib
import math
from collections import deque
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np

from cycloid_profile._display import Described
from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.contact.mesh import Meshing, mesh
from cycloid_profile.errors import GeometryError, LoadError, ResourceError
from cycloid_profile.filesystem import new_file
from cycloid_profile.geometry import Contour, DiscOutline, Trochoid
from cycloid_profile.resources import Need, unpacked_need

_FORMAT = "cycloid-profile disc compliance 1"
# Points on a lobe: cubic interpolation between 12 errs by 0.2 %; the pin radius must span some triangles.
_PER_LOBE, _PER_PIN_RADIUS = 12, 3.6
_HOLE_POINTS = 32  # of a circle, twice as many of other openings; 64 move the compliance by 0.1 %
_LARGEST = 12.0  # triangles across the radius of the disc
_DEEPEST = 0.8  # of the wall below a flank, where its own recession is read
_CHORD = 1e-2  # mm, of openings that are not round
_SAME = 1e-4  # of the area of the openings, which differ by their chords when turned
_FINE_CHORD = 1e-4  # mm
_PAIR_BYTES, _PAIR_TIME = 64.0, 7e-6  # memory and s of one core for two flank points, measured with 550 to 3000
_COPIES = 4.0  # of a matrix while it is read and checked
_POSES_AT_ONCE = 64  # of displacements: compliances of 130 forces take 9 MB
_KEPT_BYTES = 1e9  # of compliances kept: those of a bench of 3,000 rows with two discs of 60 pins take half
_DIGITS = 9  # of the sizes that name a disc in the cache


@dataclass(frozen=True, slots=True, repr=False)
class DiscCompliance(Described):
    """Compliance of one disc, its forces in equilibrium with reactions at the bearings.

    ``matrix`` shape (flank points + 2·bearings, the same): displacement against the outward normal at each flank point,
    then x and y of each bearing hole in the frame of the disc, under unit forces there [mm/N]. Displacements count from
    the mean motion of the bearing holes. ``own`` shape (flank points,): recession of each point under its own force,
    beyond what the contact law counts down to the depth of the pin radius [mm/N]. The flank points lie at equal steps
    of phase, ``per_lobe`` a lobe, the first in the root of lobe 0. ``sectors``, number of turns about the centre, the
    whole one included, that change nothing. Discs of equal ``key`` compare as equal.
    """

    key: str
    lobes: int
    per_lobe: int
    matrix: FloatArray = field(compare=False)
    own: FloatArray = field(compare=False)
    sectors: int = 1

    @property
    def bearings(self) -> int:
        """Number of bearings."""
        return (len(self.matrix) - len(self.own)) // 2

    def _key_figures(self) -> dict[str, str]:
        own = self.own * 1e6
        return {
            "flank points": f"{len(self.own)} on {self.lobes} lobes",
            "bearings": f"{self.bearings}",
            "recession under 1 kN there": f"{np.min(own):.3f} to {np.max(own):.3f} µm",
        }

    @property
    def uneven_part(self) -> DiscCompliance:
        """What the compliance between flank points differs by from its mean over all lobes: holes make a disc softer in
        some directions. Zero for a disc that is the same at all lobes.
        """
        points, lobe = len(self.own), np.arange(self.lobes)
        by_lobe = self.matrix[:points, :points].reshape(self.lobes, self.per_lobe, self.lobes, self.per_lobe)
        ahead = (lobe[:, np.newaxis] + lobe) % self.lobes
        mean = np.mean(by_lobe.transpose(0, 2, 1, 3)[lobe[:, np.newaxis], ahead], axis=0)
        even = mean[(lobe - lobe[:, np.newaxis]) % self.lobes].transpose(0, 2, 1, 3).reshape(points, points)
        matrix = np.zeros_like(self.matrix)
        matrix[:points, :points] = self.matrix[:points, :points] - even
        own = self.own - np.tile(np.mean(self.own.reshape(self.lobes, -1), axis=0), self.lobes)
        return replace(self, key=f"{self.key}, uneven part", matrix=matrix, own=own)

    def scaled(self, factor: float) -> DiscCompliance:
        """The compliance times ``factor``, as of another modulus or width."""
        return replace(self, key=f"{self.key}*{factor!r}", matrix=factor * self.matrix, own=factor * self.own)

    def save(self, path: str | Path) -> None:
        """Write an ``.npz`` file that ``read_disc_compliance`` reads (docs/elastic-disc.md)."""
        with new_file(Path(path)) as scratch, scratch.open("wb") as file:
            np.savez(
                file, format=_FORMAT, key=self.key, lobes=self.lobes, per_lobe=self.per_lobe, matrix=self.matrix,
                own=self.own, sectors=self.sectors, sha256=self._checksum(),
            )  # fmt: skip

    def _checksum(self) -> str:
        return hashlib.sha256(self.matrix.tobytes() + self.own.tobytes()).hexdigest()


def read_disc_compliance(path: Path, lobes: int, bearings: int) -> DiscCompliance:
    """The compliance in an ``.npz`` file, made by ``DiscCompliance.save`` or by another finite-element program.

    Raises
    ------
    LoadError
        If the file cannot be read, is damaged, or belongs to a disc with other lobes or bearings.
    """

    def refused(limit: str, remedy: str) -> LoadError:
        return LoadError("disc_body_file", f"{path}", limit, remedy, " ")

    if path.exists() and not path.is_file():
        raise refused("is no plain file", "give an .npz file")
    try:
        with path.open("rb") as packed:
            need = unpacked_need(packed, "disc_body_file", f"{path}", _COPIES)
        need.require()
        with np.load(path, allow_pickle=False) as file:
            entries: dict[str, Any] = {name: file[name] for name in file.files}
        found = DiscCompliance(
            key=str(entries.get("key", path.name)),
            lobes=int(entries["lobes"]),
            per_lobe=int(entries["per_lobe"]),
            matrix=np.array(entries["matrix"], dtype=np.float64, order="C"),
            own=np.array(entries["own"], dtype=np.float64),
            sectors=int(entries.get("sectors", 1)),
        )
    except ResourceError:
        raise
    except Exception as error:  # a damaged archive raises whatever its parts raise
        reason = f"{error}".split("\n")[0] or type(error).__name__
        raise refused(f"cannot be read ({reason})", "see docs/elastic-disc.md for its entries") from None
    if "sha256" in entries and str(entries["sha256"]) != found._checksum():
        raise refused("has a checksum that does not fit its numbers", "write the file again")
    points = found.lobes * found.per_lobe
    sizes = (found.lobes, found.matrix.shape, found.own.shape)
    wanted = (lobes, (points + 2 * bearings,) * 2, (points,))
    if sizes != wanted or found.per_lobe < 4:
        raise refused(f"has lobes, matrix and own {sizes}, not {wanted}", "make it for this drive, 4 points a lobe")
    if found.sectors < 1 or lobes % found.sectors:
        raise refused(f"has {found.sectors} sectors, which do not divide {lobes} lobes", "leave sectors out")
    if not (np.all(np.isfinite(found.matrix)) and np.all(found.own > 0.0)):
        raise refused("has a compliance that is not finite, or not positive", "check its matrix")
    if not np.allclose(found.matrix, found.matrix.T, rtol=0.0, atol=1e-3 * np.max(np.abs(found.matrix))):
        raise refused("is not symmetric within a thousandth", "make a force at A move B as one at B moves A")
    return found


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


def stage_compliance(discs: tuple[DiscCompliance, ...], meshing: Meshing) -> FloatArray:
    """Compliance between all forces on the discs of a stage, shape (poses, forces, forces) [mm/N].

    Forces of the pins, disc by disc, then both components of each bearing in the housing frame. Without ``discs``, of
    rigid discs, there are no forces. An array that ``kept_compliance`` keeps is returned itself: do not write into it.
    """
    from cycloid_profile.contact.bodies._kernels import fill_compliances

    poses, count, pins = meshing.phase.shape
    if not discs:
        return np.zeros((poses, 0, 0))
    some = discs[:count]
    kept = _KEPT.find(some, meshing.trochoid, meshing.crank_angle[:, 0])
    if kept is not None:
        return kept
    forces = _forces(some, pins)
    found = np.empty((poses, forces, forces))
    fill_compliances(*_compiled(some), *_places(some, meshing), found)
    return found


def kept_compliance(
    discs: tuple[DiscCompliance, ...], trochoid: Trochoid, crank_angle: FloatArray
) -> FloatArray | None:
    """``stage_compliance`` at crank angles of disc 1, shape (poses,) [rad], kept for further calls with equal discs and
    these poses, or some in a row of them; None if it is too large, or the discs are rigid.
    """
    if not discs or 8.0 * crank_angle.size * _forces(discs, trochoid.pins) ** 2 > _KEPT.most:
        return None
    found = _KEPT.find(discs, trochoid, crank_angle)
    if found is None:
        found = stage_compliance(discs, mesh(trochoid, crank_angle, len(discs)))
        _KEPT.keep(_Kept(discs, trochoid, crank_angle.copy(), found))
    return found


def _forces(discs: tuple[DiscCompliance, ...], pins: int) -> int:
    return len(discs) * (pins + 2 * discs[0].bearings)


def _equal(some: tuple[DiscCompliance, ...], others: tuple[DiscCompliance, ...]) -> bool:
    return some == others and all(
        a is b or (np.array_equal(a.matrix, b.matrix) and np.array_equal(a.own, b.own))
        for a, b in zip(some, others, strict=True)
    )


@dataclass(frozen=True, eq=False, slots=True)
class _Kept:
    """The ``compliance`` of discs at crank angles of disc 1."""

    discs: tuple[DiscCompliance, ...]
    trochoid: Trochoid
    crank_angle: FloatArray
    compliance: FloatArray

    def at(self, discs: tuple[DiscCompliance, ...], trochoid: Trochoid, crank_angle: FloatArray) -> FloatArray | None:
        """The compliance at these poses; None if they are not some in a row of its own, or the discs are others."""
        # A file of the user may give another disc the same key.
        if trochoid != self.trochoid or not _equal(discs, self.discs):
            return None
        for first in np.flatnonzero(self.crank_angle == crank_angle[0]):
            some = slice(first, first + crank_angle.size)
            if np.array_equal(self.crank_angle[some], crank_angle):
                return self.compliance[some]
        return None


class _Latest:
    """The latest compliances, up to ``most`` bytes in all.

    Diagnosis solves hundreds of reducers at the same poses: filling the compliances took two thirds of the time.
    """

    def __init__(self, most: float) -> None:
        self.most = most
        self._kept: deque[_Kept] = deque()
        self._lock = Lock()

    def find(self, discs: tuple[DiscCompliance, ...], trochoid: Trochoid, crank_angle: FloatArray) -> FloatArray | None:
        """The compliance at these poses, if it is kept."""
        with self._lock:
            for one in self._kept:
                found = one.at(discs, trochoid, crank_angle)
                if found is not None:
                    self._kept.remove(one)
                    self._kept.append(one)
                    return found
        return None

    def keep(self, one: _Kept) -> None:
        """Keep one more, and forget the oldest that there is no more room for."""
        with self._lock:
            self._kept.append(one)
            while sum(each.compliance.nbytes for each in self._kept) > self.most:
                self._kept.popleft()


_KEPT = _Latest(_KEPT_BYTES)


def stage_displacements(discs: tuple[DiscCompliance, ...], meshing: Meshing, load: FloatArray) -> FloatArray:
    """Displacements under the forces ``load`` on elastic discs, both of shape (poses, forces) [mm, N].

    Order of the forces as in ``stage_compliance``.
    """
    found = np.empty_like(load)
    for some, compliance in _in_parts(discs, meshing):
        found[some] = np.einsum("pij,pj->pi", compliance, load[some])
    return found


def displacements_by_holes(discs: tuple[DiscCompliance, ...], meshing: Meshing, load: FloatArray) -> FloatArray:
    """``stage_displacements`` without those of flanks under forces on flanks, shape (poses, forces) [mm].

    What remains is what bearing holes move, and what forces on them move.
    """
    found, pins = np.empty_like(load), meshing.phase[0].size
    for some, compliance in _in_parts(discs, meshing):
        found[some, :pins] = np.einsum("pij,pj->pi", compliance[:, :pins, pins:], load[some, pins:])
        found[some, pins:] = np.einsum("pij,pj->pi", compliance[:, pins:], load[some])
    return found


def _in_parts(discs: tuple[DiscCompliance, ...], meshing: Meshing) -> Iterator[tuple[slice, FloatArray]]:
    """``stage_compliance`` of a few poses at a time, with their place."""
    for first in range(0, len(meshing.phase), _POSES_AT_ONCE):
        some = slice(first, first + _POSES_AT_ONCE)
        yield some, stage_compliance(discs, meshing.poses(some))


def _compiled(discs: tuple[DiscCompliance, ...]) -> tuple[FloatArray, FloatArray]:
    """Matrices and own compliances of all discs, shape (discs, …), for the compiled kernels."""
    return np.stack([one.matrix for one in discs]), np.stack([one.own for one in discs])


def _places(discs: tuple[DiscCompliance, ...], meshing: Meshing) -> tuple[FloatArray, FloatArray]:
    """Place of each pin on its disc in flank points, shape (poses, discs, pins), and orientation of each disc in the
    housing, shape (poses, discs) [rad].
    """
    along = discs[0].per_lobe * (meshing.phase / (2.0 * math.pi) + meshing.lobe)
    return along, -meshing.crank_angle / meshing.trochoid.lobes


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

        from cycloid_profile.contact.bodies._disc_mesh import xy

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
        text = repr((_FORMAT, self.named, self.outline.profile.pin_radius))
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

    from cycloid_profile.contact.bodies._disc_elements import condensed
    from cycloid_profile.contact.bodies._disc_mesh import xy

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
