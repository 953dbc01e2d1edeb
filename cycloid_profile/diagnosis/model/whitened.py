"""Normal equations of whitened recordings, nuisances marginalised (docs/theory.md, Eq. 52)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, cast

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray
from cycloid_profile.diagnosis.data.noise import Values
from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.residuals import Residuals

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_NONE = np.zeros(0)


def files_together(residuals: Sequence[Residuals]) -> list[tuple[Residuals, ...]]:
    """The files that share an error of the model: each alone, or the two of a pair, the earlier one first."""
    found: dict[int, tuple[Residuals, ...]] = {}
    for number, one in enumerate(residuals):
        # Files without a counterpart get numbers that no pair has.
        key = -1 - number if one.recording.pair is None else one.recording.pair
        found[key] = (*found.get(key, ()), one)
    return list(found.values())


class Whitened:
    """Fitted rows of one recording, or of a pair, in units of independent noise.

    ``z``: shape (rows,). ``nuisance``: shape (rows, n), unit normal priors: datum, zero and drift, then the errors of
    the model, which include those of the ``members`` at coordinates ``u``. ``chosen``: mask over all rows.
    ``log_det``: ln|1 + AᵀA| of the nuisances. ``residuals``: of the recording, the later one of a pair.
    """

    def __init__(
        self,
        *files: Residuals,
        held_out: bool = False,
        members: Sequence[Candidate] = (),
        u: FloatArray = _NONE,
    ) -> None:
        self._files = [_Rows(one, held_out) for one in files]
        self.residuals = files[-1]
        self.chosen: BoolArray = np.concatenate([one.chosen for one in self._files])
        self.z = np.concatenate([one.white(one.residuals.residual) for one in self._files])
        # Datum, zero and drift come first, then the errors of the model.
        self.known = sum(one.nuisance.shape[1] for one in files)
        known = diagonal([one.white(one.residuals.nuisance) for one in self._files])
        self.nuisance = np.hstack([known, *self._model_errors(members, u)])
        # Nuisances may be nearly parallel and far larger than the noise: normal equations would lose their digits.
        count = self.nuisance.shape[1]
        orthogonal, triangle = np.linalg.qr(np.vstack([self.nuisance, np.eye(count)]))
        self._span: FloatArray = orthogonal[: self.z.size]
        self.log_det = 2.0 * float(np.sum(np.log(np.abs(np.diag(triangle)))))

    def _model_errors(self, members: Sequence[Candidate], u: FloatArray) -> list[FloatArray]:
        """Errors of the model: two files of a pair share all but those of single rows."""
        files = self._files
        shared = [[one.residuals.model_error for one in files]]
        for k, member in enumerate(members):
            shared += [[one.residuals.form_error([member], u[2 * k : 2 * k + 2]) for one in files]]
        if len(files) == 1:
            shared += [[one.residuals.path_error for one in files]]
        else:
            peak = max(one.residuals.recording.peak_torque_nm for one in files)
            shared += [[one.residuals.branch_error(peak) for one in files]]
            shared += [[one.residuals.branch_error(peak, members, u) for one in files]]
            shared += [[one.residuals.unnamed_error for one in files]]
        rows = diagonal([one.white(one.residuals.row_error) for one in files])
        white = [[one.white(columns) for one, columns in zip(files, some, strict=True)] for some in shared]
        return [rows, *(_stacked(some) for some in white)]

    def columns(self, candidates: Sequence[Candidate]) -> FloatArray:
        """Columns of all coordinates per prior width, two for each candidate; the second is zero for one coordinate."""
        n = 2 * len(candidates)
        return np.concatenate(
            [one.white(one.residuals.columns(candidates).reshape(one.chosen.size, n)) for one in self._files]
        )

    def white(self, values: Values) -> Values:
        """Whitened values of the chosen rows, from values of all rows."""
        ends = np.cumsum([one.chosen.size for one in self._files])[:-1]
        each = zip(self._files, np.split(values, ends), strict=True)
        return cast("Values", np.concatenate([one.white(some) for one, some in each]))

    @property
    def whitening(self) -> csr_array:
        """Matrix that whitens the chosen rows of a single file, shape (rows, rows)."""
        (only,) = self._files
        return only.whitening

    def product(self, left: FloatArray, right: FloatArray) -> FloatArray:
        """leftᵀ M right, nuisances marginalised."""
        inner: FloatArray = left.T @ right - (left.T @ self._span) @ (self._span.T @ right)
        return inner

    def projected(self, values: FloatArray) -> FloatArray:
        """M values: residual after a fit of the nuisances against their priors."""
        left: FloatArray = values - self._span @ (self._span.T @ values)
        return left

    @property
    def chi2(self) -> float:
        """zᵀ M z."""
        return float(self.product(self.z, self.z))


class _Rows:
    """Chosen rows of one file."""

    def __init__(self, residuals: Residuals, held_out: bool) -> None:
        self.residuals = residuals
        self.chosen: BoolArray = (residuals.recording.held_out == held_out) & np.isfinite(residuals.residual)
        self.whitening = residuals.recording.noise.whitening(residuals.recording.starts(self.chosen))

    def white(self, values: Values) -> Values:
        """Whitened values of the chosen rows, from values of all rows."""
        return cast("Values", self.whitening @ values[self.chosen])


def _stacked(columns: Sequence[FloatArray]) -> FloatArray:
    """Columns of all files below each other; a file that lacks some of them has zeros."""
    width = max(one.shape[1] for one in columns)
    return np.vstack([np.pad(one, ((0, 0), (0, width - one.shape[1]))) for one in columns])


def diagonal(columns: Sequence[FloatArray]) -> FloatArray:
    """Columns of each file alone."""
    from scipy.linalg import block_diag

    return np.asarray(block_diag(*columns), dtype=np.float64)


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

    def at_rest(self, members: Sequence[int], u: FloatArray) -> NormalEquations:
        """Equations at coordinates ``u`` of ``members``, without a slope along them but that of their priors.

        ``chi2`` stays that at these coordinates.
        """
        b = self.b.copy()
        b[coordinates(members)] = u
        return replace(self, b=b)

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
