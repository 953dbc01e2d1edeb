"""What a unit of every coordinate adds to gaps and bearing fits, once for all reducers (docs/tolerance.md, Eq. 57)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.contact.support import support_model
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.pattern import removal_between
from cycloid_profile.tolerance.scatter import Scatter, Tolerances

# Small against every bend of the curve, large against rounding: a share of the tolerance.
_STEP = 0.01


@dataclass(frozen=True)
class UnitChange:
    """The reducer before and after a small ``step`` of one coordinate."""

    before: Built
    after: Built
    step: float

    @property
    def play(self) -> float:
        """Bearing play per unit [mm]."""
        return (self.after.case.drive.support.bearing_play - self.before.case.drive.support.bearing_play) / self.step

    @property
    def series_compliance(self) -> float:
        """Series compliance per unit [rad/(N·mm)]."""
        return (self.after.series_compliance - self.before.series_compliance) / self.step

    @property
    def encoder(self) -> complex:
        """Encoder error per unit [rad]."""
        return (self.after.encoder - self.before.encoder) / self.step


@dataclass(frozen=True)
class GapPlace:
    """Contacts at which gaps change: one row a pose, ``foot``, ``lobe`` and ``normal`` shape (poses, discs, pins)."""

    foot: FloatArray
    lobe: FloatArray
    normal: ComplexArray
    crank_angle: FloatArray


def unit_changes(built: Built, tolerances: Tolerances) -> list[UnitChange]:
    """One change for every coordinate, in the order of ``Draws.coordinates``."""
    return [change for one in tolerances.scatters for change in _of_scatter(built, one)]


def _of_scatter(built: Built, scatter: Scatter) -> list[UnitChange]:
    size = scatter.axes.size
    step = _STEP * (1.0 / (size.tolerance or 1.0) if scatter.axes.inverse else (size.tolerance or 1.0))
    return [
        UnitChange(built, scatter.axes.effect(step * unit, choice).apply(built), step)
        for choice in scatter.choices
        for unit in np.eye(scatter.axes.count)
    ]


def gap_change(change: UnitChange, place: GapPlace) -> FloatArray | None:
    """What a unit adds to the gaps, shape (poses, discs, pins) [mm]; None where it adds nothing."""
    before, after = change.before, change.after
    found: FloatArray | None = None
    if after.teeth is not before.teeth:
        found = np.zeros(place.foot.shape)
        for j, (old, new) in enumerate(zip(before.teeth, after.teeth, strict=True)):
            if new is not old:
                found[:, j] = removal_between(old, new, place.foot[:, j], place.lobe[:, j])
    if after.pin_shift is not before.pin_shift:
        ring = (np.conj(place.normal) * (after.pin_shift - before.pin_shift)).real
        ring = ring - (after.pin_oversize - before.pin_oversize)
        found = ring if found is None else found + ring
    return None if found is None else found / change.step


def misfit_change(change: UnitChange, crank_angle: FloatArray) -> FloatArray | None:
    """What a unit adds to the stretch of the bearings at rest, shape (poses, bearings, 2) [mm]; None for nothing."""
    before, after = change.before, change.after
    names = ("eccentric_shift", "bore_shift", "crank_lead")
    if all(getattr(after, name) is getattr(before, name) for name in names):
        return None
    drive = before.case.drive
    misfits = [support_model(drive, crank_angle, built.parts).misfit for built in (before, after)]
    changed: FloatArray = (misfits[1] - misfits[0]) / change.step
    return changed


def rows(columns: list[FloatArray | None], size: int) -> Any:
    """Sparse matrix, shape (``size``, coordinates), whose columns are the changes flattened."""
    from scipy.sparse import csr_array

    places, values, numbers = [], [], []
    for j, column in enumerate(columns):
        if column is not None:
            flat = column.reshape(-1)
            (where,) = np.nonzero(flat)
            places.append(where)
            values.append(flat[where])
            numbers.append(np.full(where.size, j))
    if not places:
        return csr_array((size, len(columns)))
    return csr_array(
        (np.concatenate(values), (np.concatenate(places), np.concatenate(numbers))), shape=(size, len(columns))
    )
