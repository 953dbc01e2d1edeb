"""Sizes of all effects of a chunk of reducers, as linear coordinates, from random or low-discrepancy numbers.

A chunk depends only on the seed and its own number, not on the worker that draws it. Each Latin hypercube or Sobol net
fills one chunk. The chunks are independent, so their scatter estimates the sampling error.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.tolerance.inputs import Rayleigh, Scatter, Tolerances

_OWN, _BATCH = 0, 1
_LEAST_RANK = 2.0**-53


class Sequence(Protocol):
    """Distribution of the points of one chunk in the space of all normal numbers."""

    def normals(self, seed: int, chunk: int, count: int, dimensions: int) -> FloatArray:
        """Standard normal numbers of a chunk, shape (count, dimensions)."""
        ...


@dataclass(frozen=True, slots=True)
class Random:
    """Independent numbers."""

    def normals(self, seed: int, chunk: int, count: int, dimensions: int) -> FloatArray:
        return generator(seed, _OWN, chunk).standard_normal((count, dimensions))


@dataclass(frozen=True, slots=True)
class LatinHypercube:
    """Each coordinate stratified: reduces the variance of sums of many effects. McKay et al., Technometrics 21 (1979)
    239.
    """

    def normals(self, seed: int, chunk: int, count: int, dimensions: int) -> FloatArray:
        from scipy.stats import qmc

        return _ranked(qmc.LatinHypercube(dimensions, rng=generator(seed, _OWN, chunk)).random(count))


@dataclass(frozen=True, slots=True)
class Sobol:
    """Scrambled Sobol net: less variance for smooth functions of few effects. Owen, J. Complexity 14 (1998) 466."""

    def normals(self, seed: int, chunk: int, count: int, dimensions: int) -> FloatArray:
        from scipy.stats import qmc

        engine = qmc.Sobol(dimensions, rng=generator(seed, _OWN, chunk))
        return _ranked(engine.random_base2(max(count - 1, 0).bit_length()))[:count]


SEQUENCES: dict[str, Sequence] = {"random": Random(), "latin-hypercube": LatinHypercube(), "sobol": Sobol()}


def batch_normals(seed: int, batch: int, dimensions: int) -> FloatArray:
    """Standard normal numbers that all reducers of a batch share, shape (dimensions,)."""
    return generator(seed, _BATCH, batch).standard_normal(dimensions)


def generator(seed: int, purpose: int, number: int) -> np.random.Generator:
    """Independent random generator for each purpose and number."""
    return np.random.Generator(np.random.PCG64DXSM(np.random.SeedSequence(seed, spawn_key=(purpose, number))))


def _ranked(ranks: FloatArray) -> FloatArray:
    from scipy.special import ndtri

    return np.asarray(ndtri(np.clip(ranks, _LEAST_RANK, 1.0 - _LEAST_RANK)))


@dataclass(frozen=True)
class Draws:
    """Reproducible draws of ``tolerances``: ``seed``, ``sequence``, and ``batch_size`` reducers per batch."""

    tolerances: Tolerances
    seed: int = 1
    sequence: Sequence = field(default_factory=Random)
    batch_size: int = 100

    @cached_property
    def dimensions(self) -> int:
        """Number of standard normal numbers per reducer."""
        return int(self.normal_columns[-1])

    @cached_property
    def columns(self) -> IntArray:
        """First column of the coordinates of each scatter, and the end of the last, shape (scatters + 1,)."""
        return _offsets([len(one.choices) * one.axes.count for one in self.tolerances.scatters])

    @cached_property
    def normal_columns(self) -> IntArray:
        """First column of the normal numbers of each scatter, and the end of the last, shape (scatters + 1,)."""
        return _offsets([_normals(one) for one in self.tolerances.scatters])

    def coordinates(self, chunk: int, count: int, first: int) -> FloatArray:
        """Coordinates of the ``count`` reducers of a chunk, the first of which is reducer ``first``.

        Shape (count, coordinates): for each scatter, for each of its parts, for each of its axes; in the unit of the
        size.
        """
        return self.from_normals(self.normals(chunk, count, first))

    def normals(self, chunk: int, count: int, first: int) -> FloatArray:
        """Standard normal numbers with the component common to each batch, shape (count, dimensions)."""
        z = self.sequence.normals(self.seed, chunk, count, self.dimensions)
        shares = np.repeat([one.batch_share for one in self.tolerances.scatters], np.diff(self.normal_columns))
        if np.any(shares):
            batch = (first + np.arange(count)) // self.batch_size
            of, inverse = np.unique(batch, return_inverse=True)
            common = np.stack([batch_normals(self.seed, int(number), self.dimensions) for number in of])
            z = np.sqrt(1.0 - shares) * z + np.sqrt(shares) * common[inverse]
        return z

    def from_normals(self, z: FloatArray) -> FloatArray:
        """Coordinates from standard normal numbers, shape (count, dimensions) to (count, coordinates)."""
        scatters = self.tolerances.scatters
        sizes, angles = [], []
        for one, own in zip(scatters, np.split(z, self.normal_columns[1:-1], axis=1), strict=True):
            size, angle = np.split(own, [len(one.choices)], axis=1)
            sizes.append(size if one.neighbours == 0.0 else size @ _neighbour_correlation(one))
            both = one.neighbours != 0.0 and one.components
            angles.append(angle @ _neighbour_correlation(one) if both else angle)
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
    return scatter.axes.of(
        scatter.size.from_normal(z), 0.0 if scatter.angle_deg is None else scatter.angle_deg.from_normal(other)
    )


def _normals(scatter: Scatter) -> int:
    return len(scatter.choices) * (1 if scatter.angle_deg is None else 2)


def _offsets(counts: list[int]) -> IntArray:
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.intp)


def _neighbour_correlation(scatter: Scatter) -> FloatArray:
    """Matrix that correlates independent numbers within ``neighbours`` parts round the ring, variances kept."""
    ring = len({tuple(choice.values())[-1] for choice in scatter.choices})
    apart = np.arange(ring)
    apart = np.minimum(apart, ring - apart)
    row = np.exp(-apart / scatter.neighbours)
    # A circulant matrix: its root has the root of its spectrum.
    root = np.fft.irfft(np.sqrt(np.maximum(np.fft.rfft(row).real, 0.0)), ring)
    circulant = root[(np.arange(ring)[:, np.newaxis] - np.arange(ring)) % ring]
    return np.kron(np.eye(len(scatter.choices) // ring), circulant)
