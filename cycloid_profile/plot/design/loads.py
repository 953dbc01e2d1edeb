"""Figures of loads: pins that share the torque, every pin over a turn of the crank, and the whole stage."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.contact import LoadSharing, sliding_speed
from cycloid_profile.design import DesignRecord, output_speed
from cycloid_profile.plot.style import BLUE, GREEN, ORANGE, SKY, canvas, phase_axis, titled
from cycloid_profile.units import ARCMIN, DEGREE, NEWTON_METRE, UM

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_DOTS = 250  # contacts beyond which dots overlap
_HEIGHTS = 46  # cells over the face width
_LINES = (("-", BLUE), ("--", ORANGE), ("-.", GREEN), (":", SKY))
_PARTS = (("0.75", ""), (BLUE, ""), (SKY, ""), (ORANGE, ""), (GREEN, ""), (BLUE, "//"), (ORANGE, "\\\\"), (GREEN, ".."))
_PHASE = "phase ψ of the pin [°]"


def load_sharing(result: DesignRecord | LoadSharing, ax: Any = None) -> Any:
    """Gap before load and force of each pin of disc 1 on the loaded flank at the first pose; two axes.

    A design compares the classical scheme with the equilibrium, both for the conventional tooth.
    """
    if isinstance(result, LoadSharing):
        title, pins = "pins of the loaded flank", result.case.drive.trochoid.pins
        bars = [(result, _loaded_flank(result), 0.0, BLUE, result.solver, result.solver)]
    else:
        title, pins = (
            titled(result.spec.name, "pins of the loaded flank, conventional tooth"),
            result.drive.trochoid.pins,
        )
        share, part = f"{result.case.disc_share:g} of the torque on one disc", f"1/{result.drive.discs} of the torque"
        every, flank = slice(None), _loaded_flank(result.equilibrium)
        bars = [
            (result.classical, every, -0.5, BLUE, "closed form (classical)", f"classical, {share}"),
            (result.equilibrium, flank, 0.5, ORANGE, "exact", f"equilibrium, {part}"),
        ]
    width = 0.38 * 360.0 / pins
    with canvas(ax, (8.0, 6.4), 2, sharex=True) as drawn:
        top, bottom = drawn.axes
        for sharing, shown, side, colour, gap_label, force_label in bars:
            at = sharing.phase[0, 0][shown] / DEGREE + side * width
            top.bar(at, sharing.gap[0, 0][shown] / UM, width, color=colour, label=gap_label)
            bottom.bar(at, sharing.force[0, 0][shown], width, color=colour, label=force_label)
        top.set(ylabel="gap when the first pin touches [µm]", title=title)
        top.legend(loc="upper center")
        bottom.set_ylabel("force on the pin [N]")
        bottom.legend(loc="upper right")
        phase_axis(bottom, 0, 180)
    return drawn.axes


def _loaded_flank(sharing: LoadSharing) -> Any:
    """Which pins of disc 1 lie on the loaded flank at the first pose, shape (pins,)."""
    phase = sharing.phase[0, 0]
    return (phase > 0.0) & (phase < np.pi - 1e-9)


def load_map(result: DesignRecord | LoadSharing, ax: Any = None) -> Any:
    """Force on each pin by disc 1, and its peak pressure, over the crank angle; white without contact; two axes."""
    loaded = result if isinstance(result, LoadSharing) else result.under_load
    torque = f"disc 1 at {result.case.torque / NEWTON_METRE:.4g} N·m"
    pins, crank = loaded.case.drive.trochoid.pins, loaded.crank_angle / DEGREE
    step = float(crank[1] - crank[0]) if crank.size > 1 else 1.0
    extent = (float(crank[0]), round(float(crank[0]) + step * crank.size, 9), 0.5, pins + 0.5)
    with canvas(ax, (10.0, 4.8), 1, 2) as drawn:
        shown = ((loaded.force, "force on the pin [N]", "viridis"), (loaded.pressure, "peak pressure [MPa]", "magma"))
        for axes, (value, label, colours) in zip(drawn.axes, shown, strict=True):
            seen = np.where(loaded.loaded[:, 0], value[:, 0], np.nan).T
            image = axes.imshow(
                seen, origin="lower", aspect="auto", extent=extent, cmap=colours, vmin=0.0, interpolation="nearest"
            )
            drawn.figure.colorbar(image, ax=axes, label=label)
            _crank_axis(axes, extent[:2])
            axes.set_ylabel("pin [number]")
            axes.grid(visible=False)
        if isinstance(result, LoadSharing):
            drawn.title("", torque)
        else:
            drawn.title(result.spec.name, f"{torque}, tooth as ground")
    return drawn.axes


def pressure_over_width(result: DesignRecord | LoadSharing, ax: Any = None) -> Any:
    """Peak pressure on the pins of disc 1 over its face width, at the pose of the largest; white without contact."""
    loaded = result if isinstance(result, LoadSharing) else result.under_load
    b, pins = loaded.case.drive.disc_width, loaded.case.drive.trochoid.pins
    worst = int(np.argmax(np.max(loaded.edge_pressure[:, 0], axis=1)))
    edges = np.linspace(-0.5 * b, 0.5 * b, _HEIGHTS + 1)
    heights = 0.5 * (edges[1:] + edges[:-1])
    pressure = np.stack([loaded.pressure_at(float(z))[worst, 0] for z in heights], axis=-1)
    order = np.argsort(np.mod(loaded.phase[worst, 0], 2.0 * np.pi))
    order = order[loaded.force[worst, 0][order] > 0.0]
    with canvas(ax, (7.0, 4.8)) as drawn:
        axes = drawn.axes
        seen = np.where(pressure[order] > 0.0, pressure[order], np.nan)
        extent = (-0.5 * b, 0.5 * b, 0.5, order.size + 0.5)
        image = axes.imshow(
            seen, origin="lower", aspect="auto", extent=extent, cmap="magma", vmin=0.0, interpolation="nearest"
        )
        drawn.figure.colorbar(image, ax=axes, label="peak pressure [MPa]")
        axes.set_yticks(range(1, order.size + 1), [f"{k % pins + 1}" for k in order])
        axes.set(xlabel="height above the mid-plane [mm]", ylabel="pin [number], by phase")
        axes.grid(visible=False)
        crank = f"disc 1, crank at {loaded.crank_angle[worst] / DEGREE:.4g}°"
        drawn.title("" if isinstance(result, LoadSharing) else result.spec.name, f"pressure over the width, {crank}")
    return drawn.axes


def stage_load(record: DesignRecord, ax: Any = None) -> Any:
    """Force, pressure and sliding against the phase of a pin; bearing forces over one turn of the crank; 2 × 2 axes."""
    loaded = record.under_load
    psi, force, pressure = (value[loaded.loaded] for value in (loaded.phase / DEGREE, loaded.force, loaded.pressure))
    # Some hundreds of dots draw the curve of thousands of pins well enough.
    order = np.argsort(psi)[:: max(1, psi.size // _DOTS)]
    with canvas(ax, (10.0, 7.0), 2, 2) as drawn:
        (pins, stress), (slide, bearings) = drawn.axes
        dots = {"marker": ".", "linestyle": "none", "markersize": 4}
        pins.plot(psi[order], force[order], color=BLUE, **dots)
        pins.set(ylabel="force [N]", title=f"force, up to {loaded.max_force:.4g} N")
        stress.plot(psi[order], pressure[order], color=ORANGE, **dots)
        stress.set(ylabel="peak pressure [MPa]", title=f"pressure, up to {loaded.max_pressure:.4g} MPa")
        grid = np.linspace(0.0, np.pi, 181)
        slide.plot(grid / DEGREE, sliding_speed(record.drive, grid, output_speed(record.spec)), color=GREEN)
        if psi.size:
            slide.axvspan(float(psi.min()), float(psi.max()), color=SKY, alpha=0.25, label="loaded flank")
            slide.legend(loc="upper left")
        speed = f"sliding at {record.spec.load.output_speed_rpm:g} rpm output, pin held"
        slide.set(ylabel="sliding speed [mm/s]", title=speed)
        for axes in (pins, stress, slide):
            axes.set(xlabel=_PHASE, xlim=(0.0, 180.0), xticks=range(0, 181, 30))
            axes.set_ylim(bottom=0.0)
        _bearings(bearings, loaded)
        torque = f"all discs at {record.case.torque / NEWTON_METRE:.4g} N·m"
        drawn.title(record.spec.name, f"{torque}, tooth as ground")
    return drawn.axes


def rotation_by_part(results: LoadSharing | Mapping[str, LoadSharing], ax: Any = None) -> Any:
    """Rotation of the output as a bar of its parts, one bar for each stage under load, means over the poses; one axis.

    Several results are given by name. See ``LoadSharing.rotation_by_part``.
    """
    every = {results.solver: results} if isinstance(results, LoadSharing) else results
    parts = {label: one.rotation_by_part for label, one in every.items()}
    names = list(dict.fromkeys(name for one in parts.values() for name in one))
    with canvas(ax, (9.0, 1.6 + 0.45 * len(every))) as drawn:
        begin = np.zeros(len(parts))
        for i, name in enumerate(names):
            width = np.array([float(np.mean(np.abs(one.get(name, 0.0)))) / ARCMIN for one in parts.values()])
            colour, hatch = _PARTS[i % len(_PARTS)]
            drawn.axes.barh(
                list(parts), width, left=begin, color=colour, hatch=hatch, edgecolor="white", label=name, height=0.7
            )
            begin += width
        drawn.axes.invert_yaxis()
        drawn.axes.set(xlabel="rotation of the output [′]", xlim=(0.0, 1.02 * float(np.max(begin))))
        drawn.axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.15), ncols=len(names), fontsize="small")
        drawn.title("", "shares of the parts in the rotation at the torque of the case")
    return drawn.axes


def _bearings(ax: Axes, loaded: LoadSharing) -> None:
    """Force of each bearing of disc 1; the curves do not close, as a turn of the crank turns the carrier a little."""
    assert loaded.stage is not None
    force = np.abs(loaded.stage.bearing_force[:, 0])
    for m in range(force.shape[1]):
        dash, colour = _LINES[m % len(_LINES)]
        label = f"crank {m + 1}" if force.shape[1] > 1 else "eccentric"
        ax.plot(loaded.crank_angle / DEGREE, force[:, m], linestyle=dash, color=colour, label=label)
    highest = float(np.max(force))
    ax.set(ylabel="bearing force [N]", title=f"bearings of disc 1, up to {highest:.4g} N", ylim=(0.0, 1.25 * highest))
    _crank_axis(ax, (0.0, 360.0))
    ax.legend(loc="upper center", ncols=min(force.shape[1], 4))


def _crank_axis(ax: Axes, limits: tuple[float, float]) -> None:
    ax.set(xlabel="crank angle [°]", xlim=limits)
    if limits == (0.0, 360.0):
        ax.set_xticks(range(0, 361, 60))
