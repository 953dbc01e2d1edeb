"""Pictures of a diagnosis: measured beside predicted before and after, what is left, and how far it shrank."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray
from cycloid_profile.discrepancy.detection import Finding
from cycloid_profile.discrepancy.diagnosis import Diagnosis, FileGap
from cycloid_profile.discrepancy.laid import Laid, settled
from cycloid_profile.discrepancy.told import SHOWN
from cycloid_profile.plot.style import BLACK, BLUE, GREEN, GREY, ORANGE, SKY, new_figure, plain, style
from cycloid_profile.rig.gap import COLUMN

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage

Picture = tuple[str, str, "Figure"]

_QUANTITY = {
    "hysteresis": "angle",
    "transmission_error": "transmission error",
    "lost_motion_map": "lost motion",
    "profile_scan": "deviation",
}
_HELD: dict[str, Any] = {"color": GREEN, "linewidth": 2.5, "solid_capstyle": "butt"}
_OUTLINE: dict[str, Any] = {"facecolor": "none", "edgecolor": BLACK, "linewidth": 1.3}
_MISSING = "#BDBDBD"
_WINDOW_WAVES = 4  # waves of the pins in the readable window
_LABELLED_ORDERS = 5
_LOW_ORDERS = 6.5  # times the number of pins
_ROWS_PER_CELL = 4
_CALM = 5.0  # standard deviations of a cell that are the least full colour, so that noise looks pale
_COARSEST, _FINEST = 12, 60  # cells of a lobe
_SMOOTHED = 12  # parts of a lobe that the line round the disc averages over


def pictures(diagnosis: Diagnosis, name: str) -> list[Picture]:
    """File stem, caption and figure of every picture: the summary, then one for each file."""
    drawn = [_summary(diagnosis, name)]
    stems: set[str] = set()
    for gap in diagnosis.gaps:
        stem = _stem(gap.recording.name, stems)
        draw = {"profile_scan": _scan, "hysteresis": _loop}.get(gap.recording.kind, _turn)
        with style():
            figure, caption = draw(diagnosis, gap)
            figure.suptitle(f"{plain(name)}, {plain(gap.recording.name)}: {_kind(gap)}")
        drawn.append((stem, f"{gap.recording.name}: {caption}", figure))
    return drawn


def order_label(order: int, lobes: int, pins: int, poses: int) -> str:
    """An order as 39·k, 40·k or the mesh, which ``poses`` rows a turn may fold back several times."""
    names = [f"{number}·{order // number}" for number in (lobes, pins) if order % number == 0]
    mesh = folded_order(lobes * pins, poses)
    if order == mesh:
        names.append("mesh" if mesh == lobes * pins else "mesh, folded")
    return f"{order} = {' or '.join(names)}" if names else str(order)


def folded_order(order: int, poses: int) -> int:
    """Where an order shows with ``poses`` rows a turn."""
    return abs((order + poses // 2) % poses - poses // 2)


def _stem(name: str, taken: set[str]) -> str:
    base = "gap_" + (re.sub(r"[^A-Za-z0-9]+", "_", PurePath(name).stem).strip("_").lower() or "file")
    stem = next(s for s in (base, *(f"{base}_{n}" for n in range(2, 1000))) if s not in taken)
    taken.add(stem)
    return stem


def _kind(gap: FileGap) -> str:
    return gap.recording.kind.replace("_", " ")


def _unit(gap: FileGap) -> str:
    return SHOWN[gap.recording.unit]


def _with_unit(value: float, gap: FileGap) -> str:
    unit = _unit(gap)
    return f"{value:#.3g}{unit}" if unit in "′″" else f"{value:#.3g} {unit}"


def _sides(diagnosis: Diagnosis, gap: FileGap) -> list[tuple[str, Laid]]:
    """Before and after; once only where no effect was added."""
    if not diagnosis.effects:
        return [("against the prediction of the spec", gap.before)]
    return [("before", gap.before), ("after, effects added", gap.after)]


def _places(diagnosis: Diagnosis, gap: FileGap, coordinate: str) -> list[Finding]:
    return [f for f in diagnosis.where if f.file == gap.recording.name and f.coordinate == coordinate]


# Summary


def _summary(diagnosis: Diagnosis, name: str) -> Picture:
    """RMS over the noise of every file, before and after, on fitted and held-out rows."""
    from matplotlib.ticker import LogLocator, NullFormatter

    changed = bool(diagnosis.effects)
    with style():
        figure = new_figure(9.5, 1.7 + (1.15 if changed else 0.75) * len(diagnosis.gaps))
        ax = figure.add_subplot()
        middles, largest = [], 1.0
        y = 0.0
        for gap in diagnosis.gaps:
            bars = [(v, c, h) for v, c, h in _bars(gap, changed) if math.isfinite(v)]
            middles.append(y + 0.5 * (len(bars) - 1))
            for value, colour, held in bars:
                ratio = value / gap.noise
                largest = max(largest, ratio)
                look: dict[str, Any] = {"color": colour} if not held else {"facecolor": "white", "edgecolor": colour}
                ax.barh(y, ratio, height=0.8, hatch="///" if held else None, linewidth=1.0, **look)
                text = _with_unit(value, gap)
                if held and gap.closure is not None and changed and colour == ORANGE:
                    text += f", gap closed by {100.0 * min(gap.closure, 1.0):.1f} %"
                ax.annotate(text, (ratio, y), xytext=(4, 0), textcoords="offset points", va="center", fontsize=8.5)
                y += 1.0
            y += 0.8
        ax.axvline(1.0, color=BLACK, linewidth=1.2, linestyle="--")
        ax.set_xscale("log")
        ax.set_xlim(0.5, largest * (largest / 0.5) ** 0.45)
        ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if largest < 30.0 else (1.0,)))
        ax.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
        ax.xaxis.set_minor_formatter(NullFormatter())
        ax.set_yticks(middles, [f"{plain(g.recording.name)}\nnoise {_with_unit(g.noise, g)}" for g in diagnosis.gaps])
        ax.tick_params(axis="y", length=0)
        ax.grid(visible=False, axis="y")
        ax.invert_yaxis()
        ax.set_xlabel("rms of measured minus predicted over the noise [–], dashed: the noise")
        ax.set_title(f"{plain(name)}: what is left")
        _summary_legend(ax, changed)
    caption = (
        "How far measurement and prediction are apart, in units of the noise. "
        "Held-out rows took no part in finding the effects."
    )
    return "diagnosis_summary", caption, figure


def _bars(gap: FileGap, changed: bool) -> list[tuple[float, str, bool]]:
    """Value, colour and whether of held-out rows."""
    bars = [(gap.fit_before, BLUE, False), (gap.fit_after, ORANGE, False)]
    bars += [(gap.held_out_before, BLUE, True), (gap.held_out_after, ORANGE, True)]
    return [bar for bar in bars if changed or bar[1] == BLUE]


def _summary_legend(ax: Axes, changed: bool) -> None:
    from matplotlib.patches import Patch

    handles = []
    for colour, when in ((BLUE, "before, " if changed else ""), (ORANGE, "after, ")):
        if changed or colour == BLUE:
            handles.append(Patch(color=colour, label=f"{when}fitted rows"))
            handles.append(Patch(facecolor="white", edgecolor=colour, hatch="///", label=f"{when}held-out rows"))
    ax.figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), fontsize=9)


# Scan


def _scan(diagnosis: Diagnosis, gap: FileGap) -> tuple[Figure, str]:
    """Polar and unrolled deviation from the prediction, outwards positive [µm]."""
    sides = _sides(diagnosis, gap)
    lobes = diagnosis.built.case.drive.trochoid.lobes
    per_lobe = gap.recording.rows.size / np.unique(gap.before.lobe).size
    cells = int(np.clip(per_lobe / _ROWS_PER_CELL, _COARSEST, _FINEST))
    outside = [-settled(laid) for _, laid in sides]
    maps = [_cells(laid, values, lobes, cells) for (_, laid), values in zip(sides, outside, strict=True)]
    # Before and after have one scale; two cells of a thousand may exceed it.
    least = _CALM * gap.noise / math.sqrt(per_lobe / cells)
    scale = _round_up(max(float(np.nanquantile(np.abs(maps[0]), 0.998)), least))
    radius = 1e3 * float(np.mean(np.abs(gap.before.placed.placed[gap.recording.rows])))
    # The middle of the disc stands at −3 scales: a ring of that radius is the disc.
    magnified = float(f"{radius / (3.0 * scale):.2g}")
    figure = new_figure(11.0, 10.2) if len(sides) == 2 else new_figure(11.0, 5.8)
    if len(sides) == 2:
        spots: list[tuple[Any, Any]] = [((2, 2, 1), (2, 2, 3)), ((2, 2, 2), (2, 2, 4))]
    else:
        spots = [((1, 2, 1), (1, 2, 2))]
    flat = []
    for (title, laid), values, mean, (up, down) in zip(sides, outside, maps, spots, strict=True):
        ring = figure.add_subplot(*up, projection="polar")
        _ring(ring, laid, values, scale, per_lobe)
        ring.set_title(f"{title}\ndeviation magnified {magnified:,.0f} times", fontsize=10)
        ax = figure.add_subplot(*down)
        drawn = _unrolled(ax, mean, scale, lobes)
        _held_in_map(ax, laid)
        for finding in _places(diagnosis, gap, "lobe") if laid is gap.before else []:
            _outline_lobes(ax, finding)
        for finding in _places(diagnosis, gap, "psi_deg") if laid is gap.before else []:
            ax.axvspan(finding.start, finding.end, linestyle=":", **_OUTLINE)
        ax.set_title(title, fontsize=10)
        flat.append(ax)
    bar = figure.colorbar(drawn, ax=flat, label="outwards of the prediction [µm]", pad=0.015, aspect=28)
    bar.ax.set_label("<colorbar>")
    _legend(figure, gap, missing=bool(np.any(np.all(np.isnan(maps[0]), axis=1))), outlined=bool(
        _places(diagnosis, gap, "lobe") or _places(diagnosis, gap, "psi_deg")
    ))  # fmt: skip
    caption = (
        f"deviation of the scanned flank from the prediction, ±{scale:g} µm; "
        "round the disc and unrolled, lobe over phase. Red stands out, blue is missing."
    )
    return figure, caption


def _cells(laid: Laid, outside: FloatArray, lobes: int, cells: int) -> FloatArray:
    """Mean deviation of each cell, shape (lobes, cells), NaN without points."""
    phase = np.mod(laid.phase + np.pi, 2.0 * np.pi) / (2.0 * np.pi)
    place = laid.lobe.astype(int) * cells + np.minimum((phase * cells).astype(int), cells - 1)
    count = np.bincount(place, minlength=lobes * cells)
    total = np.bincount(place, weights=outside, minlength=lobes * cells)
    mean: FloatArray = np.where(count > 0, total / np.maximum(count, 1), np.nan).reshape(lobes, cells)
    return mean


def _ring(ax: Any, laid: Laid, outside: FloatArray, scale: float, per_lobe: float) -> None:
    rows = laid.recording.rows
    angle = np.angle(laid.placed.placed[rows])
    order = np.argsort(angle)
    angle, values = angle[order], outside[order]
    width = max(int(per_lobe / _SMOOTHED), 1)
    smooth = np.convolve(np.pad(values, width, mode="wrap"), np.ones(width) / width, mode="same")[width:-width]
    # A lobe that was not scanned leaves a hole in the line.
    gaps = np.flatnonzero(np.diff(angle) > 0.5 * 2.0 * np.pi / laid.placed.tooth.trochoid.lobes) + 1
    full = np.linspace(-np.pi, np.pi, 361)
    ax.plot(angle, np.clip(values, -2.9 * scale, 1.5 * scale), ".", color=SKY, markersize=1.2, rasterized=True)
    ax.plot(np.insert(angle, gaps, np.nan), np.insert(smooth, gaps, np.nan), color=BLUE, linewidth=0.8)
    ax.plot(full, np.zeros(full.size), color=GREY, linewidth=0.8)
    held = np.where(laid.recording.held_out[order], 1.58 * scale, np.nan)
    ax.plot(np.insert(angle, gaps, np.nan), np.insert(held, gaps, np.nan), **_HELD)
    ax.set_ylim(-3.0 * scale, 1.7 * scale)
    ax.set_yticks([-scale, 0.0, scale], [f"−{scale:g}", "0", f"+{scale:g} µm"], fontsize=8)
    ax.set_rlabel_position(112.5)
    for label in ax.get_yticklabels():
        label.set_bbox({"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.5})
    ax.set_xlabel("polar angle [°]", fontsize=9)
    ax.tick_params(axis="x", labelsize=8)


def _unrolled(ax: Axes, mean: FloatArray, scale: float, lobes: int) -> AxesImage:
    drawn = ax.imshow(
        mean,
        origin="lower",
        aspect="auto",
        extent=(-180.0, 180.0, 0.5, lobes + 0.5),
        cmap="RdBu_r",
        vmin=-scale,
        vmax=scale,
        interpolation="nearest",
    )
    ax.set_facecolor(_MISSING)
    ax.set_xticks(range(-180, 181, 60))
    ax.set(xlabel="phase ψ [°] (0 root, ±180 tip)", ylabel="lobe [number]")
    ax.grid(visible=False)
    return drawn


def _held_in_map(ax: Axes, laid: Laid) -> None:
    """A thin line at the foot of each lobe where rows are held out."""
    from matplotlib.collections import LineCollection

    held = laid.recording.held_out
    if not np.any(held) or np.all(held):
        return
    edges = np.flatnonzero(np.diff(np.concatenate([[False], held, [False]]).astype(int)))
    segments = []
    for first, last in zip(edges[::2], edges[1::2] - 1, strict=True):
        for (low, high), lobe in _lobe_ranges(
            laid.position[first] / (2.0 * np.pi) + 1.0, laid.position[last] / (2.0 * np.pi) + 1.0
        ):
            segments.append([(low, lobe - 0.42), (high, lobe - 0.42)])
    ax.add_collection(LineCollection(segments, colors=GREEN, linewidths=0.9, capstyle="butt"))


def _lobe_ranges(start: float, end: float) -> list[tuple[tuple[float, float], int]]:
    """A range of lobe numbers with their parts, as ranges of ψ [°] with the lobe of each."""
    found = []
    for lobe in range(math.floor(start), math.ceil(end)):
        low, high = max(start, lobe) - lobe, min(end, lobe + 1) - lobe
        if high > low:
            found.append(((360.0 * low - 180.0, 360.0 * high - 180.0), lobe))
    return found


def _outline_lobes(ax: Axes, finding: Finding) -> None:
    from matplotlib.patches import Rectangle

    for (low, high), lobe in _lobe_ranges(finding.start, finding.end):
        # A narrow place keeps a frame wide enough to be seen round it.
        wide = max(high - low, 12.0)
        left = min(max(0.5 * (low + high - wide), -180.0), 180.0 - wide)
        ax.add_patch(Rectangle((left, lobe - 0.6), wide, 1.2, zorder=5, clip_on=False, **_OUTLINE))


def _round_up(value: float) -> float:
    """The next number of two figures that is easy to read."""
    power = 10.0 ** math.floor(math.log10(value))
    steps = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
    return float(f"{next(s for s in steps if s * power >= value * (1.0 - 1e-9)) * power:.2g}")


# Loop


def _loop(diagnosis: Diagnosis, gap: FileGap) -> tuple[Figure, str]:
    """Torque over angle, and what is left row by row."""
    sides = _sides(diagnosis, gap)
    recording = gap.recording
    torque = recording.measurement["torque_nm"][recording.rows]
    angle = recording.measurement["angle_arcmin"][recording.rows]
    number = recording.rows.astype(np.float64) + 1.0
    figure = new_figure(11.0 if len(sides) == 2 else 7.5, 8.2)
    axes = figure.subplots(2, len(sides), squeeze=False, height_ratios=(1.5, 1.0))
    for column, (title, laid) in enumerate(sides):
        top, bottom = axes[0, column], axes[1, column]
        left = settled(laid)
        x, y = _broken(recording.rows, angle - left, torque)
        top.plot(angle, torque, ".", color=BLUE, markersize=4.0, label="measured")
        top.plot(x, y, color=ORANGE, linewidth=1.3, label="predicted")
        top.set(xlabel="angle [′]", ylabel="torque [N·m]")
        top.set_title(title, fontsize=10)
        top.legend(loc="upper left")
        _residual(bottom, number, left, gap)
        for finding in _places(diagnosis, gap, "row") if laid is gap.before else []:
            rows = recording.rows[np.clip([int(finding.start), int(finding.end)], 0, recording.rows.size - 1)] + 1.0
            _outline_span(bottom, float(rows[0]), float(rows[1]))
        bottom.set_xlabel("row of the file [number]")
    limits = [ax.get_xlim() for ax in axes[0]]
    for ax in axes[0]:
        ax.set_xlim(min(low for low, _ in limits), max(high for _, high in limits))
    _legend(figure, gap, outlined=bool(_places(diagnosis, gap, "row")))
    return figure, "the loop with its prediction, and measured minus predicted row by row; mind the scales."


def _broken(rows: np.ndarray, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A path, broken where rows of the file are left out."""
    gaps = np.flatnonzero(np.diff(rows) > 1) + 1
    return np.insert(x, gaps, np.nan), np.insert(y, gaps, np.nan)


