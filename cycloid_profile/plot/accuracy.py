"""Torque against twist, and the transmission error over a mesh cycle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from cycloid_profile.contact.backlash import input_locked_factor
from cycloid_profile.design.accuracy import LOAD_SHARES
from cycloid_profile.design.record import DesignRecord
from cycloid_profile.plot.style import COMPENSATED, CONVENTIONAL, GREY, new_figure, plain, style
from cycloid_profile.units import ARCMIN, ARCSEC, NEWTON_METRE

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def accuracy_plot(record: DesignRecord) -> Figure:
    """Left: twist of the output with the input held. Right: transmission error at rated torque."""
    cases = [("conventional", CONVENTIONAL, record.conventional_accuracy)]
    if record.compensation is not None:
        cases.append(("compensated", COMPENSATED, record.compensated_accuracy))
    pitch = 360.0 / record.drive.trochoid.pins
    with style():
        figure = new_figure(10.0, 4.6)
        left, right = figure.subplots(1, 2, width_ratios=(1.2, 1.0))
        for label, look, found in cases:
            # At no torque the output floats between the two touches.
            touches = [found.backlash.backward, found.backlash.forward]
            float_twist = [float(np.mean(t)) * input_locked_factor(found.case.drive) for t in touches]
            half = len(found.torque) // 2
            twist = np.insert(np.mean(found.rotation, axis=1), half, float_twist) / ARCMIN
            left.plot(
                twist,
                np.insert(found.torque, half, [0.0, 0.0]) / NEWTON_METRE,
                marker=".",
                **look,
                label=f"{label}: lost motion {found.lost_motion / ARCMIN:.3f}′,\n"
                f"{found.torsional_rigidity * ARCMIN / NEWTON_METRE:.4g} N·m/′ at 50–100 %",
            )
            error = found.rotation[LOAD_SHARES.index(1.0)]
            right.plot(
                np.append(found.crank_angle * 180.0 / np.pi, pitch),
                np.append(error, error[0]) / ARCSEC - error.mean() / ARCSEC,
                **look,
                label=f"{label}: {found.transmission_error / ARCSEC:.3f}″ peak to peak",
            )
        left.axhline(0.0, color=GREY, linewidth=0.8)
        left.set(
            xlabel="twist of the output, input held [′]", ylabel="torque [N·m]", title="torque and twist, no friction"
        )
        left.legend(loc="upper left", fontsize=9)
        low, high = left.get_ylim()
        left.set_ylim(low, high + 0.35 * (high - low))
        right.set(
            xlabel="crank angle over one mesh cycle [°]", ylabel="transmission error [″]", title="at rated torque"
        )
        right.set_xlim(0.0, pitch)
        low, high = right.get_ylim()
        right.set_ylim(low, high + 0.3 * (high - low))
        right.legend(loc="upper left", fontsize=9)
        figure.suptitle(f"{plain(record.spec.name)}: mesh and bearings only")
    return figure
