"""A recording laid on a reducer: residual, what no measurement can know, and what each hypothesis would add."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy

import numpy as np
from scipy.sparse import csr_array

from cycloid_profile.arrays import ComplexArray, FloatArray, IntArray
from cycloid_profile.discrepancy.candidates import Candidate
from cycloid_profile.discrepancy.probes import Probes
from cycloid_profile.discrepancy.recording import Recording
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.pattern import removal_between
from cycloid_profile.rig.first_order import FirstOrder
from cycloid_profile.rig.gap import COLUMN
from cycloid_profile.rig.prediction import CurvePrediction, predict_curves
from cycloid_profile.rig.registration import place_scan
from cycloid_profile.units import DEGREE, UM

# What is wider than this many standard deviations of a row is not known at all.
_FREE = 100.0
# Datum and drift are taken off up to so many times the accuracy they should have.
_ACCURACIES = 2.0
# Prior widths of what the measurement cannot know, in the unit of the column.
DATUM_ACCURACY_UM = 0.1  # origin of a scan whose datum is the bore
_UNKNOWN = 1e6
_NOTHING = np.zeros((1, 2))
_DRIFT = {"hysteresis": 0.002, "transmission_error": 0.02, "lost_motion_map": 0.0005}


class Laid:
    """A recording beside a reducer; arrays over the rows of the recording, in the unit of its column.

    ``residual`` measured minus predicted (removal of a scan), NaN where the reducer has no prediction; ``nuisance``
    shape (rows, n), each column scaled by its prior width.
    """

    def __init__(
        self,
        recording: Recording,
        built: Built,
        probes: Probes | None = None,
        predicted: CurvePrediction | None = None,
    ) -> None:
        self.recording, self.built = recording, built
        self.probes = Probes(built) if probes is None else probes
        self._columns: dict[int, tuple[Candidate, FloatArray]] = {}
        self._weights: dict[int, list[tuple[csr_array, slice | IntArray]]] = {}
        rows, measurement = recording.rows, recording.measurement
        if recording.kind == "profile_scan":
            keep = np.zeros(measurement["x_mm"].size, dtype=bool)
            keep[rows] = True
            self.placed = place_scan(built.teeth[recording.disc], measurement, keep, recording.placed)
            self.residual = self.placed.removal[rows] / UM
            stated = measurement.number("datum_um")
            datum = DATUM_ACCURACY_UM if stated is None else stated
            origin = _UNKNOWN if measurement.keys.get("datum", "bore") == "free" else datum
            normal = self.placed.normal[rows]
            lever = self.placed.lever[rows] / self.placed.tooth.trochoid.pin_circle_radius
            self.nuisance = np.stack([_UNKNOWN * lever, origin * normal.real, origin * normal.imag], axis=1)
            self.phase, self.lobe = self.placed.foot[rows], self.placed.lobe[rows]
            self.position = np.mod(self.placed.along[rows] + np.pi, self.placed.tooth.trochoid.phase_period)
        else:
            if predicted is None:
                predicted = laid_curves([recording], built)[0]
            self.first_order = FirstOrder(predicted)
            self.residual = measurement[COLUMN[recording.kind]][rows] - predicted.value
            ramp = np.linspace(-1.0, 1.0, rows.size)
            columns = [_DRIFT[recording.kind] * ramp]
            if recording.kind != "lost_motion_map":
                columns.append(np.full(rows.size, _UNKNOWN))
            self.nuisance = np.stack(columns, axis=1)
            self.position = (
                rows + 1.0 if recording.kind == "hysteresis" else measurement["output_angle_deg"][rows] * DEGREE
            )

    def under(self, recording: Recording) -> Laid:
        """The same with other rows held out; nothing is computed anew."""
        twin = copy(self)
        twin.recording = recording
        return twin

    def on(self, built: Built) -> Laid | None:
        """The same on another reducer, if that shows the recording the very same: a scan sees its own disc only."""
        if self.recording.kind != "profile_scan":
            return None
        if built.teeth[self.recording.disc] is not self.built.teeth[self.recording.disc]:
            return None
        twin = copy(self)
        twin.built = built
        return twin

    def columns(self, candidates: Sequence[Candidate]) -> FloatArray:
        """What the prediction gains per width of each coordinate, shape (rows, candidates, 2).

        The second is zero where a candidate has one coordinate.
        """
        fresh = [c for c in candidates if id(c) not in self._columns]
        sampled = [c for c in fresh if self.probes.sampled(c)]
        for candidate, own in zip(sampled, self._of_flanks(sampled), strict=True):
            # The candidate is kept too, so that its id stays its own.
            self._columns[id(candidate)] = (candidate, own)
        for candidate in fresh:
            if id(candidate) not in self._columns:
                self._columns[id(candidate)] = (candidate, self._of_change(candidate))
        found = np.zeros((self.residual.size, len(candidates), 2))
        for i, candidate in enumerate(candidates):
            found[:, i] = self._columns[id(candidate)][1]
        return found

    def _of_flanks(self, candidates: Sequence[Candidate]) -> list[FloatArray]:
        """The columns of flank effects, each of shape (rows, 2), from what they remove."""
        scan = self.recording.kind == "profile_scan"
        found = {id(c): _NOTHING for c in candidates}
        for j in [self.recording.disc] if scan else range(self.built.discs):
            some = [c for c in candidates if self.probes.touches(c, j)]
            removals = self.probes.removals(some, j)
            shown = sum((weights @ removals)[of] for weights, of in self._on_grid(j))
            for i, candidate in enumerate(some):
                found[id(candidate)] = found[id(candidate)] + shown[:, 2 * i : 2 * i + 2]
        return [np.broadcast_to(found[id(c)], (self.residual.size, 2)) for c in candidates]

    def _on_grid(self, disc: int) -> list[tuple[csr_array, slice | IntArray]]:
        """Weights of removals on the grid of the probes, shape (poses, grid), and which pose each row is like; rows are
        sums of these.
        """
        if disc not in self._weights:
            if self.recording.kind == "profile_scan":
                rows = self.residual.size
                along = self.phase + 2.0 * np.pi * self.lobe
                weights = self.probes.weights(np.arange(rows), along, np.full(rows, 1.0 / UM), rows)
                self._weights[disc] = [(weights, slice(None))]
            else:
                self._weights[disc] = [
                    (self.probes.weights(one.pose, one.along, one.weight, one.poses), one.of)
                    for one in self.first_order.flank_weights(disc)
                ]
        return self._weights[disc]

    def _of_change(self, candidate: Candidate) -> FloatArray:
        found = np.zeros((self.residual.size, 2))
        for c in range(candidate.coordinates):
            after, step = self.probes.after(candidate, c, self.built)
            found[:, c] = self._change(after) * (candidate.width / step)
        return found

    def waves(self, number: float) -> ComplexArray:
        """exp(i·number·t) along the disc of a scan, shape (rows,)."""
        # Numbers that do not come out even jump where the effect lets them jump: at the tip before lobe 0.
        t = self.position - np.pi
        wave: ComplexArray = np.exp(1j * number * t / self.placed.tooth.trochoid.lobes)
        return wave

    def _change(self, after: Built) -> FloatArray:
        if self.recording.kind != "profile_scan":
            return self.first_order.change(after)
        before, new = self.built.teeth[self.recording.disc], after.teeth[self.recording.disc]
        if new is before:
            return np.zeros(self.residual.size)
        return removal_between(before, new, self.phase, self.lobe) / UM


def laid_curves(
    recordings: Sequence[Recording], built: Built, near: Sequence[CurvePrediction] | None = None
) -> list[CurvePrediction]:
    """What is predicted at the rows of curves; solved together, but for what was predicted before.

    ``near``, the same for a slightly different reducer.
    """
    known = {i: r.predicted for i, r in enumerate(recordings) if r.predicted is not None and r.predicted.built is built}
    fresh = [i for i in range(len(recordings)) if i not in known]
    found = dict(
        zip(
            fresh,
            predict_curves(
                built,
                [(recordings[i].measurement, recordings[i].rows) for i in fresh],
                None if near is None else [near[i] for i in fresh],
            ),
            strict=True,
        )
    )
    return [known[i].at(r.rows) if i in known else found[i] for i, r in enumerate(recordings)]


def settled(laid: Laid, held_out: bool = False) -> FloatArray:
    """Residual of all rows, in its unit, with what no measurement can know taken off as the fitted rows have it.

    With ``held_out`` as the rows that were held out have it.

    Zero and place are taken off whatever they are, drift and datum up to a few times the accuracy they should have.
    """
    rows = np.isfinite(laid.residual)
    if held_out or not np.all(laid.recording.held_out):
        rows &= laid.recording.held_out == held_out
    A, left = laid.nuisance / laid.recording.noise.sigma, laid.residual / laid.recording.noise.sigma
    gram = np.eye(A.shape[1]) + A[rows].T @ A[rows]
    amount = np.linalg.solve(gram, A[rows].T @ left[rows])
    free = np.sqrt(np.mean(A[rows] ** 2, axis=0)) > _FREE
    amount[~free] = np.clip(amount[~free], -_ACCURACIES, _ACCURACIES)
    if np.any(free):
        rest = left[rows] - A[rows][:, ~free] @ amount[~free]
        amount[free] = np.linalg.lstsq(A[rows][:, free], rest, rcond=None)[0]
    found: FloatArray = (left - A @ amount) * laid.recording.noise.sigma
    return found
