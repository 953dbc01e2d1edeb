"""Figures of solver results: accuracy of the output, and convergence of the iterations."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.mesh import input_locked_factor
from cycloid_profile.design import LOAD_SHARES, Accuracy, DesignRecord
from cycloid_profile.plot.style import BLUE, COMPENSATED, CONVENTIONAL, GREY, ORANGE, canvas, headroom, note
from cycloid_profile.units import ARCMIN, ARCSEC, NEWTON_METRE, NM, UM

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_PUBLISHED_STOP = 1e-3  # relative change at which the published iteration ends


def accuracy(result: DesignRecord | Accuracy, ax: Any = None) -> Any:
    """Torsion of the output with the input locked, and transmission error at rated torque; two axes."""
    if isinstance(result, Accuracy):
        name, cases = "", [("nominal drive", CONVENTIONAL, result)]
    else:
        name, cases = result.spec.name, [("conventional", CONVENTIONAL, result.conventional_accuracy)]
        if result.compensation is not None:
            cases.append(("compensated", COMPENSATED, result.compensated_accuracy))
    with canvas(ax, (10.0, 4.6), 1, 2, width_ratios=(1.2, 1.0)) as drawn:
        left, right = drawn.axes
        for label, look, found in cases:
            _torque_over_twist(left, found, label, look)
            error = found.rotation[LOAD_SHARES.index(1.0)]
            angle = found.crank_angle * 180.0 / np.pi
            whole = angle[-1] + angle[1] - angle[0]
            right.plot(
                np.append(angle, whole),
                np.append(error, error[0]) / ARCSEC - error.mean() / ARCSEC,
                **look,
                label=f"{label}: {found.transmission_error / ARCSEC:.3f}″ peak to peak",
            )
        left.axhline(0.0, color=GREY, linewidth=0.8)
        left.set(xlabel="twist of the output, input held [′]", ylabel="torque [N·m]")
        left.set_title("torque and twist, no friction")
        headroom(left, 0.35)
        right.set(xlabel="crank angle over one cycle [°]", ylabel="transmission error [″]")
        right.set(title="at rated torque", xlim=(0.0, whole))
        headroom(right, 0.3)
        for axes in drawn.axes:
            axes.legend(loc="upper left", fontsize=9)
        body = "elastic" if cases[0][2].case.disc_bodies else "rigid"
        drawn.title(name, f"mesh, crank bearings and {body} discs")
    return drawn.axes


def _torque_over_twist(ax: Axes, found: Accuracy, label: str, look: dict[str, Any]) -> None:
    # Without torque the output is free between the two touches.
    touches = [found.backlash.backward, found.backlash.forward]
    free_twist = [float(np.mean(t)) * input_locked_factor(found.case.drive) for t in touches]
    half = len(found.torque) // 2
    ax.plot(
        np.insert(np.mean(found.rotation, axis=1), half, free_twist) / ARCMIN,
        np.insert(found.torque, half, [0.0, 0.0]) / NEWTON_METRE,
        marker=".",
        **look,
        label=f"{label}: lost motion {found.lost_motion / ARCMIN:.3f}′,\n"
        f"{found.torsional_rigidity * ARCMIN / NEWTON_METRE:.4g} N·m/′ at 50–100 %",
    )


def convergence(record: DesignRecord, ax: Any = None) -> Any:
    """Error of the largest pin force by iteration, and change of δmax by round of compensation; two axes."""
    with canvas(ax, (9.6, 4.4), 1, 2) as drawn:
        left, right = drawn.axes
        for sharing, colour, marker in ((record.classical, BLUE, "o"), (record.equilibrium, ORANGE, "s")):
            force = np.array([step[0] for step in sharing.history])
            error = _drawable(np.abs(force / force[-1] - 1.0), 1e-10)
            label = f"{sharing.solver}: {sharing.iterations} iteration{'s' * (sharing.iterations != 1)}"
            look: dict[str, Any] = {"color": colour, "markersize": 5, "linestyle": "-", "linewidth": 1.0}
            left.semilogy(np.arange(1, error.size + 1), error, marker, label=label, **look)
        _stop_line(left, _PUBLISHED_STOP, "published stop, 0.1 %")
        left.set(xlabel="iteration", ylabel="relative error of the largest force, to 1e-10", title="load sharing")
        left.set_ylim(3e-11, 20.0)
        left.minorticks_off()
        left.legend(loc="upper right")
        _rounds(right, record)
        drawn.title(record.spec.name, "convergence")
    return drawn.axes


def _drawable(values: FloatArray, floor: float) -> FloatArray:
    """Values for a logarithmic axis, to three digits and not below ``floor``, where rounding errors prevail."""
    return np.array([float(f"{max(value, floor):.2e}") for value in values.tolist()])


def _stop_line(ax: Axes, value: float, text: str) -> None:
    ax.axhline(value, color=GREY, linestyle=":", linewidth=1.0)
    ax.text(
        0.98, value * 1.3, text, color=GREY, ha="right", va="bottom", fontsize=9, transform=ax.get_yaxis_transform()
    )


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
        note(ax, f"{delta / UM:.4f} µm", (i, change[i - 1]), (6, 6), fontsize=9)
    _stop_line(ax, 0.1, "stop, 0.1 nm")
    ax.set_xticks(rounds)
    ax.minorticks_off()
    ax.set_xlim(0.7, change.size + 0.8)
