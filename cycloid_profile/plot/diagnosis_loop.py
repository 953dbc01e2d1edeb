"""The gap of a hysteresis loop: torque over angle with the prediction, and what is left row by row."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.laid import settled
from cycloid_profile.discrepancy.outcome import Diagnosis, FileGap
from cycloid_profile.plot.diagnosis_marks import legend, row_marks, sides, striking
from cycloid_profile.plot.diagnosis_residual import curve_marks, draw_residual, outline_span
from cycloid_profile.plot.style import BLUE, ORANGE, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def loop_gap(diagnosis: Diagnosis, gap: FileGap) -> tuple[Figure, str]:
    """Torque over angle, and what is left row by row."""
    shown = sides(diagnosis, gap)
    recording = gap.recording
    torque = recording.measurement["torque_nm"][recording.rows]
    angle = recording.measurement["angle_arcmin"][recording.rows]
    number = recording.rows.astype(np.float64) + 1.0
    figure = new_figure(11.0 if len(shown) == 2 else 7.5, 8.2)
    axes = figure.subplots(2, len(shown), squeeze=False, height_ratios=(1.5, 1.0))
    for column, (title, laid) in enumerate(shown):
        top, bottom = axes[0, column], axes[1, column]
        left = settled(laid)
        x, y = _broken(recording.rows, angle - left, torque)
        top.plot(angle, torque, ".", color=BLUE, markersize=4.0, label="measured")
        top.plot(x, y, color=ORANGE, linewidth=1.3, label="predicted")
        top.set(xlabel="angle [′]", ylabel="torque [N·m]")
        top.set_title(title, fontsize=10)
        top.legend(loc="upper left")
        draw_residual(bottom, number, left, gap)
        for finding in striking(diagnosis, gap, "row") if laid is gap.before else []:
            rows = recording.rows[np.clip([int(finding.start), int(finding.end)], 0, recording.rows.size - 1)] + 1.0
            outline_span(bottom, float(rows[0]), float(rows[1]))
        bottom.set_xlabel("row of the file [number]")
    limits = [ax.get_xlim() for ax in axes[0]]
    for ax in axes[0]:
        ax.set_xlim(min(low for low, _ in limits), max(high for _, high in limits))
    outlined = bool(striking(diagnosis, gap, "row"))
    legend(figure, [*curve_marks(), *row_marks(gap, outlined)])
    return figure, "the loop with its prediction, and measured minus predicted row by row; mind the scales."


def _broken(rows: np.ndarray, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A path, broken where rows of the file are left out."""
    gaps = np.flatnonzero(np.diff(rows) > 1) + 1
    return np.insert(x, gaps, np.nan), np.insert(y, gaps, np.nan)
