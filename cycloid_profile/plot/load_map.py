"""Force and pressure of every pin over one turn of the crank."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from cycloid_profile.design.record import DesignRecord
from cycloid_profile.plot.style import new_figure, plain, style
from cycloid_profile.units import NEWTON_METRE

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def load_map(record: DesignRecord) -> Figure:
    """Left: force on each pin by disc 1. Right: its peak pressure. White: no contact."""
    loaded = record.under_load
    pins = record.drive.trochoid.pins
    extent = (0.0, 360.0, 0.5, pins + 0.5)
    with style():
        figure = new_figure(10.0, 4.8)
        panels = figure.subplots(1, 2)
        shown = ((loaded.force, "force on the pin [N]", "viridis"), (loaded.pressure, "peak pressure [MPa]", "magma"))
        for ax, (value, label, colours) in zip(panels, shown, strict=True):
            seen = np.where(loaded.loaded[:, 0], value[:, 0], np.nan).T
            drawn = ax.imshow(
                seen, origin="lower", aspect="auto", extent=extent, cmap=colours, vmin=0.0, interpolation="nearest"
            )
            figure.colorbar(drawn, ax=ax, label=label)
            ax.set(xlabel="crank angle [°]", ylabel="pin [number]", xlim=(0.0, 360.0))
            ax.set_xticks(range(0, 361, 60))
            ax.grid(visible=False)
        figure.suptitle(
            f"{plain(record.spec.name)}: disc 1 at {record.case.torque / NEWTON_METRE:.4g} N·m, tooth as ground"
        )
    return figure
