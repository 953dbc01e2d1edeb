"""One block of poses of a stage on its way to equilibrium, in numpy; ``near`` is a short cut to its answer."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray, IntArray
from cycloid_profile.contact.as_built import AsBuilt
from cycloid_profile.contact.backlash import OVERLAP_TOLERANCE, closing_turn
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.energy import EnergyPoint, StageEnergy, minimise
from cycloid_profile.contact.following import following
from cycloid_profile.contact.gap import Gaps, gaps
from cycloid_profile.contact.meshing import Meshing
from cycloid_profile.contact.near import REFRESHES, WHOLE_STEPS, settled_near
from cycloid_profile.contact.sharing import STATUSES, LoadSharing, StageMotion, StagePlace, Status
from cycloid_profile.contact.support import support_model

_TOUCH_STEPS = 40
_TOUCHED = 1e-12  # rad
# Rounding of the gaps, some 1e-14 mm, against a stiff contact: no balance comes closer than this.
_ROUNDING_FORCE = 1e-7  # N
_CONVERGED, _INTERFERENCE, _NO_CONTACT, _NOT_CONVERGED, _LOST = (STATUSES.index(s) for s in Status)


class StageBlock:
    """One block of poses on its way to equilibrium."""

    def __init__(
        self, case: LoadCase, as_built: AsBuilt, tolerance: float, meshing: Meshing, torque: FloatArray
    ) -> None:
        self.case, self.as_built, self.tolerance, self.torque = case, as_built, tolerance, torque
        self.direction = np.sign(torque)
        self.meshing = meshing
        self.support = support_model(case.drive, self.meshing.crank_angle, as_built)
        self.spring_matrix = self.support.spring_matrix

    def solved(self, near: StagePlace | None = None, compiled: bool = False) -> LoadSharing:
        """Every pose at equilibrium, or with the reason why it has none.

        ``near``, where the search begins; first touch is not looked for then. ``compiled``, from first touch on by the
        short cut where it can be taken, as it is beside ``near``.
        """
        if near is not None:
            outcome = np.full(len(self.torque), _CONVERGED)
            corners = any(tooth.corners for tooth in self.as_built.teeth or [self.case.profile])
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
        """By the short cut, its balances checked with exact gaps if wanted; the plain search takes the poses that it
        leaves. ``outcome`` is kept up to date.
        """
        everywhere, history = np.arange(len(begin)), list[tuple[float, float]]()
        rests = settled_near(
            self.case, self.as_built, self.meshing, self.support, self.torque, self._tolerance(everywhere),
            self._overclosure(), begin, foot,
        )  # fmt: skip
        if rests is None:
            return self._searched_from(begin, outcome)
        u, seen, settled = rests
        if check:
            settled[settled] = self._balanced(everywhere[settled], u, seen)
        left = everywhere[~settled]
        if left.size:
            others = StageBlock(self.case, self.as_built, self.tolerance, self.meshing.poses(left), self.torque[left])
            how = outcome[left]
            u[left], found, history = others._searched_from(begin[left], how)
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
        """By turns the convex problem and exact gaps, until every pose has arrived or is lost: the unknowns, and the
        largest force and approach of each turn. ``seen`` and ``outcome`` are kept up to date.
        """
        active = np.arange(len(begin))
        # Pressed together a little: Newton then has forces to balance from the start.
        pressed = self.support.rigid_motion * (to_touch + self._overclosure())[:, np.newaxis]
        enough = 0.1 * self.tolerance
        u = begin + minimise(self._energy(active, begin, seen), pressed, enough).step
        imbalance = np.full(len(u), np.inf)
        history: list[tuple[float, float]] = []
        for refresh in range(REFRESHES):
            # A turn by a radian or a shift by the pin circle's radius is no small motion: such a pose is lost,
            # and rests where it began.
            gone = ~(np.max(np.abs(u[active] / self.support.arm), axis=-1) < 1.0)
            u[active[gone]] = begin[active[gone]]
            found = self._gaps(active, u, seen.foot[active])
            gone |= np.any(np.isnan(found.gap), axis=(1, 2))
            outcome[active[gone]] = _LOST
            seen.put(active, found)
            problem = self._energy(active, u, found)
            point = problem.at(np.zeros_like(u[active]))
            imbalance[active] = problem.imbalance(point)
            history.append((float(np.max(point.force)), float(np.max(point.approach))))
            todo = ~gone & ~(imbalance[active] < self._tolerance(active))
            if not np.any(todo):
                break
            problem, active = problem.poses(todo), active[todo]
            step = minimise(problem, np.zeros_like(u[active]), enough).step
            # A disc afloat in its play and pressed from both sides can swing between two places.
            u[active] += step if refresh < WHOLE_STEPS else 0.5 * step
        short = (outcome < _NO_CONTACT) & ~(imbalance < self._tolerance(np.arange(len(u))))
        outcome[short] = _NOT_CONVERGED
        return u, history

    def _unknowns(self, place: StagePlace) -> FloatArray:
        """The unknowns of a place."""
        u = np.zeros_like(self.support.rigid_motion)
        u[:, self.support.disc_unknowns] = place.motion
        u[:, 0] = place.rotation
        return u

    def _tolerance(self, active: IntArray) -> FloatArray:
        """What the imbalance of each pose must fall below."""
        floor = _ROUNDING_FORCE * self.case.drive.trochoid.pin_circle_radius / np.abs(self.torque[active])
        tolerance: FloatArray = self.tolerance + floor if self.tolerance > 0.0 else np.zeros_like(floor)
        return tolerance

    def _gaps(self, active: IntArray, u: FloatArray, start: FloatArray | None) -> Gaps:
        """Exact gaps at the active poses, each disc with its own tooth where they differ."""
        as_built, case = self.as_built, self.case
        meshing = self.meshing.poses(active)
        motion = self.support.motion(u[active])
        shift, turn = motion[..., 0] + 1j * motion[..., 1], motion[..., 2]
        radius = case.drive.pin_radius + (0.0 if as_built.pin_oversize is None else as_built.pin_oversize)
        pins = 0.0 if as_built.pin_shift is None else as_built.pin_shift
        if as_built.teeth is None:
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
            for j, tooth in enumerate(as_built.teeth)
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

    def _energy(self, active: IntArray, u: FloatArray, found: Gaps) -> StageEnergy:
        support = self.support.poses(active)
        return StageEnergy(
            law=self.case.law,
            contact=self.case.line_contact(found.curvature),
            gap=found.gap,
            normal_x=found.normal.real.copy(),
            normal_y=found.normal.imag.copy(),
            lever=found.lever,
            disc_unknowns=support.disc_unknowns,
            spring_stretch=support.spring_stretch,
            spring_matrix=self.spring_matrix[active],
            stretch=support.misfit + np.einsum("psdu,pu->psd", support.spring_stretch, u[active]),
            bearing_stiffness=support.stiffness,
            play=support.play,
            torque=self.torque[active],
            rotation=u[active, 0],
            arm=support.arm,
        )

    def _sharing(
        self,
        u: FloatArray,
        touch: FloatArray,
        gap_at_touch: FloatArray,
        outcome: IntArray,
        seen: Gaps,
        history: Sequence[tuple[float, float]] = (),
    ) -> LoadSharing:
        problem = self._energy(np.arange(len(u)), u, seen)
        point = problem.at(np.zeros_like(u))
        sense = self.direction[:, np.newaxis, np.newaxis]
        bearings = point.bearing_force.reshape(len(u), self.case.drive.discs, -1, 2)
        return LoadSharing(
            case=self.case,
            solver="stage",
            crank_angle=self.meshing.crank_angle[:, 0],
            torque=self.torque,
            phase=sense * self.meshing.phase,
            gap=gap_at_touch,
            approach=np.maximum(point.approach, 0.0),
            force=point.force,
            pressure=self.case.law.peak_pressure(point.force, problem.contact),
            lever=sense * problem.lever,
            curvature=problem.contact.curvature,
            pin_stiffness=point.stiffness,
            rotation=u[:, 0],
            touch=touch,
            torsional_stiffness=_torsional_stiffness(problem, point),
            residual=problem.imbalance(point),
            outcome=outcome,
            max_force=float(np.max(point.force)),
            delta_max=float(np.max(point.approach, initial=0.0)),
            history=tuple(history) or ((float(np.max(point.force)), float(np.max(point.approach))),),
            stage=StageMotion(
                meshing=self.meshing,
                motion=self.support.motion(u),
                foot=seen.foot,
                normal=problem.normal_x + 1j * problem.normal_y,
                bearing_force=bearings[..., 0] + 1j * bearings[..., 1],
                energy=point.energy,
            ),
        )


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
    follow = following(discs, coupling, rcond=1e-12)
    stiffness: FloatArray = hessian[:, 0, 0] - np.sum(coupling * follow, axis=(1, 2))
    return np.where(lost, np.nan, stiffness)
