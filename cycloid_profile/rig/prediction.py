"""What the rig predicts at the very rows of a measured curve, with the equilibria behind it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.sharing import LoadSharing
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.effects.built import Built
from cycloid_profile.errors import MeasurementError
from cycloid_profile.measurement.files import Measurement
from cycloid_profile.rig.hysteresis import stage_torque
from cycloid_profile.units import ARCMIN, ARCSEC, DEGREE, NEWTON_METRE

# Inside the backlash the angle is whatever the last push left: these torques are not compared.
AFLOAT = 0.03
CURVE_UNITS = {"hysteresis": ARCMIN, "transmission_error": ARCSEC, "lost_motion_map": ARCMIN}


@dataclass(frozen=True, eq=False)
class Term:
    """One angle of which a row is made: ``weight`` times the angle read at ``output_angle`` [rad].

    ``sharing`` is the equilibrium there, a pose each row; ``through`` the torque that winds up what stands in series
    [N·mm]; ``settled`` where there is an equilibrium to compare with.
    """

    weight: float
    sharing: LoadSharing
    output_angle: FloatArray
    through: FloatArray
    settled: np.ndarray

    def angle(self, built: Built) -> FloatArray:
        """Angle the encoder reads, NaN where not settled, shape (rows,) [rad]."""
        turned = np.where(self.settled, self.sharing.rotation, np.nan)
        read: FloatArray = (
            turned + built.series_compliance * self.through + (built.encoder * np.exp(-1j * self.output_angle)).real
        )
        return read


@dataclass(frozen=True, eq=False)
class CurvePrediction:
    """Predicted column: ``value`` in the unit of the column, shape (rows,), and the ``terms`` it is made of."""

    built: Built
    measurement: Measurement
    value: FloatArray
    terms: tuple[Term, ...]

    @property
    def unit(self) -> float:
        """Radians in the unit of the column."""
        return CURVE_UNITS[self.measurement.kind]


def predict_curve(built: Built, measurement: Measurement) -> CurvePrediction:
    """The angle column of a loop, transmission error or lost motion map; a zero of the angle is not taken off.

    Rows of a loop at which the stage floats in its backlash are NaN.

    Raises
    ------
    MeasurementError
        If the torque of the file is zero.
    """
    if measurement.kind == "hysteresis":
        terms: tuple[Term, ...] = (_loop(built, measurement),)
    else:
        angle = measurement["output_angle_deg"] * DEGREE
        torque = np.full(angle.size, _torque(measurement))
        terms = (_term(built, 1.0, angle, torque),)
        if measurement.kind == "lost_motion_map":
            terms = (*terms, _term(built, -1.0, angle, -torque))
    value = sum(term.weight * term.angle(built) for term in terms) / CURVE_UNITS[measurement.kind]
    return CurvePrediction(built, measurement, np.asarray(value), terms)


def torque_before(measurement: Measurement) -> float:
    """Sign of the push before the first row of a loop, which starts at zero: it came from the other way."""
    torque = measurement["torque_nm"]
    return -1.0 if torque[min(1, torque.size - 1)] >= torque[0] else 1.0


def _loop(built: Built, measurement: Measurement) -> Term:
    torque = measurement["torque_nm"] * NEWTON_METRE
    angle = np.full(torque.size, (measurement.number("output_angle_deg") or 0.0) * DEGREE)
    left = stage_torque(torque, built.coulomb_torque, built.proportional_friction, torque_before(measurement))
    least = AFLOAT * abs(built.case.torque)
    afloat = np.abs(left) < least
    term = _term(built, 1.0, angle, np.where(afloat, least, left))
    return Term(1.0, term.sharing, angle, left, term.settled & ~afloat)


def _term(built: Built, weight: float, output_angle: FloatArray, torque: FloatArray) -> Term:
    crank = -output_angle * built.case.drive.trochoid.lobes
    solved = StageEquilibrium(as_built=built.parts).at(built.case, crank, torque)
    return Term(weight, solved, output_angle, torque, solved.settled)


def _torque(measurement: Measurement) -> float:
    torque = (measurement.number("torque_nm") or 0.0) * NEWTON_METRE
    if torque == 0.0:
        raise MeasurementError(
            f"{measurement.name}: torque_nm", 0, "leaves the angle undefined within the backlash", "measure under load"
        )
    return torque
