"""The whole stage at rated torque: pin forces and pressure, sliding, and the loads of the crank bearings."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from cycloid_profile.contact.running import sliding_speed
from cycloid_profile.design.from_spec import output_speed
from cycloid_profile.design.record import DesignRecord
from cycloid_profile.plot.style import BLUE, GREEN, ORANGE, SKY, new_figure, plain, style
from cycloid_profile.units import DEGREE, NEWTON_METRE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_DOTS = 250
_LINES = (("-", BLUE), ("--", ORANGE), ("-.", GREEN), (":", SKY))


def under_load(record: DesignRecord) -> Figure:
    """Force, pressure and sliding against the phase of a pin; bearing forces over one turn of the crank."""
    loaded = record.under_load
    psi, force, pressure = (value[loaded.loaded] for value in (loaded.phase / DEGREE, loaded.force, loaded.pressure))
    # Thousands of pins make a dense row of dots; some hundreds show it as well.
    order = np.argsort(psi)[:: max(1, psi.size // _DOTS)]
    with style():
        figure = new_figure(10.0, 7.0)
        (pins, stress), (slide, bearings) = figure.subplots(2, 2)
        dots = {"marker": ".", "linestyle": "none", "markersize": 4}
        pins.plot(psi[order], force[order], color=BLUE, **dots)
        pins.set(xlabel="phase ψ of the pin [°]", ylabel="force [N]", title=f"force, up to {loaded.max_force:.4g} N")
        stress.plot(psi[order], pressure[order], color=ORANGE, **dots)
        stress.set(
            xlabel="phase ψ of the pin [°]",
            ylabel="peak pressure [MPa]",
            title=f"pressure, up to {loaded.max_pressure:.4g} MPa",
        )
        grid = np.linspace(0.0, np.pi, 181)
        speed = sliding_speed(record.drive, grid, output_speed(record.spec))
        slide.plot(grid / DEGREE, speed, color=GREEN)
        if psi.size:
            slide.axvspan(float(psi.min()), float(psi.max()), color=SKY, alpha=0.25, label="loaded flank")
            slide.legend(loc="upper left")
        slide.set(
            xlabel="phase ψ of the pin [°]",
            ylabel="sliding speed [mm/s]",
            title=f"sliding at {record.spec.load.output_speed_rpm:g} rpm output, pin held",
        )
        for ax in (pins, stress, slide):
            ax.set_xlim(0.0, 180.0)
            ax.set_xticks(range(0, 181, 30))
            ax.set_ylim(bottom=0.0)
        _bearings(bearings, record)
        figure.suptitle(
            f"{plain(record.spec.name)}: all discs at {record.case.torque / NEWTON_METRE:.4g} N·m, tooth as ground"
        )
    return figure


def _bearings(ax: Axes, record: DesignRecord) -> None:
    stage = record.under_load.stage
    assert stage is not None
    # Not closed: after one turn of the crank the carrier stands a little further.
    angle = record.under_load.crank_angle / DEGREE
    force = np.abs(stage.bearing_force[:, 0])
    for m in range(force.shape[1]):
        dash, colour = _LINES[m % len(_LINES)]
        label = f"crank {m + 1}" if force.shape[1] > 1 else "eccentric"
        ax.plot(angle, force[:, m], linestyle=dash, color=colour, label=label)
    low, high = 0.0, 1.25 * float(np.max(force))
    ax.set(
        xlabel="crank angle [°]",
        ylabel="bearing force [N]",
        title=f"bearings of disc 1, up to {float(np.max(force)):.4g} N",
        xlim=(0.0, 360.0),
        ylim=(low, high),
    )
    ax.set_xticks(range(0, 361, 60))
    ax.legend(loc="upper center", ncols=min(force.shape[1], 4))
