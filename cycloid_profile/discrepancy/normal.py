"""Whitened normal equations of recordings and hypotheses, nuisances marginalised (docs/theory.md, Eq. 52)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray
from cycloid_profile.discrepancy.candidates import Candidate
from cycloid_profile.discrepancy.laid import Laid
from cycloid_profile.discrepancy.noise import Values


class Whitened:
    """The rows of one recording that are fitted, in units of independent noise.

    ``z`` shape (rows,), ``nuisance`` shape (rows, n), with unit normal priors; ``chosen`` the rows of the recording.
    """

    def __init__(self, laid: Laid, held_out: bool = False) -> None:
        recording = laid.recording
        self.laid = laid
        self.chosen: BoolArray = (recording.held_out == held_out) & np.isfinite(laid.residual)
        self.starts = recording.starts(self.chosen)
        self.z = self._white(laid.residual)
        self.nuisance = self._white(laid.nuisance)
        gram = np.eye(self.nuisance.shape[1]) + self.nuisance.T @ self.nuisance
        self._gram_inverse = np.linalg.inv(gram)

    def columns(self, candidates: Sequence[Candidate]) -> FloatArray:
        """Columns of all coordinates per width of each, two a candidate (the second zero where it has one)."""
        columns = self.laid.columns(candidates)
        return self._white(columns.reshape(len(columns), -1))

    def white(self, values: Values) -> Values:
        """Whitened values of all rows, of the chosen rows."""
        return self._white(values)

    def product(self, left: FloatArray, right: FloatArray) -> FloatArray:
        """leftᵀ M right with what no measurement can know marginalised."""
        inner: FloatArray = left.T @ right - (left.T @ self.nuisance) @ self._gram_inverse @ (self.nuisance.T @ right)
        return inner

    def projected(self, values: FloatArray) -> FloatArray:
        """M values: what is left once the nuisances are fitted against their priors."""
        left: FloatArray = values - self.nuisance @ (self._gram_inverse @ (self.nuisance.T @ values))
        return left

    @property
    def chi2(self) -> float:
        """zᵀ M z."""
        return float(self.product(self.z, self.z))

    def _white(self, values: Values) -> Values:
        return self.laid.recording.noise.whiten(values[self.chosen], self.starts)


@dataclass(frozen=True, eq=False)
class Part:
    """What one recording adds to the equations: ``R``, over ``rows`` of standard deviation ``sigma``.

    ``accuracy`` of the simulation in the same unit as ``sigma``.
    """

    R: FloatArray
    rows: int
    sigma: float
    accuracy: float

    def contribution(self, members: Sequence[int], u: FloatArray, of: int) -> float:
        """Root mean square of what member ``of`` (its place among them) alone explains, over the accuracy."""
        own = coordinates([members[of]])
        others = coordinates([m for i, m in enumerate(members) if i != of])
        R = self.R[np.ix_(own, own)]
        if others.size:
            cross = self.R[np.ix_(own, others)]
            R = R - cross @ np.linalg.pinv(self.R[np.ix_(others, others)], rcond=1e-9) @ cross.T
        own_u = u[2 * of : 2 * of + 2]
        return self.over_accuracy(float(own_u @ R @ own_u))

    def over_accuracy(self, fall: float) -> float:
        """Root mean square that a fall of chi² explains, over the accuracy of the simulation."""
        return float(np.sqrt(max(fall, 0.0) / max(self.rows, 1))) * self.sigma / self.accuracy


@dataclass(frozen=True, eq=False)
class Normal:
    """Normal equations of ``candidates``, two coordinates each in units of their widths.

    ``b`` shape (2n,), ``R`` shape (2n, 2n); ``chi2`` of no effect at all and ``rows`` behind it; ``parts`` a recording.
    """

    candidates: tuple[Candidate, ...]
    b: FloatArray
    R: FloatArray
    chi2: float
    rows: int
    parts: tuple[Part, ...]

    def about(self, members: Sequence[int], u: FloatArray) -> Normal:
        """The equations taken at coordinates ``u`` of ``members``, told from zero."""
        where = coordinates(members)
        grown = float(2.0 * u @ self.b[where] + u @ self.R[np.ix_(where, where)] @ u)
        return replace(self, b=self.b + self.R[:, where] @ u, chi2=self.chi2 + grown)

    def plus(self, more: Normal) -> Normal:
        """The equations of these recordings and of ``more``, of the same candidates."""
        return Normal(
            self.candidates, self.b + more.b, self.R + more.R, self.chi2 + more.chi2, self.rows + more.rows,
            (*self.parts, *more.parts),
        )  # fmt: skip

    def contribution(self, members: Sequence[int], u: FloatArray, of: int) -> float:
        """The largest of what member ``of`` alone explains in any recording, over the accuracy of the simulation."""
        return max(part.contribution(members, u, of) for part in self.parts)


def normal(blocks: Sequence[Whitened], candidates: Sequence[Candidate]) -> Normal:
    """Sum of the equations of all recordings."""
    size = 2 * len(candidates)
    b, R = np.zeros(size), np.zeros((size, size))
    parts = []
    for block in blocks:
        G = block.columns(candidates)
        b += block.product(G, block.z)
        own = block.product(G, G)
        R += own
        recording = block.laid.recording
        parts.append(Part(own, block.z.size, recording.noise.sigma, recording.accuracy))
    chi2, rows = sum(block.chi2 for block in blocks), sum(block.z.size for block in blocks)
    return Normal(tuple(candidates), b, R, chi2, rows, tuple(parts))


def coordinates(members: Sequence[int]) -> np.ndarray:
    """Places of the coordinates of ``members``."""
    return np.array([2 * i + c for i in members for c in range(2)], dtype=np.intp)
