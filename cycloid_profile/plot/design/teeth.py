"""Figures of the tooth: one lobe, its modifications, the deformation compensated, and the disc among its pins."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.design import DesignRecord
from cycloid_profile.export.curves import distances
from cycloid_profile.geometry import EqualArc, ToothProfile, sample
from cycloid_profile.plot import style
from cycloid_profile.plot.style import BLACK, BLUE, COMPENSATED, CONVENTIONAL, GREY, ORANGE, THEORY
from cycloid_profile.units import DEGREE, NEWTON_METRE, UM

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_POINTS = 361
_STEPS = (1, 2, 5)
_POINTS_PER_LOBE = 24
_CHORDS = 0.02  # mm


def normal_removal(record: DesignRecord, profile: ToothProfile, phase: FloatArray) -> FloatArray:
    """Removal of ``profile`` relative to the theoretical tooth, along the normal [mm]; exact distances."""
    return -distances(record.drive.theoretical_profile, profile.at(phase).position)


def profile_comparison(record: DesignRecord, ax: Any = None) -> Any:
    """Theoretical, modified and compensated tooth of a design, two axes.

    Above: removal along one lobe, unrolled. Below: the lobe about the disc's centre, removal magnified.
    """
    psi = np.linspace(-math.pi, math.pi, _POINTS)
    curves = [("conventional modification", CONVENTIONAL, record.conventional)]
    if record.compensation is not None:
        curves.append(("with deformation compensation", COMPENSATED, record.profile))
    with style.canvas(ax, (8.0, 7.4), 2, height_ratios=(1.3, 1.0)) as drawn:
        unrolled, lobe = drawn.axes
        unrolled.plot(psi / DEGREE, np.zeros_like(psi), label="theory", **THEORY)
        for label, look, profile in curves:
            unrolled.plot(psi / DEGREE, normal_removal(record, profile, psi) / UM, label=label, **look)
        style.phase_axis(unrolled)
        style.headroom(unrolled, 0.32)
        unrolled.set(ylabel="material removed along the normal [µm]", title="unrolled")
        unrolled.legend(loc="upper left")
        _draw_lobe(lobe, record, curves)
        drawn.title(record.spec.name, "tooth against theory")
    return drawn.axes


def _draw_lobe(ax: Axes, record: DesignRecord, curves: list[tuple[str, dict[str, Any], ToothProfile]]) -> None:
    around, position, normal = _upright_lobe(record.drive.theoretical_profile)
    ax.plot(position.real, position.imag, **THEORY)
    removals = [normal_removal(record, profile, around) for _, _, profile in curves]
    factor = _magnification(record, float(np.max(np.abs(removals))))
    for (_, look, _), removal in zip(curves, removals, strict=True):
        drawn = position - factor * removal * normal
        ax.plot(drawn.real, drawn.imag, **look)
    # Limits in whole micrometres, because the frame's shape, and so the file, follows them to the last bit.
    half_width, low, high = float(np.max(position.real)), ax.dataLim.y0, ax.dataLim.y1
    margin = 0.05 * (high - low)
    ax.set_xlim(-round(1.1 * half_width, 3), round(1.1 * half_width, 3))
    ax.set_ylim(round(low - margin, 3), round(high + margin, 3))
    ax.set_aspect("equal", adjustable="box")
    ax.set(xlabel="x [mm]", ylabel="y [mm]", title=f"polar view of one lobe, removal × {factor}")


def _upright_lobe(profile: ToothProfile) -> tuple[FloatArray, Any, Any]:
    """Phase, position and normal along the lobe between two roots, tip up, shape (points,)."""
    around = np.linspace(0.0, 2.0 * math.pi, _POINTS)
    points = profile.at(around)
    upright = np.exp(1j * (0.5 * math.pi + math.pi / profile.trochoid.lobes))
    return around, points.position * upright, points.normal * upright


def _magnification(record: DesignRecord, largest: float) -> int:
    """A round factor that draws the largest removal about a third of the tooth's height; 1 for no removal."""
    height = 2.0 * record.drive.trochoid.eccentricity
    wanted = 0.35 * height / largest if largest > 0.0 else 1.0
    if wanted <= 1.0:
        return 1
    decade = 10 ** math.floor(math.log10(wanted))
    return int(max(step for step in _STEPS if step * decade <= wanted) * decade)


def tooth(profile: ToothProfile, ax: Any = None, *, name: str = "") -> Any:
    """One lobe of a tooth profile between two roots, tip up, about the disc's centre; one pair of axes."""
    _, position, _ = _upright_lobe(profile)
    with style.canvas(ax, (6.0, 3.6)) as drawn:
        axes = drawn.axes
        axes.fill_between(position.real, position.imag, float(np.min(position.imag)), color="#E8EEF4")
        axes.plot(position.real, position.imag, **THEORY)
        axes.set_aspect("equal", adjustable="datalim")
        axes.set(xlabel="x [mm]", ylabel="y [mm]")
        axes.set_title(style.titled(name, f"one of {profile.trochoid.lobes} lobes"))
    return axes


