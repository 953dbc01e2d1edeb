"""Figure of a correction: removal round the disc and along the lobes, and the residual before and after it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.correction import Correction, ExpectedScan
from cycloid_profile.plot import style
from cycloid_profile.plot.measured import draw_deviation_rings
from cycloid_profile.plot.style import BLACK, BLUE, GREEN, GREY, ORANGE, SKY
from cycloid_profile.units import DEGREE, UM

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.projections.polar import PolarAxes

_POINTS_PER_LOBE = 120
_SHOWN_LOBES = 4
_MEANS_PER_LOBE = 2
_SIDES = (("before", ORANGE, "as scanned"), ("after", BLUE, "after the correction"))
_LOOKS = ((BLUE, "-"), (ORANGE, "--"), (GREEN, "-."), (BLACK, ":"))


def correction(result: Correction, ax: Any = None, *, name: str = "") -> Any:
    """Removal magnified round the disc and along a few lobes, spread of the gap, and its mean by flank; 2 × 2 axes.

    Of given axes the first must be polar.
    """
    with style.canvas(ax, (11.0, 9.0), 2, 2, polar=(0,), width_ratios=(1.0, 1.25)) as drawn:
        axes = drawn.axes
        _round_disc(axes[0, 0], result)
        _along_lobes(axes[0, 1], result)
        _spread(axes[1, 0], result.scans)
        _draw_flank_means(axes[1, 1], result.scans, result.drawing.trochoid.lobes)
        lead = f"{style.plain(name)}, " if name else ""
        heading = f"{lead}disc {result.disc + 1}: program against drawing, at most {result.shape.largest / UM:.2f} µm"
        drawn.title("", f"{heading}; gap as scanned and as expected after regrinding")
    return axes


def _round_disc(ax: PolarAxes, result: Correction) -> None:
    lobes = result.drawing.trochoid.lobes
    along = np.linspace(0.0, result.drawing.trochoid.phase_period, lobes * _POINTS_PER_LOBE + 1)
    outside = -result.removal(along) / UM
    angle = np.angle(result.drawing.at(along).position)
    scale = style.round_up(float(np.max(np.abs(outside), initial=0.05)))
    ax.plot(angle, np.zeros_like(angle), color=GREY, linewidth=0.8)
    ax.plot(angle, outside, color=BLUE, linewidth=0.8)
    draw_deviation_rings(ax, scale, 1.2, f"{scale:g}")
    ax.set_title("program outwards of the drawing", fontsize=10)


def _along_lobes(ax: Axes, result: Correction) -> None:
    psi = np.linspace(-math.pi, math.pi, 4 * _POINTS_PER_LOBE + 1)
    lobes = result.drawing.trochoid.lobes
    # Within the lobe: its ends are the tips.
    removal = result.removal(psi * (1.0 - 1e-12) + 2.0 * math.pi * np.arange(float(lobes))[:, np.newaxis]) / UM
    if result.program.identical_lobes:
        shown = [0]
    else:
        # The lobe that is changed most, and others evenly round the disc from it.
        worst = int(np.argmax(np.max(np.abs(removal), axis=1)))
        shown = sorted((worst + i * lobes // _SHOWN_LOBES) % lobes for i in range(min(_SHOWN_LOBES, lobes)))
    for lobe, (colour, line) in zip(shown, _LOOKS, strict=False):
        label = f"lobe {lobe + 1}" if len(shown) > 1 else "every lobe"
        ax.plot(psi / DEGREE, removal[lobe], color=colour, linestyle=line, linewidth=1.5, label=label)
    ax.axhline(0.0, color=GREY, linewidth=0.8)
    style.phase_axis(ax)
    style.headroom(ax, 0.25)
    ax.set_ylabel("removal by the program [µm]")
    ax.set_title("removal beyond the drawing, along ψ")
    ax.legend(loc="upper right", ncols=2)


def _spread(ax: Axes, scans: tuple[ExpectedScan, ...]) -> None:
    if not scans:
        return
    before, after = (np.concatenate([getattr(s, which) for s in scans]) for which in ("before", "after"))
    noise = float(np.sqrt(np.mean([s.noise**2 for s in scans])))
    reach = max(float(np.quantile(np.abs(before), 0.999)), 4.0 * noise)
    edges = np.linspace(-reach, reach, 81)
    look: dict[str, Any] = {"density": True, "histtype": "step", "linewidth": 1.6}
    for values, (_, colour, label) in zip((before, after), _SIDES, strict=True):
        rms = f"{label}: {float(np.sqrt(np.mean(values**2))):.3g} µm rms"
        ax.hist(np.clip(values, -reach, reach), edges.tolist(), color=colour, label=rms, **look)
    normal = np.exp(-0.5 * (edges / noise) ** 2) / (noise * math.sqrt(2.0 * math.pi))
    ax.plot(edges, normal, color=BLACK, linestyle=":", label=f"noise alone: {noise:.3g} µm")
    # Local deviations are few points, visible on a logarithmic scale only.
    ax.set_yscale("log")
    ax.set_ylim(0.3 / (before.size * (edges[1] - edges[0])), 40.0 / noise)
    ax.set(xlabel="missing against the drawing [µm]", ylabel="share of points per µm", title="gap, point by point")
    ax.legend(loc="upper left", fontsize=8)


def _draw_flank_means(ax: Axes, scans: tuple[ExpectedScan, ...], lobes: int) -> None:
    if not scans:
        return
    along = np.concatenate([s.along for s in scans])
    noise = float(np.sqrt(np.mean([s.noise**2 for s in scans])))
    count = lobes * _MEANS_PER_LOBE
    # Each flank by itself: a lobe begins at its tip.
    cell = np.mod(np.floor((along + math.pi) / (2.0 * math.pi) * _MEANS_PER_LOBE), count).astype(int)
    points = np.bincount(cell, minlength=count)
    for which, colour, label in _SIDES:
        sums = np.bincount(cell, weights=np.concatenate([getattr(s, which) for s in scans]), minlength=count)
        with np.errstate(invalid="ignore", divide="ignore"):
            mean: FloatArray = np.where(points > 0, sums / points, np.nan)
        where = np.arange(count) / _MEANS_PER_LOBE + 0.5 + 0.5 / _MEANS_PER_LOBE
        ax.plot(where, mean, color=colour, linewidth=1.0, marker=".", markersize=4, label=label)
    typical = 2.0 * noise / math.sqrt(max(float(np.median(points[points > 0])), 1.0))
    ax.axhspan(-typical, typical, color=SKY, alpha=0.35, label="± 2σ of such a mean")
    ax.set_xlim(0.5, lobes + 0.5)
    style.headroom(ax, 0.25)
    ax.set(xlabel="lobe", ylabel="missing against the drawing [µm]", title="gap, mean of each flank")
    ax.legend(loc="upper right", ncols=3, fontsize=8)
