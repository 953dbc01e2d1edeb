"""What all pictures of a diagnosis share: units, the two sides, striking places, held-out rows, and the legend."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.discrepancy.detection import Finding
from cycloid_profile.discrepancy.laid import Laid
from cycloid_profile.discrepancy.outcome import Diagnosis, FileGap
from cycloid_profile.plot.style import BLACK, GREEN
from cycloid_profile.units import SIGNS

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.figure import Figure

HELD: dict[str, Any] = {"color": GREEN, "linewidth": 2.5, "solid_capstyle": "butt"}
OUTLINE: dict[str, Any] = {"facecolor": "none", "edgecolor": BLACK, "linewidth": 1.3}


def unit(gap: FileGap) -> str:
    """Sign of the unit of a file."""
    return SIGNS[gap.recording.unit]


def with_unit(value: float, gap: FileGap) -> str:
    """Three figures with the unit; signs of angles stand close."""
    sign = unit(gap)
    return f"{value:#.3g}{sign}" if sign in "′″" else f"{value:#.3g} {sign}"


def sides(diagnosis: Diagnosis, gap: FileGap) -> list[tuple[str, Laid]]:
    """Before and after; once only where no effect was added."""
    if not diagnosis.effects:
        return [("against the prediction of the spec", gap.before)]
    return [("before", gap.before), ("after, effects added", gap.after)]


def striking(diagnosis: Diagnosis, gap: FileGap, coordinate: str) -> list[Finding]:
    """Places of a file that differ most, in one coordinate."""
    return [f for f in diagnosis.where if f.file == gap.recording.name and f.coordinate == coordinate]


def row_marks(gap: FileGap, outlined: bool) -> list[Artist]:
    """Legend of held-out rows and of outlined places, where there are any."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    held = gap.recording.held_out
    handles: list[Artist] = []
    if np.any(held) and not np.all(held):
        handles.append(Line2D([], [], label="rows held out, not fitted", **HELD))
    if np.all(held):
        handles.append(Line2D([], [], linestyle="", label="whole file held out, not fitted"))
    if outlined:
        handles.append(Patch(label="most striking", **OUTLINE))
    return handles


def legend(figure: Figure, handles: Sequence[Artist]) -> None:
    """What the marks mean, once for the figure."""
    columns = len(handles) if len(handles) <= 6 else math.ceil(len(handles) / 2)
    figure.legend(handles=handles, loc="outside lower center", ncols=columns, fontsize=9)
