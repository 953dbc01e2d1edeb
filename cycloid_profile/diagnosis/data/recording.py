"""A measured file prepared for the diagnosis: ordered rows, reading errors removed, some rows held out."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray, IntArray
from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.data._drift import DRIFT_WIDTH, loop_drift, origin_drift, turn_drift
from cycloid_profile.diagnosis.data._loops import NEAR_ZERO, loop_noise, shown_friction, usable_rows
from cycloid_profile.diagnosis.data._reading_errors import errors_of_turn, gross_errors, reading_step
from cycloid_profile.diagnosis.data._smooth_forms import forms_of_scan, waves
from cycloid_profile.diagnosis.data.noise import Noise, estimate_noise, local_noise, run_starts
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.errors import MeasurementError
from cycloid_profile.measurement import (
    HYSTERESIS,
    LOST_MOTION_MAP,
    PROFILE_SCAN,
    TRANSMISSION_ERROR,
    Measurement,
    MeasurementKind,
)
from cycloid_profile.rig import (
    CurvePrediction,
    RegisteredScan,
    predict_curve,
    register_scan,
)
from cycloid_profile.units import DEGREE, UM

# Accuracy of the simulation in the unit of the column: docs/diagnosis.md, "Accuracy of the simulation".
SIMULATION_ACCURACY = {
    PROFILE_SCAN: 0.008,
    HYSTERESIS: 0.002,
    TRANSMISSION_ERROR: 0.02,
    LOST_MOTION_MAP: 0.001,
}
# Held-out rows come in blocks, so that correlated noise does not reach them from fitted rows.
_BLOCKS_PER_LOBE = 6
_BLOCKS_PER_TURN = 60  # of 6°, two thirds of a pin pitch of 40 pins
_LOOP_BLOCK = 5  # rows
_HELD_OUT = 5  # one block in five
# Rows of a scan from which neighbours are averaged: 0.02 mm on the flank of an RV-40E, a tenth of a contact width.
MOST_ROWS = 20_000
_GAP = 2.0  # times the usual length of a group: larger gaps separate groups
FEW_LOBES = 0.5  # share of the lobes: fewer show no waves round the disc
_FEW_ERRORS = 5  # up to this number, notes give their locations


@dataclass(frozen=True, eq=False)
class Recording:
    """A measured file and the properties known before any effect is fitted.

    ``rows``: rows in use, ordered along the disc, the angle or the loop. ``held_out``: mask of ``rows`` kept for the
    check. ``disc``: scanned disc, counted from 0. ``placed``: first registration of a scan.
    ``predicted``: first prediction of a curve. ``notes``: sentences about the data. ``lobes_covered``:
    number of lobes that a scan shows. ``drift``: standard deviation of a drift, of a curve or of the origin of a scan,
    from the middle to either end, in the unit of the column; 0 for none. ``drift_of_another_file``: another file of its
    kind shows the drift, these rows do not. ``later``: measured after changes of the specimen. ``pair``: number shared
    with the file of the other time that was measured in the same way; None without one. ``unnamed``: size of a smooth
    error of any form that both have in common, in the unit of the column.
    """

    measurement: Measurement
    disc: int
    rows: IntArray
    held_out: BoolArray
    noise: Noise
    notes: tuple[str, ...] = ()
    placed: RegisteredScan | None = None
    predicted: CurvePrediction | None = None
    lobes_covered: int = 0
    drift: float = 0.0
    drift_of_another_file: bool = False
    later: bool = False
    pair: int | None = None
    unnamed: float = 0.0

    @property
    def kind(self) -> MeasurementKind:
        """Kind of the file."""
        return self.measurement.kind

    @property
    def name(self) -> str:
        """Name of the file."""
        return self.measurement.name

    @property
    def unit(self) -> str:
        """Unit of residual and noise, such as ``um``."""
        return self.kind.unit

    @property
    def peak_torque_nm(self) -> float:
        """Largest torque of a loop, 0 of other files."""
        return float(np.max(np.abs(self.measurement["torque_nm"]))) if self.kind is HYSTERESIS else 0.0

    @property
    def shown_friction_nm(self) -> float:
        """Friction torque that opens a loop clearly, beyond what counts as zero torque; 0 of others."""
        friction = shown_friction(self.measurement) if self.kind is HYSTERESIS else 0.0
        return friction if friction > NEAR_ZERO * self.peak_torque_nm else 0.0

    @property
    def accuracy(self) -> float:
        """Declared accuracy of the simulation, in ``unit``."""
        return SIMULATION_ACCURACY[self.kind]

    @property
    def shown_drift(self) -> float:
        """Drift that the rows show, from the middle to either end, in ``unit``."""
        return 0.0 if self.drift_of_another_file else self.drift / DRIFT_WIDTH

    def starts(self, chosen: BoolArray) -> BoolArray:
        """Mask of the ``chosen`` rows without a predecessor, shape (chosen rows,)."""
        # Omitted rows separate their neighbours: rows near zero torque, reading errors.
        return run_starts(np.flatnonzero(chosen)) | run_starts(self.rows[chosen])


_STATED = (1e-6, 1e6)  # in the unit of the column: a millionth of what any instrument resolves, and more than any reads


def record(reducer: AsBuiltReducer, measurement: Measurement, disc: int = 0) -> Recording:
    """Prepare a measured file.

    Raises
    ------
    MeasurementError
        If fewer than 8 rows can be compared with the prediction, the disc does not exist, or the stated noise is of no
        instrument.
    """
    stated, (least, most) = measurement.stated_noise, _STATED
    if stated is not None and not least <= stated <= most:
        limit = f"is outside {least:g} to {most:g}"
        raise MeasurementError(f"{measurement.name}: {measurement.kind.noise_key}", stated, limit, "check its unit")
    if measurement.kind is PROFILE_SCAN:
        return _scan_recording(reducer, measurement, disc)
    return _curve_recording(reducer, measurement)


def use_all_rows(recording: Recording) -> Recording:
    """The recording with all rows to fit."""
    return replace(recording, held_out=np.zeros_like(recording.held_out))


def for_validation_only(recording: Recording) -> Recording:
    """The recording with all rows held out."""
    return replace(recording, held_out=np.ones_like(recording.held_out))


def _scan_recording(reducer: AsBuiltReducer, measurement: Measurement, disc: int) -> Recording:
    if not 0 <= disc < reducer.discs:
        raise MeasurementError("disc", disc + 1, f"is not one of the {reducer.discs} discs", "count from 1")
    tooth = reducer.teeth[disc]
    placed = register_scan(tooth, measurement, thinned_rows(measurement.rows))
    along = np.mod(placed.along + np.pi, tooth.trochoid.phase_period)
    rows = np.argsort(along, kind="stable")
    notes = []
    spacing = np.diff(along[rows])
    repeated = np.concatenate([[False], spacing < 0.02 * float(np.median(spacing))])
    # Noise along the flank places points of a dense scan together by chance; they are averaged.
    if np.any(repeated) and rows.size < 2 * MOST_ROWS:
        notes.append(f"{np.count_nonzero(repeated)} points repeat a position and are omitted")
        rows = rows[~repeated]
    residual = placed.removal[rows] / UM
    erroneous = gross_errors(residual, local_noise(residual, np.arange(rows.size)).sigma)
    if np.any(erroneous):
        count = int(np.count_nonzero(erroneous))
        hit = ", ".join(str(n + 1) for n in np.unique(placed.lobe[rows[erroneous]].astype(int)))
        where = f", on lobe {hit}: a pit narrower than the point spacing looks the same" if count <= _FEW_ERRORS else ""
        notes.append(f"{count} reading errors are omitted{where}")
        rows = rows[~erroneous]
    if rows.size > 2 and float(np.median(np.diff(np.unwrap(np.angle(placed.placed))))) > 0.0:
        notes.append("the points run anticlockwise; their order was reversed")
    stated = measurement.stated_noise
    cell = rows.size // MOST_ROWS
    if cell > 1:
        if stated is not None:
            stated = estimate_noise(residual[~erroneous], np.arange(rows.size), stated).averaged(cell).sigma
        notes.append(f"{rows.size} points are averaged in groups of {cell} neighbours")
        measurement = averaged_scan(measurement, placed, rows, cell)
        rows = np.arange(measurement.rows)
    keep = np.zeros(measurement.rows, dtype=bool)
    keep[rows] = True
    if cell > 1 or np.any(erroneous):
        placed = register_scan(tooth, measurement, keep, placed)
    along = np.mod(placed.along + np.pi, tooth.trochoid.phase_period)
    if cell > 1:
        rows = np.argsort(along, kind="stable")
    noise = estimate_noise(placed.removal[rows] / UM, np.arange(rows.size), stated)
    forms = forms_of_scan(tooth, along[rows], placed.lobe[rows], placed.foot[rows])
    # A disc bent by its clamping varies faster round the turn, but passes from lobe to lobe without a step.
    lobes = tooth.trochoid.lobes
    forms = np.hstack(
        [forms, waves([k * along[rows] / lobes for k in range(3, min(lobes // 2, tuned.LOW_ORDERS) + 1)])]
    )
    drift = origin_drift(placed.removal[rows] / UM, placed.normal[rows], rows, forms, noise)
    if drift:
        notes.append("the origin drifts from the first point to the last; its path is fitted with the effects")
    points = np.bincount(placed.lobe[rows].astype(int), minlength=lobes)
    # A lobe that was not scanned may contain a point of its neighbour, at the tip.
    covered = int(np.count_nonzero(points > 0.25 * np.median(points[points > 0])))
    if covered < lobes:
        notes.append(_partial_scan_note(covered, lobes))
    block = np.floor(along[rows] / (2.0 * np.pi) * _BLOCKS_PER_LOBE).astype(int)
    held_out = block % _HELD_OUT == 2
    return Recording(measurement, disc, rows, held_out, noise, tuple(notes), placed, lobes_covered=covered, drift=drift)


def _partial_scan_note(covered: int, lobes: int) -> str:
    """What a scan of ``covered`` lobes cannot show."""
    note = f"{lobes - covered} of {lobes} lobes were not scanned"
    if covered < FEW_LOBES * lobes:
        note += (
            f": {covered} lobes do not tell errors round the disc (runout, oval, pitch, wear of the wheel) from each"
            " other or from the form of all lobes; scan the whole disc"
        )
    return note


def thinned_rows(count: int, most: int = MOST_ROWS) -> BoolArray | None:
    """Mask of at most about ``most`` evenly spaced rows; None if there are no more."""
    if count < 2 * most:
        return None
    chosen = np.zeros(count, dtype=bool)
    chosen[:: count // most] = True
    return chosen


def averaged_scan(measurement: Measurement, placed: RegisteredScan, rows: IntArray, cell: int) -> Measurement:
    """The scan with ``cell`` neighbouring points each replaced by one with their mean position and mean removal.

    ``rows``: order along the disc. No group crosses a gap; its last points, fewer than ``cell``, are omitted. Groups
    stay in the order of measurement.
    """
    tooth = placed.tooth
    along = np.unwrap(placed.along[rows], period=tooth.trochoid.phase_period)
    gap = np.concatenate([[True], np.diff(along) > _GAP * cell * float(np.median(np.diff(along)))])
    run = np.cumsum(gap) - 1
    number = np.arange(rows.size) - np.flatnonzero(gap)[run]
    size = np.bincount(run)
    kept = number < (size[run] // cell) * cell
    middle = along[kept].reshape(-1, cell).mean(axis=1)
    removal = placed.removal[rows][kept].reshape(-1, cell).mean(axis=1)
    lobe = np.round(middle / (2.0 * np.pi))
    phase, which = middle - 2.0 * np.pi * lobe, np.mod(lobe, tooth.trochoid.lobes)
    # The mean of points on a curved flank lies inside it: the group is placed at its mean distance from the tooth.
    at = tooth.at(phase, None, None if tooth.identical_lobes else which)
    point = (at.position - removal * at.normal) * np.exp(-2j * np.pi * which / tooth.trochoid.lobes)
    z = point * np.exp(1j * placed.turn) + placed.shift
    z = z[np.argsort(rows[kept].reshape(-1, cell).min(axis=1))]
    return replace(measurement, columns={"x_mm": z.real, "y_mm": z.imag})


def _curve_recording(reducer: AsBuiltReducer, measurement: Measurement) -> Recording:
    predicted = predict_curve(reducer, measurement)
    residual = measurement.value - predicted.on_last_flank
    rows = np.arange(residual.size)
    notes = []
    if measurement.kind is HYSTERESIS:
        rows = rows[usable_rows(measurement)]
        block = rows // _LOOP_BLOCK
    else:
        angle = measurement["output_angle_deg"]
        if rows.size > 2 and float(np.median(np.diff(angle))) < 0.0:
            notes.append("the angles decrease; the rows were sorted")
        rows = np.argsort(angle, kind="stable")
        repeated = np.concatenate([[False], np.diff(angle[rows]) < 1e-9])
        if np.any(repeated):
            notes.append(f"{np.count_nonzero(repeated)} rows repeat an angle and are omitted")
            rows = rows[~repeated]
        block = np.floor(angle[rows] / 360.0 * _BLOCKS_PER_TURN).astype(int)
    rows, block = rows[np.isfinite(residual[rows])], block[np.isfinite(residual[rows])]
    if rows.size < 8:
        raise MeasurementError(
            f"{measurement.name}: rows to compare", rows.size, "are too few", "measure more rows, away from zero torque"
        )
    step = reading_step(measurement.value[rows])
    if measurement.kind is HYSTERESIS:
        erroneous = gross_errors(residual[rows], local_noise(residual[rows], rows).sigma, step)
        noise = loop_noise(reducer, residual[rows[~erroneous]], rows[~erroneous], measurement)
    else:
        angle = measurement["output_angle_deg"][rows] * DEGREE
        erroneous, filled = errors_of_turn(residual[rows], angle, reducer.case.drive.trochoid, step)
        # Gaps would cut the rows into runs too short to show waves of the mesh as lines.
        noise = estimate_noise(filled, rows, measurement.stated_noise)
    if np.any(erroneous):
        notes.append(f"{np.count_nonzero(erroneous)} reading errors are omitted")
        rows, block = rows[~erroneous], block[~erroneous]
    drift = _drift(reducer, measurement, residual[rows], rows, noise)
    held_out = block % _HELD_OUT == 2
    found = Recording(measurement, 0, rows, held_out, noise, tuple(notes), predicted=predicted, drift=drift)
    return replace(found, notes=(*notes, *_drift_note(found)))


def _drift_note(recording: Recording) -> list[str]:
    if not recording.drift:
        return []
    note = "the rows drift from the first to the last; their drift is fitted with the effects"
    times = recording.shown_drift / recording.noise.sigma
    if times > tuned.DRIFT:
        note = f"{note}; it is {times:.0f} times the noise: parts creep or warm up, or the instrument does"
    return [note]


def _drift(
    reducer: AsBuiltReducer, measurement: Measurement, residual: FloatArray, rows: IntArray, noise: Noise
) -> float:
    """Prior width of the drift of a curve, in the unit of its column."""
    if measurement.kind is HYSTERESIS:
        return loop_drift(residual, measurement["torque_nm"][rows], rows, noise)
    trochoid = reducer.case.drive.trochoid
    multiples = np.concatenate([np.arange(1, 4) * count for count in (trochoid.lobes, trochoid.pins)])
    return turn_drift(residual, measurement["output_angle_deg"][rows] * DEGREE, noise, list(multiples))
