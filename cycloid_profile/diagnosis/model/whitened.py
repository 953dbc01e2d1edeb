"""Normal equations of whitened recordings, nuisances marginalised (docs/theory.md, Eq. 52)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray
from cycloid_profile.diagnosis.data.noise import Values
from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.residuals import Residuals

_NONE = np.zeros(0)


class Whitened:
    """Fitted rows of one recording in units of independent noise.

    ``z``: shape (rows,). ``nuisance``: shape (rows, n), unit normal priors: datum, zero and drift, then the errors of
    the model, which include those of the ``members`` at coordinates ``u``. ``chosen``: mask over the rows of the
    recording. ``log_det``: ln|1 + AᵀA| of the nuisances.
    """

    def __init__(
        self, residuals: Residuals, held_out: bool = False, members: Sequence[Candidate] = (), u: FloatArray = _NONE
    ) -> None:
        recording = residuals.recording
        self.residuals = residuals
        self.chosen: BoolArray = (recording.held_out == held_out) & np.isfinite(residuals.residual)
        self.starts = recording.starts(self.chosen)
        self.z = self._white(residuals.residual)
        # Datum, zero and drift come first, then the errors of the model.
        self.known = residuals.nuisance.shape[1]
        every = [residuals.nuisance, residuals.model_error, residuals.row_error]
        if members:
            every.append(residuals.form_error(members, u))
        self.nuisance = self._white(np.hstack(every))
        gram = np.eye(self.nuisance.shape[1]) + self.nuisance.T @ self.nuisance
        # Widths differ by many powers of ten: scaled to a unit diagonal, the matrix is regular.
        scale = np.sqrt(np.diag(gram))
        scaled = gram / np.outer(scale, scale)
        self._gram_inverse = np.linalg.inv(scaled) / np.outer(scale, scale)
        self.log_det = float(np.linalg.slogdet(scaled)[1] + 2.0 * np.sum(np.log(scale)))

    def columns(self, candidates: Sequence[Candidate]) -> FloatArray:
        """Columns of all coordinates per prior width, two for each candidate; the second is zero for one coordinate."""
        columns = self.residuals.columns(candidates)
        return self._white(columns.reshape(len(columns), -1))

    def white(self, values: Values) -> Values:
        """Whitened values of the chosen rows, from values of all rows."""
        return self._white(values)

    def product(self, left: FloatArray, right: FloatArray) -> FloatArray:
        """leftᵀ M right, nuisances marginalised."""
        inner: FloatArray = left.T @ right - (left.T @ self.nuisance) @ self._gram_inverse @ (self.nuisance.T @ right)
        return inner

    def projected(self, values: FloatArray) -> FloatArray:
        """M values: residual after a fit of the nuisances against their priors."""
        left: FloatArray = values - self.nuisance @ (self._gram_inverse @ (self.nuisance.T @ values))
        return left

    @property
    def chi2(self) -> float:
        """zᵀ M z."""
        return float(self.product(self.z, self.z))

    def _white(self, values: Values) -> Values:
        return self.residuals.recording.noise.whiten(values[self.chosen], self.starts)


@dataclass(frozen=True, eq=False)
class FileEquations:
    """Contribution of one recording: matrix ``R`` over ``rows`` with standard deviation ``sigma``.

    ``accuracy``: accuracy of the simulation in the unit of ``sigma``.
    """

    R: FloatArray
    rows: int
    sigma: float
    accuracy: float

    def contribution(self, members: Sequence[int], u: FloatArray, of: int) -> float:
        """Root mean square explained by member number ``of`` alone, divided by the accuracy of the simulation."""
        own = coordinates([members[of]])
        others = coordinates([m for i, m in enumerate(members) if i != of])
        R = self.R[np.ix_(own, own)]
        if others.size:
            cross = self.R[np.ix_(own, others)]
            R = R - cross @ np.linalg.pinv(self.R[np.ix_(others, others)], rcond=1e-9) @ cross.T
        own_u = u[2 * of : 2 * of + 2]
        return self.over_accuracy(float(own_u @ R @ own_u))

    def over_accuracy(self, fall: float) -> float:
        """Root mean square of a reduction of chi², divided by the accuracy of the simulation."""
        return float(np.sqrt(max(fall, 0.0) / max(self.rows, 1))) * self.sigma / self.accuracy


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """Normal equations of ``candidates``, two coordinates each, in units of their prior widths.

    ``b``: shape (2n,); ``R``: shape (2n, 2n); ``chi2`` without effects over ``rows`` rows; ``parts``: one for each
    recording.
    """

    candidates: tuple[Candidate, ...]
    b: FloatArray
    R: FloatArray
    chi2: float
    rows: int
    parts: tuple[FileEquations, ...]

    def about(self, members: Sequence[int], u: FloatArray) -> NormalEquations:
        """Equations linearised at coordinates ``u`` of ``members``, referred to zero."""
        where = coordinates(members)
        grown = float(2.0 * u @ self.b[where] + u @ self.R[np.ix_(where, where)] @ u)
        return replace(self, b=self.b + self.R[:, where] @ u, chi2=self.chi2 + grown)

    def plus(self, more: NormalEquations) -> NormalEquations:
        """Sum with the equations of other recordings and the same candidates."""
        return NormalEquations(
            self.candidates, self.b + more.b, self.R + more.R, self.chi2 + more.chi2, self.rows + more.rows,
            (*self.parts, *more.parts),
        )  # fmt: skip

    def contribution(self, members: Sequence[int], u: FloatArray, of: int) -> float:
        """Largest contribution of member number ``of`` in any recording, divided by the accuracy of the simulation."""
        return max(part.contribution(members, u, of) for part in self.parts)


def normal_equations(blocks: Sequence[Whitened], candidates: Sequence[Candidate]) -> NormalEquations:
    """Sum of the equations of all recordings."""
    size = 2 * len(candidates)
    b, R = np.zeros(size), np.zeros((size, size))
    parts = []
    for block in blocks:
        G = block.columns(candidates)
        b += block.product(G, block.z)
        own = block.product(G, G)
        R += own
        recording = block.residuals.recording
        parts.append(FileEquations(own, block.z.size, recording.noise.sigma, recording.accuracy))
    chi2, rows = sum(block.chi2 for block in blocks), sum(block.z.size for block in blocks)
    return NormalEquations(tuple(candidates), b, R, chi2, rows, tuple(parts))


def coordinates(members: Sequence[int]) -> np.ndarray:
    """Indices of the coordinates of ``members``."""
    return np.array([2 * i + c for i in members for c in range(2)], dtype=np.intp)