def deformation(record: DesignRecord, ax: Any = None) -> Any:
    """Deformation δ(ψ) = δmax |sinψ| S over one lobe, with that of each loaded pin; one pair of axes.

    The deformation at a pin is the approach of its contact and how far an elastic disc receded there.
    """
    trochoid, sharing = record.drive.trochoid, record.equilibrium
    applied = record.compensation is not None
    delta_max = record.compensation.delta_max if record.compensation is not None else sharing.delta_max
    psi = np.linspace(-math.pi, math.pi, 721)
    delta = delta_max * np.abs(trochoid.lever_function(psi))
    psi0 = trochoid.critical_phase
    with style.canvas(ax, (8.0, 4.6)) as drawn:
        axes = drawn.axes
        label = "δ(ψ) added to both flanks" if applied else "δ(ψ), not added to the tooth"
        axes.plot(psi / DEGREE, delta / UM, color=ORANGE, linewidth=1.8, label=label)
        shown = slice(None, None, 4)  # every fourth pose draws the curve well enough
        loaded = sharing.force[shown] > 0.0
        pins, approach, receded = (
            values[shown][loaded] for values in (sharing.phase, sharing.approach, sharing.receded)
        )
        parts = [("approach of the loaded pins, poses of a mesh cycle", approach, BLUE)]
        if np.any(receded):
            parts = [
                ("loaded pins, poses of a mesh cycle", approach + receded, BLUE),
                ("of it contact", approach, GREY),
            ]
        for label, part, colour in parts:
            axes.plot(pins / DEGREE, part / UM, ".", color=colour, markersize=4, label=label)
        for side in (-1.0, 1.0):
            axes.axvline(side * psi0 / DEGREE, color=GREY, linewidth=0.9, linestyle=":")
        text = f"δmax = {delta_max / UM:.3f} µm at ψ0 = {psi0 / DEGREE:.2f}°"
        style.note(axes, text, (-psi0 / DEGREE, delta_max / UM), (0, 6), ha="center")
        style.phase_axis(axes)
        axes.set_ylim(0.0, 1.42 * max(delta_max, float(np.max(approach + receded, initial=0.0))) / UM)
        axes.set_ylabel("deformation along the normal [µm]")
        axes.set_title(style.titled(record.spec.name, f"deformation at {record.case.torque / NEWTON_METRE:.4g} N·m"))
        axes.legend(loc="upper right")
    return axes


def disc(record: DesignRecord, ax: Any = None) -> Any:
    """Disc 1 at crank angle 0 with its openings, and the force on every pin at rated torque; one pair of axes."""
    from matplotlib import colormaps
    from matplotlib.collections import PatchCollection
    from matplotlib.patches import Circle

    drive, trochoid = record.drive, record.drive.trochoid
    centre = trochoid.eccentricity
    with style.canvas(ax, (7.2, 6.4), subplot_kw={"aspect": "equal"}) as drawn:
        axes = drawn.axes
        axes.add_patch(_disc_patch(record))
        angle = 2.0 * np.pi * np.arange(trochoid.pins) / trochoid.pins
        pins = [
            Circle((trochoid.pin_circle_radius * np.cos(t), trochoid.pin_circle_radius * np.sin(t)), drive.pin_radius)
            for t in angle
        ]
        # Dark for a high force; idle pins are masked and stay white.
        colours = colormaps["cividis_r"].with_extremes(bad="white")
        collection = PatchCollection(pins, cmap=colours, edgecolor=BLACK, linewidth=0.7)
        force = record.equilibrium.force[0, 0]
        collection.set_array(np.ma.masked_equal(force, 0.0))
        collection.set_clim(0.0, float(np.max(force)))
        axes.add_collection(collection)
        drawn.figure.colorbar(collection, ax=axes, shrink=0.75, label="force on the pin [N]   (white: idle)")
        axes.plot(0.0, 0.0, marker="+", color=GREY, markersize=12)
        axes.plot(centre, 0.0, marker="x", color=BLACK, markersize=6)
        text = f"× disc centre,\n{centre:g} mm from\nthe ring's +"
        style.note(axes, text, (centre, 0.0), (0, -8), ha="center", va="top", fontsize=8)
        reach = 1.04 * (trochoid.pin_circle_radius + drive.pin_radius)
        axes.set(xlim=(-reach, reach), ylim=(-reach, reach), xlabel="x [mm]", ylabel="y [mm]")
        axes.grid(visible=False)
        text = f"{trochoid.lobes} lobes in {trochoid.pins} pins, {record.case.torque / NEWTON_METRE:.4g} N·m"
        axes.set_title(style.titled(record.spec.name, f"{text}, one disc of {drive.discs}"))
    return axes


def _disc_patch(record: DesignRecord) -> Any:
    """Outline and openings of the disc, its centre at (eccentricity, 0) [mm]."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    centre = record.drive.trochoid.eccentricity
    outline = sample(record.profile, EqualArc(_POINTS_PER_LOBE)).xy + np.array([centre, 0.0])
    rings = [Path(np.vstack([outline, outline[:1]]), closed=True)]
    for contour in record.outline.contours:
        ring = contour.points(_CHORDS) + centre
        ring = np.append(ring, ring[:1])
        rings.append(Path(np.stack([ring.real, ring.imag], axis=-1), closed=True))
    return PathPatch(Path.make_compound_path(*rings), facecolor="#E8EEF4", edgecolor=BLACK, linewidth=0.9)
