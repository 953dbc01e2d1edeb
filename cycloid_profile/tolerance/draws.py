"""Sizes of all effects of a chunk of reducers, as linear coordinates."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.tolerance.distribution import Rayleigh
from cycloid_profile.tolerance.scatter import Scatter, Tolerances
from cycloid_profile.tolerance.sequence import Random, Sequence, batch_normals


@dataclass(frozen=True)
class Draws:
    """Reproducible draws of ``tolerances``: ``seed``, ``sequence``, and ``batch_size`` reducers to a batch."""

    tolerances: Tolerances
    seed: int = 1
    sequence: Sequence = field(default_factory=Random)
    batch_size: int = 100

    @cached_property
    def dimensions(self) -> int:
        """Number of standard normal numbers a reducer takes."""
        return int(sum(_normals(one) for one in self.tolerances.scatters))

    @cached_property
    def columns(self) -> IntArray:
        """Where the coordinates of each scatter begin, and where the last end, shape (scatters + 1,)."""
        counts = [len(one.choices) * one.axes.count for one in self.tolerances.scatters]
        return np.concatenate([[0], np.cumsum(counts)]).astype(np.intp)

    def coordinates(self, chunk: int, count: int, first: int) -> FloatArray:
        """Coordinates of the ``count`` reducers of a chunk, the first of which is reducer ``first``.

        Shape (count, coordinates): for each scatter, for each of its parts, for each of its axes; in the unit of the
        size.
        """
        return self.from_normals(self.normals(chunk, count, first))

    def normals(self, chunk: int, count: int, first: int) -> FloatArray:
        """Standard normal numbers with what batches have in common, shape (count, dimensions)."""
        z = self.sequence.normals(self.seed, chunk, count, self.dimensions)
        shares = np.repeat(
            [one.batch_share for one in self.tolerances.scatters], [_normals(one) for one in self.tolerances.scatters]
        )
        if np.any(shares):
            batch = (first + np.arange(count)) // self.batch_size
            of, inverse = np.unique(batch, return_inverse=True)
            common = np.stack([batch_normals(self.seed, int(number), self.dimensions) for number in of])
            z = np.sqrt(1.0 - shares) * z + np.sqrt(shares) * common[inverse]
        return z

    def from_normals(self, z: FloatArray) -> FloatArray:
        """Coordinates from standard normal numbers, shape (count, dimensions) to (count, coordinates)."""
        scatters = self.tolerances.scatters
        sizes, angles, at = [], [], 0
        for one in scatters:
            parts = len(one.choices)
            own = z[:, at : at + parts]
            sizes.append(own if one.neighbours == 0.0 else own @ _neighbourly(one))
            other = z[:, at + parts : at + _normals(one)]
            angles.append(other if one.neighbours == 0.0 or not one.components else other @ _neighbourly(one))
            at += _normals(one)
        mixed = self._correlated(sizes)
        found = np.empty((len(z), int(self.columns[-1])))
        for j, one in enumerate(scatters):
            found[:, self.columns[j] : self.columns[j + 1]] = _placed(one, mixed[j], angles[j]).reshape(len(z), -1)
        return found

    def _correlated(self, sizes: list[FloatArray]) -> list[FloatArray]:
        if not self.tolerances.correlations:
            return sizes
        matrix = np.eye(len(sizes))
        for one in self.tolerances.correlations:
            matrix[one.first, one.second] = matrix[one.second, one.first] = one.value
        lower = np.linalg.cholesky(matrix)
        return [
            sum((lower[j, k] * sizes[k] for k in range(j) if lower[j, k]), lower[j, j] * sizes[j])
            for j in range(len(sizes))
        ]


def _placed(scatter: Scatter, z: FloatArray, other: FloatArray) -> FloatArray:
    """Coordinates of one scatter, shape (count, parts, axes)."""
    if scatter.components:
        assert isinstance(scatter.size, Rayleigh)
        return scatter.size.sigma * np.stack([z, other], axis=-1)
    return scatter.axes.of(scatter.size.of(z), 0.0 if scatter.angle_deg is None else scatter.angle_deg.of(other))


def _normals(scatter: Scatter) -> int:
    return len(scatter.choices) * (1 if scatter.angle_deg is None else 2)


def _neighbourly(scatter: Scatter) -> FloatArray:
    """Matrix that makes independent numbers alike within ``neighbours`` parts round the ring, variances kept."""
    ring = len({tuple(choice.values())[-1] for choice in scatter.choices})
    apart = np.arange(ring)
    apart = np.minimum(apart, ring - apart)
    row = np.exp(-apart / scatter.neighbours)
    # A circulant matrix: its root has the root of its spectrum.
    root = np.fft.irfft(np.sqrt(np.maximum(np.fft.rfft(row).real, 0.0)), ring)
    circulant = root[(np.arange(ring)[:, np.newaxis] - np.arange(ring)) % ring]
    return np.kron(np.eye(len(scatter.choices) // ring), circulant)
