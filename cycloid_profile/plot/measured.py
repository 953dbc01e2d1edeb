"""Measured and simulated files, and the gaps between them, as a gear engineer expects to see them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.effects.built import Built
from cycloid_profile.measurement.files import Measurement, scanned_disc
from cycloid_profile.plot.disc_map import cell_means, deviation_rings, unrolled
from cycloid_profile.plot.orders import order_label
from cycloid_profile.plot.style import BLUE, GREEN, GREY, ORANGE, SKY, new_figure, plain, style
from cycloid_profile.plot.turn_axis import turn_ticks, widened
from cycloid_profile.rig.evaluation import evaluate_loop
from cycloid_profile.rig.gap import Gap, gap
from cycloid_profile.rig.transmission import spectrum
from cycloid_profile.units import ARCMIN, NEWTON_METRE, SIGNS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_NO_ORDER = 1e-6  # ″
_LABELLED_ORDERS = 6
_TO_THE_LEFT = 0.85  # part of the axis beyond which a name would leave the picture to the right
_CELLS = 60  # of a lobe


def measurement_plot(measurement: Measurement, built: Built, name: str) -> Figure:
    """The picture of one file: loop with its construction, error with its orders, map, or scan about its disc."""
    draw = {
        "profile_scan": _scan,
        "hysteresis": _loop,
        "transmission_error": _transmission,
        "lost_motion_map": _map,
    }[measurement.kind]
    with style():
        figure = draw(measurement, built)
        figure.suptitle(f"{plain(name)}: {measurement.kind.replace('_', ' ')}")
    return figure


def gap_plot(found: Gap, name: str) -> Figure:
    """Measured minus predicted, and what is left beside the noise."""
    unit = SIGNS[found.unit]
    with style():
        if found.measurement.kind == "profile_scan":
            figure = _polar(found)
        else:
            figure = new_figure(9.0, 4.6)
            ax = figure.add_subplot()
            ax.plot(found.where, found.residual, color=BLUE, linewidth=0.9)
            ax.axhspan(-2.0 * found.noise, 2.0 * found.noise, color=SKY, alpha=0.3, label="± 2σ of the noise")
            ax.set(xlabel=found.axis, ylabel=f"measured minus predicted [{unit}]")
            ax.set_xlim(float(found.where[0]), float(found.where[-1]))
            ax.legend(loc="upper right")
        figure.suptitle(
            f"{plain(name)}, {plain(found.measurement.name)}: "
            f"gap {found.rms:.3g} {unit} rms, noise {found.noise:.3g} {unit}"
        )
    return figure


def _loop(measurement: Measurement, built: Built) -> Figure:
    del built
    torque, angle = measurement["torque_nm"], measurement["angle_arcmin"]
    found = evaluate_loop(torque * NEWTON_METRE, angle * ARCMIN)
    low, high = (value / ARCMIN for value in found.centreline)
    up, down = (value / ARCMIN for value in found.zero)
    peak = float(np.max(torque))
    three = 0.03 * peak
    figure = new_figure(10.0, 5.2)
    whole, near = figure.subplots(1, 2, width_ratios=(1.2, 1.0))
    for ax in (whole, near):
        ax.plot(angle, torque, color=BLUE, linewidth=1.3)
        ax.axhline(0.0, color=GREY, linewidth=0.8)
        ax.set(xlabel="angle [′]", ylabel="torque [N·m]")
    (T1, a1), (T2, a2) = found.rigidity_points
    rigidity = found.torsional_rigidity * ARCMIN / NEWTON_METRE
    whole.plot(
        [a1 / ARCMIN, a2 / ARCMIN, a2 / ARCMIN],
        [T1 / NEWTON_METRE, T1 / NEWTON_METRE, T2 / NEWTON_METRE],
        color=ORANGE,
        linestyle="--",
        label=f"torsional rigidity b/a = {rigidity:.4g} N·m/′",
    )
    whole.legend(loc="upper left")
    whole.set_ylim(-1.1 * peak, 1.35 * peak)
    whole.set_title("whole loop")
    near.plot(
        [low, high], [-three, three], "o", color=GREEN, label=f"lost motion, centreline at ±3 %: {high - low:.3f}′"
    )
    near.plot(
        [up, down], [0.0, 0.0], color=ORANGE, linewidth=3.0, label=f"hysteresis loss at zero torque: {down - up:.3f}′"
    )
    for T in (-three, three):
        near.axhline(T, color=GREEN, linewidth=0.8, linestyle=":")
    margin = 0.4 * max(high - low, abs(down - up), 1e-3)
    near.set_xlim(min(low, up) - margin, max(high, down) + margin)
    near.set_ylim(-2.5 * three, 5.0 * three)
    near.legend(loc="upper left")
    near.set_title("about zero torque")
    return figure


def _transmission(measurement: Measurement, built: Built) -> Figure:
    angle, error = measurement["output_angle_deg"], measurement["error_arcsec"]
    figure = new_figure(10.0, 6.4)
    top, bottom = figure.subplots(2, 1)
    top.plot(angle, error, color=BLUE, linewidth=0.7)
    top.set(xlabel="output angle [°]", ylabel="transmission error [″]")
    top.set_title(f"{np.ptp(error):.3g}″ peak to peak at {float(measurement.keys['torque_nm']):.4g} N·m")
    top.set_xlim(0.0, 360.0)
    turn_ticks(top)
    _orders(bottom, error, built)
    return figure


def _orders(ax: Axes, error: FloatArray, built: Built) -> None:
    """Order spectrum with the largest orders named as multiples of lobes, pins or the mesh."""
    trochoid = built.case.drive.trochoid
    amplitude = spectrum(error)
    orders = np.arange(amplitude.size)
    ax.vlines(orders[1:], 0.0, amplitude[1:], color=BLUE, linewidth=1.0)
    # One row a pin pitch shows the same pose again and again: no order at all.
    highest = max(float(np.max(amplitude[1:])), _NO_ORDER)
    for order in np.argsort(amplitude[1:])[::-1][:_LABELLED_ORDERS] + 1:
        if amplitude[order] < max(0.02 * highest, _NO_ORDER):
            continue
        ax.annotate(
            order_label(int(order), trochoid.lobes, trochoid.pins, error.size),
            (float(order), float(amplitude[order])),
            xytext=(-3, 3) if order > _TO_THE_LEFT * orders[-1] else (3, 3),
            textcoords="offset points",
            ha="right" if order > _TO_THE_LEFT * orders[-1] else "left",
            fontsize=8,
            color=ORANGE,
        )
    ax.set(xlabel="order per turn of the output", ylabel="amplitude [″]")
    ax.set_xlim(0.0, float(orders[-1]) * 1.04)
    ax.set_ylim(0.0, 1.2 * highest)


def _map(measurement: Measurement, built: Built) -> Figure:
    del built
    angle, value = measurement["output_angle_deg"], measurement["lost_motion_arcmin"]
    figure = new_figure(9.0, 4.4)
    ax = figure.add_subplot()
    ax.plot(angle, value, color=BLUE, linewidth=1.0)
    ax.axhline(float(np.mean(value)), color=ORANGE, linestyle="--", label=f"mean {np.mean(value):.4g}′")
    ax.set(xlabel="output angle [°]", ylabel="lost motion [′]", xlim=(0.0, 360.0))
    turn_ticks(ax)
    ax.set_title(f"between ±{float(measurement.keys['torque_nm']):.4g} N·m, {np.ptp(value):.3g}′ peak to peak")
    widened(ax, 0.7, 0.05 * float(np.mean(value)))
    ax.legend(loc="upper right")
    return figure


def _scan(measurement: Measurement, built: Built) -> Figure:
    disc = scanned_disc(measurement, built.discs)
    bare = replace(built, teeth=(built.case.profile,) * built.discs)
    return _polar(gap(bare, measurement, disc), "tooth of the drawing")


def _polar(found: Gap, reference: str = "prediction") -> Figure:
    """Deviation along the normal, magnified about a circle, and unrolled over lobe and phase."""
    angle, outside = np.deg2rad(found.where), -found.residual
    order = np.argsort(angle)
    scale = max(4.0 * float(np.std(outside)), 3.0 * found.noise, 1e-3)
    figure = new_figure(11.0, 5.6)
    left = figure.add_subplot(1, 2, 1, projection="polar")
    left.plot(angle[order], np.zeros(order.size), color=GREY, linewidth=0.8)
    left.plot(angle[order], outside[order], color=BLUE, linewidth=0.6)
    deviation_rings(left, scale, 1.2, f"{scale:.2g}")
    left.set_title(f"outwards of the {reference}", fontsize=10)
    lobes = found.built.case.drive.trochoid.lobes
    turned = -angle * lobes / (2.0 * np.pi)
    lobe = np.round(turned)
    mean = cell_means(np.mod(lobe, lobes).astype(int), turned - lobe + 0.5, outside, lobes, _CELLS)
    right = figure.add_subplot(1, 2, 2)
    drawn = unrolled(right, mean, scale, 0.5)
    right.set(xlabel="part of a lobe (0 root, ±0.5 tip)", ylabel="lobe", title="unrolled")
    figure.colorbar(drawn, ax=right, label="outwards [µm]")
    return figure
