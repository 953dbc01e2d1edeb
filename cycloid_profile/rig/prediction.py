"""Predicted column of a measured curve, row by row, with the equilibria behind it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import singledispatch
from typing import Any

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray, IntArray
from cycloid_profile.contact import LoadCase, LoadSharing, StagePositions, joined
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.errors import MeasurementError, SolveError
from cycloid_profile.measurement import Hysteresis, LostMotionMap, Measurement, MeasurementKind, TransmissionErrorCurve
from cycloid_profile.resources import Need
from cycloid_profile.rig._equivalent_poses import EquivalentPoses, equivalent_poses
from cycloid_profile.rig.hysteresis import UNLOADED_SHARE
from cycloid_profile.units import DEGREE, NEWTON_METRE

# Share of the largest torque of a loop below which a row is not compared: close to the backlash the preceding load
# decides the angle. Larger than ``UNLOADED_SHARE``, which only keeps a solve defined.
LEAST_COMPARED_SHARE = 0.03
# Imbalance of forces over the torque: it turns the output by a millionth of an arc second.
_QUICK_TOLERANCE = 1e-7
# Poses of a changed reducer that are tried first: a change without equilibrium in most of them is given up.
_PROBES = 16
_CONTACT_BYTES, _CONTACT_TIME = 650.0, 3e-5  # memory and s of one core for one pin in one pose, measured with 40 pins


@dataclass(frozen=True, eq=False)
class Term:
    """One term of a row: ``weight`` times the angle read at ``output_angle`` [rad].

    ``sharing`` is the equilibrium of the solved poses, ``equivalent`` maps rows to these; ``through`` the torque
    that friction leaves to the stage [N·mm] and ``twist`` what it twists in series [rad]; ``unloaded`` where the stage
    rests inside the backlash on the flank touched last.
    """

    weight: float
    sharing: LoadSharing
    equivalent: EquivalentPoses
    output_angle: FloatArray
    through: FloatArray
    twist: FloatArray
    unloaded: BoolArray

    def angle(self, reducer: AsBuiltReducer) -> FloatArray:
        """Encoder reading, NaN where the row has no equilibrium, shape (rows,) [rad]."""
        solved = self.equivalent.representative
        turned = np.where(self.sharing.settled[solved], self.sharing.rotation[solved], np.nan)
        read = reducer.angle_error(self.output_angle)
        return np.asarray(turned + self.twist + read)

    def place(self, rows: IntArray) -> StagePositions:
        """Positions of the parts of the stage in some rows."""
        equivalent, used = self.equivalent.at(rows)
        return equivalent.place(self.sharing.place.poses(used), self.sharing.case.drive.trochoid.pins)

    def at(self, rows: IntArray) -> Term:
        """The term at some of its rows."""
        equivalent, used = self.equivalent.at(rows)
        return replace(
            self,
            sharing=_at_poses(self.sharing, used),
            equivalent=equivalent,
            output_angle=self.output_angle[rows],
            through=self.through[rows],
            twist=self.twist[rows],
            unloaded=self.unloaded[rows],
        )


@dataclass(frozen=True, eq=False)
class CurvePrediction:
    """Predicted column at some ``rows`` of the file and the ``terms`` that it is the sum of.

    ``value`` in the unit of the column, NaN inside the backlash; ``on_last_flank``, the same with the stage on the
    flank touched last there, NaN without equilibrium; shape (rows,).
    """

    reducer: AsBuiltReducer
    measurement: Measurement
    rows: IntArray
    value: FloatArray
    on_last_flank: FloatArray
    terms: tuple[Term, ...]

    @property
    def unit(self) -> float:
        """Radians in the unit of the column."""
        return self.measurement.kind.unit_size

    def at(self, rows: IntArray) -> CurvePrediction:
        """The prediction at some rows of the file, all of which must have been predicted."""
        where = np.full(int(np.max(self.rows, initial=0)) + 1, -1, dtype=np.intp)
        where[self.rows] = np.arange(self.rows.size)
        some = where[rows]
        return replace(
            self,
            rows=rows,
            value=self.value[some],
            on_last_flank=self.on_last_flank[some],
            terms=tuple(term.at(some) for term in self.terms),
        )


@dataclass(frozen=True, eq=False)
class _UnsolvedTerm:
    """A ``Term`` before its solve: ``solved_torque``, torque on the stage [N·mm], a small substitute where
    ``unloaded``.
    """

    weight: float
    output_angle: FloatArray
    solved_torque: FloatArray
    through: FloatArray
    twist: FloatArray
    unloaded: BoolArray

    def solved(self, sharing: LoadSharing, equivalent: EquivalentPoses) -> Term:
        return Term(self.weight, sharing, equivalent, self.output_angle, self.through, self.twist, self.unloaded)


def curve_need(what: str, rows: int, case: LoadCase, joint: str = " = ") -> Need:
    """What a curve of so many ``rows`` needs: each is an equilibrium, which is kept."""
    pins = case.drive.trochoid.pins
    contacts = rows * pins
    value = f"{rows:,} with {pins} pins"
    return Need(what, value, "take fewer rows", _CONTACT_BYTES * contacts, time=_CONTACT_TIME * contacts, joint=joint)


def predict_curve(reducer: AsBuiltReducer, measurement: Measurement, rows: IntArray | None = None) -> CurvePrediction:
    """Measured column of a loop, transmission error or lost motion map as predicted, without subtraction of the zero
    offset.

    At some ``rows`` or at all of them. Rows of a loop below ``LEAST_COMPARED_SHARE`` are NaN.

    Raises ``MeasurementError`` if the torque of the file is zero, ``ResourceError`` if it has too many rows.
    """
    (found,) = predict_curves(reducer, [(measurement, np.arange(measurement.rows) if rows is None else rows)])
    return found


def predict_curves(
    reducer: AsBuiltReducer,
    asked: Sequence[tuple[Measurement, IntArray]],
    near: Sequence[CurvePrediction] | None = None,
) -> list[CurvePrediction]:
    """``predict_curve`` of several files, each at some of its rows, in one solve, for speed.

    ``near``, the same rows predicted for a slightly different reducer, halves the time; the result equals that of a
    full search to a millionth of an arc second. Raises ``SolveError`` where most of these have no equilibrium.
    """
    names = ", ".join(measurement.name or "file" for measurement, _ in asked)
    curve_need(f"{names}: rows", sum(rows.size for _, rows in asked), reducer.case).require()
    by_file = [_terms(measurement.kind, reducer, measurement, rows) for measurement, rows in asked]
    unsolved = [term for terms in by_file for term in terms]
    if not unsolved:
        return []
    poses = [equivalent_poses(reducer, term.output_angle, term.solved_torque) for term in unsolved]
    solved = [some for some, _ in poses]
    angle = np.concatenate([term.output_angle[some] for term, some in zip(unsolved, solved, strict=True)])
    solved_torque = np.concatenate([term.solved_torque[some] for term, some in zip(unsolved, solved, strict=True)])
    together = _equilibria(
        reducer, angle, solved_torque, None if near is None else _starting_configuration(near, solved)
    )
    ends = np.cumsum([some.size for some in solved])
    shares = (_at_poses(together, slice(end - some.size, end)) for some, end in zip(solved, ends, strict=True))
    settled = (term.solved(share, own) for term, share, (_, own) in zip(unsolved, shares, poses, strict=True))
    found = []
    for (measurement, rows), own in zip(asked, by_file, strict=True):
        terms = tuple(next(settled) for _ in own)
        everywhere = np.asarray(sum(term.weight * term.angle(reducer) for term in terms) / measurement.kind.unit_size)
        unloaded = np.any([term.unloaded for term in terms], axis=0)
        value = np.where(unloaded, np.nan, everywhere)
        found.append(CurvePrediction(reducer, measurement, rows, value, everywhere, terms))
    return found


def preceding_sign(measurement: Measurement) -> float:
    """Sign (±1) of the load before a loop, which starts at zero torque: assumed opposite to its first load."""
    torque = measurement["torque_nm"]
    return -1.0 if torque[min(1, torque.size - 1)] >= torque[0] else 1.0


def loop_path(reducer: AsBuiltReducer, loop: Measurement) -> tuple[FloatArray, FloatArray]:
    """Torque on the stage [N·mm] and twist in series with it [rad], shape (rows,): both depend on the whole path."""
    applied = loop["torque_nm"] * NEWTON_METRE
    transmitted = reducer.stage_torque(applied, preceding_sign(loop))
    return transmitted, reducer.series_twist(transmitted, applied)


@singledispatch
def _terms(
    kind: MeasurementKind, reducer: AsBuiltReducer, measurement: Measurement, rows: IntArray
) -> list[_UnsolvedTerm]:
    """Angles whose weighted sum is the measured column of a curve."""
    raise NotImplementedError(f"a {kind.title} is no curve")


@_terms.register
def _loop_terms(
    _: Hysteresis, reducer: AsBuiltReducer, measurement: Measurement, rows: IntArray
) -> list[_UnsolvedTerm]:
    path, twisted = loop_path(reducer, measurement)
    transmitted, twist = path[rows], twisted[rows]
    angle = np.full(rows.size, (measurement.number("output_angle_deg") or 0.0) * DEGREE)
    peak = float(np.max(np.abs(measurement["torque_nm"]))) * NEWTON_METRE
    least, unloaded = UNLOADED_SHARE * peak, np.abs(transmitted) < LEAST_COMPARED_SHARE * peak
    solved = np.where(np.abs(transmitted) < least, least * _last_flank(path, measurement)[rows], transmitted)
    return [_UnsolvedTerm(1.0, angle, solved, transmitted, twist, unloaded)]


def _last_flank(transmitted: FloatArray, loop: Measurement) -> FloatArray:
    """Sign (±1) of the torque that last pressed on a flank, shape (rows,)."""
    touched = np.where(transmitted != 0.0, np.arange(transmitted.size), -1)
    last = np.maximum.accumulate(touched)
    return np.where(last < 0, preceding_sign(loop), np.sign(transmitted[last]))


@_terms.register
def _transmission_error_terms(
    _: TransmissionErrorCurve, reducer: AsBuiltReducer, measurement: Measurement, rows: IntArray
) -> list[_UnsolvedTerm]:
    return [_over_turn(reducer, measurement, rows, 1.0)]


@_terms.register
def _lost_motion_terms(
    _: LostMotionMap, reducer: AsBuiltReducer, measurement: Measurement, rows: IntArray
) -> list[_UnsolvedTerm]:
    return [_over_turn(reducer, measurement, rows, sign) for sign in (1.0, -1.0)]


def _over_turn(reducer: AsBuiltReducer, measurement: Measurement, rows: IntArray, sign: float) -> _UnsolvedTerm:
    """Angles at ``sign`` times the torque of the file, weighted by ``sign``."""
    torque = (measurement.number("torque_nm") or 0.0) * NEWTON_METRE
    if torque == 0.0:
        raise MeasurementError(
            f"{measurement.name}: torque_nm", 0, "leaves the angle undefined within the backlash", "measure under load"
        )
    load = np.full(rows.size, sign * torque)
    angle = measurement["output_angle_deg"][rows] * DEGREE
    return _UnsolvedTerm(sign, angle, load, load, reducer.series_twist(load), np.zeros(rows.size, dtype=bool))


def _equilibria(
    reducer: AsBuiltReducer, angle: FloatArray, torque: FloatArray, near: StagePositions | None
) -> LoadSharing:
    """The stage at angles of the output [rad] under torques [N·mm]."""
    crank, case = -angle * reducer.case.drive.trochoid.lobes, reducer.case
    full = StageEquilibrium(deviations=reducer.deviations)
    if near is None:
        return full.at(case, crank, torque)
    quick = StageEquilibrium(tolerance=_QUICK_TOLERANCE, deviations=reducer.deviations, stiffness=False)
    if crank.size > 2 * _PROBES:
        probes = np.linspace(0, crank.size - 1, _PROBES).astype(np.intp)
        _give_up_without_most(quick.at(case, crank[probes], torque[probes], near.poses(probes)))
    found = quick.at(case, crank, torque, near)
    if found.converged:
        return found
    _give_up_without_most(found)
    left = np.flatnonzero(~found.settled)
    both = joined([_at_poses(found, np.flatnonzero(found.settled)), full.at(case, crank[left], torque[left])])
    return _at_poses(both, np.argsort(np.concatenate([np.flatnonzero(found.settled), left])))


def _give_up_without_most(found: LoadSharing) -> None:
    if np.count_nonzero(found.settled) < 0.5 * found.settled.size:
        raise SolveError("reducer", found.status.value, "in most poses", "make the effects smaller", " ")


def _starting_configuration(near: Sequence[CurvePrediction], rows: Sequence[IntArray]) -> StagePositions:
    """Starting positions of the parts, from some ``rows`` of each term of earlier predictions."""
    terms = [term for one in near for term in one.terms]
    places = [term.place(some) for term, some in zip(terms, rows, strict=True)]
    return StagePositions(
        np.concatenate([place.rotation for place in places]),
        np.concatenate([place.motion for place in places]),
        *(_together([getattr(place, name) for place in places]) for name in ("foot", "load", "tilt")),
    )


def _together(parts: Sequence[FloatArray | None]) -> FloatArray | None:
    """The parts in one array, None if one is missing."""
    known = [part for part in parts if part is not None]
    return np.concatenate(known) if len(known) == len(parts) else None


def _at_poses(sharing: LoadSharing, which: slice | IntArray) -> LoadSharing:
    """The load at some of the poses."""
    arrays: dict[str, Any] = {
        field.name: getattr(sharing, field.name)[which]
        for field in fields(sharing)
        if isinstance(getattr(sharing, field.name), np.ndarray)
    }
    stage = sharing.stage
    return replace(
        sharing,
        **arrays,
        max_force=float(np.max(arrays["force"], initial=0.0)),
        stage=None if stage is None else stage.of_poses(which),
    )
