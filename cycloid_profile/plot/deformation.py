"""The deformation δ(ψ) that compensation adds back to the tooth."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from cycloid_profile.design.record import DesignRecord
from cycloid_profile.plot.style import BLUE, GREY, ORANGE, new_figure, phase_axis, plain, style
from cycloid_profile.units import DEGREE, UM

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def deformation(record: DesignRecord) -> Figure:
    """δ(ψ) = δmax |sinψ| S over one lobe, with the approach of each pin under load."""
    trochoid, sharing = record.drive.trochoid, record.equilibrium
    applied = record.compensation is not None
    delta_max = record.compensation.delta_max if record.compensation is not None else sharing.delta_max
    psi = np.linspace(-math.pi, math.pi, 721)
    delta = delta_max * np.abs(trochoid.lever_function(psi))
    psi0 = trochoid.critical_phase
    with style():
        figure = new_figure(8.0, 4.6)
        ax = figure.add_subplot()
        label = "δ(ψ) added to both flanks" if applied else "δ(ψ), not added to the tooth"
        ax.plot(psi / DEGREE, delta / UM, color=ORANGE, linewidth=1.8, label=label)
        shown = slice(None, None, 4)  # every fourth pose draws the curve well enough
        loaded = sharing.force[shown] > 0.0
        ax.plot(
            sharing.phase[shown][loaded] / DEGREE,
            sharing.approach[shown][loaded] / UM,
            ".",
            color=BLUE,
            markersize=4,
            label="approach of the loaded pins, poses of a mesh cycle",
        )
        for side in (-1.0, 1.0):
            ax.axvline(side * psi0 / DEGREE, color=GREY, linewidth=0.9, linestyle=":")
        ax.annotate(
            f"δmax = {delta_max / UM:.3f} µm at ψ0 = {psi0 / DEGREE:.2f}°",
            (-psi0 / DEGREE, delta_max / UM),
            xytext=(0, 6),
            textcoords="offset points",
            ha="center",
        )
        phase_axis(ax)
        ax.set_ylim(0.0, 1.38 * delta_max / UM)
        ax.set_ylabel("deformation along the normal [µm]")
        ax.set_title(f"{plain(record.spec.name)}: deformation at {record.case.torque / 1e3:.4g} N·m")
        ax.legend(loc="upper right")
    return figure
