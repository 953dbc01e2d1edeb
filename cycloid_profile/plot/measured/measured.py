"""Figures of measured and simulated files and curves, and of their residuals."""

from __future__ import annotations

from dataclasses import replace
from functools import singledispatch
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile._display import with_unit
from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.geometry import ToothProfile
from cycloid_profile.measurement import (
    Hysteresis,
    LostMotionMap,
    Measurement,
    MeasurementKind,
    ProfileScan,
    TransmissionErrorCurve,
    scanned_disc,
)
from cycloid_profile.plot.measured.panels import (
    cell_means,
    cells_of_a_lobe,
    deviation_scale,
    draw_deviation_rings,
    draw_lobe_image,
    draw_orders,
    draw_residual,
    no_points_marks,
    noise_mark,
    order_namer,
    turn_ticks,
    widened,
)
from cycloid_profile.plot.style import BLUE, GREEN, GREY, ORANGE, canvas, line_mark, plain
from cycloid_profile.rig import (
    LOST_MOTION_SHARE,
    AngleMap,
    Loop,
    MeasurementResidual,
    TransmissionError,
    evaluate_loop,
    spectrum,
)
from cycloid_profile.rig import measurement_residual as residual_of
from cycloid_profile.units import ARCMIN, ARCSEC, DEGREE, NEWTON_METRE, SIGNS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_PHASES_OF_A_LOBE = 721  # a table every half degree, far finer than a cell of the map


def measurement(result: Measurement, ax: Any = None, *, reducer: AsBuiltReducer | None = None, name: str = "") -> Any:
    """One measured file: hysteresis loop with its characteristic values, transmission error with its orders, map, or
    scan.

    Two axes, or one of a map; of those given for a scan the first must be polar. ``reducer`` names the orders and is
    the reference of a scan; a scan without one is drawn about its mean radius.
    """
    return _file(result.kind, result, ax, reducer, name)


@singledispatch
def _file(kind: MeasurementKind, result: Measurement, ax: Any, reducer: AsBuiltReducer | None, name: str) -> Any:
    """Picture of a file of this ``kind``."""
    raise NotImplementedError(f"a {kind.title} has no picture")


@_file.register
def _(kind: Hysteresis, result: Measurement, ax: Any, reducer: AsBuiltReducer | None, name: str) -> Any:  # noqa: ARG001
    return _loop(result["torque_nm"], result["angle_arcmin"], ax, name, kind.title)


@_file.register
def _(kind: TransmissionErrorCurve, result: Measurement, ax: Any, reducer: AsBuiltReducer | None, name: str) -> Any:
    torque = result.number("torque_nm")
    return _error(result["output_angle_deg"], result["error_arcsec"], torque, reducer, ax, name, kind.title)


@_file.register
def _(kind: LostMotionMap, result: Measurement, ax: Any, reducer: AsBuiltReducer | None, name: str) -> Any:  # noqa: ARG001
    torque = result.number("torque_nm")
    return _map(result["output_angle_deg"], result["lost_motion_arcmin"], torque, "lost motion", ax, name, kind.title)


@_file.register
def _(kind: ProfileScan, result: Measurement, ax: Any, reducer: AsBuiltReducer | None, name: str) -> Any:
    if reducer is not None:
        nominal = replace(reducer, teeth=(reducer.case.profile,) * reducer.discs)
        found = residual_of(nominal, result, scanned_disc(result, reducer.discs))
        return scan_deviation(found, "tooth of the drawing", ax, name, kind.title)
    with canvas(ax, (11.0, 5.6), 1, 2, polar=(0,)) as drawn:
        z = result["x_mm"] + 1j * result["y_mm"]
        angle, radius = np.angle(z), np.abs(z) - np.mean(np.abs(z))
        for axes, x in zip(drawn.axes, (angle, angle / DEGREE), strict=True):
            axes.plot(x, radius, ".", color=BLUE, markersize=1.5)
        drawn.axes[1].set(xlabel="polar angle [°]", ylabel="radius minus its mean [mm]")
        drawn.title(name, kind.title)
    return drawn.axes


