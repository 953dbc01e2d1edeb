"""Free space of the sheet: cells taken by strokes, texts and views, and the nearest free place for a label."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cycloid_profile.arrays import ComplexArray, FloatArray

A3 = (420.0, 297.0)
_CELL = 0.5  # mm
_STEP = 2.0  # mm between places that are tried
_REACH = 150.0  # mm from the tip of a leader
_MARGIN = 1.6  # mm, clear round a label
_LANDING = 2.5  # mm, horizontal end of a leader
_SHORTEST = 6.0  # mm of a leader, twice its arrow
_CROSSING = 6.0  # mm of a longer leader, for each cell of a stroke that it crosses
_TRIED = 600  # nearest free places whose leaders are compared
_AT_TIP = 1.5  # mm at the tip, where a leader meets its own feature
_FRAME = (20.0, 10.0, A3[0] - 10.0, A3[1] - 10.0)

_Cells = NDArray[np.bool_]


def _cells() -> _Cells:
    return np.zeros((int(A3[0] / _CELL), int(A3[1] / _CELL)), dtype=np.bool_)


@dataclass(frozen=True, slots=True)
class Space:
    """Cells of the sheet that hold ``strokes``, ``texts`` that no leader may cross, or ``views``."""

    strokes: _Cells = field(default_factory=_cells)
    texts: _Cells = field(default_factory=_cells)
    views: _Cells = field(default_factory=_cells)

    def stroke(self, points: Sequence[complex]) -> None:
        """Take the cells along a polyline."""
        self.strokes[_indices(_along(np.asarray(points, dtype=np.complex128)))] = True

    def text(self, corner: complex, size: complex) -> None:
        """Take a rectangle that nothing may cross."""
        self._fill(self.texts, corner, size)

    def leader(self, path: Sequence[complex]) -> None:
        """Take the cells along a leader, which no other leader may cross."""
        self.texts[_indices(_along(np.asarray(path, dtype=np.complex128)))] = True

    def view(self, corner: complex, size: complex) -> None:
        """Take a rectangle that leaders may cross."""
        self._fill(self.views, corner, size)

    def round_view(self, centre: complex, radius: float) -> None:
        """Take a disc that leaders may cross."""
        x, y = np.indices(self.views.shape) * _CELL
        self.views[np.hypot(x - centre.real, y - centre.imag) <= radius] = True

    @staticmethod
    def _fill(cells: _Cells, corner: complex, size: complex) -> None:
        (x0, x1), (y0, y1) = _indices(np.array([corner, corner + size]))
        cells[x0 : x1 + 1, y0 : y1 + 1] = True

    def free(self, corners: ComplexArray, size: complex, margin: float = _MARGIN) -> _Cells:
        """Whether rectangles are in the frame and hold nothing, shape of ``corners``."""
        sums = np.zeros((self.strokes.shape[0] + 1, self.strokes.shape[1] + 1), dtype=np.int64)
        sums[1:, 1:] = (self.strokes | self.texts | self.views).cumsum(axis=0, dtype=np.int64).cumsum(axis=1)
        around = complex(margin, margin)
        low, high = corners - around, corners + size + around
        left, bottom, right, top = _FRAME
        inside = (low.real >= left) & (low.imag >= bottom) & (high.real <= right) & (high.imag <= top)
        (x0, y0), (x1, y1) = _indices(low), _indices(high)
        x1, y1 = x1 + 1, y1 + 1
        return np.asarray(inside & (sums[x1, y1] - sums[x0, y1] - sums[x1, y0] + sums[x0, y0] == 0))

    def crossed(self, path: Sequence[complex]) -> float:
        """Number of cells of strokes along a path, infinite where it crosses a text."""
        points = np.asarray(path, dtype=np.complex128)
        along = _along(points)
        cells = _indices(along[np.abs(along - points[0]) > _AT_TIP])
        return np.inf if bool(np.any(self.texts[cells])) else float(np.count_nonzero(self.strokes[cells]))

    def place(self, tip: complex, size: complex, level: float) -> tuple[complex, list[complex]] | None:
        """Lower left corner of the best free rectangle for a label, and its leader from the tip.

        The leader ends at the left or right side, ``level`` above the corner. None where the sheet is full.
        """
        x, y = np.meshgrid(np.arange(-_REACH, _REACH, _STEP), np.arange(-_REACH, _REACH, _STEP), indexing="ij")
        corners = (tip + x + 1j * y).ravel()
        corners = corners[self.free(corners, size)]
        ends = np.stack([corners - 1.0, corners + size.real + 1.0]) + 1j * level
        distance = np.abs(ends - tip)
        order = np.argsort(np.round(np.min(distance, axis=0), 6), kind="stable")[:_TRIED]
        best: tuple[float, complex, list[complex]] | None = None
        for i in order:
            if best is not None and np.min(distance[:, i]) - _LANDING >= best[0]:
                break
            for side in (0, 1):
                end = complex(ends[side, i])
                knee = end + (-_LANDING if side == 0 else _LANDING)
                # From outside, so that the leader does not pass through its own label.
                if (knee.real - tip.real) * (1 if side == 0 else -1) < 0.0 or abs(knee - tip) < _SHORTEST:
                    continue
                path = [tip, knee, end]
                cost = round(abs(knee - tip) + _CROSSING * self.crossed(path), 6)
                if cost < (np.inf if best is None else best[0]):
                    best = cost, complex(corners[i]), path
        return None if best is None else (best[1], best[2])


def _indices(points: ComplexArray) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Cells of points, those outside the sheet moved to its edge."""
    cells = [np.floor(part / _CELL + 1e-9).astype(np.int64) for part in (points.real, points.imag)]
    return np.clip(cells[0], 0, int(A3[0] / _CELL) - 1), np.clip(cells[1], 0, int(A3[1] / _CELL) - 1)


def _along(points: ComplexArray) -> ComplexArray:
    """Points of a polyline at half a cell or closer."""
    lengths: FloatArray = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(points)))])
    if len(points) < 2 or lengths[-1] == 0.0:
        return points
    at = np.linspace(0.0, lengths[-1], int(np.ceil(lengths[-1] / (0.5 * _CELL))) + 1)
    return np.asarray(np.interp(at, lengths, points.real) + 1j * np.interp(at, lengths, points.imag))
