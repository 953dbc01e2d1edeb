"""Compliance of an elastic disc between its flanks and bearings, and the file that holds one."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile._display import Described
from cycloid_profile.arrays import FloatArray
from cycloid_profile.errors import LoadError, ResourceError
from cycloid_profile.filesystem import new_file
from cycloid_profile.resources import unpacked_need

FORMAT = "cycloid-profile disc compliance 1"
_COPIES = 4.0  # of a matrix while it is read and checked


@dataclass(frozen=True, repr=False)
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

    @cached_property
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

    @cached_property
    def hole_part(self) -> DiscCompliance:
        """What bearing holes move, and what forces on them move, without what flanks move under forces on flanks."""
        points, matrix = len(self.own), self.matrix.copy()
        matrix[:points, :points] = 0.0
        return replace(self, key=f"{self.key}, holes", matrix=matrix, own=np.zeros(points))

    def scaled(self, factor: float) -> DiscCompliance:
        """The compliance times ``factor``, as of another modulus or width."""
        return replace(self, key=f"{self.key}*{factor!r}", matrix=factor * self.matrix, own=factor * self.own)

    def save(self, path: str | Path) -> None:
        """Write an ``.npz`` file that ``read_disc_compliance`` reads (docs/elastic-disc.md)."""
        with new_file(Path(path)) as scratch, scratch.open("wb") as file:
            np.savez(
                file, format=FORMAT, key=self.key, lobes=self.lobes, per_lobe=self.per_lobe, matrix=self.matrix,
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
