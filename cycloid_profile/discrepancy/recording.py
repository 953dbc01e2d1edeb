"""One measured file made ready: rows in order, gross errors out, some rows held back for the final check."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray, IntArray
from cycloid_profile.discrepancy.noise import Noise, gross_errors, local_noise, spectral_noise
from cycloid_profile.effects.built import Built
from cycloid_profile.errors import MeasurementError
from cycloid_profile.measurement.files import Measurement
from cycloid_profile.rig.gap import COLUMN, UNITS
from cycloid_profile.rig.prediction import AFLOAT, CurvePrediction, predict_curve
from cycloid_profile.rig.registration import PlacedScan, place_scan
from cycloid_profile.units import NEWTON_METRE, UM

# How far the model itself can be trusted, in the unit of the column: docs/diagnosis.md, "Accuracy of the simulation".
SIMULATION_ACCURACY = {
    "profile_scan": 0.008,
    "hysteresis": 0.002,
    "transmission_error": 0.02,
    "lost_motion_map": 0.001,
}
# Torques of a loop closer to zero than this share of the rated one are left out: friction decides which flank holds.
NEAR_ZERO = 0.05
# Friction takes part of the torque away before it loads the stage: what stays of a row must be clear of zero, too,
# with so much more friction than the branches of the loop are apart.
_FRICTION_MARGIN = 1.25
_MIDDLE = 0.3  # of the largest torque: where the branches are compared
# Nor is it sure how friction turns round: so much of the rated torque behind a turning point is left out.
NEAR_TURN = 0.05
_BLOCKS_PER_LOBE = 6
_BLOCKS_PER_TURN = 60
_LOOP_BLOCK = 5
_HELD_OUT = 5  # one block in so many
_FEW_ERRORS = 5  # so many are told with their places


@dataclass(frozen=True, eq=False)
class Recording:
    """A measured file with what is known of it before any effect is thought of.

    ``rows`` of the file that are used, in the order along the disc, the angle or the loop; ``held_out``, shape of
    ``rows``, true where they are kept for the check; ``disc`` scanned, counted from 0, and where it was first
    ``placed``, and whether its lobes are ``lobes_counted`` from the first one the effects know, which no scan of lobes
    alike tells by itself; of a curve what was first ``predicted``; ``notes``, sentences about the data.
    """

    measurement: Measurement
    disc: int
    rows: IntArray
    held_out: BoolArray
    noise: Noise
    notes: tuple[str, ...] = ()
    placed: PlacedScan | None = None
    predicted: CurvePrediction | None = None
    lobes_counted: bool = False

    @property
    def kind(self) -> str:
        """Kind of the file."""
        return self.measurement.kind

    @property
    def name(self) -> str:
        """Name of the file."""
        return self.measurement.name

    @property
    def unit(self) -> str:
        """Unit of residual and noise."""
        return UNITS[self.kind]

    @property
    def accuracy(self) -> float:
        """Declared accuracy of the simulation, in ``unit``."""
        return SIMULATION_ACCURACY[self.kind]

    def starts(self, chosen: BoolArray) -> BoolArray:
        """Of the ``chosen`` rows, those without a neighbour before them; shape (chosen rows,)."""
        place = np.flatnonzero(chosen)
        return np.concatenate([[True], np.diff(place) > 1])


def record(built: Built, measurement: Measurement, disc: int = 0) -> Recording:
    """A file made ready.

    Raises
    ------
    MeasurementError
        If hardly any row can be compared with the prediction.
    """
    if measurement.kind == "profile_scan":
        return _of_scan(built, measurement, disc)
    return _of_curve(built, measurement)


def hold_nothing_out(recording: Recording) -> Recording:
    """The same with all rows to fit."""
    return replace(recording, held_out=np.zeros_like(recording.held_out))


def hold_all_out(recording: Recording) -> Recording:
    """The same with all rows for the check."""
    return replace(recording, held_out=np.ones_like(recording.held_out))


def _of_scan(built: Built, measurement: Measurement, disc: int) -> Recording:
    if not 0 <= disc < built.discs:
        raise MeasurementError("disc", disc + 1, f"is not one of the {built.discs} discs", "count from 1")
    tooth = built.teeth[disc]
    placed = place_scan(tooth, measurement)
    along = np.mod(placed.along + np.pi, tooth.trochoid.phase_period)
    rows = np.argsort(along, kind="stable")
    notes = []
    spacing = np.diff(along[rows])
    repeated = np.concatenate([[False], spacing < 0.02 * float(np.median(spacing))])
    if np.count_nonzero(repeated):
        notes.append(f"{np.count_nonzero(repeated)} points stand where another does and are left out")
        rows = rows[~repeated]
    residual = placed.removal[rows] / UM
    wild = gross_errors(residual, local_noise(residual, np.arange(rows.size)).sigma)
    if np.any(wild):
        count = int(np.count_nonzero(wild))
        hit = ", ".join(str(n + 1) for n in np.unique(placed.lobe[rows[wild]].astype(int)))
        where = f", on lobe {hit}: a pit between two points looks like that" if count <= _FEW_ERRORS else ""
        notes.append(f"{count} gross errors of reading are left out{where}")
        rows = rows[~wild]
        keep = np.zeros(along.size, dtype=bool)
        keep[rows] = True
        placed = place_scan(tooth, measurement, keep, placed)
    noise = spectral_noise(placed.removal[rows] / UM, measurement.number("noise_um"))
    points = np.bincount(placed.lobe[rows].astype(int), minlength=tooth.trochoid.lobes)
    # A lobe that was not scanned may still have a point of its neighbour at its tip.
    lobes = int(np.count_nonzero(points > 0.25 * np.median(points[points > 0])))
    if lobes < tooth.trochoid.lobes:
        notes.append(f"{tooth.trochoid.lobes - lobes} of {tooth.trochoid.lobes} lobes were not scanned")
    if rows.size > 2 and float(np.median(np.diff(np.unwrap(np.angle(placed.placed))))) > 0.0:
        notes.append("the points run anticlockwise; they were put in the order of the disc")
    block = np.floor(along[rows] / (2.0 * np.pi) * _BLOCKS_PER_LOBE).astype(int)
    return Recording(measurement, disc, rows, block % _HELD_OUT == 2, noise, tuple(notes), placed)


def _settled_rows(torque: FloatArray, angle: FloatArray, rated: float) -> BoolArray:
    """Rows of a loop away from zero torque, and from where the torque turned back: friction is on its way there."""
    way = np.sign(np.diff(torque, prepend=torque[0]))
    least = max(NEAR_ZERO * rated, AFLOAT * rated + _FRICTION_MARGIN * _friction(torque, angle, way))
    turned = np.full(torque.size, np.inf)
    for i in range(1, torque.size):
        back = way[i] * way[i - 1] < 0.0
        turned[i] = torque[i - 1] if back else turned[i - 1]
    near: BoolArray = np.abs(torque - turned) < NEAR_TURN * rated
    return (np.abs(torque) >= least) & ~near


def _friction(torque: FloatArray, angle: FloatArray, way: FloatArray) -> float:
    """Half of what the branches of a loop are apart in torque about its middle; 0 without two branches."""
    middle = np.abs(torque) < _MIDDLE * float(np.max(np.abs(torque)))
    up, down = ((way == sign) & middle for sign in (1.0, -1.0))
    if np.count_nonzero(up) < 2 or np.count_nonzero(down) < 2:
        return 0.0
    order = np.argsort(angle[up], kind="stable")
    both = down & (angle >= angle[up][order[0]]) & (angle <= angle[up][order[-1]])
    if not np.any(both):
        return 0.0
    risen = np.interp(angle[both], angle[up][order], torque[up][order])
    return max(0.5 * float(np.median(risen - torque[both])), 0.0)


def _of_curve(built: Built, measurement: Measurement) -> Recording:
    predicted = predict_curve(built, measurement)
    residual = measurement[COLUMN[measurement.kind]] - predicted.value
    rows = np.arange(residual.size)
    notes = []
    if measurement.kind == "hysteresis":
        rows = rows[
            _settled_rows(measurement["torque_nm"], measurement["angle_arcmin"], abs(built.case.torque) / NEWTON_METRE)
        ]
        block = rows // _LOOP_BLOCK
    else:
        angle = measurement["output_angle_deg"]
        if rows.size > 2 and float(np.median(np.diff(angle))) < 0.0:
            notes.append("the angles fall from row to row; they were put in rising order")
        rows = np.argsort(angle, kind="stable")
        repeated = np.concatenate([[False], np.diff(angle[rows]) < 1e-9])
        if np.any(repeated):
            notes.append(f"{np.count_nonzero(repeated)} rows repeat an angle and are left out")
            rows = rows[~repeated]
        block = np.floor(angle[rows] / 360.0 * _BLOCKS_PER_TURN).astype(int)
    rows, block = rows[np.isfinite(residual[rows])], block[np.isfinite(residual[rows])]
    if rows.size < 8:
        raise MeasurementError(
            f"{measurement.name}: rows to compare", rows.size, "are too few", "measure more rows, away from zero torque"
        )
    wild = gross_errors(residual[rows], local_noise(residual[rows], rows).sigma)
    if np.any(wild):
        notes.append(f"{np.count_nonzero(wild)} gross errors of reading are left out")
        rows, block = rows[~wild], block[~wild]
    stated = measurement.number(f"noise_{UNITS[measurement.kind]}")
    if measurement.kind == "hysteresis":
        noise = local_noise(residual[rows], rows, stated)
    else:
        noise = spectral_noise(residual[rows], stated)
    return Recording(measurement, 0, rows, block % _HELD_OUT == 2, noise, tuple(notes), predicted=predicted)
