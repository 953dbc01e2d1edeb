"""Figure of an NC program as it runs: plan of rapid, approach and cutting moves, and height along the way."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.arrays import ComplexArray
from cycloid_profile.export.nc import Blank, Motion, Program
from cycloid_profile.plot.style import BLACK, BLUE, GREEN, GREY, ORANGE, canvas
from cycloid_profile.units import DEGREE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_KINDS = (("rapid", ORANGE, "rapid"), ("air", GREEN, "approach and retract"), ("cut", BLUE, "in the blank"))
_ARC_POINTS = 9


def nc_program(program: Program, blank: Blank, title: str = "", ax: Any = None) -> Any:
    """Plan of a program's path in the frame of the disc, and its height along the way; 1 × 2 axes.

    The path of a compensated tool is that of its contact, any other that of its centre.
    """
    with canvas(ax, (11.0, 5.0), 1, 2) as drawn:
        plan, side = np.ravel(drawn.axes)
        _plan(plan, program, blank)
        _height(side, program, blank)
        drawn.title(title or "NC program", f"{len(program.motions)} motions")
    return drawn.axes


def _along(motion: Motion) -> ComplexArray:
    """Points of a motion in the frame of the disc [mm]; C turns the disc, X of a polar program is a radius."""
    start, end = motion.start, motion.end
    share = np.linspace(0.0, 1.0, 2 if motion.kind in ("rapid", "line") and start.c == end.c else _ARC_POINTS)
    if math.isnan(end.y):
        x, c = (a + share * (b - a) for a, b in ((start.x, end.x), (start.c, end.c)))
        return np.asarray(x * np.exp(-1j * c * DEGREE), dtype=np.complex128)
    if motion.kind in ("rapid", "line"):
        return np.asarray(start.plane + share * (end.plane - start.plane), dtype=np.complex128)
    a, b = start.plane - motion.centre, end.plane - motion.centre
    turn = float(np.angle(b / a)) % (2.0 * math.pi)
    swept = share * (turn if motion.kind == "anticlockwise" else turn - 2.0 * math.pi)
    return np.asarray(motion.centre + a * np.exp(1j * swept), dtype=np.complex128)


def _kind(motion: Motion, blank: Blank, points: ComplexArray) -> str:
    if motion.kind == "rapid":
        return "rapid"
    lower = min(motion.start.z, motion.end.z)
    inside = bool(np.any(np.abs(points) < blank.radius + 3.0)) and not lower >= blank.height
    # Arcs and turns of C cut; straight moves in X and Y lead in and out.
    return "cut" if inside and (motion.kind != "line" or motion.start.c != motion.end.c) else "air"


def _plan(ax: Axes, program: Program, blank: Blank) -> None:
    rows: dict[str, list[ComplexArray]] = {kind: [] for kind, _, _ in _KINDS}
    gap = np.array([complex(math.nan, math.nan)])
    for motion in program.motions:
        points = _along(motion)
        if not np.any(np.isnan(points)):
            rows[_kind(motion, blank, points)] += [points, gap]
    rim = blank.radius * np.exp(1j * np.linspace(0.0, 2.0 * math.pi, 181))
    ax.plot(rim.real, rim.imag, color=GREY, linestyle=":", linewidth=0.9, label="blank")
    for kind, colour, label in _KINDS:
        if rows[kind]:
            path = np.concatenate(rows[kind])
            ax.plot(path.real, path.imag, color=colour, linewidth=0.9 if kind == "cut" else 1.6, label=label)
    ax.set_aspect("equal")
    ax.set(xlabel="X [mm]", ylabel="Y [mm]", title="plan, frame of the disc")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2, fontsize=8)


def _height(ax: Axes, program: Program, blank: Blank) -> None:
    known = [motion for motion in program.motions if not math.isnan(motion.start.z)]
    if not known:
        ax.text(0.5, 0.5, "no Z: a wire", ha="center", va="center", transform=ax.transAxes)
        ax.set_axis_off()
        return
    number = np.arange(len(known) + 1.0)
    z = [known[0].start.z, *(motion.end.z for motion in known)]
    ax.axhspan(0.0, blank.height, color=GREY, alpha=0.3, label="disc")
    ax.plot(number, z, color=BLACK, linewidth=1.2, label="Z of the tool")
    on = np.array([motion.state.spindle > 0.0 for motion in known])
    low = min(0.0, *z)
    ax.fill_between(number[1:], low - 4.0, low - 2.0, where=on, color=BLUE, alpha=0.6, label="spindle on")
    ax.set(xlabel="motion", ylabel="Z [mm]", title="height")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=1, fontsize=8)
