"""Standard normal numbers for a chunk of reducers: random, Latin hypercube or scrambled Sobol.

A chunk depends on the seed and its own number alone, so that it does not matter who draws it, or when. Hypercubes and
nets fill one chunk each and are independent of each other: the scatter between chunks is an honest error.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from cycloid_profile.arrays import FloatArray

_OWN, _BATCH = 0, 1
_LEAST_RANK = 2.0**-53


class Sequence(Protocol):
    """How the points of one chunk lie in the space of all normal numbers."""

    def normals(self, seed: int, chunk: int, count: int, dimensions: int) -> FloatArray:
        """Standard normal numbers of a chunk, shape (count, dimensions)."""
        ...


@dataclass(frozen=True, slots=True)
class Random:
    """Independent numbers."""

    def normals(self, seed: int, chunk: int, count: int, dimensions: int) -> FloatArray:
        """See ``Sequence.normals``."""
        return generator(seed, _OWN, chunk).standard_normal((count, dimensions))


@dataclass(frozen=True, slots=True)
class LatinHypercube:
    """Each number alone evenly spread: mends sums of many effects. McKay et al., Technometrics 21 (1979) 239."""

    def normals(self, seed: int, chunk: int, count: int, dimensions: int) -> FloatArray:
        """See ``Sequence.normals``."""
        from scipy.stats import qmc

        return _ranked(qmc.LatinHypercube(dimensions, rng=generator(seed, _OWN, chunk)).random(count))


@dataclass(frozen=True, slots=True)
class Sobol:
    """Scrambled Sobol net: mends smooth answers of few effects. Owen, J. Complexity 14 (1998) 466."""

    def normals(self, seed: int, chunk: int, count: int, dimensions: int) -> FloatArray:
        """See ``Sequence.normals``; a net has a power of two points, a shorter chunk is its beginning."""
        from scipy.stats import qmc

        engine = qmc.Sobol(dimensions, rng=generator(seed, _OWN, chunk))
        return _ranked(engine.random_base2(max(count - 1, 0).bit_length()))[:count]


SEQUENCES: dict[str, Sequence] = {"random": Random(), "latin-hypercube": LatinHypercube(), "sobol": Sobol()}


def batch_normals(seed: int, batch: int, dimensions: int) -> FloatArray:
    """Standard normal numbers that all reducers of a batch share, shape (dimensions,)."""
    return generator(seed, _BATCH, batch).standard_normal(dimensions)


def generator(seed: int, purpose: int, number: int) -> np.random.Generator:
    """A stream of its own for each purpose and number."""
    return np.random.Generator(np.random.PCG64DXSM(np.random.SeedSequence(seed, spawn_key=(purpose, number))))


def _ranked(ranks: FloatArray) -> FloatArray:
    from scipy.special import ndtri

    z: FloatArray = ndtri(np.clip(ranks, _LEAST_RANK, 1.0 - _LEAST_RANK))
    return z
