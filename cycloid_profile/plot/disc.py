"""The disc among its pins, loaded pins coloured by their force."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.design.record import DesignRecord
from cycloid_profile.geometry.sampling import EqualArc, sample
from cycloid_profile.plot.style import BLACK, GREY, new_figure, plain, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_POINTS_PER_LOBE = 24
_CHORDS = 0.02  # mm


def disc_in_pins(record: DesignRecord) -> Figure:
    """Disc 1 at crank angle 0 with bore and holes, and the force on every pin at rated torque."""
    from matplotlib.collections import PatchCollection
    from matplotlib.patches import Circle, PathPatch
    from matplotlib.path import Path

    trochoid, drive = record.drive.trochoid, record.drive
    with style():
        figure = new_figure(7.2, 6.4)
        ax = figure.add_subplot(aspect="equal")
        centre = trochoid.eccentricity
        outline = sample(record.profile, EqualArc(_POINTS_PER_LOBE)).xy + np.array([centre, 0.0])
        rings = [Path(np.vstack([outline, outline[:1]]), closed=True)]
        for contour in record.outline.contours:
            ring = contour.points(_CHORDS) + centre
            ring = np.append(ring, ring[:1])
            rings.append(Path(np.stack([ring.real, ring.imag], axis=-1), closed=True))
        ax.add_patch(PathPatch(Path.make_compound_path(*rings), facecolor="#E8EEF4", edgecolor=BLACK, linewidth=0.9))

        angle = 2.0 * np.pi * np.arange(trochoid.pins) / trochoid.pins
        pins = [
            Circle((trochoid.pin_circle_radius * np.cos(t), trochoid.pin_circle_radius * np.sin(t)), drive.pin_radius)
            for t in angle
        ]
        collection = PatchCollection(pins, cmap=_colours(), edgecolor=BLACK, linewidth=0.7)
        force = record.equilibrium.force[0, 0]
        collection.set_array(np.ma.masked_equal(force, 0.0))
        collection.set_clim(0.0, float(np.max(force)))
        ax.add_collection(collection)
        figure.colorbar(collection, ax=ax, shrink=0.75, label="force on the pin [N]   (white: idle)")
        ax.plot(0.0, 0.0, marker="+", color=GREY, markersize=12)
        ax.plot(centre, 0.0, marker="x", color=BLACK, markersize=6)
        ax.annotate(
            f"× disc centre,\n{centre:g} mm from\nthe ring's +",
            (centre, 0.0),
            xytext=(0, -8),
            textcoords="offset points",
            ha="center",
            va="top",
            fontsize=8,
        )
        reach = 1.04 * (trochoid.pin_circle_radius + drive.pin_radius)
        ax.set(xlim=(-reach, reach), ylim=(-reach, reach), xlabel="x [mm]", ylabel="y [mm]")
        ax.grid(visible=False)
        ax.set_title(
            f"{plain(record.spec.name)}: {trochoid.lobes} lobes in {trochoid.pins} pins, "
            f"{record.case.torque / 1e3:.4g} N·m, one disc of {drive.discs}"
        )
    return figure


def _colours() -> Any:
    """Dark for a high force; idle pins, which are masked, stay white."""
    from matplotlib import colormaps

    return colormaps["cividis_r"].with_extremes(bad="white")
