"""Figure of two measurements of one specimen: both with their predictions, and what the changes explain."""

from __future__ import annotations

import re
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis import Comparison, Residuals, nuisance_fitted
from cycloid_profile.measurement import HYSTERESIS, PROFILE_SCAN
from cycloid_profile.plot.style import BLACK, BLUE, ORANGE, canvas, figure_holding, plain
from cycloid_profile.units import DEGREE, SIGNS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_CAPTION = (
    "the file before and after with their predictions; measured minus predicted without the changes; the same with "
    "them, where both times share the error of the model."
)


def changes(comparison: Comparison, ax: Any = None, *, file: int = 0, name: str = "") -> Any:
    """Measured and predicted before and after, and the residuals without and with the changes, of one file.

    ``file``: number of the pair from 0. Returns three axes.
    """
    pair = comparison.files[file]
    unit = SIGNS[pair.after.recording.unit]
    with canvas(ax, (8.5, 10.5), 3, 1) as drawn:
        top, middle, bottom = drawn.axes
        sides = [(pair.after, "after", ORANGE)]
        if pair.before is not None:
            sides.insert(0, (pair.before, "before", BLUE))
        for residuals, when, colour in sides:
            x, measured = _place(residuals), _measured(residuals)
            label = f"{when}: {plain(residuals.recording.name)}"
            top.plot(x, measured, ".", color=colour, markersize=3.0, label=label)
            top.plot(x, measured - nuisance_fitted(residuals), color=BLACK, linewidth=0.7)
            _dots(bottom, residuals, colour, when)
        if pair.before is not None:
            _dots(middle, pair.before, BLUE, "before")
        _dots(middle, pair.unchanged, ORANGE, "after, without the changes")
        top.set_title("measured (points) and predicted (lines)", fontsize=10)
        middle.set_title("residual, both times on the reducer before", fontsize=10)
        bottom.set_title("residual, the changes added after", fontsize=10)
        for axes in (top, middle, bottom):
            _label(axes, pair.after, unit)
        drawn.title(name, "what changed between the two measurements")
    return drawn.axes


def change_pictures(comparison: Comparison, name: str) -> list[tuple[str, str, Figure]]:
    """File stem, caption and figure of every pair of files."""
    found: list[tuple[str, str, Figure]] = []
    for number, pair in enumerate(comparison.files):
        file = pair.after.recording.name
        base = "change_" + (re.sub(r"[^A-Za-z0-9]+", "_", PurePath(file).stem).strip("_").lower() or "file")
        taken = {stem for stem, _, _ in found}
        stem = next(s for s in (base, *(f"{base}_{n}" for n in range(2, 1000))) if s not in taken)
        found.append((stem, f"{file}: {_CAPTION}", figure_holding(changes(comparison, file=number, name=name))))
    return found


def _dots(axes: Axes, residuals: Residuals, colour: str, label: str) -> None:
    axes.plot(_place(residuals), nuisance_fitted(residuals), ".", color=colour, markersize=3.0, label=label)


def _place(residuals: Residuals) -> FloatArray:
    """Torque of a loop [N·m], lobe of a scan, output angle of a turn [°]."""
    recording = residuals.recording
    if recording.kind is HYSTERESIS:
        return recording.measurement["torque_nm"][recording.rows]
    if recording.kind is PROFILE_SCAN:
        return residuals.phase / (2.0 * np.pi) + residuals.lobe
    return residuals.position / DEGREE


def _measured(residuals: Residuals) -> FloatArray:
    """The measured column; the removal of a scan, of which the prediction is zero."""
    recording = residuals.recording
    if recording.kind is PROFILE_SCAN:
        return residuals.residual
    return recording.measurement.value[recording.rows]


def _label(axes: Axes, residuals: Residuals, unit: str) -> None:
    places = {HYSTERESIS: "torque [N·m]", PROFILE_SCAN: "lobe [number]"}
    axes.set_xlabel(places.get(residuals.recording.kind, "output angle [°]"))
    axes.set_ylabel(f"{residuals.recording.kind.title} [{unit}]")
    axes.legend(fontsize=9)