# Curves over a turn


def _turn(diagnosis: Diagnosis, gap: FileGap) -> tuple[Figure, str]:
    """Curve over a turn and in a window, what is left, and the orders of that."""
    sides = _sides(diagnosis, gap)
    recording = gap.recording
    angle = recording.measurement["output_angle_deg"][recording.rows]
    value = recording.measurement[COLUMN[recording.kind]][recording.rows]
    pins = diagnosis.built.case.drive.trochoid.pins
    quantity = f"{_QUANTITY[recording.kind]} [{_unit(gap)}]"
    window = _window(diagnosis, gap, angle, 360.0 * _WINDOW_WAVES / pins)
    figure = new_figure(11.0, 13.0)
    parts: Any = figure.subfigures(3, 1, height_ratios=(1.2, 1.9, 1.2))
    whole, near, spectra = parts
    turns = whole.subplots(1, len(sides), squeeze=False, sharey=True)[0]
    lower = near.subplots(2, len(sides), squeeze=False)
    left = [settled(laid) for _, laid in sides]
    inside = (angle >= window[0]) & (angle <= window[1])
    for column, (title, _) in enumerate(sides):
        ax = turns[column]
        predicted = value - left[column]
        ax.plot(angle, value, color=BLUE, linewidth=0.6, label="measured")
        ax.plot(angle, predicted, color=ORANGE, linewidth=0.6, linestyle="--", label="predicted")
        ax.axvspan(*window, color=GREY, alpha=0.25, linewidth=0)
        ax.set(xlabel="output angle [°]", ylabel=quantity)
        ax.set_title(f"{title}: the turn (grey: window below)", fontsize=10)
        _degrees(ax, angle)
        close, rest = lower[0, column], lower[1, column]
        close.plot(angle[inside], value[inside], ".", color=BLUE, markersize=3.5, label="measured")
        close.plot(angle[inside], predicted[inside], color=ORANGE, linewidth=1.2, label="predicted")
        close.set(xlabel="output angle [°]", ylabel=quantity, xlim=window)
        close.set_title(f"{title}: the window, {_WINDOW_WAVES} waves of the pins", fontsize=10)
        close.legend(loc="upper right", fontsize=9)
        low, high = close.get_ylim()
        close.set_ylim(low, high + 0.3 * (high - low))
        _residual(rest, angle, left[column], gap)
        for finding in _places(diagnosis, gap, "output_angle_deg") if column == 0 else []:
            _outline_span(rest, finding.start, finding.end)
        rest.set_xlabel("output angle [°]")
        if angle[-1] - angle[0] > 300.0:
            rest.set_xticks(range(0, 361, 60))
    if recording.kind == "lost_motion_map":
        # A perfect reducer has the same lost motion everywhere: its ripple is not drawn as if it were large.
        _widen(turns[0], float(np.mean(value)))
    _orders(spectra, diagnosis, gap, angle, left)
    _legend(figure, gap, outlined=bool(_places(diagnosis, gap, "output_angle_deg")), of=diagnosis)
    return figure, (
        "measured and predicted, measured minus predicted, and its orders per turn of the output. "
        f"A whole turn holds {pins} waves, so {_WINDOW_WAVES} of them are drawn large."
    )


