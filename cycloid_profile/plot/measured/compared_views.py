"""A measured file over its prediction, with the residual: the picture of ``compare``."""

from __future__ import annotations

import math
from functools import singledispatch
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile._display import with_unit
from cycloid_profile.arrays import FloatArray
from cycloid_profile.errors import MeasurementError
from cycloid_profile.measurement import Hysteresis, MeasurementKind, ProfileScan, TransmissionErrorCurve
from cycloid_profile.plot.measured.measured import scan_deviation
from cycloid_profile.plot.measured.panels import draw_orders, draw_residual, noise_mark, order_namer, turn_ticks
from cycloid_profile.plot.style import BLUE, GREEN, GREY, ORANGE, canvas, line_mark, plain
from cycloid_profile.rig import LoopFigures, MeasurementResidual, evaluate_loop, evenly_over_turn, spectrum
from cycloid_profile.units import ARCMIN, NEWTON_METRE, SIGNS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MEASURED: dict[str, Any] = {"color": BLUE, "linewidth": 1.4}
_PREDICTED: dict[str, Any] = {"color": ORANGE, "linewidth": 1.0}
_NEAR = 2.5  # times 3 % of the rated torque: height of the picture about zero torque


def comparison(result: MeasurementResidual, ax: Any = None, *, name: str = "") -> Any:
    """A measured file over its prediction and its residual.

    Four axes of a loop, three of a transmission error, two of a map, and of a scan, the first polar.
    """
    unit = SIGNS[result.unit]
    rms, noise = (with_unit(f"{value:.3g}", unit) for value in (result.rms, result.noise))
    file = ", ".join(plain(part) for part in (name, result.measurement.name) if part)
    heading = f"{file}: gap {rms} rms, noise {noise}"
    return _drawn(result.measurement.kind, result, ax, heading)


@singledispatch
def _drawn(kind: MeasurementKind, result: MeasurementResidual, ax: Any, heading: str) -> Any:
    """Picture of a curve over a turn."""
    with canvas(ax, (10.0, 6.4), 2) as drawn:
        _curve_over_turn(drawn.axes[0], result, kind.title)
        _residual(drawn.axes[1], result, result.position, result.axis)
        turn_ticks(drawn.axes[1])
        drawn.title("", heading)
        drawn.legend(3, handles=_marks())
    return drawn.axes


@_drawn.register
def _(_: ProfileScan, result: MeasurementResidual, ax: Any, heading: str) -> Any:
    return scan_deviation(result, "prediction", ax, "", heading)


@_drawn.register
def _(kind: TransmissionErrorCurve, result: MeasurementResidual, ax: Any, heading: str) -> Any:
    with canvas(ax, (10.0, 9.0), 3) as drawn:
        curve, residual, orders = drawn.axes
        _curve_over_turn(curve, result, kind.title)
        _residual(residual, result, result.position, result.axis)
        turn_ticks(residual)
        _orders(orders, result)
        drawn.title("", heading)
        drawn.legend(3, handles=_marks())
    return drawn.axes


@_drawn.register
def _(_: Hysteresis, result: MeasurementResidual, ax: Any, heading: str) -> Any:
    torque, measured, predicted = result.measurement["torque_nm"], result.measurement.value, _predicted(result)
    with canvas(ax, (11.0, 8.4), 2, 2) as drawn:
        (whole, near), (by_row, by_torque) = drawn.axes
        for axes in (whole, near):
            axes.plot(measured, torque, **_MEASURED)
            axes.plot(predicted, torque, **_PREDICTED)
            axes.axhline(0.0, color=GREY, linewidth=0.8)
            axes.set(xlabel="angle [′]", ylabel="torque [N·m]")
        whole.set_title("whole loop")
        _about_zero(near, result, torque, measured, predicted)
        _residual(by_row, result, result.position, result.axis)
        _residual(by_torque, result, torque, "torque [N·m]")
        by_torque.set_ylabel("")
        drawn.title("", heading)
        drawn.legend(3, handles=_marks())
    return drawn.axes


def _about_zero(
    ax: Axes, result: MeasurementResidual, torque: FloatArray, measured: FloatArray, predicted: FloatArray
) -> None:
    """Limits about zero torque, with lost motion and width of both loops where they are whole."""
    rated = abs(result.reducer.case.torque)
    found = [_figures(torque, angle, rated) for angle in (measured, predicted)]
    shown = [one for one in found if one is not None]
    height = _NEAR * (shown[0].light / NEWTON_METRE if shown else 0.1 * float(np.max(np.abs(torque))))
    ax.set(ylim=(-height, height), title="about zero torque; dotted: ±3 % of the rated torque")
    close = np.abs(torque) <= height
    angles = np.concatenate([measured[close], predicted[close]])
    angles = angles[np.isfinite(angles)]
    if angles.size:
        margin = 0.05 * max(float(np.ptp(angles)), 1e-3)
        ax.set_xlim(float(np.min(angles)) - margin, float(np.max(angles)) + margin)
    for one, look in zip(found, (_MEASURED, _PREDICTED), strict=True):
        if one is not None:
            light = one.light / NEWTON_METRE
            label = f"lost motion {one.lost_motion / ARCMIN:.3g}′, width {one.hysteresis_loss / ARCMIN:.3g}′"
            ends = np.array(one.centreline) / ARCMIN
            ax.plot(ends, [-light, light], "o-", color=look["color"], linewidth=0.6, markersize=5, label=label)
            for T in (-light, light):
                ax.axhline(T, color=GREEN, linewidth=0.8, linestyle=":")
    if shown:
        ax.legend(loc="upper left", fontsize=8, frameon=True)


def _figures(torque: FloatArray, angle: FloatArray, rated: float) -> LoopFigures | None:
    """Figures of a loop of torques [N·m] and angles [′] that ``rated`` [N·mm] refers to, None if it is not whole."""
    try:
        return evaluate_loop(torque * NEWTON_METRE, angle * ARCMIN, rated)
    except MeasurementError:
        return None


def _curve_over_turn(ax: Axes, result: MeasurementResidual, quantity: str) -> None:
    ax.plot(result.position, result.measurement.value, **{**_MEASURED, "linewidth": 0.8})
    ax.plot(result.position, _predicted(result), **{**_PREDICTED, "linewidth": 0.8})
    ax.set(ylabel=f"{quantity} [{SIGNS[result.unit]}]", xlabel=result.axis)
    ax.margins(x=0.01)
    turn_ticks(ax)


def _residual(ax: Axes, result: MeasurementResidual, x: FloatArray, label: str) -> None:
    draw_residual(ax, x, result.residual, result.noise, SIGNS[result.unit])
    ax.set_xlabel(label)


def _orders(ax: Axes, result: MeasurementResidual) -> None:
    measured, predicted = result.measurement.value, _predicted(result)
    if not evenly_over_turn(result.position):
        ax.set_title("no orders: they need even rows over one whole turn", fontsize=10)
        return
    floor = result.noise * math.sqrt(math.pi / measured.size)
    name = order_namer(result.reducer, measured.size)
    spectra = [spectrum(measured), np.nan_to_num(spectrum(predicted))]
    draw_orders(ax, spectra, (BLUE, ORANGE), floor, name, SIGNS[result.unit])


def _predicted(result: MeasurementResidual) -> FloatArray:
    assert result.predicted is not None
    return result.predicted


def _marks() -> list[Any]:
    return [line_mark("measured", **_MEASURED), line_mark("predicted", **_PREDICTED), noise_mark()]
