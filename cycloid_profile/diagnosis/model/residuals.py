"""Residuals of a recording: measured minus predicted, its nuisances, and the response to each hypothesis."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from cycloid_profile.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from cycloid_profile.diagnosis.data._drift import origin_path, smooth_path
from cycloid_profile.diagnosis.data.recording import Recording
from cycloid_profile.diagnosis.model._model_error import (
    CornerWaves,
    branch_error,
    form_error,
    form_error_of_loop,
    hole_error,
    law_error,
    load_error,
    order_error,
    path_error,
    pins_error,
    row_error,
    smooth_columns,
    uneven_discs,
)
from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.flank_grid import FlankGrid
from cycloid_profile.effects import AsBuiltReducer, chatter_angle, removal_between
from cycloid_profile.measurement import HYSTERESIS, PROFILE_SCAN
from cycloid_profile.rig import CurvePrediction, LinearisedCurve, predict_curves, register_scan
from cycloid_profile.units import DEGREE, UM

if TYPE_CHECKING:
    from scipy.sparse import csr_array

# A nuisance wider than this number of standard deviations of a row counts as unknown.
_FREE = 100.0
# Datum and drift are subtracted up to this number of their standard deviations.
_ACCURACIES = 2.0
# Prior widths of the nuisances, in the unit of the column.
DATUM_ACCURACY_UM = 0.1  # origin of a scan whose datum is the bore
_UNKNOWN = 1e6  # standard deviation of a free nuisance, far above ``_FREE``
_NOTHING = np.zeros((1, 2))


class Residuals:
    """Residuals of a recording on a reducer; arrays over the rows of the recording, in the unit of its column.

    ``residual``: measured minus predicted (removal for a scan), NaN without a prediction. ``nuisance``: shape (rows,
    n), each column scaled by its prior width. ``bare``: the same recording on the reducer without effects, if
    ``reducer`` has some.
    """

    def __init__(
        self,
        recording: Recording,
        reducer: AsBuiltReducer,
        flank_grid: FlankGrid | None = None,
        predicted: CurvePrediction | None = None,
        bare: Residuals | None = None,
    ) -> None:
        self.recording, self.reducer, self._bare = recording, reducer, bare
        self.flank_grid = FlankGrid(reducer) if flank_grid is None else flank_grid
        self._columns: dict[Candidate, FloatArray] = {}
        self._angles: dict[str, FloatArray] = {}
        self._weights: dict[int, list[tuple[csr_array, slice | IntArray]]] = {}
        rows, measurement = recording.rows, recording.measurement
        if recording.kind is PROFILE_SCAN:
            keep = np.zeros(measurement["x_mm"].size, dtype=bool)
            keep[rows] = True
            self.placed = register_scan(reducer.teeth[recording.disc], measurement, keep, recording.placed)
            self.residual = self.placed.removal[rows] / UM
            stated = measurement.number("datum_um")
            datum = DATUM_ACCURACY_UM if stated is None else stated
            origin = _UNKNOWN if measurement.datum_free else datum
            normal = self.placed.normal[rows]
            lever = self.placed.lever[rows] / self.placed.tooth.trochoid.pin_circle_radius
            self.nuisance = np.stack([_UNKNOWN * lever, origin * normal.real, origin * normal.imag], axis=1)
            if recording.drift:
                self.nuisance = np.hstack([self.nuisance, recording.drift * origin_path(normal, rows)])
            self.phase, self.lobe = self.placed.foot[rows], self.placed.lobe[rows]
            self.position = np.mod(self.placed.along[rows] + np.pi, self.placed.tooth.trochoid.phase_period)
        else:
            if predicted is None:
                predicted = predicted_curves([recording], reducer)[0]
            self.first_order = LinearisedCurve(predicted)
            self.residual = measurement.value[rows] - predicted.on_last_flank
            self.nuisance = recording.drift * smooth_path(rows)
            if recording.kind.zero_unknown:
                self.nuisance = np.hstack([self.nuisance, np.full((rows.size, 1), _UNKNOWN)])
            self.position = (
                rows + 1.0 if recording.kind is HYSTERESIS else measurement["output_angle_deg"][rows] * DEGREE
            )

    def under(self, recording: Recording) -> Residuals:
        """The same with other rows held out, without recomputation."""
        twin = copy(self)
        twin.recording = recording
        return twin

    def on(self, reducer: AsBuiltReducer) -> Residuals | None:
        """The same on another reducer with an identical scanned disc; None for other recordings."""
        if self.recording.kind.is_curve:
            return None
        if reducer.teeth[self.recording.disc] is not self.reducer.teeth[self.recording.disc]:
            return None
        twin = copy(self)
        twin.reducer = reducer
        return twin

    @cached_property
    def model_error(self) -> FloatArray:
        """Error of the model but for the form of effects, as columns with their prior widths, shape (rows, columns)."""
        if self.recording.kind is PROFILE_SCAN:
            return np.zeros((self.residual.size, 0))
        further = pins_error(self.first_order, self.recording, self._load_error)
        if self._bare is None:
            return np.hstack([self._load_error, further, self._order_error])
        columns = [self._load_error, further, self._bare._order_error]
        if self.recording.kind.over_output_turn:
            solved = np.isfinite(self.residual) & np.isfinite(self._bare.residual)
            added = np.where(solved[:, np.newaxis], self._load_error - self._bare._load_error, 0.0)
            columns.append(self._bare._corner_waves.error(added, self.recording.noise))
        return np.hstack(columns)

    @cached_property
    def _corner_waves(self) -> CornerWaves:
        return CornerWaves.of(self.reducer, self.position)

    @cached_property
    def _load_error(self) -> FloatArray:
        curve = self.first_order
        return np.hstack(
            [load_error(self.reducer, curve), hole_error(self.reducer, curve), uneven_discs(self.reducer, curve)]
        )

    @cached_property
    def _order_error(self) -> FloatArray:
        return order_error(self.reducer, self.recording, self.position, self.first_order, self._load_error)

    @cached_property
    def path_error(self) -> FloatArray:
        """Error of the path of a loop, as columns with their prior widths, shape (rows, columns)."""
        if self.recording.kind is PROFILE_SCAN:
            return np.zeros((self.residual.size, 0))
        return path_error(self.reducer, self.first_order, self.recording)

    def branch_error(self, peak: float, changed: Sequence[Candidate] = (), u: FloatArray = _NOTHING) -> FloatArray:
        """The same by torque on each branch, up to ``peak`` [N·m], for loops of different paths.

        With ``changed`` at coordinates ``u``: that of the changes among them, a share of their largest response.
        """
        if self.recording.kind is not HYSTERESIS:
            return np.zeros((self.residual.size, 0))
        changes = [one.is_change for one in changed]
        size = None
        if changed:
            response = np.einsum("rmc,mc->r", self.columns(changed)[:, changes], u.reshape(-1, 2)[changes])
            size = float(np.max(np.abs(response), initial=0.0))
        return branch_error(self.reducer, self.first_order, self.recording, peak, size)

    @property
    def unnamed_error(self) -> FloatArray:
        """Smooth error of any form that two measurements of one specimen share, shape (rows, columns)."""
        size = self.recording.unnamed
        if self.recording.kind is HYSTERESIS or not size:
            return np.zeros((self.residual.size, 0))
        scan = self.recording.kind is PROFILE_SCAN
        lobe, phase = (self.lobe, self.phase) if scan else (self.position, self.position)
        return size * smooth_columns(self.reducer, self.recording, self.position, lobe, phase)

    @cached_property
    def row_error(self) -> FloatArray:
        """Further error of single rows, as columns with their prior widths, shape (rows, columns)."""
        if self.recording.kind is PROFILE_SCAN:
            return np.zeros((self.residual.size, 0))
        return row_error(self.reducer, self.first_order, self.recording)

    def form_error(self, members: Sequence[Candidate], u: FloatArray) -> FloatArray:
        """Error in the form of effects at coordinates ``u``, as columns with their prior widths."""
        signatures = np.einsum("rmc,mc->mr", self.columns(members), u.reshape(-1, 2))
        if self.recording.kind is HYSTERESIS:
            # On a loop these columns cover a shape between two proposed ones, so that ``_shape_error`` is not added.
            each = [form_error_of_loop(one, self.first_order, self.recording) for one in signatures if np.any(one)]
            each += [
                law_error(one, self.reducer, self.recording)
                for one, member in zip(signatures, members, strict=True)
                if member.kind.law_varies
            ]
        else:
            phase = self.phase if self.recording.kind is PROFILE_SCAN else self.position
            each = [
                form_error(one, self.reducer, self.recording, self.position, phase) for one in signatures if np.any(one)
            ]
            each += [self._shape_error(one, x) for one, x in zip(members, u.reshape(-1, 2), strict=True)]
        return np.hstack([np.zeros((self.residual.size, 0)), *each])

    def _shape_error(self, member: Candidate, u: FloatArray) -> FloatArray:
        """Error of an effect whose shape lies between two that are proposed, shape (rows, columns)."""
        shown = self.columns([member, *member.near_shapes(0.5)]) @ u
        return shown[:, 1:] - shown[:, :1]

    def columns(self, candidates: Sequence[Candidate]) -> FloatArray:
        """Change of the prediction per prior width of each coordinate, shape (rows, candidates, 2).

        The second is zero for candidates with one coordinate.
        """
        amounts = [c.amount for c in candidates]
        fresh = [c for c in dict.fromkeys(amounts) if c not in self._columns]
        sampled = [c for c in fresh if self.flank_grid.sampled(c)]
        self._columns.update(zip(sampled, self._flank_columns(sampled), strict=True))
        for candidate in fresh:
            if candidate not in self._columns:
                self._columns[candidate] = self._change_column(candidate)
        found = np.zeros((self.residual.size, len(candidates), 2))
        for i, (candidate, amount) in enumerate(zip(candidates, amounts, strict=True)):
            if self.recording.later or not candidate.is_change:
                found[:, i] = self._columns[amount]
        return found

    def _flank_columns(self, candidates: Sequence[Candidate]) -> list[FloatArray]:
        """Columns of flank effects from their tabulated removals, each of shape (rows, 2)."""
        scan = self.recording.kind is PROFILE_SCAN
        found = dict.fromkeys(candidates, _NOTHING)
        for j in [self.recording.disc] if scan else range(self.reducer.discs):
            some = [c for c in candidates if self.flank_grid.touches(c, j)]
            removals = self.flank_grid.removals(some, j)
            shown = sum((weights @ removals)[of] for weights, of in self._on_grid(j))
            for i, candidate in enumerate(some):
                found[candidate] = found[candidate] + shown[:, 2 * i : 2 * i + 2]
        return [np.broadcast_to(found[c], (self.residual.size, 2)) for c in candidates]

    def _on_grid(self, disc: int) -> list[tuple[csr_array, slice | IntArray]]:
        """Pairs of weights on the flank grid, shape (poses, grid), and the pose of each row; they add up."""
        if disc not in self._weights:
            if self.recording.kind is PROFILE_SCAN:
                rows = self.residual.size
                along = self.phase + 2.0 * np.pi * self.lobe
                weights = self.flank_grid.weights(np.arange(rows), along, np.full(rows, 1.0 / UM), rows)
                self._weights[disc] = [(weights, slice(None))]
            else:
                self._weights[disc] = [
                    (self.flank_grid.weights(one.pose, one.along, one.weight, one.poses), one.of)
                    for one in self.first_order.flank_weights(disc)
                ]
        return self._weights[disc]

    def _change_column(self, candidate: Candidate) -> FloatArray:
        found = np.zeros((self.residual.size, 2))
        for c in range(candidate.coordinates):
            after, step = self.flank_grid.after(candidate, c, self.reducer)
            found[:, c] = self._change(after) * (candidate.width / step)
        return found

    def waves(self, number: float, speed: str = "generating") -> ComplexArray:
        """exp(i·number·t) along the disc of a scan, shape (rows,); t is the angle that ran at constant ``speed``."""
        if speed not in self._angles:
            # A non-integer number of waves has its step at the tip before lobe 0, as in the effect.
            self._angles[speed] = chatter_angle(speed, self.placed.tooth, self.position - np.pi)
        wave: ComplexArray = np.exp(1j * number * self._angles[speed])
        return wave

    def _change(self, after: AsBuiltReducer) -> FloatArray:
        if self.recording.kind.is_curve:
            return self.first_order.change(after)
        before, new = self.reducer.teeth[self.recording.disc], after.teeth[self.recording.disc]
        if new is before:
            return np.zeros(self.residual.size)
        return removal_between(before, new, self.phase, self.lobe) / UM


def predicted_curves(
    recordings: Sequence[Recording], reducer: AsBuiltReducer, near: Sequence[CurvePrediction] | None = None
) -> list[CurvePrediction]:
    """Predictions at the rows of curves, solved together except for those known already.

    ``near``: predictions for a similar reducer, used as start.
    """
    known = {
        i: r.predicted for i, r in enumerate(recordings) if r.predicted is not None and r.predicted.reducer is reducer
    }
    fresh = [i for i in range(len(recordings)) if i not in known]
    found = dict(
        zip(
            fresh,
            predict_curves(
                reducer,
                [(recordings[i].measurement, recordings[i].rows) for i in fresh],
                None if near is None else [near[i] for i in fresh],
            ),
            strict=True,
        )
    )
    return [known[i].at(r.rows) if i in known else found[i] for i, r in enumerate(recordings)]


def fitted_rms(residuals: Residuals, rows: BoolArray, held_out: bool = False) -> float:
    """Root mean square of ``nuisance_fitted`` at those of ``rows`` that have a prediction; NaN without any."""
    rows = rows & np.isfinite(residuals.residual)
    if not np.any(rows):
        return float("nan")
    return float(np.sqrt(np.mean(nuisance_fitted(residuals, held_out)[rows] ** 2)))


def nuisance_fitted(residuals: Residuals, held_out: bool = False) -> FloatArray:
    """Residual of all rows in its unit, with the nuisances fitted to the rows to fit and subtracted.

    ``held_out``: fit them to the held-out rows instead. Unknown nuisances (angular zero, free origin) are subtracted in
    full, drift and datum up to twice their accuracy.
    """
    rows = np.isfinite(residuals.residual)
    if held_out or not np.all(residuals.recording.held_out):
        rows &= residuals.recording.held_out == held_out
    A, left = residuals.nuisance / residuals.recording.noise.sigma, residuals.residual / residuals.recording.noise.sigma
    gram = np.eye(A.shape[1]) + A[rows].T @ A[rows]
    amount = np.linalg.solve(gram, A[rows].T @ left[rows])
    free = np.sqrt(np.mean(A[rows] ** 2, axis=0)) > _FREE
    amount[~free] = np.clip(amount[~free], -_ACCURACIES, _ACCURACIES)
    if np.any(free):
        rest = left[rows] - A[rows][:, ~free] @ amount[~free]
        amount[free] = np.linalg.lstsq(A[rows][:, free], rest, rcond=None)[0]
    found: FloatArray = (left - A @ amount) * residuals.recording.noise.sigma
    return found