def measurement_residual(result: MeasurementResidual, ax: Any = None, *, name: str = "") -> Any:
    """Measured minus predicted, compared with the noise; one pair of axes, or two of a scan, the first polar."""
    unit = SIGNS[result.unit]
    rms, noise = (with_unit(f"{value:.3g}", unit) for value in (result.rms, result.noise))
    file = f"{plain(name)}, {plain(result.measurement.name)}" if name else plain(result.measurement.name)
    heading = f"{file}: gap {rms} rms, noise {noise}"
    if not result.measurement.kind.is_curve:
        return scan_deviation(result, "prediction", ax, "", heading)
    with canvas(ax, (9.0, 4.6)) as drawn:
        axes = drawn.axes
        draw_residual(axes, result.position, result.residual, result.noise, unit)
        axes.set_xlabel(result.axis)
        if result.measurement.kind.over_output_turn:
            turn_ticks(axes)
        drawn.title("", heading)
        handles = [line_mark("measured minus predicted", color=BLUE), noise_mark()]
        drawn.legend(len(handles), handles=handles, fontsize=9)
    return axes


def hysteresis_loop(result: Loop, ax: Any = None, *, name: str = "") -> Any:
    """Torque over angle with the four characteristic values, whole loop and near zero torque; two axes."""
    heading = f"loop at an output angle of {result.output_angle / DEGREE:.4g}°"
    return _loop(result.torque / NEWTON_METRE, result.angle / ARCMIN, ax, name, heading)


def transmission_error(result: TransmissionError, ax: Any = None, *, name: str = "") -> Any:
    """Error over a turn of the output, and its orders; two axes."""
    angle, error, torque = result.output_angle / DEGREE, result.error / ARCSEC, result.torque / NEWTON_METRE
    return _error(angle, error, torque, result.reducer, ax, name, "transmission error")


def angle_map(result: AngleMap, ax: Any = None, *, name: str = "") -> Any:
    """The angle [′] or stiffness [N·m/′] over a turn of the output, with its mean; one pair of axes."""
    angle, torque = result.output_angle / DEGREE, result.torque / NEWTON_METRE
    if result.is_stiffness:
        stiffness = result.value * ARCMIN / NEWTON_METRE
        return _map(angle, stiffness, torque, "torsional rigidity", ax, name, "map of rigidity", " N·m/′")
    return _map(angle, result.value / ARCMIN, torque, "angle", ax, name, "map of an angle")


def _loop(torque: FloatArray, angle: FloatArray, ax: Any, name: str, heading: str) -> Any:
    """Torque [N·m] over angle [′]."""
    found = evaluate_loop(torque * NEWTON_METRE, angle * ARCMIN)
    with canvas(ax, (10.0, 5.2), 1, 2, width_ratios=(1.2, 1.0)) as drawn:
        whole, near = drawn.axes
        for axes in drawn.axes:
            axes.plot(angle, torque, color=BLUE, linewidth=1.3)
            axes.axhline(0.0, color=GREY, linewidth=0.8)
            axes.set(xlabel="angle [′]", ylabel="torque [N·m]")
        peak = float(np.max(torque))
        (T1, a1), (T2, a2) = ((T / NEWTON_METRE, a / ARCMIN) for T, a in found.rigidity_points)
        rigidity = f"torsional rigidity b/a = {found.torsional_rigidity * ARCMIN / NEWTON_METRE:.4g} N·m/′"
        whole.plot([a1, a2, a2], [T1, T1, T2], color=ORANGE, linestyle="--", label=rigidity)
        whole.legend(loc="upper left")
        whole.set(ylim=(-1.1 * peak, 1.35 * peak), title="whole loop")
        _about_zero(
            near, LOST_MOTION_SHARE * peak, *(np.array(found.centreline) / ARCMIN), *np.array(found.zero) / ARCMIN
        )
        drawn.title(name, heading)
    return drawn.axes


def _about_zero(ax: Axes, light: float, low: float, high: float, up: float, down: float) -> None:
    """Lost motion between the centreline at ± ``light`` [N·m], and width of the loop at zero torque; angles [′]."""
    lost = f"lost motion, centreline at ±3 %: {high - low:.3f}′"
    ax.plot([low, high], [-light, light], "o", color=GREEN, label=lost)
    loss = f"hysteresis loss at zero torque: {down - up:.3f}′"
    ax.plot([up, down], [0.0, 0.0], color=ORANGE, linewidth=3.0, label=loss)
    for T in (-light, light):
        ax.axhline(T, color=GREEN, linewidth=0.8, linestyle=":")
    margin = 0.4 * max(high - low, abs(down - up), 1e-3)
    ax.set_xlim(min(low, up) - margin, max(high, down) + margin)
    ax.set_ylim(-2.5 * light, 5.0 * light)
    ax.legend(loc="upper left")
    ax.set_title("about zero torque")


