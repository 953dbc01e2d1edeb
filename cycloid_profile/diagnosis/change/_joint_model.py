"""Likelihood of two measurements of one specimen: common effects, their changes, and one error of the model.

The hypothesis has ``common`` effects with amounts u before, and ``changed`` effects whose amounts rise by v. The smooth
error of the model, its change and the noise have sizes that follow from the data by maximum likelihood.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis.change._common_error import Pair, WhiteRows, pairs_of, smooth_columns
from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.evidence import log_evidence_at
from cycloid_profile.diagnosis.model.exact_model import ExactModel, State

_STEPS = 8
_HALVINGS = 3
_SHORTER = 0.4
_CONVERGED = 0.05  # of the misfit
_ABANDONED_ABOVE = 50.0  # of the misfit of the best fit
_LOST = 50.0**2  # chi² of a row without a prediction
_RATIO = 2.0  # between neighbouring sizes of an error
_LARGEST = 14  # 2^14 times the noise
_LEAST = 1e-3  # widths: a one-sided effect never vanishes quite


@dataclass(frozen=True)
class Hypothesis:
    """Effects ``common`` to both times, and those that ``changed``; one that changed but is not common is new."""

    common: frozenset[Candidate]
    changed: frozenset[Candidate]

    @cached_property
    def before(self) -> tuple[Candidate, ...]:
        """Effects before, in a fixed order."""
        return _ordered(self.common)

    @cached_property
    def changes(self) -> tuple[Candidate, ...]:
        """Effects with a change, in a fixed order."""
        return _ordered(self.changed)

    @cached_property
    def after(self) -> tuple[Candidate, ...]:
        """Effects after: those before, then new ones."""
        return (*self.before, *_ordered(self.changed - self.common))

    @cached_property
    def to_after(self) -> FloatArray:
        """Matrix from all coordinates to those of the effects after."""
        n = len(self.before)
        found = np.eye(2 * len(self.after), 2 * (n + len(self.changes)))
        found[2 * n :, 2 * n :] = 0.0
        for k, member in enumerate(self.changes):
            i = self.after.index(member)
            found[2 * i : 2 * i + 2, 2 * (n + k) : 2 * (n + k) + 2] = np.eye(2)
        return found

    @property
    def coordinates(self) -> tuple[Candidate, ...]:
        """Owner of each pair of coordinates; the change of a common effect may be negative."""
        common = [replace(one, one_sided=False) if one in self.common else one for one in self.changes]
        return (*self.before, *common)

    def within_bounds(self, theta: FloatArray) -> FloatArray:
        """Coordinates with one-sided amounts above zero at both times."""
        found = theta.copy()
        n = len(self.before)
        for i, member in enumerate(self.before):
            if member.one_sided:
                found[2 * i] = max(found[2 * i], _LEAST)
        for k, member in enumerate(self.changes):
            if member.one_sided:
                then = found[2 * self.before.index(member)] if member in self.common else 0.0
                found[2 * (n + k)] = max(found[2 * (n + k)], _LEAST - then)
        return found


def _ordered(members: frozenset[Candidate]) -> tuple[Candidate, ...]:
    return tuple(sorted(members, key=lambda one: one.label))


@dataclass(frozen=True)
class Sizes:
    """Powers of two: sizes of the smooth ``common`` error, of its change in the file after, and of the noise.

    An error of power 0 is none.
    """

    common: int = 0
    own: int = 0
    noise: int = 0


@dataclass(frozen=True, eq=False)
class JointState:
    """Both reducers with the effects of a hypothesis at coordinates ``theta``: amounts before, then changes."""

    hypothesis: Hypothesis
    theta: FloatArray
    before: State
    after: State

    @property
    def u(self) -> FloatArray:
        """Coordinates before."""
        return self.theta[: 2 * len(self.hypothesis.before)]

    @property
    def v(self) -> FloatArray:
        """Coordinates of the changes."""
        return self.theta[2 * len(self.hypothesis.before) :]


@dataclass(frozen=True, eq=False)
class JointFit:
    """Optimum of a hypothesis: state, sizes of the errors of each pair of files, and covariance of all coordinates.

    ``misfit``: minus twice the log likelihood, ``log_evidence``; both up to a constant of the data.
    """

    state: JointState
    sizes: tuple[Sizes, ...]
    covariance: FloatArray
    misfit: float
    log_evidence: float

    @property
    def objective(self) -> float:
        """Misfit with the terms of the priors."""
        return self.misfit + float(self.state.theta @ self.state.theta)


class Products:
    """Products of all columns of one pair of files, from which the likelihood follows for any sizes of its errors.

    ``fixed``: nuisances with known widths; ``smooth`` ones of both files, and the ``own`` ones of the file after;
    ``wanted``: columns of the amounts; ``z``: the whitened rows. ``lost``: number of rows without a prediction.
    """

    def __init__(
        self, fixed: FloatArray, smooth: FloatArray, own: FloatArray, wanted: FloatArray, z: FloatArray, lost: int
    ) -> None:
        self.rows, self._lost = z.size, lost
        self._ends = np.cumsum([fixed.shape[1], smooth.shape[1], own.shape[1]])
        every = np.hstack([fixed, smooth, own, wanted, z[:, np.newaxis]])
        # A row without an equilibrium nearby has no response.
        every = np.nan_to_num(every, posinf=0.0, neginf=0.0)
        self._products = every.T @ every

    def equations(self, sizes: Sizes) -> tuple[float, FloatArray, FloatArray]:
        """Misfit, minus twice the log likelihood up to a constant, with b and R of the wanted columns."""
        from scipy.linalg import solve_triangular

        scale = np.ones(len(self._products))
        first, second, third = self._ends
        scale[first:second] = _size(sizes.common)
        scale[second:third] = _size(sizes.own)
        used = np.flatnonzero(scale)
        scale = scale[used] / _RATIO**sizes.noise
        G = self._products[np.ix_(used, used)] * np.outer(scale, scale)
        n = int(np.count_nonzero(used < third))
        lower = np.linalg.cholesky(G[:n, :n] + np.eye(n))
        half = np.asarray(solve_triangular(lower, G[:n, n:], lower=True))
        left = G[n:, n:] - half.T @ half
        log_det = 2.0 * float(np.sum(np.log(np.diag(lower))) + self.rows * sizes.noise * np.log(_RATIO))
        return float(left[-1, -1]) + log_det + _LOST * self._lost, left[:-1, -1], left[:-1, :-1]

    def best_sizes(self, start: Sizes, smooth: bool) -> Sizes:
        """Sizes of least misfit about ``start``; without ``smooth`` errors only that of the noise."""
        best, least = start, self.equations(start)[0]
        keys = ("common", "own", "noise") if smooth else ("noise",)
        improved = True
        while improved:
            improved = False
            for key, step in product(keys, (-4, -1, 1, 4)):
                tried = replace(best, **{key: min(max(getattr(best, key) + step, 0), _LARGEST)})
                found = least if tried == best else self.equations(tried)[0]
                if found < least - _CONVERGED:
                    best, least, improved = tried, found, True
        return best


def _size(power: int) -> float:
    """Size of an error in units of the noise; none at 0."""
    return float(_RATIO ** (power - 3)) if power else 0.0


class JointModel:
    """Two exact models of one reducer, ``before`` and ``after``, with ``pairs`` of their files."""

    def __init__(self, before: ExactModel, after: ExactModel) -> None:
        self.before, self.after = before, after
        self.pairs = pairs_of(before.recordings, after.recordings)

    @property
    def only_loops(self) -> bool:
        """Whether all files are hysteresis loops."""
        return self.before.only_loops and self.after.only_loops

    @property
    def only_scans(self) -> bool:
        """Whether all files are profile scans."""
        return self.before.only_scans and self.after.only_scans

    def state(self, hypothesis: Hypothesis, theta: FloatArray) -> JointState | None:
        """State at coordinates, u then v; None without a solution."""
        theta = hypothesis.within_bounds(theta)
        u = theta[: 2 * len(hypothesis.before)]
        first = self.before.state(hypothesis.before, u)
        second = self.after.state(hypothesis.after, hypothesis.to_after @ theta)
        return None if first is None or second is None else JointState(hypothesis, theta, first, second)

    def products(
        self, state: JointState, common: Sequence[Candidate], changed: Sequence[Candidate]
    ) -> tuple[Products, ...]:
        """Products of each pair, for the amounts of ``common`` before and the changes of ``changed``."""
        return tuple(self._products(pair, state, common, changed) for pair in self.pairs)

    def _products(
        self, pair: Pair, state: JointState, common: Sequence[Candidate], changed: Sequence[Candidate]
    ) -> Products:
        sides = [
            _Side(WhiteRows(one.residuals[i]), is_after)
            for one, i, is_after in ((state.before, pair.before, False), (state.after, pair.after, True))
            if i is not None
        ]
        peak = max(side.rows.peak for side in sides)
        smooth = [side.rows.white(smooth_columns(side.rows.residuals, peak)) for side in sides]
        own = [columns if side.is_after else 0.0 * columns for columns, side in zip(smooth, sides, strict=True)]
        wanted = [
            np.hstack([side.rows.columns(common), float(side.is_after) * side.rows.columns(changed)]) for side in sides
        ]
        return Products(
            np.hstack([_block_diagonal([side.rows.own for side in sides]), *_model_errors(sides, state)]),
            np.vstack(smooth),
            np.vstack(own)[:, : own[0].shape[1] * (len(sides) - 1)],
            np.vstack(wanted),
            np.concatenate([side.rows.z for side in sides]),
            sum(side.rows.lost for side in sides),
        )

    def fit(
        self,
        hypothesis: Hypothesis,
        start: FloatArray,
        prior: float,
        sizes: tuple[Sizes, ...] | None = None,
        beat: float = math.inf,
        smooth: bool = True,
    ) -> JointFit | None:
        """Optimum of a hypothesis from ``start``; None without a solution, or if it cannot reach ``beat``.

        Without known ``sizes`` the smooth errors stay out of the first steps, and without ``smooth`` of all, so that
        effects explain what they can.
        """
        self.before.start_anew()
        self.after.start_anew()
        state = self.state(hypothesis, start)
        if state is None:
            return None
        now = sizes or tuple(Sizes() for _ in self.pairs)
        for also_smooth in (False, smooth) if sizes is None and smooth else (smooth,):
            for number in range(_STEPS):
                now, (misfit, b, R) = self._equations(state, now, also_smooth)
                gradient = b - state.theta
                promised = float(gradient @ np.linalg.solve(np.eye(b.size) + R, gradient))
                # The linear promise is less reliable before the second step.
                least = misfit + float(state.theta @ state.theta) - (1.0 + 2.0 / max(number, 1) ** 2) * promised
                if least > beat + _ABANDONED_ABOVE:
                    return None
                found = self._step(state, now, misfit, b, R)
                if found is None:
                    break
                state = found
        now, (misfit, _, R) = self._equations(state, now, smooth)
        covariance = np.asarray(np.linalg.inv(np.eye(R.shape[0]) + R), dtype=np.float64)
        value = log_evidence_at(-misfit, state.theta, covariance, prior, hypothesis.coordinates)
        return JointFit(state, now, covariance, misfit, value)

    def _equations(
        self, state: JointState, sizes: tuple[Sizes, ...], smooth: bool
    ) -> tuple[tuple[Sizes, ...], tuple[float, FloatArray, FloatArray]]:
        """Best sizes of the errors about known ones, and the equations of all coordinates with them."""
        each = self.products(state, state.hypothesis.before, state.hypothesis.changes)
        now = tuple(one.best_sizes(known, smooth) for one, known in zip(each, sizes, strict=True))
        return now, summed(each, now)

    def _step(
        self, state: JointState, sizes: tuple[Sizes, ...], misfit: float, b: FloatArray, R: FloatArray
    ) -> JointState | None:
        """A Gauss–Newton step, shortened until the misfit falls; None at the optimum."""
        theta = state.theta
        gradient = b - theta
        step = np.linalg.solve(np.eye(theta.size) + R, gradient)
        if theta.size == 0 or float(step @ gradient) < _CONVERGED:
            return None
        step /= max(float(np.max(np.abs(step))), 1.0)
        before = misfit + float(theta @ theta)
        for _ in range(_HALVINGS):
            tried = self.state(state.hypothesis, theta + step)
            if tried is not None:
                value = summed(self.products(tried, (), ()), sizes)[0] + float(tried.theta @ tried.theta)
                if value < before:
                    return tried
            step = _SHORTER * step
        return None


@dataclass(frozen=True, eq=False)
class _Side:
    """Rows of a file, measured before or after."""

    rows: WhiteRows
    is_after: bool


def _model_errors(sides: Sequence[_Side], state: JointState) -> list[FloatArray]:
    """Errors of the model with one coefficient in both files, and the error in the form of each change."""
    hypothesis = state.hypothesis
    now = hypothesis.to_after @ state.theta
    then = np.concatenate([state.u, np.zeros(now.size - state.u.size)])
    found = [_stacked([side.rows.white(side.rows.residuals.model_error) for side in sides])]
    for k, member in enumerate(hypothesis.after):
        own = slice(2 * k, 2 * k + 2)
        found.append(_stacked([side.rows.form(member, (now if side.is_after else then)[own]) for side in sides]))
    for k, member in enumerate(hypothesis.changes):
        change = state.v[2 * k : 2 * k + 2]
        found.append(_stacked([side.rows.form(member, float(side.is_after) * change) for side in sides]))
    return found


def _stacked(columns: Sequence[FloatArray]) -> FloatArray:
    """The columns of both files below each other; a file without them has zeros."""
    width = max(one.shape[1] for one in columns)
    return np.vstack([np.pad(one, ((0, 0), (0, width - one.shape[1]))) for one in columns])


def _block_diagonal(columns: Sequence[FloatArray]) -> FloatArray:
    from scipy.linalg import block_diag

    return np.asarray(block_diag(*columns), dtype=np.float64)


def summed(each: Sequence[Products], sizes: Sequence[Sizes]) -> tuple[float, FloatArray, FloatArray]:
    """Misfit, b and R of all pairs."""
    misfit, b, R = each[0].equations(sizes[0])
    for one, own in zip(each[1:], sizes[1:], strict=True):
        more = one.equations(own)
        misfit, b, R = misfit + more[0], b + more[1], R + more[2]
    return misfit, b, R
