"""Equilibrium of one block of poses: first touch, compiled search, then exact gaps for the rest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray, IntArray
from cycloid_profile.contact.bodies import PartDeviations, support_model
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.mesh import OVERLAP_TOLERANCE, Gaps, Meshing, closing_turn, gaps
from cycloid_profile.contact.result import STATUSES, LoadSharing, SolveStatus, StageMotion, StagePositions
from cycloid_profile.contact.stage._linear_compliance import solve_linear_compliance
from cycloid_profile.contact.stage._nearby import REFRESHES, WHOLE_STEPS, settled_near
from cycloid_profile.contact.stage.energy import EnergyPoint, StageEnergy, minimise

_TOUCH_STEPS = 40
_TOUCHED = 1e-12  # rad
# Rounding of the gaps, some 1e-14 mm, against a stiff contact: no balance comes closer than this.
_ROUNDING_FORCE = 1e-7  # N
_CONVERGED, _INTERFERENCE, _NO_CONTACT, _NOT_CONVERGED, _LOST = (STATUSES.index(s) for s in SolveStatus)


class StageBlock:
    """Solver for one block of poses; ``compliance`` of the bodies at these poses, if it is known; ``stiffness`` as in
    ``StageEquilibrium``.
    """

    def __init__(
        self,
        case: LoadCase,
        deviations: PartDeviations,
        tolerance: float,
        meshing: Meshing,
        torque: FloatArray,
        compliance: FloatArray | None = None,
        stiffness: bool = True,
    ) -> None:
        self._stiffness = stiffness
        self.case, self.deviations, self.tolerance, self.torque = case, deviations, tolerance, torque
        self.direction = np.sign(torque)
        self.meshing = meshing
        self.support = support_model(case.drive, self.meshing.crank_angle, deviations, case.width)
        self.compliance = case.body_compliance(meshing) if compliance is None else compliance
        self.load = np.zeros(self.compliance.shape[:2])

    def solved(self, near: StagePositions | None = None, compiled: bool = False) -> LoadSharing:
        """Every pose at equilibrium, or with the reason why it has none.

        ``near`` is a nearby equilibrium to start from; first touch is not searched for then. ``compiled``: the compiled
        search starts from first touch, too.
        """
        if near is not None:
            outcome = np.full(len(self.torque), _CONVERGED)
            if near.load is not None and near.load.shape == self.load.shape:
                self.load = near.load.copy()
            corners = any(tooth.corners for tooth in self.deviations.teeth or [self.case.profile])
            u, seen, history = self._settled_from(self._unknowns(near), near.foot, outcome, check=corners)
            none = np.full(self.meshing.phase.shape, np.nan)
            return self._sharing(u, none[:, 0, 0], none, outcome, seen, history)
        begin, seen, outcome = self._rigid_touch()
        touch, gap_at_touch = begin[:, 0], seen.gap.copy()
        if compiled:
            u, seen, history = self._settled_from(begin, seen.foot, outcome, check=True)
        else:
            u, history = self._searched(begin, seen, np.zeros(len(begin)), outcome)
        return self._sharing(u, touch, gap_at_touch, outcome, seen, history)

    def _settled_from(
        self, begin: FloatArray, foot: FloatArray | None, outcome: IntArray, check: bool
    ) -> tuple[FloatArray, Gaps, list[tuple[float, float]]]:
        """Compiled search, its balances checked with exact gaps on request; the search with exact gaps takes the poses
        it leaves. ``outcome`` is kept up to date.
        """
        everywhere, history = np.arange(len(begin)), list[tuple[float, float]]()
        rests = settled_near(
            self.case, self.deviations, self.meshing, self.support, self.torque, self._tolerance(everywhere),
            self._overclosure(), self.compliance, begin, foot, self.load,
        )  # fmt: skip
        u, seen, settled = rests
        if check:
            settled[settled] = self._balanced(everywhere[settled], u, seen)
        left = everywhere[~settled]
        if left.size:
            others = StageBlock(
                self.case,
                self.deviations,
                self.tolerance,
                self.meshing.poses(left),
                self.torque[left],
                self.compliance[left],
            )
            how = outcome[left]
            u[left], found, history = others._searched_from(begin[left], how)
            self.load[left] = others.load
            seen.put(left, found)
            outcome[left] = how
        return u, seen, history

    def _balanced(self, active: IntArray, u: FloatArray, seen: Gaps) -> BoolArray:
        """Whether the active poses balance with exact gaps, which are written into ``seen``."""
        seen.put(active, self._gaps(active, u, seen.foot[active]))
        problem = self._energy(active, u, seen.poses(active))
        balanced: BoolArray = problem.imbalance(problem.at(np.zeros_like(u[active]))) < self._tolerance(active)
        return balanced

    def _searched_from(
        self, begin: FloatArray, outcome: IntArray
    ) -> tuple[FloatArray, Gaps, list[tuple[float, float]]]:
        """The search from unknowns near the equilibrium."""
        active = np.arange(len(begin))
        seen = self._gaps(active, begin, None)
        to_touch = self.direction * _finite(self._to_touch(active, seen))
        u, history = self._searched(begin, seen, to_touch, outcome)
        return u, seen, history

    def _searched(
        self, begin: FloatArray, seen: Gaps, to_touch: FloatArray, outcome: IntArray
    ) -> tuple[FloatArray, list[tuple[float, float]]]:
        """Alternate between the convex problem and exact gaps until every pose converges or fails: the unknowns, and
        the largest force and approach of each iteration. ``seen`` and ``outcome`` are kept up to date.
        """
        active = np.arange(len(begin))
        # Pressed together a little: Newton then has forces to balance from the start.
        pressed = self.support.rigid_motion * (to_touch + self._overclosure())[:, np.newaxis]
        enough = 0.1 * self.tolerance
        step, self.load = minimise(self._energy(active, begin, seen), pressed, enough)
        u = begin + step
        imbalance = np.full(len(u), np.inf)
        history: list[tuple[float, float]] = []
        for refresh in range(REFRESHES):
            # A rotation of a radian or a shift by the pin circle's radius is not a small motion: the pose has
            # failed and keeps its start.
            gone = ~(np.max(np.abs(u[active] / self.support.arm), axis=-1) < 1.0)
            u[active[gone]] = begin[active[gone]]
            found = self._gaps(active, u, seen.foot[active])
            gone |= np.any(np.isnan(found.gap), axis=(1, 2))
            outcome[active[gone]] = _LOST
            seen.put(active, found)
            problem = self._energy(active, u, found)
            point = problem.at(np.zeros_like(u[active]))
            imbalance[active] = problem.imbalance(point)
            history.append((float(np.max(point.force)), float(np.max(_deformation(point)))))
            todo = ~gone & ~(imbalance[active] < self._tolerance(active))
            if not np.any(todo):
                break
            problem, active = problem.poses(todo), active[todo]
            step, self.load[active] = minimise(problem, np.zeros_like(u[active]), enough)
            # An unloaded disc within its play, pressed from both sides, can swing between two positions.
            u[active] += step if refresh < WHOLE_STEPS else 0.5 * step
        short = (outcome < _NO_CONTACT) & ~(imbalance < self._tolerance(np.arange(len(u))))
        outcome[short] = _NOT_CONVERGED
        return u, history

    def _unknowns(self, place: StagePositions) -> FloatArray:
        """Unknowns u of the positions ``place``."""
        u = np.zeros_like(self.support.rigid_motion)
        u[:, self.support.disc_unknowns] = place.motion
        u[:, 0] = place.rotation
        if place.tilt is not None:
            u[:, self.support.tilt_unknowns] = place.tilt
        return u

    def _tolerance(self, active: IntArray) -> FloatArray:
        """Largest permissible imbalance of each pose."""
        floor = _ROUNDING_FORCE * self.case.drive.trochoid.pin_circle_radius / np.abs(self.torque[active])
        tolerance: FloatArray = self.tolerance + floor if self.tolerance > 0.0 else np.zeros_like(floor)
        return tolerance

    def _gaps(self, active: IntArray, u: FloatArray, start: FloatArray | None) -> Gaps:
        """Exact gaps at the active poses, each disc with its own tooth where they differ."""
        deviations, case = self.deviations, self.case
        meshing = self.meshing.poses(active)
        motion = self.support.motion(u[active])
        shift, turn = motion[..., 0] + 1j * motion[..., 1], motion[..., 2]
        radius = case.drive.pin_radius + (0.0 if deviations.pin_oversize is None else deviations.pin_oversize)
        pins = 0.0 if deviations.pin_shift is None else deviations.pin_shift
        if deviations.teeth is None:
            return gaps(case.profile, radius, meshing, shift, turn, pins, start)
        discs = [
            gaps(
                tooth,
                radius,
                meshing.disc(j),
                shift[:, j : j + 1],
                turn[:, j : j + 1],
                pins,
                None if start is None else start[:, j : j + 1],
            )
            for j, tooth in enumerate(deviations.teeth)
        ]
        return Gaps.of_discs(discs)

    def _rigid_touch(self) -> tuple[FloatArray, Gaps, IntArray]:
        """Turn carrier and discs as one, bearings unstretched, until the first pin of any disc touches."""
        support = self.support
        u = np.zeros_like(support.rigid_motion)
        active = np.arange(len(u))
        seen = self._gaps(active, u, None)
        outcome = np.full(len(u), _NO_CONTACT)
        for _ in range(_TOUCH_STEPS):
            turn = self._to_touch(active, seen)
            touching = (np.abs(turn) < _TOUCHED) & ~np.any(np.isnan(seen.gap[active]), axis=(1, 2))
            outcome[active[touching]] = _CONVERGED
            active, turn = active[~touching], turn[~touching]
            if not active.size:
                break
            step = self.direction[active] * _finite(turn)
            u[active] += support.rigid_motion[active] * step[:, np.newaxis]
            seen.put(active, self._gaps(active, u, seen.foot[active]))
        overlap = np.min(seen.gap, axis=(1, 2)) < -OVERLAP_TOLERANCE
        outcome[overlap & (outcome == _CONVERGED)] = _INTERFERENCE
        return u, seen, outcome

    def _to_touch(self, active: IntArray, seen: Gaps) -> FloatArray:
        """Turn of carrier and discs as one, in the sense of the torque, that closes the first pin of the active
        poses, its gap linear; infinite where none can be closed, shape (active,) [rad]."""
        along = self.support.motion(self.support.rigid_motion[active])[:, :, np.newaxis]
        n, gap = seen.normal[active], seen.gap[active]
        arm = n.real * along[..., 0] + n.imag * along[..., 1] + seen.lever[active] * along[..., 2]
        sense = self.direction[active, np.newaxis, np.newaxis]
        turn: FloatArray = np.min(closing_turn(self.case.profile, gap, sense * arm), axis=(1, 2))
        return turn

    def _overclosure(self) -> FloatArray:
        """A rotation that surely closes several pins, shape (poses,) [rad]."""
        drive = self.case.drive
        per_disc = np.abs(self.torque) / drive.discs / drive.trochoid.longest_lever
        delta = self.case.law.approach(per_disc, self.case.line_contact(np.zeros_like(per_disc)))
        return self.direction * delta / drive.trochoid.longest_lever

    def _energy(self, active: slice | IntArray, u: FloatArray, found: Gaps) -> StageEnergy:
        elastic = self.compliance[active], self.load[active]
        return StageEnergy.about(self.case, self.support.poses(active), found, u[active], self.torque[active], *elastic)

    def _supports_receded(self) -> FloatArray:
        """How far the supports give way at the pins, shape (poses, discs, pins) [mm]."""
        shape = self.meshing.phase.shape
        found = np.zeros((shape[0], shape[1] * shape[2]))
        for one in self.case.supports.matrices(self.case.drive, self.meshing).values():
            found += np.einsum("pij,pj->pi", one[:, : found.shape[1]], self.load)
        return found.reshape(shape)

    def _sharing(
        self,
        u: FloatArray,
        touch: FloatArray,
        gap_at_touch: FloatArray,
        outcome: IntArray,
        seen: Gaps,
        history: Sequence[tuple[float, float]] = (),
    ) -> LoadSharing:
        problem = self._energy(slice(None), u, seen)
        point = problem.at(np.zeros_like(u))
        receded = point.receded - self._supports_receded()
        sense = self.direction[:, np.newaxis, np.newaxis]
        bearings = point.bearing_force.reshape(len(u), self.case.drive.discs, -1, 2)
        deformation = _deformation(point._replace(receded=receded))
        approach = np.maximum(point.approach, 0.0)
        if point.tilt is not None:
            # The middle of a pin that carries at an edge alone may be clear of the tooth.
            approach = np.where(point.force > 0.0, point.approach, 0.0)
        return LoadSharing(
            case=self.case,
            solver="stage",
            crank_angle=self.meshing.crank_angle[:, 0],
            torque=self.torque,
            phase=sense * self.meshing.phase,
            gap=gap_at_touch,
            approach=approach,
            receded=receded,
            force=point.force,
            pressure=self.case.law.peak_pressure(point.force, problem.contact),
            lever=sense * problem.lever,
            curvature=problem.contact.curvature,
            pin_stiffness=point.stiffness,
            rotation=u[:, 0],
            touch=touch,
            torsional_stiffness=_torsional_stiffness(problem, point) if self._stiffness else np.full(len(u), np.nan),
            residual=problem.imbalance(point),
            outcome=outcome,
            max_force=float(np.max(point.force)),
            deformation=deformation,
            history=tuple(history) or ((float(np.max(point.force)), float(np.max(deformation))),),
            stage=StageMotion(
                meshing=self.meshing,
                motion=self.support.motion(u),
                foot=seen.foot,
                normal=problem.normal_x + 1j * problem.normal_y,
                bearing_force=bearings[..., 0] + 1j * bearings[..., 1],
                energy=point.energy,
                tilt=None if problem.width is None else problem.width.slope,
            ),
        )


def _deformation(point: EnergyPoint) -> FloatArray:
    """Largest deformation of contact and elastic bodies together at a loaded pin, shape (poses,) [mm]."""
    both = np.where(point.force > 0.0, point.approach + point.receded, 0.0)
    return np.asarray(np.max(both, axis=(1, 2), initial=0.0))


def _finite(turn: FloatArray) -> FloatArray:
    """The turn, zero where there is none."""
    return np.where(np.isfinite(turn), turn, 0.0)


def _torsional_stiffness(problem: StageEnergy, point: EnergyPoint) -> FloatArray:
    """dT/dΘ at the equilibrium with every disc free to follow, shape (poses,) [N·mm/rad]."""
    hessian = problem.hessian(point)
    # A pose without gaps has no stiffness either, and must not stop the others.
    lost = np.any(np.isnan(hessian), axis=(1, 2))
    hessian[lost] = 0.0
    discs, coupling = hessian[:, 1:, 1:], hessian[:, 1:, :1]
    follow = solve_linear_compliance(discs, coupling, rcond=1e-12)
    stiffness: FloatArray = hessian[:, 0, 0] - np.sum(coupling * follow, axis=(1, 2))
    return np.where(lost, np.nan, stiffness)
