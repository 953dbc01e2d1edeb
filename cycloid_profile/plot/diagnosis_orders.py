"""Orders of what is left of a curve over a turn, before and after, the largest of them named."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.outcome import Diagnosis, FileGap
from cycloid_profile.plot.diagnosis_marks import unit
from cycloid_profile.plot.orders import folded_order, order_label
from cycloid_profile.plot.style import BLACK, BLUE, GREEN, ORANGE

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

_LABELLED_ORDERS = 5
_LOW_ORDERS = 6.5  # times the number of pins


def draw_orders(
    spectra: Any, diagnosis: Diagnosis, gap: FileGap, angle: FloatArray, left: Sequence[FloatArray]
) -> None:
    """Amplitudes of the orders before and after, low orders with room for their names, the others beside them."""
    trochoid = diagnosis.built.case.drive.trochoid
    poses = round(360.0 / float(np.median(np.diff(angle))))
    low = min(round(_LOW_ORDERS * trochoid.pins), poses // 2)
    split = low < 0.9 * (poses // 2)
    panels = spectra.subplots(1, 2 if split else 1, squeeze=False, sharey=True, width_ratios=(2.0, 1.0)[: 1 + split])[0]
    amplitudes = [_amplitudes(angle, values, poses) for values in left]
    floor = gap.noise * math.sqrt(math.pi / angle.size)
    top = max(float(np.max(a[1:])) for a in amplitudes)
    bottom = 0.3 * min(floor, top)
    mesh = folded_order(trochoid.lobes * trochoid.pins, poses)
    looks = ((BLUE, 1.6), (ORANGE, 0.9))
    for ax in panels:
        for amplitude, (colour, width) in zip(amplitudes, looks[: len(left)], strict=True):
            x = np.repeat(np.arange(1.0, amplitude.size), 3)
            y = np.stack([np.full(x.size // 3, bottom), amplitude[1:], np.full(x.size // 3, np.nan)], axis=1).ravel()
            ax.plot(x, y, color=colour, linewidth=width, rasterized=True)
        ax.axhline(floor, color=BLACK, linewidth=1.0, linestyle="--")
        ax.axvline(mesh, color=GREEN, linewidth=1.0, linestyle=":")
        ax.set_yscale("log")
        # Room above for the names of the orders.
        ax.set_ylim(bottom, top * max((top / bottom) ** 0.9, 30.0))
        ax.set_xlabel("order per turn of the output [–]")
    part = "" if angle[-1] - angle[0] > 0.95 * 360.0 else "; part of a turn only, so that orders run into each other"
    panels[0].set_title(f"orders of measured minus predicted{part}", fontsize=10)
    panels[0].set_ylabel(f"amplitude [{unit(gap)}]")
    panels[0].set_xlim(0, low)
    if split:
        panels[1].set_xlim(low, poses // 2 + 0.02 * poses)
        panels[1].set_title("higher orders", fontsize=10)
    for ax, (first, last) in zip(panels, ((1, low), (low + 1, poses // 2)), strict=False):
        _name_orders(ax, amplitudes[0], first, last, 4.0 * floor, (trochoid.lobes, trochoid.pins, poses))


def order_marks(diagnosis: Diagnosis) -> list[Artist]:
    """Legend of the orders."""
    from matplotlib.lines import Line2D

    trochoid = diagnosis.built.case.drive.trochoid
    handles: list[Artist] = []
    if diagnosis.effects:
        handles.append(Line2D([], [], color=BLUE, linewidth=1.6, label="orders before"))
        handles.append(Line2D([], [], color=ORANGE, linewidth=0.9, label="orders after"))
    handles.append(Line2D([], [], color=BLACK, linestyle="--", label="orders of noise alone"))
    mesh = f"mesh order {trochoid.lobes * trochoid.pins}, as sampled"
    handles.append(Line2D([], [], color=GREEN, linestyle=":", label=mesh))
    return handles


def _amplitudes(angle: FloatArray, values: FloatArray, poses: int) -> FloatArray:
    """Amplitudes of the orders, from 0 on, of rows that need not be evenly spaced."""
    orders = np.arange(poses // 2 + 1)
    centred = values - np.mean(values)
    turned = np.exp(-1j * np.outer(orders, np.deg2rad(angle)))
    found: FloatArray = 2.0 * np.abs(turned @ centred) / angle.size
    return found


def _name_orders(
    ax: Axes, amplitude: FloatArray, first: int, last: int, least: float, of: tuple[int, int, int]
) -> None:
    """Names of the largest orders in a panel, upright so that neighbours do not cover each other."""
    largest = first + np.argsort(amplitude[first : last + 1])[::-1]
    named = sorted(int(o) for o in largest[:_LABELLED_ORDERS] if amplitude[o] > least)
    room = 0.03 * (last - first) * (1.0 if first == 1 else 2.0)
    # Names pushed apart to the right, and back where they would leave the panel.
    x = np.asarray(named, dtype=np.float64)
    for i in range(x.size):
        x[i] = max(x[i], x[i - 1] + room if i else first + 0.5 * room)
    for i in reversed(range(x.size)):
        x[i] = min(x[i], x[i + 1] - room if i + 1 < x.size else last - 0.2 * room)
    for order, at in zip(named, x, strict=True):
        height = float(np.max(amplitude[[o for o in named if abs(o - at) < 2.0 * room] or [order]]))
        text = ax.annotate(
            order_label(order, *of),
            (float(at), height),
            xytext=(0, 3),
            textcoords="offset points",
            rotation=90,
            ha="center",
            va="bottom",
            fontsize=7.5,
        )
        text.set_in_layout(False)
