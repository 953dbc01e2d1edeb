"""What the rig predicts at the very rows of a measured curve, with the equilibria behind it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray, IntArray
from cycloid_profile.contact.sharing import LoadSharing, StagePlace
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.effects.built import Built
from cycloid_profile.errors import MeasurementError
from cycloid_profile.measurement.files import Measurement
from cycloid_profile.rig.alike_poses import AlikePoses, alike_poses
from cycloid_profile.rig.hysteresis import stage_torque
from cycloid_profile.units import ARCMIN, ARCSEC, DEGREE, NEWTON_METRE

# Inside the backlash the angle is whatever the last push left: these torques are not compared.
AFLOAT = 0.03
# Balance of forces over the torque: what is left of it turns the output by a millionth of an arc second.
_QUICK_TOLERANCE = 1e-7
CURVE_UNITS = {"hysteresis": ARCMIN, "transmission_error": ARCSEC, "lost_motion_map": ARCMIN}


@dataclass(frozen=True, eq=False)
class Term:
    """One angle of which a row is made: ``weight`` times the angle read at ``output_angle`` [rad].

    ``sharing`` is the equilibrium of the poses that are ``alike`` no other, a row being one pose; ``through`` the
    torque that winds up what stands in series [N·mm]; ``settled`` where there is an equilibrium to compare with.
    """

    weight: float
    sharing: LoadSharing
    alike: AlikePoses
    output_angle: FloatArray
    through: FloatArray
    settled: BoolArray

    def angle(self, built: Built) -> FloatArray:
        """Angle the encoder reads, NaN where not settled, shape (rows,) [rad]."""
        turned = np.where(self.settled, self.sharing.rotation[self.alike.of], np.nan)
        read: FloatArray = (
            turned + built.series_compliance * self.through + (built.encoder * np.exp(-1j * self.output_angle)).real
        )
        return read

    def place(self, rows: IntArray) -> StagePlace:
        """Where the stage rests in some rows."""
        alike, used = self.alike.at(rows)
        return alike.place(self.sharing.place.poses(used), self.sharing.case.drive.trochoid.pins)

    def at(self, rows: IntArray) -> Term:
        """The same at some of its rows."""
        alike, used = self.alike.at(rows)
        return replace(
            self,
            sharing=_part(self.sharing, used),
            alike=alike,
            output_angle=self.output_angle[rows],
            through=self.through[rows],
            settled=self.settled[rows],
        )


@dataclass(frozen=True, eq=False)
class CurvePrediction:
    """Predicted column at some ``rows`` of the file: ``value`` in the unit of the column, shape (rows,), and the
    ``terms`` it is made of.
    """

    built: Built
    measurement: Measurement
    rows: IntArray
    value: FloatArray
    terms: tuple[Term, ...]

    @property
    def unit(self) -> float:
        """Radians in the unit of the column."""
        return CURVE_UNITS[self.measurement.kind]

    def at(self, rows: IntArray) -> CurvePrediction:
        """The same at some of the rows of the file, which must all have been predicted."""
        where = np.full(int(np.max(self.rows, initial=0)) + 1, -1, dtype=np.intp)
        where[self.rows] = np.arange(self.rows.size)
        some = where[rows]
        return replace(self, rows=rows, value=self.value[some], terms=tuple(term.at(some) for term in self.terms))


@dataclass(frozen=True, eq=False)
class _Leg:
    """A term before it is solved: ``pressed``, torque on the stage, where it floats one that does not matter."""

    weight: float
    output_angle: FloatArray
    pressed: FloatArray
    through: FloatArray
    afloat: BoolArray

    def solved(self, sharing: LoadSharing, alike: AlikePoses) -> Term:
        settled = sharing.settled[alike.of] & ~self.afloat
        return Term(self.weight, sharing, alike, self.output_angle, self.through, settled)


def predict_curve(built: Built, measurement: Measurement, rows: IntArray | None = None) -> CurvePrediction:
    """The angle column of a loop, transmission error or lost motion map; a zero of the angle is not taken off.

    At some ``rows`` or at all of them. Rows of a loop at which the stage floats in its backlash are NaN.

    Raises
    ------
    MeasurementError
        If the torque of the file is zero.
    """
    every = np.arange(next(iter(measurement.columns.values())).size)
    (found,) = predict_curves(built, [(measurement, every if rows is None else rows)])
    return found


def predict_curves(
    built: Built, asked: Sequence[tuple[Measurement, IntArray]], near: Sequence[CurvePrediction] | None = None
) -> list[CurvePrediction]:
    """The same for several files, each at some of its rows: all are solved together, which costs least.

    ``near``, the same rows predicted for a slightly different reducer, saves half of it; the answers are those of a
    search from the beginning to a millionth of an arc second.
    """
    legs = [_legs(built, measurement, rows) for measurement, rows in asked]
    flat = [leg for own in legs for leg in own]
    if not flat:
        return []
    # Of poses that are alike one is solved.
    alike = [alike_poses(built, leg.output_angle, leg.pressed) for leg in flat]
    solved = [some for some, _ in alike]
    angle = np.concatenate([leg.output_angle[some] for leg, some in zip(flat, solved, strict=True)])
    pressed = np.concatenate([leg.pressed[some] for leg, some in zip(flat, solved, strict=True)])
    together = _solved(built, angle, pressed, None if near is None else _place(near, solved))
    ends = np.cumsum([some.size for some in solved])
    shares = (_part(together, slice(end - some.size, end)) for some, end in zip(solved, ends, strict=True))
    settled = (leg.solved(share, own) for leg, share, (_, own) in zip(flat, shares, alike, strict=True))
    found = []
    for (measurement, rows), own in zip(asked, legs, strict=True):
        terms = tuple(next(settled) for _ in own)
        value = sum(term.weight * term.angle(built) for term in terms) / CURVE_UNITS[measurement.kind]
        found.append(CurvePrediction(built, measurement, rows, np.asarray(value), terms))
    return found


def _solved(built: Built, angle: FloatArray, torque: FloatArray, near: StagePlace | None) -> LoadSharing:
    """The stage at angles of the output [rad] under torques [N·mm]."""
    crank = -angle * built.case.drive.trochoid.lobes
    if near is not None:
        quick = StageEquilibrium(tolerance=_QUICK_TOLERANCE, as_built=built.parts)
        found = quick.at(built.case, crank, torque, near)
        if found.converged:
            return found
    return StageEquilibrium(as_built=built.parts).at(built.case, crank, torque)


def _place(near: Sequence[CurvePrediction], rows: Sequence[IntArray]) -> StagePlace:
    """Where the stage rests in some ``rows`` of each term of some predictions."""
    terms = [term for one in near for term in one.terms]
    places = [term.place(some) for term, some in zip(terms, rows, strict=True)]
    feet = [place.foot for place in places if place.foot is not None]
    return StagePlace(
        np.concatenate([place.rotation for place in places]),
        np.concatenate([place.motion for place in places]),
        np.concatenate(feet) if len(feet) == len(places) else None,
    )


def torque_before(measurement: Measurement) -> float:
    """Sign of the push before the first row of a loop, which starts at zero: it came from the other way."""
    torque = measurement["torque_nm"]
    return -1.0 if torque[min(1, torque.size - 1)] >= torque[0] else 1.0


def _legs(built: Built, measurement: Measurement, rows: IntArray) -> list[_Leg]:
    never = np.zeros(rows.size, dtype=bool)
    if measurement.kind == "hysteresis":
        # What friction leaves depends on the whole path.
        path = measurement["torque_nm"] * NEWTON_METRE
        left = stage_torque(path, built.coulomb_torque, built.proportional_friction, torque_before(measurement))[rows]
        angle = np.full(rows.size, (measurement.number("output_angle_deg") or 0.0) * DEGREE)
        least = AFLOAT * abs(built.case.torque)
        afloat = np.abs(left) < least
        return [_Leg(1.0, angle, np.where(afloat, least, left), left, afloat)]
    angle = measurement["output_angle_deg"][rows] * DEGREE
    torque = np.full(rows.size, _torque(measurement))
    there = _Leg(1.0, angle, torque, torque, never)
    return [there, _Leg(-1.0, angle, -torque, -torque, never)] if measurement.kind == "lost_motion_map" else [there]


def _part(sharing: LoadSharing, which: slice | IntArray) -> LoadSharing:
    """The load at some of the poses."""
    arrays: dict[str, Any] = {
        field.name: getattr(sharing, field.name)[which]
        for field in fields(sharing)
        if isinstance(getattr(sharing, field.name), np.ndarray)
    }
    stage = sharing.stage
    if stage is not None:
        names = ("motion", "foot", "normal", "bearing_force", "energy")
        of_stage: dict[str, Any] = {name: getattr(stage, name)[which] for name in names}
        stage = replace(stage, meshing=stage.meshing.poses(which), **of_stage)
    return replace(sharing, **arrays, max_force=float(np.max(arrays["force"], initial=0.0)), stage=stage)


def _torque(measurement: Measurement) -> float:
    torque = (measurement.number("torque_nm") or 0.0) * NEWTON_METRE
    if torque == 0.0:
        raise MeasurementError(
            f"{measurement.name}: torque_nm", 0, "leaves the angle undefined within the backlash", "measure under load"
        )
    return torque
