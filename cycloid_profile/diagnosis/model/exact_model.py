"""Nonlinear least squares with priors: sizes of a set of effects on the exact model."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.data.recording import Recording
from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.evidence import log_evidence_at
from cycloid_profile.diagnosis.model.flank_grid import FlankGrid
from cycloid_profile.diagnosis.model.optimum import FARTHEST, Attempt, Optimum
from cycloid_profile.diagnosis.model.residuals import Residuals, predicted_curves
from cycloid_profile.diagnosis.model.whitened import NormalEquations, Whitened, files_together, normal_equations
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.errors import CycloidError
from cycloid_profile.measurement import HYSTERESIS, PROFILE_SCAN
from cycloid_profile.rig import CurvePrediction

# Levenberg–Marquardt: damping of a step, in shares of the curvature, without which a step may leave the linear range.
_DAMPING = (0.0, 0.3, 3.0, 30.0)
_LARGEST_STEP = 1.0  # prior widths, see ``_bounded``
_CACHED_STATES = 6  # states in the cache; each holds the load on every pin at every row
_VANISHED = 1e-3  # prior widths: a one-sided effect that a change takes away
# A row without a prediction counts as this many standard deviations.
_NO_PREDICTION = 50.0


@dataclass(frozen=True, eq=False)
class State:
    """The reducer with some effects, before any change, and the residuals of all recordings at their time."""

    reducer: AsBuiltReducer
    residuals: tuple[Residuals, ...]
    members: tuple[Candidate, ...] = ()
    u: FloatArray = field(default_factory=lambda: np.zeros(0))

    @cached_property
    def blocks(self) -> tuple[Whitened, ...]:
        """Rows to fit."""
        return tuple(Whitened(*some, members=self.members, u=self.u) for some in files_together(self.residuals))

    @cached_property
    def misfit(self) -> float:
        """chi² plus the logarithm of the determinant of the covariance, up to a constant: −2 ln of the likelihood."""
        return self.chi2 + sum(block.log_det for block in self.blocks)

    @property
    def misfit_with_prior(self) -> float:
        """The same plus the terms of the priors, unit normal in the coordinates."""
        return self.misfit + float(self.u @ self.u)

    @cached_property
    def chi2(self) -> float:
        """chi² of all rows to fit, nuisances marginalised."""
        lost = sum(
            int(np.count_nonzero(~np.isfinite(one.residual) & ~one.recording.held_out)) for one in self.residuals
        )
        return sum(block.chi2 for block in self.blocks) + _NO_PREDICTION**2 * lost


def _bounded(step: FloatArray) -> FloatArray:
    """The step, limited to one prior width in each coordinate: the linear model is invalid further away."""
    largest = float(np.max(np.abs(step), initial=0.0))
    return step / max(largest / _LARGEST_STEP, 1.0)


class ExactModel:
    """Recordings of a reducer to which effects can be added; ``residuals`` of the reducer without them, if known."""

    def __init__(
        self,
        reducer: AsBuiltReducer,
        recordings: Sequence[Recording],
        flank_grid: FlankGrid | None = None,
        residuals: Sequence[Residuals] | None = None,
    ) -> None:
        self.reducer, self.recordings = reducer, tuple(recordings)
        self.flank_grid = FlankGrid(reducer) if flank_grid is None else flank_grid
        self._states: OrderedDict[tuple[tuple[Candidate, ...], bytes], tuple[Residuals, ...]] = OrderedDict()
        self._latest: list[CurvePrediction] | None = None
        self._baseline = None if residuals is None else self._residuals_on(reducer, residuals)

    def with_recordings(
        self, recordings: Sequence[Recording], residuals: Sequence[Residuals] | None = None
    ) -> ExactModel:
        """The same reducer with other recordings."""
        return ExactModel(self.reducer, recordings, self.flank_grid, residuals)

    def with_residuals(self, residuals: Sequence[Residuals]) -> ExactModel:
        """The same rows of the same files with another lobe index."""
        recordings = [
            replace(one.recording, held_out=r.held_out) for one, r in zip(residuals, self.recordings, strict=True)
        ]
        return self.with_recordings(recordings, residuals)

    def with_held_out(self, recordings: Sequence[Recording]) -> ExactModel:
        """The same with other rows held out; known residuals are reused."""
        twin = self.with_recordings(recordings, self.baseline.residuals)
        twin._states = self._states
        return twin

    @property
    def only_loops(self) -> bool:
        """Whether all files are hysteresis loops, each at one output angle."""
        return all(r.kind is HYSTERESIS for r in self.recordings)

    @property
    def is_comparison(self) -> bool:
        """Whether some files were measured after changes of the specimen."""
        return any(r.later for r in self.recordings)

    @property
    def only_scans(self) -> bool:
        """Whether all files are profile scans."""
        return all(r.kind is PROFILE_SCAN for r in self.recordings)

    @property
    def baseline(self) -> State:
        """State without additional effects."""
        if self._baseline is None:
            self._baseline = State(self.reducer, self._register(self.reducer, self.reducer))
        return self._baseline

    def state(self, members: Sequence[Candidate], u: FloatArray, farthest: float = FARTHEST) -> State | None:
        """State with effects at coordinates ``u``; None without solution or beyond ``farthest`` widths."""
        if not members:
            return self.baseline
        key = (tuple(members), u.tobytes())
        if key in self._states:
            self._states.move_to_end(key)
        else:
            try:
                reducers = self._reducers_with(members, u, farthest)
                if reducers is None:
                    return None
                self._states[key] = self._register(*reducers)
            except CycloidError:
                return None
            if len(self._states) > _CACHED_STATES:
                self._states.popitem(last=False)
        residuals = self._states[key]
        return self._residuals_on(residuals[0].reducer, residuals, key[0], u)

    def _reducers_with(
        self, members: Sequence[Candidate], u: FloatArray, farthest: float
    ) -> tuple[AsBuiltReducer, AsBuiltReducer] | None:
        """The reducer with the amounts of ``members``, and with their changes, too; None beyond ``farthest`` widths."""
        pairs = u.reshape(-1, 2)
        if np.any(np.hypot(pairs[:, 0], pairs[:, 1]) > farthest):
            return None
        before = {one: x for one, x in zip(members, pairs, strict=True) if not one.is_change}
        after = dict(before)
        for candidate, x in zip(members, pairs, strict=True):
            if candidate.is_change:
                one = candidate.amount
                least = _VANISHED if one in before and one.one_sided else -np.inf
                after[one] = np.maximum(before.get(one, 0.0) + x, least)
        earlier = self._with_amounts(before)
        later = earlier if len(before) == len(members) else self._with_amounts(after)
        return None if earlier is None or later is None else (earlier, later)

    def _with_amounts(self, amounts: Mapping[Candidate, FloatArray]) -> AsBuiltReducer | None:
        reducer = self.reducer
        for candidate, x in amounts.items():
            effect = candidate.effect(x * candidate.width)
            if effect is None:
                return None
            reducer = effect.apply(reducer)
        return reducer

    def at(self, optimum: Optimum) -> State:
        """The state of an optimum."""
        state = self.state(optimum.members, optimum.u)
        assert state is not None
        return state

    def optimum(self, attempt: Attempt, prior: float) -> Optimum | None:
        """Optimum of one set with log prior ``prior``; None if the start has no solution or the attempt is abandoned.

        Damped Gauss–Newton steps (Levenberg–Marquardt); the priors are unit normal in units of widths.
        """
        members, u = attempt.members, np.array(attempt.start, dtype=np.float64)
        steps, farthest = attempt.steps, attempt.farthest
        for i, candidate in enumerate(members):
            if candidate.one_sided:
                u[2 * i] = max(u[2 * i], 1e-3)
        self.start_anew()
        now = self.state(members, u, farthest)
        if now is None:
            return None
        converged, stalled, damping = False, False, 0
        R = np.zeros((u.size, u.size))
        if not members:
            converged, steps = True, 0
        for number in range(steps):
            equations = normal_equations(now.blocks, members)
            R = equations.R
            step = _bounded(np.asarray(np.linalg.solve(np.eye(u.size) + R, equations.b - u), dtype=np.float64))
            expected = float(step @ (equations.b - u))
            if expected < attempt.least_gain:
                converged = True
                break
            promised = float((equations.b - u) @ np.linalg.solve(np.eye(u.size) + R, equations.b - u))
            # The linear promise is less reliable before the second step.
            if attempt.cannot_beat(now.misfit_with_prior - (1.0 + 2.0 / max(number, 1) ** 2) * promised):
                return None
            new = self._improved(members, u, equations, now, farthest, max(damping - 1, 0))
            if new is None:
                stalled = True
                break
            u, now, damping = new
        if members and not converged:
            R = normal_equations(now.blocks, members).R
        rows = sum(block.z.size for block in now.blocks)
        fall = self.baseline.misfit - now.misfit
        covariance = np.asarray(np.linalg.inv(np.eye(u.size) + R), dtype=np.float64)
        value = log_evidence_at(fall, u, covariance, prior, members)
        return Optimum(members, u, covariance, R, now.chi2, now.misfit_with_prior, rows, value, converged, stalled)

    def deficit(self, part: Optimum, whole: Optimum) -> float:
        """Half chi², with the terms of prior and covariance, by which a part of a set fits worse than the whole.

        Each with its own error of the model, or both with that of the part, whichever is less: a further member must
        explain what the error of the others does not, and a smaller error alone makes no set better.
        """
        own = 0.5 * (part.misfit - whole.misfit)
        some, every = (None if own <= 0.0 else self.state(one.members, one.u) for one in (part, whole))
        if some is None or every is None:
            return own
        pairs = list(zip(some.blocks, every.blocks, strict=True))
        if not all(np.array_equal(a.chosen, b.chosen) for a, b in pairs):
            return own
        fall = sum(float(a.product(a.z, a.z) - a.product(b.z, b.z)) for a, b in pairs)
        return min(own, 0.5 * (fall + float(part.u @ part.u - whole.u @ whole.u)))

    def start_anew(self) -> None:
        """Start from the poses without effects, so that results do not depend on the order of attempts."""
        self._latest = self._predicted(self.baseline.residuals)

    def with_residual_noise(self, optimum: Optimum) -> Optimum:
        """The optimum with covariances scaled by the residual variance of each file, and the error of scale.

        The noise estimate made before any fit has a large scatter on few rows.
        """
        if not optimum.members:
            return optimum
        blocks = self.at(optimum).blocks
        parts = normal_equations(blocks, optimum.members).parts
        scans, curves = np.zeros_like(optimum.R), np.zeros_like(optimum.R)
        for part, block in zip(parts, blocks, strict=True):
            of = scans if block.residuals.recording.kind is PROFILE_SCAN else curves
            of += part.R * (block.z.size / block.chi2)
        # A predicted response may be larger or smaller than that of nature by some share. A scan shows the size itself.
        scale = tuned.SCALE * np.kron(np.eye(len(optimum.members)), np.ones((2, 1))) * optimum.u[:, np.newaxis]
        seen = curves @ scale
        curves -= seen @ np.linalg.solve(np.eye(len(optimum.members)) + scale.T @ seen, seen.T)
        covariance = np.asarray(np.linalg.inv(np.eye(optimum.u.size) + scans + curves), dtype=np.float64)
        covariance += np.diag(np.repeat([member.size_error**2 for member in optimum.members], 2))
        return replace(optimum, covariance=covariance)

    def _improved(
        self,
        members: tuple[Candidate, ...],
        u: FloatArray,
        equations: NormalEquations,
        now: State,
        farthest: float,
        first: int,
    ) -> tuple[FloatArray, State, int] | None:
        """Coordinates and state with a smaller chi², and the number of the damping that led there; None without one.

        ``first`` damping to try.
        """
        curvature = np.eye(u.size) + equations.R
        for number in range(first, len(_DAMPING)):
            damped = curvature + _DAMPING[number] * np.diag(np.diag(curvature))
            tried = u + _bounded(np.asarray(np.linalg.solve(damped, equations.b - u), dtype=np.float64))
            for i, candidate in enumerate(members):
                if candidate.one_sided:
                    tried[2 * i] = max(tried[2 * i], 0.1 * u[2 * i])
            state = self.state(members, tried, farthest)
            if state is not None and state.misfit_with_prior < now.misfit_with_prior:
                return tried, state, number
        return None

    def _register(self, earlier: AsBuiltReducer, later: AsBuiltReducer) -> tuple[Residuals, ...]:
        """Residuals of all recordings, each on the reducer of its time."""
        of = [later if r.later else earlier for r in self.recordings]
        curves = [i for i, r in enumerate(self.recordings) if r.kind.is_curve]
        # The previous reducers are similar: their poses are a good start.
        near = None if self._latest is None else dict(zip(curves, self._latest, strict=True))
        predicted: dict[int, CurvePrediction] = {}
        for reducer in (earlier,) if earlier is later else (earlier, later):
            own = [i for i in curves if of[i] is reducer]
            if own:
                start = None if near is None else [near[i] for i in own]
                found = predicted_curves([self.recordings[i] for i in own], reducer, start)
                predicted.update(zip(own, found, strict=True))
        self._latest = [predicted[i] for i in curves]
        bare = self._baseline
        return tuple(
            self._reusable_residual(i, of[i])
            or Residuals(r, of[i], self.flank_grid, predicted.get(i), None if bare is None else bare.residuals[i])
            for i, r in enumerate(self.recordings)
        )

    def _reusable_residual(self, i: int, reducer: AsBuiltReducer) -> Residuals | None:
        """Residuals of scan ``i``, reusable if the effects leave its disc unchanged; None otherwise."""
        return None if self._baseline is None else self._baseline.residuals[i].on(reducer)

    @staticmethod
    def _predicted(residuals: Sequence[Residuals]) -> list[CurvePrediction]:
        return [one.first_order.prediction for one in residuals if one.recording.kind.is_curve]

    def _residuals_on(
        self,
        reducer: AsBuiltReducer,
        residuals: Sequence[Residuals],
        members: tuple[Candidate, ...] = (),
        u: FloatArray | None = None,
    ) -> State:
        some = tuple(one.under(r) for one, r in zip(residuals, self.recordings, strict=True))
        return State(reducer, some, members, np.zeros(0) if u is None else u)
