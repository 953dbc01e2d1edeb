"""How far the gap of each file shrank, beside its noise."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from cycloid_profile.discrepancy.outcome import Diagnosis, FileGap
from cycloid_profile.plot.diagnosis_marks import with_unit
from cycloid_profile.plot.style import BLACK, BLUE, ORANGE, new_figure, plain, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def summary(diagnosis: Diagnosis, name: str) -> tuple[str, str, Figure]:
    """RMS over the noise of every file, before and after, on fitted and held-out rows."""
    from matplotlib.ticker import LogLocator, NullFormatter

    changed = bool(diagnosis.effects)
    with style():
        figure = new_figure(9.5, 1.7 + (1.15 if changed else 0.75) * len(diagnosis.gaps))
        ax = figure.add_subplot()
        middles, largest = [], 1.0
        y = 0.0
        for gap in diagnosis.gaps:
            bars = [(v, c, h) for v, c, h in _bars(gap, changed) if math.isfinite(v)]
            middles.append(y + 0.5 * (len(bars) - 1))
            for value, colour, held in bars:
                ratio = value / gap.noise
                largest = max(largest, ratio)
                look: dict[str, Any] = {"color": colour} if not held else {"facecolor": "white", "edgecolor": colour}
                ax.barh(y, ratio, height=0.8, hatch="///" if held else None, linewidth=1.0, **look)
                text = with_unit(value, gap)
                if held and gap.closure is not None and changed and colour == ORANGE:
                    text += f", gap closed by {100.0 * min(gap.closure, 1.0):.1f} %"
                ax.annotate(text, (ratio, y), xytext=(4, 0), textcoords="offset points", va="center", fontsize=8.5)
                y += 1.0
            y += 0.8
        ax.axvline(1.0, color=BLACK, linewidth=1.2, linestyle="--")
        ax.set_xscale("log")
        ax.set_xlim(0.5, largest * (largest / 0.5) ** 0.45)
        ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if largest < 30.0 else (1.0,)))
        ax.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
        ax.xaxis.set_minor_formatter(NullFormatter())
        ax.set_yticks(middles, [f"{plain(g.recording.name)}\nnoise {with_unit(g.noise, g)}" for g in diagnosis.gaps])
        ax.tick_params(axis="y", length=0)
        ax.grid(visible=False, axis="y")
        ax.invert_yaxis()
        ax.set_xlabel("rms of measured minus predicted over the noise [–], dashed: the noise")
        ax.set_title(f"{plain(name)}: what is left")
        _legend(ax, changed)
    caption = (
        "How far measurement and prediction are apart, in units of the noise. "
        "Held-out rows took no part in finding the effects."
    )
    return "diagnosis_summary", caption, figure


def _bars(gap: FileGap, changed: bool) -> list[tuple[float, str, bool]]:
    """Value, colour and whether of held-out rows."""
    bars = [(gap.fit_before, BLUE, False), (gap.fit_after, ORANGE, False)]
    bars += [(gap.held_out_before, BLUE, True), (gap.held_out_after, ORANGE, True)]
    return [bar for bar in bars if changed or bar[1] == BLUE]


def _legend(ax: Axes, changed: bool) -> None:
    from matplotlib.patches import Patch

    handles = []
    for colour, when in ((BLUE, "before, " if changed else ""), (ORANGE, "after, ")):
        if changed or colour == BLUE:
            handles.append(Patch(color=colour, label=f"{when}fitted rows"))
            handles.append(Patch(facecolor="white", edgecolor=colour, hatch="///", label=f"{when}held-out rows"))
    ax.figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), fontsize=9)
