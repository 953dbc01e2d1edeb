"""A measured file prepared for the diagnosis: ordered rows, reading errors removed, some rows held out."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray, IntArray
from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.data._branches import contrasts_of_branches
from cycloid_profile.diagnosis.data._drift import DRIFT_WIDTH, loop_drift, origin_drift, turn_drift
from cycloid_profile.diagnosis.data._reading_errors import gross_errors, reading_step
from cycloid_profile.diagnosis.data._smooth_forms import forms_of_scan, waves
from cycloid_profile.diagnosis.data.noise import Noise, estimate_noise, local_noise, run_starts, scatter_about_cubics
from cycloid_profile.effects import AsBuiltReducer, transmitted_torque
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
    preceding_sign,
    predict_curve,
    register_scan,
)
from cycloid_profile.rig.hysteresis import UNLOADED_SHARE
from cycloid_profile.units import DEGREE, UM

# Accuracy of the simulation in the unit of the column: docs/diagnosis.md, "Accuracy of the simulation".
SIMULATION_ACCURACY = {
    PROFILE_SCAN: 0.008,
    HYSTERESIS: 0.002,
    TRANSMISSION_ERROR: 0.02,
    LOST_MOTION_MAP: 0.001,
}
# Rows of a loop with less than this share of its largest torque on the stage are omitted: it may touch either flank.
NEAR_ZERO = 0.05
FRICTION_MARGIN = 0.25  # of friction, which a loop shows to this share: the limit above is raised by it
_MIDDLE, _ANGLES = 0.3, 41  # share of the range of angles, and angles in it, at which the branches are compared
_RANGE = 0.02, 0.98  # of the rows: few reading errors are beyond
# Share of the largest torque after a reversal that is omitted: the friction law at reversals is uncertain.
NEAR_TURN = 0.05
# Held-out rows come in blocks, so that correlated noise does not reach them from fitted rows.
_BLOCKS_PER_LOBE = 6
_BLOCKS_PER_TURN = 60  # of 6°, two thirds of a pin pitch of 40 pins
_LOOP_BLOCK = 5  # rows
_HELD_OUT = 5  # one block in five
# Rows of a scan from which neighbours are averaged: 0.02 mm on the flank of an RV-40E, a tenth of a contact width.
MOST_ROWS = 20_000
_GAP = 2.0  # times the usual length of a group: larger gaps separate groups
FEW_LOBES = 0.5  # share of the lobes: fewer show no waves round the disc
_CHANCE = 0.05  # that contrasts of branches scatter so much less than rows of the same noise
_SMOOTHED = 0.85  # correlation of neighbours that no reading of a loop has
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
        friction = _friction(self.measurement) if self.kind is HYSTERESIS else 0.0
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


def _usable_rows(measurement: Measurement) -> BoolArray:
    """Rows of a loop whose stage is loaded and away from reversals, where friction changes sign."""
    torque, friction = measurement["torque_nm"], _friction(measurement)
    peak = float(np.max(np.abs(torque)))
    transmitted = transmitted_torque(torque, friction, 0.0, preceding_sign(measurement))
    near = torque_since_reversal(torque, load_direction(torque)) < NEAR_TURN * peak
    return (np.abs(transmitted) >= NEAR_ZERO * peak + FRICTION_MARGIN * friction) & ~near


def load_direction(torque: FloatArray) -> FloatArray:
    """Sign of the change of torque that leads to each row, 0 at the first; in the shape of ``torque``."""
    return np.asarray(np.sign(np.diff(torque, prepend=torque[0])))


def torque_since_reversal(torque: FloatArray, direction: FloatArray) -> FloatArray:
    """Torque passed since the ``direction`` of the load last changed its sign, infinite before; in their shape."""
    reversal = np.full(torque.size, np.inf)
    for i in range(1, torque.size):
        back = direction[i] * direction[i - 1] < 0.0
        reversal[i] = torque[i - 1] if back else reversal[i - 1]
    passed: FloatArray = np.abs(torque - reversal)
    return passed


def _friction(measurement: Measurement) -> float:
    """Friction torque: half the torque between the branches in the middle of the angles; 0 for one branch."""
    torque, angle = measurement["torque_nm"], measurement["angle_arcmin"]
    # Without torque either flank may touch: such a row is on the one of the branch before.
    direction = np.where(np.abs(torque) > UNLOADED_SHARE * np.max(np.abs(torque)), load_direction(torque), 0.0)
    low, high = np.quantile(angle, _RANGE)
    at = 0.5 * (low + high) + 0.5 * (high - low) * np.linspace(-_MIDDLE, _MIDDLE, _ANGLES)
    up, down = (_torque_at(at, torque[direction == sign], angle[direction == sign]) for sign in (1.0, -1.0))
    between = up - down
    known = np.isfinite(between)
    return max(0.5 * float(np.median(between[known])), 0.0) if np.any(known) else 0.0


def _torque_at(at: FloatArray, torque: FloatArray, angle: FloatArray) -> FloatArray:
    """Torque of a branch at some angles, linear between rows: across play, too; NaN beyond the branch."""
    if torque.size < 2:
        return np.full(at.size, np.nan)
    order = np.argsort(angle, kind="stable")
    return np.asarray(np.interp(at, angle[order], torque[order], left=np.nan, right=np.nan))


def _curve_recording(reducer: AsBuiltReducer, measurement: Measurement) -> Recording:
    predicted = predict_curve(reducer, measurement)
    residual = measurement.value - predicted.on_last_flank
    rows = np.arange(residual.size)
    notes = []
    if measurement.kind is HYSTERESIS:
        rows = rows[_usable_rows(measurement)]
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
    erroneous = gross_errors(residual[rows], local_noise(residual[rows], rows).sigma, step)
    if np.any(erroneous):
        notes.append(f"{np.count_nonzero(erroneous)} reading errors are omitted")
        rows, block = rows[~erroneous], block[~erroneous]
    if measurement.kind is HYSTERESIS:
        noise = _loop_noise(residual[rows], rows, measurement)
    else:
        noise = estimate_noise(residual[rows], rows, measurement.stated_noise)
    drift = _drift(reducer, measurement, residual[rows], rows, noise)
    held_out = block % _HELD_OUT == 2
    found = Recording(measurement, 0, rows, held_out, noise, tuple(notes), predicted=predicted, drift=drift)
    return replace(found, notes=(*notes, *_drift_note(found)))


def _loop_noise(residual: FloatArray, rows: IntArray, measurement: Measurement) -> Noise:
    scatter = residual, rows
    contrasts = contrasts_of_branches(residual, rows, measurement["torque_nm"])
    # Effects that follow the torque alone vanish in contrasts; play and creep are larger there than in the rows.
    if contrasts is not None and _scatters_less(contrasts, scatter):
        scatter = contrasts
    noise = estimate_noise(*scatter, stated=measurement.stated_noise)
    if noise.rho > _SMOOTHED:
        # Averaged and smoothed: what varies slowly along the branches is the reducer, not the reading.
        return local_noise(residual, rows, measurement.stated_noise)
    return noise


def _scatters_less(one: tuple[FloatArray, IntArray], other: tuple[FloatArray, IntArray]) -> bool:
    """Whether rows, with their numbers, scatter less than others by more than chance (F test)."""
    from scipy.special import fdtrc

    (small, few), (large, many) = scatter_about_cubics(*one), scatter_about_cubics(*other)
    if min(few, many) == 0 or small == 0.0:
        return False
    return bool(fdtrc(many, few, large / small) < _CHANCE)


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
