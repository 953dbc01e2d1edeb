"""What a correction takes off, round the disc and along the lobes, and what is left of the gap beside the noise."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.corrected_scans import Outlook
from cycloid_profile.discrepancy.correction import Correction
from cycloid_profile.plot.style import BLACK, BLUE, GREEN, GREY, ORANGE, SKY, new_figure, phase_axis, plain, style
from cycloid_profile.units import DEGREE, UM

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.projections.polar import PolarAxes

_POINTS_PER_LOBE = 120
_SHOWN_LOBES = 4
_MEANS_PER_LOBE = 2
_LOOKS = ((BLUE, "-"), (ORANGE, "--"), (GREEN, "-."), (BLACK, ":"))


def correction_plot(found: Correction, name: str) -> Figure:
    """Four views: removal magnified round the disc, along a few lobes, the gap lobe by lobe, and its spread."""
    with style():
        figure = new_figure(11.0, 9.0)
        grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.25))
        _round_disc(figure.add_subplot(grid[0, 0], projection="polar"), found)  # type: ignore[arg-type]
        _along_lobes(figure.add_subplot(grid[0, 1]), found)
        _spread(figure.add_subplot(grid[1, 0]), found.scans)
        _lobe_means(figure.add_subplot(grid[1, 1]), found.scans, found.drawing.trochoid.lobes)
        figure.suptitle(
            f"{plain(name)}, disc {found.disc + 1}: program against drawing, "
            f"at most {found.shape.largest / UM:.2f} µm; gap as scanned and as expected after regrinding"
        )
    return figure


def _round_disc(ax: PolarAxes, found: Correction) -> None:
    lobes = found.drawing.trochoid.lobes
    along = np.linspace(0.0, found.drawing.trochoid.phase_period, lobes * _POINTS_PER_LOBE + 1)
    outside = -found.removal(along) / UM
    angle = np.angle(found.drawing.at(along).position)
    scale = _round_up(float(np.max(np.abs(outside), initial=0.05)))
    ax.plot(angle, np.zeros_like(angle), color=GREY, linewidth=0.8)
    ax.plot(angle, outside, color=BLUE, linewidth=0.8)
    ax.set_ylim(-3.0 * scale, 1.2 * scale)
    ax.set_yticks([-scale, 0.0, scale], [f"−{scale:g}", "0", f"+{scale:g} µm"], fontsize=8)
    ax.set_title("program outwards of the drawing", fontsize=10)


def _along_lobes(ax: Axes, found: Correction) -> None:
    psi = np.linspace(-math.pi, math.pi, 4 * _POINTS_PER_LOBE + 1)
    lobes = found.drawing.trochoid.lobes
    # Within the lobe: its ends are the tips.
    removal = found.removal(psi * (1.0 - 1e-12) + 2.0 * math.pi * np.arange(float(lobes))[:, np.newaxis]) / UM
    if found.program.lobes_alike:
        shown = [0]
    else:
        # The lobe that is changed most, and others evenly round the disc from it.
        worst = int(np.argmax(np.max(np.abs(removal), axis=1)))
        shown = sorted((worst + i * lobes // _SHOWN_LOBES) % lobes for i in range(min(_SHOWN_LOBES, lobes)))
    for lobe, (colour, line) in zip(shown, _LOOKS, strict=False):
        label = f"lobe {lobe + 1}" if len(shown) > 1 else "every lobe"
        ax.plot(psi / DEGREE, removal[lobe], color=colour, linestyle=line, linewidth=1.5, label=label)
    ax.axhline(0.0, color=GREY, linewidth=0.8)
    phase_axis(ax)
    _headroom(ax)
    ax.set_ylabel("program takes off [µm]")
    ax.set_title("more than the drawing, along ψ")
    ax.legend(loc="upper right", ncols=2)


def _spread(ax: Axes, scans: tuple[Outlook, ...]) -> None:
    if not scans:
        return
    before, after = (np.concatenate([getattr(s, which) for s in scans]) for which in ("before", "after"))
    noise = float(np.sqrt(np.mean([s.noise**2 for s in scans])))
    reach = max(float(np.quantile(np.abs(before), 0.999)), 4.0 * noise)
    edges = np.linspace(-reach, reach, 81)
    for values, colour, label in ((before, ORANGE, "as scanned"), (after, BLUE, "after the correction")):
        rms = float(np.sqrt(np.mean(values**2)))
        ax.hist(
            np.clip(values, -reach, reach),
            edges.tolist(),
            density=True,
            histtype="step",
            color=colour,
            linewidth=1.6,
            label=f"{label}: {rms:.3g} µm rms",
        )
    ax.plot(
        edges,
        np.exp(-0.5 * (edges / noise) ** 2) / (noise * math.sqrt(2.0 * math.pi)),
        color=BLACK,
        linestyle=":",
        label=f"noise alone: {noise:.3g} µm",
    )
    # Single bad places are few points: only this scale shows them. Room above for the legend.
    ax.set_yscale("log")
    ax.set_ylim(0.3 / (before.size * (edges[1] - edges[0])), 40.0 / noise)
    ax.set(xlabel="missing against the drawing [µm]", ylabel="share of points per µm", title="gap, point by point")
    ax.legend(loc="upper left", fontsize=8)


def _lobe_means(ax: Axes, scans: tuple[Outlook, ...], lobes: int) -> None:
    if not scans:
        return
    along = np.concatenate([s.along for s in scans])
    noise = float(np.sqrt(np.mean([s.noise**2 for s in scans])))
    count = lobes * _MEANS_PER_LOBE
    # Each flank by itself: a lobe begins at its tip.
    cell = np.mod(np.floor((along + math.pi) / (2.0 * math.pi) * _MEANS_PER_LOBE), count).astype(int)
    points = np.bincount(cell, minlength=count)
    for which, colour, label in (("before", ORANGE, "as scanned"), ("after", BLUE, "after the correction")):
        sums = np.bincount(cell, weights=np.concatenate([getattr(s, which) for s in scans]), minlength=count)
        with np.errstate(invalid="ignore", divide="ignore"):
            mean: FloatArray = np.where(points > 0, sums / points, np.nan)
        where = np.arange(count) / _MEANS_PER_LOBE + 0.5 + 0.5 / _MEANS_PER_LOBE
        ax.plot(where, mean, color=colour, linewidth=1.0, marker=".", markersize=4, label=label)
    typical = 2.0 * noise / math.sqrt(max(float(np.median(points[points > 0])), 1.0))
    ax.axhspan(-typical, typical, color=SKY, alpha=0.35, label="± 2σ of such a mean")
    ax.set_xlim(0.5, lobes + 0.5)
    _headroom(ax)
    ax.set(xlabel="lobe", ylabel="missing against the drawing [µm]", title="gap, mean of each flank")
    ax.legend(loc="upper right", ncols=3, fontsize=8)


def _headroom(ax: Axes) -> None:
    low, high = ax.get_ylim()
    ax.set_ylim(low, high + 0.25 * (high - low))


def _round_up(value: float) -> float:
    """The next number of 1, 2, 5 times a power of ten."""
    decade = 10.0 ** math.floor(math.log10(value))
    return next(step * decade for step in (1.0, 2.0, 5.0, 10.0) if step * decade >= value * (1.0 - 1e-9))
