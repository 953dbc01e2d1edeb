"""How the pins share the load: gap before load and force under it, pin by pin."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from cycloid_profile.design.record import DesignRecord
from cycloid_profile.plot.style import BLUE, ORANGE, new_figure, phase_axis, plain, style
from cycloid_profile.units import DEGREE, UM

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def gap_and_force(record: DesignRecord) -> Figure:
    """Gap after take-up and force of each pin on the loaded flank, classical and equilibrium."""
    classical, equilibrium = record.classical, record.equilibrium
    loaded = (equilibrium.phase[0, 0] > 0.0) & (equilibrium.phase[0, 0] < np.pi - 1e-9)
    exact_psi = equilibrium.phase[0, 0][loaded] / DEGREE
    psi = classical.phase[0, 0] / DEGREE
    width = 0.38 * 360.0 / record.drive.trochoid.pins
    with style():
        figure = new_figure(8.0, 6.4)
        top, bottom = figure.subplots(2, 1, sharex=True)
        top.bar(psi - 0.5 * width, classical.gap[0, 0] / UM, width, color=BLUE, label="closed form (classical)")
        top.bar(exact_psi + 0.5 * width, equilibrium.gap[0, 0][loaded] / UM, width, color=ORANGE, label="exact")
        top.set_ylabel("gap when the first pin touches [µm]")
        top.legend(loc="upper center")
        top.set_title(f"{plain(record.spec.name)}: pins of the loaded flank, conventional tooth")
        bottom.bar(
            psi - 0.5 * width,
            classical.force[0, 0],
            width,
            color=BLUE,
            label=f"classical, {record.case.disc_share:g} of the torque on one disc",
        )
        bottom.bar(
            exact_psi + 0.5 * width,
            equilibrium.force[0, 0][loaded],
            width,
            color=ORANGE,
            label=f"equilibrium, 1/{record.drive.discs} of the torque",
        )
        bottom.set_ylabel("force on the pin [N]")
        bottom.legend(loc="upper right")
        phase_axis(bottom, 0, 180)
    return figure
