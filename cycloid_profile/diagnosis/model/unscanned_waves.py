"""Waviness of a disc without a scan, from bench measurements over a revolution, through the loaded pins.

Each pin contacts the wave at a different place. The response of a row is C(n) = Σ w exp(i n t) over the loaded pins,
with w the response to a removal there (docs/theory.md, Eq. 50) and t the angle along the disc.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.diagnosis.data.noise import SCATTER_OF_ESTIMATE, sidak
from cycloid_profile.diagnosis.model._model_error import low_product_orders
from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.chatter_spectrum import (
    AS_GOOD,
    GENERATING,
    LEAST_WAVES,
    SHORTEST_WAVE,
    cosine_and_sine,
    off_lobes,
)
from cycloid_profile.diagnosis.model.whitened import Whitened, diagonal
from cycloid_profile.effects import chatter_angle
from cycloid_profile.measurement import PROFILE_SCAN

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_CELLS = 2**16  # of two revolutions of the disc
# Waves evaluated from the rows, number of them evaluated on a fine grid, and their least distance.
_PROPOSED, _LEADING, _APART = 12, 4, 2.0
# Waves about a peak of the grid of half waves: steps of a fifth, then of a fiftieth.
_ROUGHLY, _CLOSELY = np.arange(-2, 3) / 5.0, np.arange(-25, 26) / 50.0
_OFF_LOBES = 2.5  # waves next to those that ``off_lobes`` counts as tooth form: modulated once or twice a turn
_GAIN = 2.0  # of chi²: least gain for a change of the number of waves
_AT_ONCE = 2_000_000  # pairs of pins
# Least independence of cosine and sine; below it a wave has no power.
_ONE_OF_TWO = 0.1


@dataclass(frozen=True)
class Peak:
    """Number of ``waves`` on a ``disc``, counted from 1, None for all, even in the motion of constant ``speed``.

    ``power`` is the reduction of chi².

    ``p_value``: probability of a peak this high in noise, on any number of waves. ``over_accuracy``: largest root mean
    square it explains in any file, divided by the accuracy of the simulation.
    """

    waves: float
    disc: int | None
    speed: str
    power: float
    p_value: float
    over_accuracy: float


class UnscannedWaves:
    """Response of curves over a revolution to waves on one disc, counted from 1, or on all (None), after a free fit of
    ``members``.

    ``speed``: motion of constant speed, in which the waves are even.
    """

    def __init__(self, blocks: Sequence[Whitened], members: Sequence[Candidate], disc: int | None) -> None:
        self.blocks = [block for block in blocks if block.residuals.recording.kind.over_output_turn]
        self.disc = disc
        self._responses: dict[str, list[tuple[csr_array, FloatArray]]] = {}
        free = diagonal([np.hstack([block.nuisance[:, : block.known], _mesh(block)]) for block in self.blocks])
        # Errors of the model have prior widths: rows of their own hold them to zero.
        errors = diagonal([block.white(block.residuals.model_error) for block in self.blocks])
        self._held = errors.shape[1]
        named = np.concatenate([block.columns(members) for block in self.blocks])
        below = np.zeros((self._held, free.shape[1] + named.shape[1]))
        self._known = _basis(np.vstack([np.hstack([free, named, errors]), np.hstack([below, np.eye(self._held)])]))
        z = np.concatenate([*(block.z for block in self.blocks), np.zeros(self._held)])
        self.z: FloatArray = z - self._known @ (self._known.T @ z)

    @property
    def highest(self) -> float:
        """Largest number of waves tested: two rows for each wave, and no shorter than the contact resolves."""
        trochoid = self.blocks[0].residuals.reducer.case.drive.trochoid
        closest = min(float(np.median(np.diff(block.residuals.position))) for block in self.blocks)
        return min(2.0 * math.pi * trochoid.pin_circle_radius / SHORTEST_WAVE, math.pi / closest)

    @property
    def excess(self) -> float:
        """chi² above its number of rows, minus its scatter."""
        rows = int(self.z.size - self._held)
        return float(self.z @ self.z) - rows - 2.0 * math.sqrt((2.0 + SCATTER_OF_ESTIMATE) * rows)

    def strongest(self, speed: str = GENERATING) -> list[Peak]:
        """Wave with the largest power and waves with nearly the same, to a fiftieth, best first.

        Waves near multiples of the lobes are excluded as in ``off_lobes``.
        """
        grid, power = self._spectrum(speed)
        rough: list[tuple[float, float]] = []
        while len(rough) < _PROPOSED and np.any(power > 0.0):
            top = int(np.argmax(power))
            rough.append((float(np.max(self.power(grid[top] + _ROUGHLY, speed))), float(grid[top])))
            power[np.abs(grid - grid[top]) < _APART] = 0.0
        fine = sorted((self._near(waves, speed) for _, waves in sorted(rough, reverse=True)[:_LEADING]), reverse=True)
        return [self._peak(*one, speed, grid.size) for one in fine if one[0] > fine[0][0] - AS_GOOD]

    def _peak(self, power: float, waves: float, speed: str, looks: int) -> Peak:
        C = self._shown(np.array([waves]), speed)[:, 0]
        columns = np.stack([C.real, C.imag], axis=1)
        explained = columns @ np.linalg.lstsq(columns, self.z, rcond=None)[0]
        over, first = 0.0, 0
        for block in self.blocks:
            recording, rows = block.residuals.recording, block.z.size
            rms = recording.noise.sigma * float(np.sqrt(np.mean(explained[first : first + rows] ** 2)))
            over, first = max(over, rms / recording.accuracy), first + rows
        return Peak(waves, self.disc, speed, power, sidak(math.exp(-0.5 * power), looks), over)

    def near(self, waves: float, speed: str = GENERATING) -> float:
        """Strongest number of waves within half a wave of ``waves``, to a fiftieth; ``waves`` if the gain is small."""
        highest, best = self._near(waves, speed)
        return best if highest > float(self.power(np.array([waves]), speed)[0]) + _GAIN else waves

    def _near(self, waves: float, speed: str) -> tuple[float, float]:
        grid = waves + _CLOSELY
        power = self.power(grid, speed)
        top = int(np.argmax(power))
        return float(power[top]), float(grid[top])

    def power(self, grid: FloatArray, speed: str = GENERATING) -> FloatArray:
        """Reduction of chi² by cosine and sine of each number of waves of an evenly spaced ``grid``, in its shape."""
        C = self._shown(grid, speed)
        whole = np.sum(np.abs(C) ** 2, axis=0)
        C = C - self._known @ (self._known.T @ C)
        return _power(self.z @ C, np.sum(C * C, axis=0), np.sum(np.abs(C) ** 2, axis=0), whole)

    def _shown(self, grid: FloatArray, speed: str) -> ComplexArray:
        """Whitened C of the rows of all files for each number of waves, shape (rows, numbers)."""
        shown = []
        for block, (matrix, t) in zip(self.blocks, self._loaded_pin_response(speed), strict=True):
            waves = np.empty((t.size, grid.size), dtype=np.complex128)
            waves[:, 0] = np.exp(1j * grid[0] * t)
            if grid.size > 1:
                step = np.exp(1j * (grid[1] - grid[0]) * t)
                for k in range(1, grid.size):
                    waves[:, k] = waves[:, k - 1] * step
            shown.append(block.white(matrix @ waves))
        return np.concatenate([*shown, np.zeros((self._held, grid.size))])

    def _spectrum(self, speed: str) -> tuple[FloatArray, FloatArray]:
        """Approximate power in steps of half a wave: places rounded to cells, white noise, no other columns."""
        k = np.arange(2 * LEAST_WAVES, int(2.0 * self.highest) + 1)
        along, across, length = (np.zeros(k.size, dtype=np.complex128) for _ in range(3))
        first = 0
        for block, (matrix, t) in zip(self.blocks, self._loaded_pin_response(speed), strict=True):
            sigma = block.residuals.recording.noise.sigma
            rows = np.flatnonzero(block.chosen)
            z = np.zeros(block.chosen.size)
            z[rows] = self.z[first : first + rows.size] / sigma
            first += rows.size
            weights, places = _by_row(matrix[rows] / sigma, t)
            along += _waves(matrix.T @ z, t, k)
            for w, at in _row_batches(weights, places):
                both = w[:, :, np.newaxis] * w[:, np.newaxis]
                across += _waves(both, at[:, :, np.newaxis] + at[:, np.newaxis], k)
                length += _waves(both, at[:, :, np.newaxis] - at[:, np.newaxis], k)
        lobes = self.blocks[0].residuals.reducer.case.drive.trochoid.lobes
        grid = np.asarray(0.5 * k, dtype=np.float64)
        power = _power(along, across, length.real, length.real)
        return grid, np.where(off_lobes(grid, lobes, speed) > _OFF_LOBES, power, 0.0)

    def _loaded_pin_response(self, speed: str) -> list[tuple[csr_array, FloatArray]]:
        """For each file: response of its rows to removals at the loaded places [per mm], shape (rows, places), and
        their angles.

        Angles along the disc that run at constant ``speed`` [rad]; the root of lobe 1 is at zero.
        """
        if speed not in self._responses:
            found = []
            for block, (matrix, places) in zip(self.blocks, self._loaded_places, strict=True):
                teeth = block.residuals.reducer.teeth
                angles = [chatter_angle(speed, teeth[j], phase) + mounted for j, mounted, phase in places]
                found.append((matrix, np.concatenate(angles)))
            self._responses[speed] = found
        return self._responses[speed]

    @cached_property
    def _loaded_places(self) -> list[tuple[csr_array, list[tuple[int, float, FloatArray]]]]:
        """For each file: the same response, and number, mounting angle [rad] and generating phases of each disc."""
        from scipy.sparse import csr_array, hstack

        found = []
        for block in self.blocks:
            reducer = block.residuals.reducer
            trochoid = reducer.case.drive.trochoid
            discs = range(reducer.discs) if self.disc is None else [self.disc - 1]
            places, shown = [], []
            for j in discs:
                # Mounting angle of disc j against the first.
                mounted = 0.0 if self.disc is not None else 2.0 * math.pi * j / (reducer.discs * trochoid.lobes)
                for one in block.residuals.first_order.flank_weights(j):
                    # One revolution from the tip before lobe 1, where a non-integer number of waves has its step.
                    phase = np.mod(one.along + math.pi, trochoid.phase_period) - math.pi
                    places.append((j, mounted, phase))
                    at = (one.pose, np.arange(phase.size))
                    shown.append(csr_array((one.weight, at), shape=(one.poses, phase.size))[one.of])
            found.append((csr_array(hstack(shown)), places))
        return found


def unscanned(blocks: Sequence[Whitened]) -> list[int]:
    """Discs, counted from 1, that curves over a revolution cover but no scan; empty without such curves."""
    if not any(block.residuals.recording.kind.over_output_turn for block in blocks):
        return []
    scanned = {block.residuals.recording.disc for block in blocks if block.residuals.recording.kind is PROFILE_SCAN}
    return [j + 1 for j in range(blocks[0].residuals.reducer.discs) if j not in scanned]


def _mesh(block: Whitened) -> FloatArray:
    """Columns of the mesh order and its multiples: form of all lobes, loads and compliances."""
    trochoid = block.residuals.reducer.case.drive.trochoid
    angle = np.outer(block.residuals.position, low_product_orders(trochoid))
    return block.white(np.hstack([np.cos(angle), np.sin(angle)]))


def _basis(columns: FloatArray) -> FloatArray:
    """Orthonormal columns of the same span."""
    scale = np.linalg.norm(columns, axis=0)
    U, s, _ = np.linalg.svd(columns[:, scale > 0.0] / scale[scale > 0.0], full_matrices=False)
    basis: FloatArray = U[:, s > 1e-9 * s[0]] if s.size else U
    return basis


def _by_row(matrix: csr_array, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Weights and places of each row, padded with zero weights; shape (rows, most)."""
    counts = np.diff(matrix.indptr)
    most = int(np.max(counts, initial=0))
    inside = np.arange(most) < counts[:, np.newaxis]
    weights, places = np.zeros(inside.shape), np.zeros(inside.shape)
    weights[inside], places[inside] = matrix.data, t[matrix.indices]
    return weights, places


def _row_batches(weights: FloatArray, places: FloatArray) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Groups of rows small enough for all pairs of their pins."""
    parts = max(math.ceil(weights.size * weights.shape[1] / _AT_ONCE), 1)
    return zip(np.array_split(weights, parts), np.array_split(places, parts), strict=True)


def _waves(weight: FloatArray, t: FloatArray, k: np.ndarray) -> ComplexArray:
    """Σ weight·exp(i k t/2) for integers k, places rounded to cells."""
    cell = np.round(t.ravel() * (_CELLS / (4.0 * math.pi))).astype(np.intp) % _CELLS
    found: ComplexArray = np.conj(np.fft.rfft(np.bincount(cell, weights=weight.ravel(), minlength=_CELLS)))[k]
    return found


def _power(along: ComplexArray, across: ComplexArray, length: FloatArray, whole: FloatArray) -> FloatArray:
    """Reduction of chi² by cosine and sine together, from sums of z·C, of C² and of |C|².

    ``whole``: sum of |C|² before projection.
    """
    fall, det = cosine_and_sine(along, across, length)
    both = det > (0.5 * _ONE_OF_TWO * whole) ** 2
    power: FloatArray = np.where(both, fall, 0.0) / np.where(both, det, 1.0)
    return power
