"""Residuals of curves: a hysteresis loop, and a curve over a turn of the output with its orders."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis import Diagnosis, FileGap, nuisance_fitted
from cycloid_profile.measurement import LOST_MOTION_MAP
from cycloid_profile.plot.diagnosis import _marks as marks
from cycloid_profile.plot.measured import turn_ticks, widened
from cycloid_profile.plot.style import BLUE, GREY, ORANGE, headroom, new_figure, patch_mark

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WINDOW_WAVES = 4  # waves of the pins in the readable window: each is drawn about an inch wide
_WINDOW: dict[str, Any] = {"color": GREY, "alpha": 0.25, "linewidth": 0}


def loop_gap(diagnosis: Diagnosis, gap: FileGap) -> tuple[Figure, str]:
    """Torque over angle, and the residual of each row; with the caption."""
    shown = marks.before_and_after(diagnosis, gap)
    recording = gap.recording
    torque = recording.measurement["torque_nm"][recording.rows]
    angle = recording.measurement["angle_arcmin"][recording.rows]
    number = recording.rows.astype(np.float64) + 1.0
    figure = new_figure(11.0 if len(shown) == 2 else 7.5, 8.2)
    axes = figure.subplots(2, len(shown), squeeze=False, height_ratios=(1.5, 1.0))
    for column, (title, residuals) in enumerate(shown):
        top, bottom = axes[0, column], axes[1, column]
        difference = nuisance_fitted(residuals)
        x, y = marks.with_gaps(recording.rows, angle - difference, torque)
        top.plot(angle, torque, ".", color=BLUE, markersize=4.0, label="measured")
        top.plot(x, y, color=ORANGE, linewidth=1.3, label="predicted")
        top.set(xlabel="angle [′]", ylabel="torque [N·m]")
        top.set_title(title, fontsize=10)
        top.legend(loc="upper left")
        marks.draw_file_residual(bottom, number, residuals, gap)
        for finding in marks.significant(diagnosis, gap, "row") if residuals is gap.before else []:
            marks.outline_span(bottom, finding.start, finding.end)
        bottom.set_xlabel("row of the file [number]")
    limits = [ax.get_xlim() for ax in axes[0]]
    for ax in axes[0]:
        ax.set_xlim(min(low for low, _ in limits), max(high for _, high in limits))
    outlined = bool(marks.significant(diagnosis, gap, "row"))
    marks.legend(figure, [*marks.curve_marks(), *marks.row_marks(gap, outlined)])
    return figure, "the loop with its prediction, and measured minus predicted row by row; mind the scales."


def turn_gap(diagnosis: Diagnosis, gap: FileGap) -> tuple[Figure, str]:
    """Curve over a turn and in a window, its residual, and the orders of the residual; with the caption."""
    shown = marks.before_and_after(diagnosis, gap)
    recording = gap.recording
    angle = recording.measurement["output_angle_deg"][recording.rows]
    value = recording.measurement.value[recording.rows]
    pins = diagnosis.reducer.case.drive.trochoid.pins
    quantity = f"{recording.kind.title} [{marks.unit(gap)}]"
    window = _window(diagnosis, gap, angle, 360.0 * _WINDOW_WAVES / pins)
    figure = new_figure(11.0, 13.0)
    parts: Any = figure.subfigures(3, 1, height_ratios=(1.2, 1.9, 1.2))
    whole, near, spectra = parts
    turns = whole.subplots(1, len(shown), squeeze=False, sharey=True)[0]
    lower = near.subplots(2, len(shown), squeeze=False)
    differences = [nuisance_fitted(residuals) for _, residuals in shown]
    places = marks.significant(diagnosis, gap, "output_angle_deg")
    for column, ((title, residuals), difference) in enumerate(zip(shown, differences, strict=True)):
        close, rest = lower[:, column]
        _turn(turns[column], title, angle, value, value - difference, window)
        _close(close, title, angle, value, value - difference, window)
        for ax in (turns[column], close):
            ax.set(xlabel="output angle [°]", ylabel=quantity)
        marks.draw_file_residual(rest, angle, residuals, gap)
        for finding in places if column == 0 else []:
            marks.outline_span(rest, finding.start, finding.end)
        rest.set_xlabel("output angle [°]")
        if angle[-1] - angle[0] > 300.0:
            turn_ticks(turns[column])
            turn_ticks(rest)
    if recording.kind is LOST_MOTION_MAP:
        widened(turns[0], 0.5, 0.05 * abs(float(np.mean(value))))
    marks.draw_orders(spectra, diagnosis, gap, angle, differences)
    curves = [*marks.curve_marks(), patch_mark("window below", **_WINDOW)]
    handles = [*curves, *marks.row_marks(gap, bool(places)), *marks.order_marks(diagnosis)]
    marks.legend(figure, handles)
    return figure, (
        "measured and predicted, measured minus predicted, and its orders per turn of the output. "
        f"A whole turn holds {pins} waves, so {_WINDOW_WAVES} of them are drawn large."
    )


def _turn(
    ax: Axes, title: str, angle: FloatArray, value: FloatArray, predicted: FloatArray, window: tuple[float, float]
) -> None:
    ax.plot(angle, value, color=BLUE, linewidth=0.6, label="measured")
    ax.plot(angle, predicted, color=ORANGE, linewidth=0.6, linestyle="--", label="predicted")
    ax.axvspan(*window, **_WINDOW)
    ax.set_title(f"{title}: the turn", fontsize=10)
    ax.set_xlim(float(angle[0]), float(angle[-1]))


def _close(
    ax: Axes, title: str, angle: FloatArray, value: FloatArray, predicted: FloatArray, window: tuple[float, float]
) -> None:
    inside = (angle >= window[0]) & (angle <= window[1])
    ax.plot(angle[inside], value[inside], ".", color=BLUE, markersize=3.5, label="measured")
    ax.plot(angle[inside], predicted[inside], color=ORANGE, linewidth=1.2, label="predicted")
    ax.set_title(f"{title}: the window, {_WINDOW_WAVES} waves of the pins", fontsize=10)
    ax.set_xlim(window)
    ax.legend(loc="upper right", fontsize=9)
    headroom(ax, 0.3)


def _window(diagnosis: Diagnosis, gap: FileGap, angle: FloatArray, width: float) -> tuple[float, float]:
    """A window about the most significant deviation [°]."""
    found = marks.significant(diagnosis, gap, "output_angle_deg")
    middle = 0.5 * (found[0].start + found[0].end) if found else float(angle[0]) + 0.5 * width
    start = min(max(middle - 0.5 * width, float(angle[0])), max(float(angle[-1]) - width, float(angle[0])))
    return start, start + width
