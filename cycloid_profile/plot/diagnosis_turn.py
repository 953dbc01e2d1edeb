"""The gap of a curve over a turn of the output: the turn, a window of it, what is left, and the orders of that."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.laid import settled
from cycloid_profile.discrepancy.outcome import Diagnosis, FileGap
from cycloid_profile.plot.diagnosis_marks import legend, row_marks, sides, striking, unit
from cycloid_profile.plot.diagnosis_orders import draw_orders, order_marks
from cycloid_profile.plot.diagnosis_residual import curve_marks, draw_residual, outline_span
from cycloid_profile.plot.style import BLUE, GREY, ORANGE, new_figure
from cycloid_profile.plot.turn_axis import turn_ticks, widened
from cycloid_profile.rig.gap import COLUMN

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_QUANTITY = {"transmission_error": "transmission error", "lost_motion_map": "lost motion"}
_WINDOW_WAVES = 4  # waves of the pins in the readable window


def turn_gap(diagnosis: Diagnosis, gap: FileGap) -> tuple[Figure, str]:
    """Curve over a turn and in a window, what is left, and the orders of that."""
    shown = sides(diagnosis, gap)
    recording = gap.recording
    angle = recording.measurement["output_angle_deg"][recording.rows]
    value = recording.measurement[COLUMN[recording.kind]][recording.rows]
    pins = diagnosis.built.case.drive.trochoid.pins
    quantity = f"{_QUANTITY[recording.kind]} [{unit(gap)}]"
    window = _window(diagnosis, gap, angle, 360.0 * _WINDOW_WAVES / pins)
    figure = new_figure(11.0, 13.0)
    parts: Any = figure.subfigures(3, 1, height_ratios=(1.2, 1.9, 1.2))
    whole, near, spectra = parts
    turns = whole.subplots(1, len(shown), squeeze=False, sharey=True)[0]
    lower = near.subplots(2, len(shown), squeeze=False)
    left = [settled(laid) for _, laid in shown]
    inside = (angle >= window[0]) & (angle <= window[1])
    for column, (title, _) in enumerate(shown):
        ax = turns[column]
        predicted = value - left[column]
        ax.plot(angle, value, color=BLUE, linewidth=0.6, label="measured")
        ax.plot(angle, predicted, color=ORANGE, linewidth=0.6, linestyle="--", label="predicted")
        ax.axvspan(*window, color=GREY, alpha=0.25, linewidth=0)
        ax.set(xlabel="output angle [°]", ylabel=quantity)
        ax.set_title(f"{title}: the turn (grey: window below)", fontsize=10)
        _degrees(ax, angle)
        close, rest = lower[0, column], lower[1, column]
        close.plot(angle[inside], value[inside], ".", color=BLUE, markersize=3.5, label="measured")
        close.plot(angle[inside], predicted[inside], color=ORANGE, linewidth=1.2, label="predicted")
        close.set(xlabel="output angle [°]", ylabel=quantity, xlim=window)
        close.set_title(f"{title}: the window, {_WINDOW_WAVES} waves of the pins", fontsize=10)
        close.legend(loc="upper right", fontsize=9)
        low, high = close.get_ylim()
        close.set_ylim(low, high + 0.3 * (high - low))
        draw_residual(rest, angle, left[column], gap)
        for finding in striking(diagnosis, gap, "output_angle_deg") if column == 0 else []:
            outline_span(rest, finding.start, finding.end)
        rest.set_xlabel("output angle [°]")
        if angle[-1] - angle[0] > 300.0:
            turn_ticks(rest)
    if recording.kind == "lost_motion_map":
        widened(turns[0], 0.5, 0.05 * abs(float(np.mean(value))))
    draw_orders(spectra, diagnosis, gap, angle, left)
    outlined = bool(striking(diagnosis, gap, "output_angle_deg"))
    legend(figure, [*curve_marks(), *row_marks(gap, outlined), *order_marks(diagnosis)])
    return figure, (
        "measured and predicted, measured minus predicted, and its orders per turn of the output. "
        f"A whole turn holds {pins} waves, so {_WINDOW_WAVES} of them are drawn large."
    )


def _window(diagnosis: Diagnosis, gap: FileGap, angle: FloatArray, width: float) -> tuple[float, float]:
    """A window about the most striking place."""
    found = striking(diagnosis, gap, "output_angle_deg")
    middle = 0.5 * (found[0].start + found[0].end) if found else float(angle[0]) + 0.5 * width
    start = min(max(middle - 0.5 * width, float(angle[0])), max(float(angle[-1]) - width, float(angle[0])))
    return start, start + width


def _degrees(ax: Axes, angle: FloatArray) -> None:
    ax.set_xlim(float(angle[0]), float(angle[-1]))
    if angle[-1] - angle[0] > 300.0:
        turn_ticks(ax)
