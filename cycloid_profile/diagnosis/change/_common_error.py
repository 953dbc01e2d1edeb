"""Error of the model that two measurements of one specimen share, as nuisance columns of both.

The columns of a pair of files have one coefficient, so that they cancel in the difference. Besides the errors with a
known form there is a smooth one of any form: over torque and branch of a loop, in the orders of a turn, or over lobe
and phase of a scan.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray
from cycloid_profile.diagnosis.data.noise import Values
from cycloid_profile.diagnosis.data.recording import Recording
from cycloid_profile.diagnosis.model._model_error import hat_functions
from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.residuals import Residuals
from cycloid_profile.effects import loop_branches
from cycloid_profile.measurement import HYSTERESIS, PROFILE_SCAN

_KNOTS = 24  # of each branch of a loop between its largest torques
_PER_LOBE = 6  # knots of a lobe of a scan
_LOW_ORDERS, _MULTIPLES = 12, 4  # of a turn; of lobes and pins, with the two orders on either side
_SAME = 1e-3  # of torque and angle: files with keys this close were measured in the same way


@dataclass(frozen=True)
class Pair:
    """Numbers of the files before and after that were measured in the same way; None where there is no such file."""

    before: int | None
    after: int | None


def pairs_of(before: Sequence[Recording], after: Sequence[Recording]) -> tuple[Pair, ...]:
    """Each file with its counterpart of the other time: same kind, disc, torque and output angle; each file once."""
    free = list(range(len(after)))
    found = []
    for i, one in enumerate(before):
        same = next((j for j in free if _comparable(one, after[j])), None)
        if same is not None:
            free.remove(same)
        found.append(Pair(i, same))
    return (*found, *(Pair(None, j) for j in free))


def _comparable(one: Recording, other: Recording) -> bool:
    if one.kind is not other.kind or one.disc != other.disc:
        return False
    for key in ("torque_nm", "output_angle_deg"):
        a, b = one.measurement.number(key), other.measurement.number(key)
        if (a is None) != (b is None) or (a is not None and b is not None and abs(a - b) > _SAME * max(abs(a), 1.0)):
            return False
    return True


class WhiteRows:
    """Usable rows of one file in units of independent noise: ``z``, shape (rows,), and columns of all rows."""

    def __init__(self, residuals: Residuals) -> None:
        self.residuals = residuals
        self.chosen: BoolArray = np.isfinite(residuals.residual)
        self._starts = residuals.recording.starts(self.chosen)
        self.z = self.white(residuals.residual)

    @property
    def own(self) -> FloatArray:
        """Datum, zero, drift and errors of single rows, which no other file shares, shape (rows, columns)."""
        return self.white(np.hstack([self.residuals.nuisance, self.residuals.row_error]))

    @property
    def peak(self) -> float:
        """Largest torque of a loop [N·m], 0 of other files."""
        recording = self.residuals.recording
        return float(np.max(np.abs(recording.measurement["torque_nm"]))) if recording.kind is HYSTERESIS else 0.0

    @property
    def lost(self) -> int:
        """Number of rows without a prediction."""
        return int(np.count_nonzero(~self.chosen))

    def white(self, values: Values) -> Values:
        """Whitened usable rows of values of all rows."""
        return self.residuals.recording.noise.whiten(values[self.chosen], self._starts)

    def columns(self, candidates: Sequence[Candidate]) -> FloatArray:
        """Response to each coordinate per prior width, shape (rows, 2·candidates)."""
        columns = self.residuals.columns(candidates)
        return self.white(columns.reshape(len(columns), -1))

    def form(self, member: Candidate, u: FloatArray) -> FloatArray:
        """Error in the form of an effect at coordinates ``u``, shape (rows, columns)."""
        return self.white(self.residuals.form_error([member], u))


def smooth_columns(residuals: Residuals, peak: float) -> FloatArray:
    """Smooth error of any form at all rows, each column as large as the noise; shape (rows, columns).

    ``peak``: largest torque of the files that share it [N·m].
    """
    recording = residuals.recording
    if recording.kind is HYSTERESIS:
        torque = recording.measurement["torque_nm"]
        branch = loop_branches(torque)[recording.rows]
        hats = hat_functions((torque[recording.rows] / peak + 1.0) * 0.5 * (_KNOTS - 1), _KNOTS)
        columns = np.hstack([hats * (branch > 0.0)[:, np.newaxis], hats * (branch < 0.0)[:, np.newaxis]])
    elif recording.kind is PROFILE_SCAN:
        along = (residuals.phase / (2.0 * np.pi) + residuals.lobe) * _PER_LOBE
        count = residuals.reducer.case.drive.trochoid.lobes * _PER_LOBE
        columns = hat_functions(np.mod(along, count), count, periodic=True)
    else:
        trochoid = residuals.reducer.case.drive.trochoid
        lines = [
            k * n + s for n in (trochoid.lobes, trochoid.pins) for k in range(1, _MULTIPLES + 1) for s in (-1, 0, 1)
        ]
        angle = np.outer(residuals.position, np.unique([*range(1, _LOW_ORDERS + 1), *lines]))
        columns = np.hstack([np.cos(angle), np.sin(angle)])
    return recording.noise.sigma * columns
