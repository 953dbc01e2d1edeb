"""Overview figures: residual of each file divided by its noise, all pictures of a diagnosis, and a measurement plan."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.diagnosis import Detectability, Diagnosis, FileGap
from cycloid_profile.effects import EFFECTS, parameters
from cycloid_profile.measurement import HYSTERESIS, PROFILE_SCAN
from cycloid_profile.plot.diagnosis._curves import loop_gap, turn_gap
from cycloid_profile.plot.diagnosis._marks import with_unit
from cycloid_profile.plot.diagnosis._scan import scan_gap
from cycloid_profile.plot.style import (
    BLACK,
    BLUE,
    ORANGE,
    canvas,
    figure_holding,
    note,
    patch_mark,
    plain,
    style,
    titled,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Picture = tuple[str, str, "Figure"]
_RANGE = 2.0  # decades to either side of the tolerance
_SUMMARY = (
    "How far measurement and prediction are apart, in units of the noise. "
    "Held-out rows took no part in finding the effects."
)


def diagnosis_summary(diagnosis: Diagnosis, ax: Any = None, *, name: str = "") -> Any:
    """RMS residual over the noise of every file, before and after, on fitted and held-out rows; one pair of axes."""
    changed = bool(diagnosis.effects)
    with canvas(ax, (9.5, 1.7 + (1.15 if changed else 0.75) * len(diagnosis.gaps))) as drawn:
        axes = drawn.axes
        middles, largest, y = [], 1.0, 0.0
        for gap in diagnosis.gaps:
            bars = [bar for bar in _bars(gap, changed) if math.isfinite(bar[0])]
            middles.append(y + 0.5 * (len(bars) - 1))
            for value, colour, held in bars:
                ratio = value / gap.noise
                largest = max(largest, ratio)
                look: dict[str, Any] = {"color": colour} if not held else {"facecolor": "white", "edgecolor": colour}
                axes.barh(y, ratio, height=0.8, hatch="///" if held else None, linewidth=1.0, **look)
                text = with_unit(value, gap)
                if held and gap.closure is not None and changed and colour == ORANGE:
                    text += f", gap closed by {100.0 * min(gap.closure, 1.0):.1f} %"
                note(axes, text, (ratio, y), (4, 0), va="center", fontsize=8.5)
                y += 1.0
            y += 0.8
        axes.axvline(1.0, color=BLACK, linewidth=1.2, linestyle="--")
        _noise_axis(axes, largest)
        axes.set_yticks(middles, [f"{plain(g.recording.name)}\nnoise {with_unit(g.noise, g)}" for g in diagnosis.gaps])
        axes.tick_params(axis="y", length=0)
        axes.grid(visible=False, axis="y")
        axes.invert_yaxis()
        axes.set_title(titled(name, "residual of each file"))
        handles = _bar_marks(changed)
        drawn.legend(len(handles), handles=handles, fontsize=9)
    return axes


def _noise_axis(ax: Axes, largest: float) -> None:
    from matplotlib.ticker import LogLocator, NullFormatter

    ax.set_xscale("log")
    ax.set_xlim(0.5, largest * (largest / 0.5) ** 0.45)
    ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if largest < 30.0 else (1.0,)))
    ax.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.set_xlabel("rms of measured minus predicted over the noise [–], dashed: the noise")


def _bars(gap: FileGap, changed: bool) -> list[tuple[float, str, bool]]:
    """Value, colour and whether the rows are held out."""
    bars = [(gap.fit_before, BLUE, False), (gap.fit_after, ORANGE, False)]
    bars += [(gap.held_out_before, BLUE, True), (gap.held_out_after, ORANGE, True)]
    return [bar for bar in bars if changed or bar[1] == BLUE]


def _bar_marks(changed: bool) -> list[Any]:
    handles = []
    for colour, when in ((BLUE, "before, " if changed else ""), (ORANGE, "after, ")):
        if changed or colour == BLUE:
            handles.append(patch_mark(f"{when}fitted rows", color=colour))
            handles.append(patch_mark(f"{when}held-out rows", facecolor="white", edgecolor=colour, hatch="///"))
    return handles


def file_residuals(diagnosis: Diagnosis, *, file: int = 0, name: str = "") -> Any:
    """Measured, predicted and their difference of one file, by its number from 0; an array of the axes of a new figure.

    The layout depends on the kind of the file, so that axes cannot be given.
    """
    figure, _ = _file_figure(diagnosis, diagnosis.gaps[file], name)
    return np.array(figure.axes, dtype=object)


def _file_figure(diagnosis: Diagnosis, gap: FileGap, name: str) -> tuple[Figure, str]:
    draw = {PROFILE_SCAN: scan_gap, HYSTERESIS: loop_gap}.get(gap.recording.kind, turn_gap)
    with style():
        figure, caption = draw(diagnosis, gap)
        lead = f"{plain(name)}, " if name else ""
        figure.suptitle(f"{lead}{plain(gap.recording.name)}: {gap.recording.kind.title}")
    return figure, caption


def pictures(diagnosis: Diagnosis, name: str) -> list[Picture]:
    """File stem, caption and figure of every picture: the summary, then one for each file."""
    drawn = [("diagnosis_summary", _SUMMARY, figure_holding(diagnosis_summary(diagnosis, name=name)))]
    for gap in diagnosis.gaps:
        base = "gap_" + (re.sub(r"[^A-Za-z0-9]+", "_", PurePath(gap.recording.name).stem).strip("_").lower() or "file")
        taken = {stem for stem, _, _ in drawn}
        stem = next(s for s in (base, *(f"{base}_{n}" for n in range(2, 1000))) if s not in taken)
        figure, caption = _file_figure(diagnosis, gap, name)
        drawn.append((stem, f"{gap.recording.name}: {caption}", figure))
    return drawn


def measurement_plan(rows: Sequence[Detectability], ax: Any = None, *, name: str = "") -> Any:
    """Detectable and identifiable size of each effect by each measurement, over its tolerance; two axes."""
    effects = list(dict.fromkeys(row.effect for row in rows))
    files = list(dict.fromkeys(row.measurements for row in rows))
    with canvas(ax, (11.0, 9.0), 1, 2, sharey=True) as drawn:
        for axes, title, size in zip(
            drawn.axes,
            ("detected with 80 % probability", "identified among all effects"),
            ("detectable", "identifiable"),
            strict=True,
        ):
            values = np.full((len(effects), len(files)), np.nan)
            for row in rows:
                ratio = getattr(row, size) / _tolerance(row)
                values[effects.index(row.effect), files.index(row.measurements)] = np.log10(ratio)
            shown = np.ma.masked_invalid(values)
            image = axes.imshow(shown, aspect="auto", cmap="RdYlGn_r", vmin=-_RANGE, vmax=_RANGE)
            axes.set_facecolor("#E6E6E6")
            axes.grid(visible=False)
            axes.set_xticks(range(len(files)), [f.replace(" at ", "\nat ") for f in files], rotation=45, ha="right")
            axes.set_yticks(range(len(effects)), [e.replace("_", " ") for e in effects])
            axes.set_title(title)
        bar = drawn.figure.colorbar(image, ax=list(drawn.axes), shrink=0.6, extend="both")
        bar.set_ticks([-2, -1, 0, 1, 2], labels=["1/100", "1/10", "1", "10", "100"])
        bar.set_label("smallest size over the manufacturing tolerance (grey: never)")
        drawn.title(name, "smallest detectable and identifiable sizes by measurement")
    return drawn.axes


def _tolerance(row: Detectability) -> float:
    """Tolerance in the unit of the coordinate; for ``series_compliance`` that is the reciprocal stiffness."""
    size = next(p for p in parameters(EFFECTS[row.effect]) if p.name == row.size)
    tolerance = float(size.tolerance or 1.0)
    return 1.0 / tolerance if row.effect == "series_compliance" else tolerance
