"""Columns of smooth curves: hat functions, waves, and any smooth form of the lobes of a disc; their amounts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray, IntArray
from cycloid_profile.geometry import EqualArc, ToothProfile

CORNER_MULTIPLES = 50  # of lobes and of pins: a corner is as narrow as the load on a tooth that just touches
_PER_LOBE = 24  # knots of the form of a lobe: four waves a lobe


def hat_functions(x: FloatArray, count: int, periodic: bool = False) -> FloatArray:
    """Linear interpolation between ``count`` knots at 0, 1, …; shape (rows, count)."""
    left = np.floor(x).astype(np.intp) if periodic else np.clip(np.floor(x).astype(np.intp), 0, count - 2)
    share = x - left
    found = np.zeros((x.size, count))
    rows = np.arange(x.size)
    found[rows, left % count] += 1.0 - share
    found[rows, (left + 1) % count] += share
    return found


def waves(angles: Sequence[FloatArray]) -> FloatArray:
    """Cosine and sine of each of ``angles``, shape (rows, 2·angles)."""
    found = [wave for angle in angles for wave in (np.cos(angle), np.sin(angle))]
    return np.stack(found, axis=1)


def distinct_waves(wave: ComplexArray, digits: int = 9) -> IntArray:
    """Columns that differ from all before them: rows at equal distances show some orders as others."""
    found: IntArray = np.sort(np.unique(np.round(wave.real, digits), axis=1, return_index=True)[1])
    return found


def fitted_amounts(columns: FloatArray, values: FloatArray) -> FloatArray:
    """Least-squares amounts of columns; of many rows and few columns, normal equations are faster."""
    return np.asarray(np.linalg.lstsq(columns.T @ columns, columns.T @ values, rcond=1e-9)[0])


def forms_of_scan(profile: ToothProfile, position: FloatArray, lobe: FloatArray, phase: FloatArray) -> FloatArray:
    """Columns of size 1: a form over the ``phase`` of the lobe that varies slowly round the disc; offsets of the lobes.

    ``position``: phase along the whole disc [rad]. Shape (rows, columns).
    """
    # Equal arcs, as machines measure: the phase runs slowly where a form may be steep.
    knots = np.sort(np.mod(EqualArc(_PER_LOBE).phases(profile), 2.0 * np.pi))
    past = np.mod(phase - knots[0], 2.0 * np.pi)
    along = np.interp(past, [*(knots - knots[0]), 2.0 * np.pi], np.arange(_PER_LOBE + 1.0))
    form = hat_functions(along, _PER_LOBE, periodic=True)
    turn = position / profile.trochoid.lobes
    slow = np.hstack([np.ones((turn.size, 1)), waves([turn, 2.0 * turn])])
    offsets = lobe[:, np.newaxis] == np.arange(profile.trochoid.lobes)
    return np.hstack([(form[:, :, np.newaxis] * slow[:, np.newaxis]).reshape(turn.size, -1), offsets])
