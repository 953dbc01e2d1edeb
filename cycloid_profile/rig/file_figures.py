"""Figures of a measured curve and of its prediction, read in the same way (docs/rig.md, "Comparing").

A kind of file has one small object: it names its figures and reads them from a column, measured or predicted.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import singledispatch
from typing import Protocol

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.errors import MeasurementError
from cycloid_profile.geometry import Drive
from cycloid_profile.measurement import Hysteresis, LostMotionMap, MeasurementKind, TransmissionErrorCurve
from cycloid_profile.rig.curves_over_turn import spectrum
from cycloid_profile.rig.hysteresis import LOST_MOTION_SHARE, RIGIDITY_SHARES, evaluate_loop, loop_branches
from cycloid_profile.rig.orders import expected_orders, order_label, single_orders
from cycloid_profile.rig.residuals import MeasurementResidual
from cycloid_profile.units import ARCMIN, NEWTON_METRE

_LOST_MOTION = "lost_motion_arcmin"  # both the figure and its limit
_DRAWS = 40  # of the noise: its effect on a figure is then known within a ninth
_SAME_TORQUE = 0.02  # relative: a limit at this torque applies
_LARGEST_ORDERS = 5  # beyond the expected ones
_LEAST_ORDER = 0.1  # of the largest order
_ORDER_OVER_NOISE = 5.0  # amplitudes: of 1,500 orders of noise alone none is larger
_UNEVEN = 0.01  # of the step from row to row


@dataclass(frozen=True, slots=True)
class FigureName:
    """``key`` of a figure with its unit at the end, ``title`` without it, and the key of its ``limit`` in
    ``[tolerance.limits]``, empty without one.
    """

    key: str
    title: str
    limit: str = ""


@dataclass(frozen=True, slots=True)
class ComparedFigure:
    """One figure, ``measured`` and ``predicted``, in the unit that its ``name.key`` ends with; NaN where there is none.

    ``noise``: root mean square of the change that the measuring noise makes; a difference of its size means nothing.
    ``tolerance`` of the spec, None without one.
    """

    name: FigureName
    measured: float
    predicted: float
    noise: float
    tolerance: float | None = None

    @property
    def difference(self) -> float:
        """Measured minus predicted."""
        return self.measured - self.predicted


@dataclass(frozen=True, slots=True)
class ComparedFigures:
    """The figures of one file, and ``notes`` on how far they go."""

    figures: tuple[ComparedFigure, ...]
    notes: tuple[str, ...] = ()


class FileFigures(Protocol):
    """Figures that a file has."""

    @property
    def names(self) -> tuple[FigureName, ...]:
        """Name of each."""

    def of(self, values: FloatArray) -> FloatArray:
        """Figures of a column, measured or predicted, shape (rows,) → (names,)."""

    def notes(self, values: FloatArray) -> tuple[str, ...]:
        """Sentences on the figures of the measured column."""


def compared_figures(residual: MeasurementResidual) -> ComparedFigures:
    """Figures of a measured curve and of its prediction at the same rows."""
    measured, predicted = residual.measurement.value, residual.predicted
    if predicted is None:
        raise MeasurementError("kind", residual.measurement.kind.name, "is no curve", "inspect a scan")
    own = file_figures(residual.measurement.kind, residual)
    of_measured, of_predicted = own.of(measured), own.of(predicted)
    rng = np.random.default_rng(0)
    draws = residual.noise * rng.standard_normal((_DRAWS, measured.size))
    changes = np.array([own.of(predicted + draw) for draw in draws]) - of_predicted
    noise = np.sqrt(np.mean(changes**2, axis=0))
    values = zip(own.names, of_measured.tolist(), of_predicted.tolist(), noise.tolist(), strict=True)
    return ComparedFigures(tuple(ComparedFigure(*each) for each in values), own.notes(measured))


@singledispatch
def file_figures(kind: MeasurementKind, residual: MeasurementResidual) -> FileFigures:
    """The object that reads the figures of a file of this ``kind``."""
    raise NotImplementedError(f"a {kind.title} is no curve")


@dataclass(frozen=True, slots=True)
class _NoFigures:
    """A file whose figures cannot be read, and why."""

    reason: str
    names: tuple[FigureName, ...] = ()

    def of(self, values: FloatArray) -> FloatArray:  # noqa: ARG002
        return np.empty(0)

    def notes(self, values: FloatArray) -> tuple[str, ...]:  # noqa: ARG002
        return (self.reason,)


@dataclass(frozen=True, eq=False, slots=True)
class LoopOfFile:
    """Figures of a loop of ``torque`` [N·mm], referred to the ``rated`` torque [N·mm]."""

    torque: FloatArray
    rated: float

    @property
    def names(self) -> tuple[FigureName, ...]:
        """Lost motion, width, area, and the rigidity of both directions in both ranges."""
        ranges = [(round(100.0 * low), round(100.0 * high)) for low, high in RIGIDITY_SHARES]
        directions = (("forward", "+"), ("backward", "−"))
        return (
            FigureName(
                "lost_motion_arcmin", f"lost motion at ±{100.0 * LOST_MOTION_SHARE:.0f} %", "lost_motion_arcmin"
            ),
            FigureName("hysteresis_loss_arcmin", "width at zero torque"),
            FigureName("loss_energy_nm_arcmin", "area of the loop"),
            *(
                FigureName(f"rigidity_{low}_to_{high}_{word}_nm_per_arcmin", f"rigidity {sign} {low}–{high} %")
                for low, high in ranges
                for word, sign in directions
            ),
        )

    def of(self, values: FloatArray) -> FloatArray:
        """Figures of the angles ``values`` [′]."""
        try:
            found = evaluate_loop(self.torque, values * ARCMIN, self.rated)
        except MeasurementError:
            return np.full(len(self.names), np.nan)
        width = math.nan if found.coarse else found.hysteresis_loss
        angles = np.array([found.lost_motion, width]) / ARCMIN
        energy = found.loss_energy / NEWTON_METRE / ARCMIN
        return np.concatenate([angles, [energy], found.rigidity.ravel() * ARCMIN / NEWTON_METRE])

    def notes(self, values: FloatArray) -> tuple[str, ...]:
        """Where the loop is short, its rows are coarse, friction hides the lost motion, or there are no figures."""
        try:
            found = evaluate_loop(self.torque, values * ARCMIN, self.rated)
        except MeasurementError as error:
            return (f"no figures: {error}",)
        peak = min(float(np.max(self.torque)), -float(np.min(self.torque)))
        rated, light = (torque / NEWTON_METRE for torque in (self.rated, found.light))
        short = f"the loop reaches ±{peak / NEWTON_METRE:.4g} of {rated:.4g} N·m: no rigidity beyond"
        hidden = f"friction exceeds ±{light:.4g} N·m, 3 % of the rated torque: the lost motion leaves the backlash out"
        coarse = "both branches pass the play between two rows: finer steps about zero torque would show the width"
        joined = f"one branch is read from end and start of the file, which are {abs(found.joint) / ARCMIN:.3g}′ apart"
        said = {
            short: bool(np.any(np.isnan(found.rigidity))),
            hidden: found.crossed,
            coarse: found.coarse,
            joined: found.joint != 0.0,
        }
        return tuple(note for note, holds in said.items() if holds)


@file_figures.register
def _(_: Hysteresis, residual: MeasurementResidual) -> FileFigures:
    torque = residual.measurement["torque_nm"] * NEWTON_METRE
    try:
        loop_branches(torque, torque)
    except MeasurementError as error:
        return _NoFigures(f"no figures: {error}")
    return LoopOfFile(torque, abs(residual.reducer.case.torque))


@dataclass(frozen=True, slots=True)
class OrdersOfFile:
    """Peak to peak of a transmission error, and the amplitudes of some ``orders``, which ``drive`` names."""

    drive: Drive
    orders: tuple[int, ...]
    poses: int
    limit: str
    reason: str = ""

    @property
    def names(self) -> tuple[FigureName, ...]:
        """Peak to peak and each order."""
        numbers = (self.drive.trochoid.lobes, self.drive.trochoid.pins, self.poses, single_orders(self.drive))
        orders = (
            FigureName(f"order_{o}_amplitude_arcsec", f"order {order_label(o, *numbers)}".replace(" = ", ": "))
            for o in self.orders
        )
        return (FigureName("peak_to_peak_arcsec", "peak to peak", self.limit), *orders)

    def of(self, values: FloatArray) -> FloatArray:
        """Figures of the errors ``values`` [″]."""
        return np.concatenate([[np.ptp(values)], spectrum(values)[list(self.orders)]])

    def notes(self, values: FloatArray) -> tuple[str, ...]:  # noqa: ARG002
        """What the orders point to, or why there are none."""
        lobes, pins = self.drive.trochoid.lobes, self.drive.trochoid.pins
        where = f"orders {pins}·k: discs, cranks, carrier, planets; {lobes}·k: pin ring and housing"
        return (self.reason or where,)


@file_figures.register
def _(_: TransmissionErrorCurve, residual: MeasurementResidual) -> FileFigures:
    measured, drive = residual.measurement, residual.reducer.case.drive
    limit = "transmission_error_arcsec" if _is_at(residual, 1.0) else ""
    if not evenly_over_turn(measured["output_angle_deg"]):
        return OrdersOfFile(drive, (), measured.rows, limit, "no orders: they need even rows over one whole turn")
    expected = expected_orders(drive, measured.rows)
    assert residual.predicted is not None
    amplitude = np.maximum(spectrum(measured.value), np.nan_to_num(spectrum(residual.predicted)))[1:]
    least = _ORDER_OVER_NOISE * residual.noise * math.sqrt(math.pi / measured.rows)
    shown = amplitude > max(_LEAST_ORDER * float(np.max(amplitude)), np.nan_to_num(least))
    others = [int(k) + 1 for k in np.argsort(amplitude)[::-1] if shown[k] and k + 1 not in expected]
    orders = sorted({*expected, *others[:_LARGEST_ORDERS]})
    return OrdersOfFile(drive, tuple(orders), measured.rows, limit)


@dataclass(frozen=True, slots=True)
class LevelsOfMap:
    """Mean, largest, smallest and range of a lost motion map."""

    limit: str

    @property
    def names(self) -> tuple[FigureName, ...]:
        """Four levels."""
        return (
            FigureName("mean_arcmin", "lost motion, mean"),
            FigureName("largest_arcmin", "lost motion, largest", self.limit),
            FigureName("smallest_arcmin", "lost motion, smallest"),
            FigureName("peak_to_peak_arcmin", "peak to peak"),
        )

    def of(self, values: FloatArray) -> FloatArray:
        """Figures of the angles ``values`` [′]."""
        return np.array([np.mean(values), np.max(values), np.min(values), np.ptp(values)])

    def notes(self, values: FloatArray) -> tuple[str, ...]:  # noqa: ARG002
        """None."""
        return ()


@file_figures.register
def _(_: LostMotionMap, residual: MeasurementResidual) -> FileFigures:
    return LevelsOfMap(_LOST_MOTION if _is_at(residual, LOST_MOTION_SHARE) else "")


def evenly_over_turn(angle_deg: FloatArray) -> bool:
    """Whether rows follow each other in even steps over one whole turn, as a spectrum needs them."""
    step = 360.0 / angle_deg.size
    return bool(np.all(np.abs(np.diff(angle_deg) - step) < _UNEVEN * step))


def _is_at(residual: MeasurementResidual, share: float) -> bool:
    """Whether a file was measured at this share of the rated torque."""
    torque = abs(residual.measurement.number("torque_nm") or 0.0) * NEWTON_METRE
    wanted = share * abs(residual.reducer.case.torque)
    return abs(torque - wanted) <= _SAME_TORQUE * wanted