def _window(diagnosis: Diagnosis, gap: FileGap, angle: FloatArray, width: float) -> tuple[float, float]:
    """A window about the most striking place."""
    places = _places(diagnosis, gap, "output_angle_deg")
    middle = 0.5 * (places[0].start + places[0].end) if places else float(angle[0]) + 0.5 * width
    start = min(max(middle - 0.5 * width, float(angle[0])), max(float(angle[-1]) - width, float(angle[0])))
    return start, start + width


def _degrees(ax: Axes, angle: FloatArray) -> None:
    ax.set_xlim(float(angle[0]), float(angle[-1]))
    if angle[-1] - angle[0] > 300.0:
        ax.set_xticks(range(0, 361, 60))


def _widen(ax: Axes, mean: float) -> None:
    low, high = ax.get_ylim()
    middle, half = 0.5 * (low + high), max(0.5 * (high - low), 0.05 * abs(mean))
    ax.set_ylim(middle - half, middle + half)


def _orders(spectra: Any, diagnosis: Diagnosis, gap: FileGap, angle: FloatArray, left: Sequence[FloatArray]) -> None:
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
    panels[0].set_ylabel(f"amplitude [{_unit(gap)}]")
    panels[0].set_xlim(0, low)
    if split:
        panels[1].set_xlim(low, poses // 2 + 0.02 * poses)
        panels[1].set_title("higher orders", fontsize=10)
    for ax, (first, last) in zip(panels, ((1, low), (low + 1, poses // 2)), strict=False):
        _name_orders(ax, amplitudes[0], first, last, 4.0 * floor, (trochoid.lobes, trochoid.pins, poses))


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


# What all curves share


def _residual(ax: Axes, x: FloatArray, left: FloatArray, gap: FileGap) -> None:
    ax.axhspan(-2.0 * gap.noise, 2.0 * gap.noise, color=SKY, alpha=0.35, linewidth=0)
    ax.plot(x, left, color=BLUE, linewidth=0.7)
    ax.set_ylabel(f"measured − predicted [{_unit(gap)}]")
    low, high = float(np.min(x)), float(np.max(x))
    ax.set_xlim(low - 0.01 * (high - low), high + 0.01 * (high - low))
    half = 1.15 * max(float(np.nanmax(np.abs(left))), 2.5 * gap.noise)
    ax.set_ylim(-half, half)
    _held_strip(ax, x, gap.recording.held_out)


def _held_strip(ax: Axes, x: FloatArray, held: BoolArray) -> None:
    """A thin strip at the foot of an axis where rows are held out."""
    if np.all(held):
        return
    ax.plot(x, np.where(held, 0.012, np.nan), transform=ax.get_xaxis_transform(), **_HELD)


def _outline_span(ax: Axes, start: float, end: float) -> None:
    """A frame about a range of x, wide enough to be seen."""
    low, high = ax.get_xlim()
    widen = max(0.5 * (0.008 * (high - low) - (end - start)), 0.0)
    ax.axvspan(start - widen, end + widen, ymin=0.03, ymax=0.97, zorder=5, **_OUTLINE)


def _legend(
    figure: Figure, gap: FileGap, missing: bool = False, outlined: bool = False, of: Diagnosis | None = None
) -> None:
    """What the marks mean, once for the figure."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    held = gap.recording.held_out
    handles: list[Any] = []
    if gap.recording.kind == "profile_scan":
        handles.append(Line2D([], [], color=SKY, marker=".", linestyle="", label="points"))
        handles.append(Line2D([], [], color=BLUE, label=f"mean over 1/{_SMOOTHED} of a lobe"))
        if missing:
            handles.append(Patch(color=_MISSING, label="not scanned"))
    else:
        handles.append(Line2D([], [], color=BLUE, label="measured"))
        handles.append(Line2D([], [], color=ORANGE, label="predicted"))
        handles.append(Patch(color=SKY, alpha=0.35, label="± 2σ of the noise"))
    if np.any(held) and not np.all(held):
        handles.append(Line2D([], [], label="rows held out, not fitted", **_HELD))
    if np.all(held):
        handles.append(Line2D([], [], linestyle="", label="whole file held out, not fitted"))
    if outlined:
        handles.append(Patch(label="most striking", **_OUTLINE))
    if of is not None:
        trochoid = of.built.case.drive.trochoid
        if of.effects:
            handles.append(Line2D([], [], color=BLUE, linewidth=1.6, label="orders before"))
            handles.append(Line2D([], [], color=ORANGE, linewidth=0.9, label="orders after"))
        handles.append(Line2D([], [], color=BLACK, linestyle="--", label="orders of noise alone"))
        mesh = f"mesh order {trochoid.lobes * trochoid.pins}, as sampled"
        handles.append(Line2D([], [], color=GREEN, linestyle=":", label=mesh))
    columns = len(handles) if len(handles) <= 6 else math.ceil(len(handles) / 2)
    figure.legend(handles=handles, loc="outside lower center", ncols=columns, fontsize=9)
