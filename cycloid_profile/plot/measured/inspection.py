"""Figure of an inspected disc: pitch, runout and profile band of every flank with their tolerances."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.export.inspection import FLANKS, CheckResult, Inspection
from cycloid_profile.plot.style import BLUE, GREEN, ORANGE, canvas
from cycloid_profile.units import UM

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_COLOURS = (BLUE, ORANGE)


def inspection_chart(result: Inspection, ax: Any = None, *, name: str = "") -> Any:
    """Profile band, single and cumulative pitch of both flanks, and radial position, over the lobes; 2 × 2 axes."""
    profile, single, cumulative, runout = result.checks
    lobe = np.arange(1.0, result.position.shape[0] + 1.0)
    with canvas(ax, (11.0, 7.5), 2, 2) as drawn:
        (band, steps), (sums, radii) = drawn.axes
        for k, (flank, colour) in enumerate(zip(FLANKS, _COLOURS, strict=True)):
            at = lobe + (0.2 if k else -0.2)
            band.vlines(at, result.low[:, k] / UM, result.high[:, k] / UM, color=colour, linewidth=2.0, label=flank)
            for axes, values in ((steps, result.single_pitch), (sums, result.position)):
                axes.plot(lobe, values[:, k] / UM, "o-", color=colour, markersize=3, linewidth=0.8, label=flank)
        radii.plot(lobe, result.radial / UM, "o-", color=BLUE, markersize=3, linewidth=0.8, label="tooth space")
        _limits(band, "profile deviation along the normal [µm]", profile)
        _limits(steps, "single pitch deviation [µm]", single)
        _limits(sums, "position of flanks, arc [µm]", cumulative, result.position)
        _limits(radii, "radial position of spaces [µm]", runout, result.radial)
        drawn.title(name, "passed" if result.passed else "failed")
    return drawn.axes


def _limits(ax: Axes, label: str, check: CheckResult, values: FloatArray | None = None) -> None:
    """Lines at the tolerance: ± of it, or of its half about the middle of ``values``."""
    half = check.tolerance if values is None else 0.5 * check.tolerance
    middle = 0.0 if values is None else 0.5 * float(np.max(values) + np.min(values))
    for sign in (-1.0, 1.0):
        ax.axhline((middle + sign * half) / UM, color=GREEN, linestyle="--", linewidth=1.0)
    shown = "not shown by this scan" if check.value is None else f"{check.value / UM:.2f} µm"
    sign_text = "±" if check.both_ways else ""
    ax.set(xlabel="lobe [number]", ylabel=label)
    ax.set_title(f"{check.symbol} = {shown}, tolerance {sign_text}{check.tolerance / UM:.2f} µm", fontsize=10)
    low, high = ax.get_ylim()
    ax.set_ylim(low, high + 0.2 * (high - low))
    ax.legend(loc="upper right", ncols=2, fontsize=8)
