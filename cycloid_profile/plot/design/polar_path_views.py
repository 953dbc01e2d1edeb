"""Figure of the polar grinding program: wheel, path of the axes C and X, feed and its limits, distance of the wheel
from tangency."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.design import DesignRecord
from cycloid_profile.export.nc import (
    PolarGrinding,
    axis_limits,
    clearance,
    least_concave_radius,
    polar_grinding,
    post_of,
)
from cycloid_profile.plot.style import BLACK, BLUE, GREEN, GREY, ORANGE, SKY, canvas
from cycloid_profile.units import DEGREE, UM

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SHOWN_LOBES = 3
_WHEELS = 9  # drawn over one lobe
_BETWEEN = 8  # points evaluated between two steps


def polar_path(record: DesignRecord, ax: Any = None) -> Any:
    """Four views of the program that ``gcode-polar`` writes, over the first lobe or three; 2 × 2 axes."""
    grinding = polar_grinding(record)
    lobe = _first_lobes(grinding, record, 1)
    with canvas(ax, (11.0, 8.5), 2, 2) as drawn:
        (wheel, path), (feed, tangency) = drawn.axes
        _wheel(wheel, record, grinding, lobe)
        _axes_path(path, record, grinding)
        _feed(feed, record, grinding, lobe)
        _tangency_deviation(tangency, record, grinding, lobe)
        turn = f"{float(np.sum(grinding.feed.time)):.1f} s a turn"
        drawn.title(record.spec.name, f"polar grinding with a wheel of radius {grinding.path.radius:g} mm, {turn}")
    return drawn.axes


def _first_lobes(grinding: PolarGrinding, record: DesignRecord, count: int) -> int:
    """Number of the step at which the wheel has passed ``count`` tips."""
    phase = grinding.path.phase - grinding.path.phase[0]
    lobes = min(count, record.drive.trochoid.lobes)
    return int(np.searchsorted(phase, 2.0 * math.pi * lobes - 1e-9))


def _wheel(ax: Axes, record: DesignRecord, grinding: PolarGrinding, lobe: int) -> None:
    path = grinding.path
    # Seen with the middle of the lobe upwards.
    middle = path.c[0] + math.pi / record.drive.trochoid.lobes
    turn = np.exp(1j * (middle + 0.5 * math.pi))
    period = path.phase[lobe] - path.phase[0]
    psi = np.linspace(path.phase[0] - 0.5 * period, path.phase[lobe] + 0.5 * period, 1201)
    tooth = record.profile.at(np.mod(psi, record.profile.trochoid.phase_period)).position * turn
    centre = path.centre[: lobe + 1] * turn
    low = float(np.min(tooth.imag))
    ax.fill_between(tooth.real, tooth.imag, low, color="#E6E6E6")
    ax.plot(tooth.real, tooth.imag, color=BLACK, linewidth=1.2, label="tooth")
    ax.plot(centre.real, centre.imag, color=ORANGE, linewidth=1.4, label="centre of the wheel")
    for distance in np.linspace(0.0, path.arc_length[lobe], _WHEELS):
        at = centre[int(np.argmin(np.abs(path.arc_length[: lobe + 1] - distance)))]
        rim = at + path.radius * np.exp(1j * np.linspace(0.0, 2.0 * math.pi, 121))
        ax.plot(rim.real, rim.imag, color=SKY, linewidth=0.7)
    limit = least_concave_radius(record.profile)
    ax.set_aspect("equal")
    concave = "no concave part" if math.isinf(limit) else f"least concave radius {limit:.4f} mm"
    ax.set(xlabel="[mm]", ylabel="[mm]", title=f"wheel over one lobe, {concave}")
    top = float(np.max(centre.imag)) + path.radius
    ax.set_ylim(low, top + 0.3 * (top - low))
    ax.legend(loc="upper center", ncols=2, fontsize=9)


def _axes_path(ax: Axes, record: DesignRecord, grinding: PolarGrinding) -> None:
    path = grinding.path
    shown = _first_lobes(grinding, record, _SHOWN_LOBES)
    ax.plot(path.c[: shown + 1] / DEGREE, path.x[: shown + 1], color=BLUE, linewidth=1.4)
    lobes = min(_SHOWN_LOBES, record.drive.trochoid.lobes)
    ax.set(xlabel="C [°]", ylabel="X of the wheel's centre [mm]", title=f"path of the axes, {lobes} lobes")


def _feed(ax: Axes, record: DesignRecord, grinding: PolarGrinding, lobe: int) -> None:
    export, path = record.spec.export, grinding.path
    limits = axis_limits(post_of(export))
    c = path.c[: lobe + 1] / DEGREE
    middle = 0.5 * (c[1:] + c[:-1])
    speed = grinding.feed.speed[: lobe + 1]
    squares = speed**2
    pull = 0.5 * np.diff(squares) / np.diff(path.arc_length[: lobe + 1])
    c_pull = path.c_second[:lobe, 0] * squares[:-1] + path.c_rate[:lobe, 0] * pull
    x_pull = path.x_second[:lobe, 0] * squares[:-1] + path.x_rate[:lobe, 0] * pull
    shares = (
        ("contact along the flank", c, speed / (export.feed_mm_per_min / 60.0), BLACK, "-"),
        ("speed of C", middle, np.abs(path.c_rate[:lobe, 0] * speed[:-1]) / limits.c_speed, BLUE, "-"),
        ("speed of X", middle, np.abs(path.x_rate[:lobe, 0] * speed[:-1]) / limits.x_speed, ORANGE, "-"),
        ("acceleration of C", middle, np.abs(c_pull) / limits.c_acceleration, BLUE, ":"),
        ("acceleration of X", middle, np.abs(x_pull) / limits.x_acceleration, ORANGE, ":"),
    )  # fmt: skip
    for label, at, share, colour, line in shares:
        ax.plot(at, 100.0 * share, color=colour, linestyle=line, linewidth=1.4, label=label)
    ax.set_ylim(0.0, 165.0)
    ax.set_yticks(range(0, 101, 20))
    least, most = (f"{60.0 * float(v):.4g}" for v in (np.min(speed), np.max(speed)))
    feed = most if least == most else f"{least} to {most}"
    ax.set(xlabel="C [°]", ylabel="share of speed asked for, of limits [%]")
    ax.set_title(f"feed: {feed} mm/min along the flank")
    ax.legend(loc="upper center", ncols=2, fontsize=8)


def _tangency_deviation(ax: Axes, record: DesignRecord, grinding: PolarGrinding, lobe: int) -> None:
    path = grinding.path
    share = np.arange(_BETWEEN) / _BETWEEN
    c, x = (np.interp(np.add.outer(np.arange(lobe), share).ravel(), np.arange(v.size), v) for v in (path.c, path.x))
    off = (clearance(record.profile, x * np.exp(-1j * c)) - path.radius) / UM
    tolerance = record.spec.export.chord_tolerance_um
    low, high = (_envelope(off, extreme) for extreme in (np.minimum, np.maximum))
    ax.fill_between(c / DEGREE, low, high, color=BLUE, linewidth=0.0, label="along the steps")
    for value, label in ((-tolerance, None), (tolerance, "chord tolerance")):
        ax.axhline(value, color=GREEN, linestyle="--", linewidth=1.0, label=label)
    ax.axhline(0.0, color=GREY, linewidth=0.8)
    ax.set_ylim(-1.2 * tolerance, 1.9 * tolerance)
    ax.set(xlabel="C [°]", ylabel="gap between wheel and flank [µm]")
    ax.set_title("distance from tangency; below 0 the wheel cuts in")
    ax.legend(
        loc="upper right", fontsize=9,
        title=f"left in the grooves at root and tip: {grinding.groove_stock / UM:.2g} µm", title_fontsize=9,
    )  # fmt: skip


def _envelope(off: FloatArray, extreme: np.ufunc) -> FloatArray:
    """Least or largest value of every step and its neighbours, at all points of the step."""
    each = extreme.reduce(off.reshape(-1, _BETWEEN), axis=1)
    return np.repeat(extreme(extreme(np.roll(each, 1), np.roll(each, -1)), each), _BETWEEN)
