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
    curves = [("conventional modification", CONVENTIONAL, normal_removal(record, record.conventional, psi))]
    if record.compensation is not None:
        compensated = normal_removal(record, record.profile, psi)
        curves.append(("with deformation compensation", COMPENSATED, compensated))
    with style():
        figure = new_figure(8.0, 7.4)
        unrolled, lobe = figure.subplots(2, 1, height_ratios=(1.3, 1.0))
        unrolled.plot(psi / DEGREE, np.zeros_like(psi), label="theory", **THEORY)
        for label, look, removal in curves:
            unrolled.plot(psi / DEGREE, removal / UM, label=label, **look)
        phase_axis(unrolled)
        low, high = unrolled.get_ylim()
        unrolled.set_ylim(low, high + 0.32 * (high - low))
        unrolled.set_ylabel("material removed along the normal [µm]")
        unrolled.set_title("unrolled")
        unrolled.legend(loc="upper left")
        _draw_lobe(lobe, record, psi, curves)
        figure.suptitle(f"{plain(record.spec.name)}: tooth against theory")
    return figure


def _draw_lobe(
    ax: Axes, record: DesignRecord, psi: FloatArray, curves: list[tuple[str, dict[str, Any], FloatArray]]
) -> None:
    # The lobe between two roots, tip up.
    around = psi + math.pi
    theory = record.drive.theoretical_profile.at(around)
    upright = np.exp(1j * (0.5 * math.pi + math.pi / record.drive.trochoid.lobes))
    position, normal = theory.position * upright, theory.normal * upright
    ax.plot(position.real, position.imag, **THEORY)
    factor = _magnification(record, max(float(np.max(np.abs(r))) for _, _, r in curves))
    for _, look, removal in curves:
        # Removal is given from tip to tip; the same values serve from root to root half a turn on.
        drawn = position - factor * np.roll(removal[:-1], _POINTS // 2)[np.arange(_POINTS) % (_POINTS - 1)] * normal
        ax.plot(drawn.real, drawn.imag, **look)
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
