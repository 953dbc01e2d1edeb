"""What each measurement could tell: smallest detectable and nameable sizes beside the workshop tolerance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from cycloid_profile.discrepancy.plan import Visibility
from cycloid_profile.effects.effect import parameters
from cycloid_profile.effects.registry import EFFECTS
from cycloid_profile.plot.style import new_figure, plain, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_RANGE = 2.0  # decades to either side of the tolerance


def plan_plot(rows: Sequence[Visibility], name: str) -> Figure:
    """Two maps, effects over measurements: what is seen, and what can be named, in workshop tolerances."""
    effects = list(dict.fromkeys(row.effect for row in rows))
    files = list(dict.fromkeys(row.measurements for row in rows))
    with style():
        figure = new_figure(11.0, 9.0)
        left, right = figure.subplots(1, 2, sharey=True)
        for ax, title, pick in (
            (left, "seen, 80 % of the time", "detectable"),
            (right, "seen and told from all others", "identifiable"),
        ):
            values = np.full((len(effects), len(files)), np.nan)
            for row in rows:
                size = getattr(row, pick) / _tolerance(row)
                values[effects.index(row.effect), files.index(row.measurements)] = np.log10(size)
            shown = np.ma.masked_invalid(values)
            drawn = ax.imshow(shown, aspect="auto", cmap="RdYlGn_r", vmin=-_RANGE, vmax=_RANGE)
            ax.set_facecolor("#E6E6E6")
            ax.grid(visible=False)
            ax.set_xticks(range(len(files)), [f.replace(" at ", "\nat ") for f in files], rotation=45, ha="right")
            ax.set_yticks(range(len(effects)), [e.replace("_", " ") for e in effects])
            ax.set_title(title)
        bar = figure.colorbar(drawn, ax=[left, right], shrink=0.6, extend="both")
        bar.set_ticks([-2, -1, 0, 1, 2], labels=["1/100", "1/10", "1", "10", "100"])
        bar.set_label("smallest size over the workshop tolerance (grey: never)")
        figure.suptitle(f"{plain(name)}: what each measurement could tell")
    return figure


def _tolerance(row: Visibility) -> float:
    """Workshop tolerance in the unit of the coordinate, which is the reciprocal of a stiffness."""
    size = next(p for p in parameters(EFFECTS[row.effect]) if p.name == row.size)
    tolerance = float(size.tolerance or 1.0)
    return 1.0 / tolerance if row.effect == "series_compliance" else tolerance
