"""Theory, modified and compensated tooth side by side, as magnified normal deviation along one lobe."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.design.record import DesignRecord
from cycloid_profile.export.deviation import distances
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.plot.style import COMPENSATED, CONVENTIONAL, THEORY, new_figure, phase_axis, plain, style
from cycloid_profile.units import DEGREE, UM

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_POINTS = 361
_STEPS = (1, 2, 5)


def normal_removal(record: DesignRecord, profile: ToothProfile, phase: FloatArray) -> FloatArray:
    """Material ``profile`` lacks against the theoretical tooth, along the normal [mm]; exact distances."""
    removal: FloatArray = -distances(record.drive.theoretical_profile, profile.at(phase).position)
    return removal


def profile_comparison(record: DesignRecord) -> Figure:
    """Above: removal along one lobe, unrolled. Below: the lobe about the disc's centre, removal magnified."""
    psi = np.linspace(-math.pi, math.pi, _POINTS)
    curves = [("conventional modification", CONVENTIONAL, record.conventional)]
    if record.compensation is not None:
        curves.append(("with deformation compensation", COMPENSATED, record.profile))
    with style():
        figure = new_figure(8.0, 7.4)
        unrolled, lobe = figure.subplots(2, 1, height_ratios=(1.3, 1.0))
        unrolled.plot(psi / DEGREE, np.zeros_like(psi), label="theory", **THEORY)
        for label, look, profile in curves:
            unrolled.plot(psi / DEGREE, normal_removal(record, profile, psi) / UM, label=label, **look)
        phase_axis(unrolled)
        low, high = unrolled.get_ylim()
        unrolled.set_ylim(low, high + 0.32 * (high - low))
        unrolled.set_ylabel("material removed along the normal [µm]")
        unrolled.set_title("unrolled")
        unrolled.legend(loc="upper left")
        _draw_lobe(lobe, record, curves)
        figure.suptitle(f"{plain(record.spec.name)}: tooth against theory")
    return figure


def _draw_lobe(ax: Axes, record: DesignRecord, curves: list[tuple[str, dict[str, Any], ToothProfile]]) -> None:
    # The lobe between two roots, tip up.
    around = np.linspace(0.0, 2.0 * math.pi, _POINTS)
    theory = record.drive.theoretical_profile.at(around)
    upright = np.exp(1j * (0.5 * math.pi + math.pi / record.drive.trochoid.lobes))
    position, normal = theory.position * upright, theory.normal * upright
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


def _magnification(record: DesignRecord, largest: float) -> int:
    """A round factor that draws the largest removal about a third of the tooth's height; 1 for no removal."""
    height = 2.0 * record.drive.trochoid.eccentricity
    wanted = 0.35 * height / largest if largest > 0.0 else 1.0
    if wanted <= 1.0:
        return 1
    decade = 10 ** math.floor(math.log10(wanted))
    return int(max(step for step in _STEPS if step * decade <= wanted) * decade)
