"""Compliance of all discs of a stage at its poses, and how far flanks and bearing holes give way under the forces.

docs/theory.md, Eqs. 81, 82.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from functools import partial
from threading import Lock

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.bodies.elastic_disc.compliance import DiscCompliance
from cycloid_profile.contact.mesh import Meshing, mesh
from cycloid_profile.geometry import Trochoid

_KEPT_BYTES = 1e9  # of compliances kept: those of a bench of 3,000 rows with two discs of 60 pins take half


def stage_compliance(discs: tuple[DiscCompliance, ...], meshing: Meshing) -> FloatArray:
    """Compliance between all forces on the discs of a stage, shape (poses, forces, forces) [mm/N].

    Forces of the pins, disc by disc, then both components of each bearing in the housing frame. Without ``discs``, of
    rigid discs, there are no forces. An array that ``kept_compliance`` keeps is returned itself: do not write into it.
    """
    from cycloid_profile.contact.bodies.elastic_disc._kernels import fill_compliances

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

    Of all bearings and of the pins that carry a force, zero at the others. Order of the forces as in
    ``stage_compliance``.
    """
    from cycloid_profile.compiled import on_all_cores
    from cycloid_profile.contact.bodies.elastic_disc._kernels import fill_displacements

    found = np.zeros_like(load)
    on_all_cores(partial(fill_displacements, *_compiled(discs), *_places(discs, meshing), load, found), len(load))
    return found


def _compiled(discs: tuple[DiscCompliance, ...]) -> tuple[FloatArray, FloatArray]:
    """Matrices and own compliances of all discs, shape (discs, …), for the compiled kernels."""
    return np.stack([one.matrix for one in discs]), np.stack([one.own for one in discs])


def _places(discs: tuple[DiscCompliance, ...], meshing: Meshing) -> tuple[FloatArray, FloatArray]:
    """Place of each pin on its disc in flank points, shape (poses, discs, pins), and orientation of each disc in the
    housing, shape (poses, discs) [rad].
    """
    along = discs[0].per_lobe * (meshing.phase / (2.0 * math.pi) + meshing.lobe)
    return along, -meshing.crank_angle / meshing.trochoid.lobes