def _error(
    angle: FloatArray, error: FloatArray, torque: float | None, reducer: AsBuiltReducer | None, ax: Any, name: str,
    heading: str,
) -> Any:  # fmt: skip
    """Error [″] over angle [°] at a torque [N·m]."""
    with canvas(ax, (10.0, 6.4), 2) as drawn:
        top, bottom = drawn.axes
        top.plot(angle, error, color=BLUE, linewidth=0.7)
        top.set(xlabel="output angle [°]", ylabel="transmission error [″]", xlim=(0.0, 360.0))
        top.set_title(f"{np.ptp(error):.3g}″ peak to peak at {torque:.4g} N·m")
        turn_ticks(top)
        amplitude = spectrum(error)
        # Noise is unknown here: half of the orders lie below the median.
        draw_orders(bottom, [amplitude], (BLUE,), float(np.median(amplitude)), order_namer(reducer, error.size), "″")
        drawn.title(name, heading)
    return drawn.axes


def _map(
    angle: FloatArray, value: FloatArray, torque: float | None, quantity: str, ax: Any, name: str, heading: str,
    unit: str = "′",
) -> Any:  # fmt: skip
    """A quantity over angle [°], found between ± a torque [N·m]."""
    with canvas(ax, (9.0, 4.4)) as drawn:
        axes = drawn.axes
        drawn.title(name, heading)
        axes.plot(angle, value, color=BLUE, linewidth=1.0)
        axes.axhline(float(np.mean(value)), color=ORANGE, linestyle="--", label=f"mean {np.mean(value):.4g}{unit}")
        axes.set(xlabel="output angle [°]", ylabel=f"{quantity} [{unit.strip()}]", xlim=(0.0, 360.0))
        turn_ticks(axes)
        axes.set_title(f"between ±{torque:.4g} N·m, {np.ptp(value):.3g}{unit} peak to peak")
        widened(axes, 0.7, 0.05 * float(np.mean(value)))
        axes.legend(loc="upper right")
    return axes


def scan_deviation(found: MeasurementResidual, reference: str, ax: Any, name: str, heading: str) -> Any:
    """Deviation along the normal, magnified about a circle, and unrolled over lobe and phase."""
    angle, outside = np.deg2rad(found.position), -found.residual
    order = np.argsort(angle)
    lobes = found.reducer.case.drive.trochoid.lobes
    number, part = _lobe_and_part(found.reducer.case.profile, angle)
    per_lobe = angle.size / np.unique(number).size
    mean = cell_means(number, part, outside, lobes, cells_of_a_lobe(per_lobe))
    scale = deviation_scale(mean, found.noise, per_lobe)
    with canvas(ax, (11.0, 5.6), 1, 2, polar=(0,)) as drawn:
        left, right = drawn.axes
        left.plot(angle[order], np.zeros(order.size), color=GREY, linewidth=0.8)
        left.plot(angle[order], outside[order], color=BLUE, linewidth=0.6)
        rings = max(4.0 * float(np.std(outside)), scale)
        draw_deviation_rings(left, rings, 1.2, f"{rings:.2g}")
        left.set_title(f"outwards of the {reference}", fontsize=10)
        image = draw_lobe_image(right, mean, scale)
        right.set_title("unrolled")
        drawn.figure.colorbar(image, ax=right, label="outwards [µm]")
        if handles := no_points_marks(mean):
            right.legend(handles=handles, loc="upper right", fontsize=8, frameon=True)
        drawn.title(name, heading)
    return drawn.axes


def _lobe_and_part(profile: ToothProfile, angle: FloatArray) -> tuple[IntArray, FloatArray]:
    """Lobe from 0 and part of it in phase ψ, 0 and 1 at the tips, of the points of a tooth at polar angles [rad]."""
    lobes = profile.trochoid.lobes
    # Lobes follow each other clockwise, the first with its root at angle 0.
    turned = -angle * lobes / (2.0 * np.pi)
    lobe = np.round(turned)
    psi = np.linspace(-np.pi, np.pi, _PHASES_OF_A_LOBE)
    along = -np.angle(profile.at(psi).position) * lobes / (2.0 * np.pi)
    return np.mod(lobe, lobes).astype(np.intp), np.interp(turned - lobe, along, psi / (2.0 * np.pi) + 0.5)
