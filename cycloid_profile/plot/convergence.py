"""How the iterations end: the engagement iteration, the moment balance and the compensation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.sharing import LoadSharing
from cycloid_profile.design.record import DesignRecord
from cycloid_profile.plot.style import BLUE, GREY, ORANGE, new_figure, plain, style
from cycloid_profile.units import NM, UM

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PUBLISHED_STOP = 1e-3


def convergence(record: DesignRecord) -> Figure:
    """Left: error of the largest pin force by iteration. Right: change of δmax by round of compensation."""
    with style():
        figure = new_figure(9.6, 4.4)
        left, right = figure.subplots(1, 2)
        for sharing, colour, marker in ((record.classical, BLUE, "o"), (record.equilibrium, ORANGE, "s")):
            error = _relative_error(sharing)
            left.semilogy(
                np.arange(1, error.size + 1),
                error,
                marker,
                color=colour,
                markersize=5,
                linestyle="-",
                linewidth=1.0,
                label=f"{sharing.solver}: {sharing.iterations} iterations",
            )
        left.axhline(_PUBLISHED_STOP, color=GREY, linestyle=":", linewidth=1.0)
        left.text(
            0.98,
            _PUBLISHED_STOP * 1.3,
            "published stop, 0.1 %",
            color=GREY,
            ha="right",
            va="bottom",
            fontsize=9,
            transform=left.get_yaxis_transform(),
        )
        left.set(xlabel="iteration", ylabel="relative error of the largest force, to 1e-10", title="load sharing")
        left.set_ylim(3e-11, 20.0)
        left.minorticks_off()
        left.legend(loc="upper right")
        _rounds(right, record)
        figure.suptitle(f"{plain(record.spec.name)}: convergence")
    return figure


def _relative_error(sharing: LoadSharing) -> FloatArray:
    force = np.array([step[0] for step in sharing.history])
    return _drawable(np.abs(force / force[-1] - 1.0), 1e-10)


def _drawable(values: FloatArray, floor: float) -> FloatArray:
    """Values for a logarithmic axis, to three digits and not below ``floor``: under it rounding errors rule."""
    return np.array([float(f"{max(value, floor):.2e}") for value in values.tolist()])


def _rounds(ax: Axes, record: DesignRecord) -> None:
    ax.set(xlabel="round", ylabel="change of δmax [nm], to 0.001 nm", title="deformation compensation")
    if record.compensation is None or record.compensation.sharing is None:
        ax.text(0.5, 0.5, "no iteration: δmax was not sought", ha="center", transform=ax.transAxes, color=GREY)
        ax.set(xticks=[], yticks=[])
        return
    history = np.array([0.0, *record.compensation.history])
    change = _drawable(np.abs(np.diff(history)) / NM, 1e-3)
    rounds = np.arange(1, change.size + 1)
    ax.semilogy(rounds, change, "D-", color=ORANGE, markersize=5, linewidth=1.0)
    for i, delta in zip(rounds.tolist(), history[1:].tolist(), strict=True):
        ax.annotate(f"{delta / UM:.4f} µm", (i, change[i - 1]), xytext=(6, 6), textcoords="offset points", fontsize=9)
    ax.axhline(0.1, color=GREY, linestyle=":", linewidth=1.0)
    ax.text(
        0.98, 0.13, "stop, 0.1 nm", color=GREY, ha="right", va="bottom", fontsize=9, transform=ax.get_yaxis_transform()
    )
    ax.set_xticks(rounds)
    ax.minorticks_off()
    ax.set_xlim(0.7, change.size + 0.8)
