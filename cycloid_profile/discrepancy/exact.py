"""Sizes of a set of effects on the exact model: least squares with priors, linearised anew at each step."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.candidates import Candidate
from cycloid_profile.discrepancy.evidence import log_evidence_at
from cycloid_profile.discrepancy.laid import Laid, laid_curves
from cycloid_profile.discrepancy.normal import Whitened, normal
from cycloid_profile.discrepancy.optimum import FARTHEST, Attempt, Optimum
from cycloid_profile.discrepancy.probes import Probes
from cycloid_profile.discrepancy.recording import Recording
from cycloid_profile.effects.built import Built
from cycloid_profile.errors import CycloidError
from cycloid_profile.rig.prediction import CurvePrediction

_HALVINGS = 3
_FEW_OF_POSES = 0.25
_LONGEST = 1.0
_HOPELESS = 50.0  # of chi²
_RECENT = 6  # states kept: each holds the load on every pin at every row
_ENOUGH = 0.02  # of chi²: a step that gains less is the last
# A row without a prediction counts like one this many standard deviations off.
_NO_ANSWER = 50.0


@dataclass(frozen=True, eq=False)
class State:
    """The reducer with some effects, and the recordings laid on it."""

    built: Built
    laid: tuple[Laid, ...]

    @cached_property
    def blocks(self) -> tuple[Whitened, ...]:
        """Rows to fit."""
        return tuple(Whitened(one) for one in self.laid)

    @cached_property
    def chi2(self) -> float:
        """Of all rows to fit, nuisances marginalised."""
        lost = sum(int(np.count_nonzero(~np.isfinite(one.residual) & ~one.recording.held_out)) for one in self.laid)
        return sum(block.chi2 for block in self.blocks) + _NO_ANSWER**2 * lost


def _bounded(step: FloatArray) -> FloatArray:
    """The step, no coordinate of it larger than one width: further off the linear model says nothing."""
    largest = float(np.max(np.abs(step), initial=0.0))
    return step / max(largest / _LONGEST, 1.0)


class ExactModel:
    """Recordings beside a reducer that may get effects; ``laid`` if they lie on the reducer as it is already."""

    def __init__(
        self,
        built: Built,
        recordings: Sequence[Recording],
        probes: Probes | None = None,
        laid: Sequence[Laid] | None = None,
    ) -> None:
        self.built, self.recordings = built, tuple(recordings)
        self.probes = Probes(built) if probes is None else probes
        self._recent: OrderedDict[bytes, tuple[tuple[Candidate, ...], tuple[Laid, ...]]] = OrderedDict()
        self._latest: list[CurvePrediction] | None = None
        self._nothing = None if laid is None else self._under(built, laid)

    def with_recordings(self, recordings: Sequence[Recording], laid: Sequence[Laid] | None = None) -> ExactModel:
        """The same reducer beside other recordings."""
        return ExactModel(self.built, recordings, self.probes, laid)

    def with_laid(self, laid: Sequence[Laid]) -> ExactModel:
        """The same rows of the same files with their lobes counted otherwise."""
        recordings = [replace(one.recording, held_out=r.held_out) for one, r in zip(laid, self.recordings, strict=True)]
        return self.with_recordings(recordings, laid)

    def without_scans(self) -> ExactModel:
        """The same reducer beside the other files alone."""
        return self._with_some([one for one in self.nothing.laid if one.recording.kind != "profile_scan"])

    def scans_alone(self) -> ExactModel:
        """The same reducer beside the scans alone."""
        return self._with_some([one for one in self.nothing.laid if one.recording.kind == "profile_scan"])

    def _with_some(self, laid: Sequence[Laid]) -> ExactModel:
        return self.with_recordings([one.recording for one in laid], laid)

    def with_rows(self, recordings: Sequence[Recording]) -> ExactModel:
        """The same with other rows held out; what lies already is not laid anew."""
        twin = self.with_recordings(recordings, self.nothing.laid)
        twin._recent = self._recent
        return twin

    def optima(
        self, attempts: Sequence[Attempt], prior: Callable[[Sequence[Candidate]], float]
    ) -> list[Optimum | None]:
        """The best sizes of each attempt, None without a way to begin."""
        return [self.optimum(one, prior(one.members)) for one in attempts]

    @property
    def only_loops(self) -> bool:
        """Whether all there is are loops, each at one place of the output."""
        return all(r.kind == "hysteresis" for r in self.recordings)

    @property
    def only_scans(self) -> bool:
        """Whether all there is are scans, which show each place of an effect as it is."""
        return all(r.kind == "profile_scan" for r in self.recordings)

    def solves_few_poses(self, members: Sequence[Candidate]) -> bool:
        """Whether most poses are alike others with these members: a state then costs next to nothing."""
        return self._most_alike and not any(member.tells_pins_apart for member in members)

    @cached_property
    def _most_alike(self) -> bool:
        terms = [term for one in self._predicted(self.nothing.laid) for term in one.terms]
        solved = sum(term.sharing.torque.size for term in terms)
        return bool(terms) and solved <= _FEW_OF_POSES * sum(term.output_angle.size for term in terms)

    @property
    def nothing(self) -> State:
        """The reducer as it is."""
        if self._nothing is None:
            self._nothing = State(self.built, self._lay(self.built))
        return self._nothing

    def state(self, members: Sequence[Candidate], u: FloatArray, farthest: float = FARTHEST) -> State | None:
        """With effects at coordinates ``u``, none larger than ``farthest`` widths; None where that cannot be."""
        if not members:
            return self.nothing
        key = np.array([id(member) for member in members]).tobytes() + u.tobytes()
        if key in self._recent:
            self._recent.move_to_end(key)
        else:
            try:
                built = self._with(members, u, farthest)
                if built is None:
                    return None
                # Members are kept too, so that their ids stay their own.
                self._recent[key] = (tuple(members), self._lay(built))
            except CycloidError:
                return None
            if len(self._recent) > _RECENT:
                self._recent.popitem(last=False)
        laid = self._recent[key][1]
        return self._under(laid[0].built, laid)

    def _with(self, members: Sequence[Candidate], u: FloatArray, farthest: float) -> Built | None:
        built = self.built
        for i, candidate in enumerate(members):
            if float(np.hypot(u[2 * i], u[2 * i + 1])) > farthest:
                return None
            effect = candidate.effect(u[2 * i : 2 * i + 2] * candidate.width)
            if effect is None:
                return None
            built = effect.apply(built)
        return built

    def at(self, optimum: Optimum) -> State:
        """The state of an optimum."""
        state = self.state(optimum.members, optimum.u)
        assert state is not None
        return state

    def optimum(self, attempt: Attempt, prior: float) -> Optimum | None:
        """Best sizes of one set whose log ``prior`` is given; None without a way to begin.

        None too where the attempt was given up.
        """
        members, u = attempt.members, np.array(attempt.start, dtype=np.float64)
        steps, beat, farthest = attempt.steps, attempt.beat, attempt.farthest
        for i, candidate in enumerate(members):
            if candidate.one_sided:
                u[2 * i] = max(u[2 * i], 1e-3)
        # Each begins at the same place, whatever was fitted before.
        self._latest = self._predicted(self.nothing.laid)
        now = self.state(members, u, farthest)
        if now is None:
            return None
        settled = False
        R = np.zeros((u.size, u.size))
        if not members:
            settled, steps = True, 0
        for number in range(steps):
            equations = normal(now.blocks, members)
            R = equations.R
            step = _bounded(np.asarray(np.linalg.solve(np.eye(u.size) + R, equations.b - u), dtype=np.float64))
            expected = float(step @ (equations.b - u))
            if expected < _ENOUGH:
                settled = True
                break
            promised = float((equations.b - u) @ np.linalg.solve(np.eye(u.size) + R, equations.b - u))
            # Before the second step the promise is less sure than after it.
            if now.chi2 + float(u @ u) - (1.0 + 2.0 / max(number, 1) ** 2) * promised > beat + _HOPELESS:
                return None
            new = self._shorter(members, u, step, now, farthest)
            if new is None:
                break
            u, now = new
            if np.any(np.hypot(u[0::2], u[1::2]) < attempt.least):
                return None
        if members and not settled:
            R = normal(now.blocks, members).R
        rows = sum(block.z.size for block in now.blocks)
        fall = self.nothing.chi2 - now.chi2
        covariance = np.asarray(np.linalg.inv(np.eye(u.size) + R), dtype=np.float64)
        value = log_evidence_at(fall, u, covariance, prior, members)
        return Optimum(members, u, covariance, R, now.chi2, rows, value, settled)

    def with_noise_left(self, optimum: Optimum) -> Optimum:
        """The same with the covariance that the noise left in each file makes: what few rows told of the noise before
        anything was explained scatters.
        """
        if not optimum.members:
            return optimum
        blocks = self.at(optimum).blocks
        parts = normal(blocks, optimum.members).parts
        R = sum(part.R * (block.z.size / block.chi2) for part, block in zip(parts, blocks, strict=True))
        return replace(optimum, covariance=np.asarray(np.linalg.inv(np.eye(optimum.u.size) + R), dtype=np.float64))

    def _shorter(
        self, members: tuple[Candidate, ...], u: FloatArray, step: FloatArray, now: State, farthest: float
    ) -> tuple[FloatArray, State] | None:
        """The step, halved until it gains."""
        before = now.chi2 + float(u @ u)
        share = 1.0
        for _ in range(_HALVINGS):
            tried = u + share * step
            for i, candidate in enumerate(members):
                if candidate.one_sided:
                    tried[2 * i] = max(tried[2 * i], 0.1 * u[2 * i])
            state = self.state(members, tried, farthest)
            if state is not None and state.chi2 + float(tried @ tried) < before:
                return tried, state
            share *= 0.4
        return None

    def _lay(self, built: Built) -> tuple[Laid, ...]:
        curves = [r for r in self.recordings if r.kind != "profile_scan"]
        # The last reducer was much like this one: where it rested is a good place to begin.
        self._latest = laid_curves(curves, built, self._latest)
        predicted = dict(zip(map(id, curves), self._latest, strict=True))
        return tuple(
            self._on_its_own_disc(i, built) or Laid(r, built, self.probes, predicted.get(id(r)))
            for i, r in enumerate(self.recordings)
        )

    def _on_its_own_disc(self, i: int, built: Built) -> Laid | None:
        """A scan whose disc is as without any effect lies as it did then."""
        return None if self._nothing is None else self._nothing.laid[i].on(built)

    @staticmethod
    def _predicted(laid: Sequence[Laid]) -> list[CurvePrediction]:
        return [one.first_order.prediction for one in laid if one.recording.kind != "profile_scan"]

    def _under(self, built: Built, laid: Sequence[Laid]) -> State:
        return State(built, tuple(one.under(r) for one, r in zip(laid, self.recordings, strict=True)))
