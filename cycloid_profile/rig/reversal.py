"""A run in the time domain whose input reverses periodically (docs/rig.md, "Reversal run").

One degree of freedom: the inertia of the output on the stage, whose static torque–twist curve acts between it and the
input; a reversal changes the loaded flank.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_profile._display import Described, frame
from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.errors import SolveError
from cycloid_profile.rig.curves_over_turn import touch_angles
from cycloid_profile.units import ARCMIN, DEGREE

# The article's drive V = 15000 sin(30 t) + 10890, whose unit is deg/s: 10890/6/121 = 15 rpm of the output.
PUBLISHED_REVERSAL_SPEED = (15000.0 * DEGREE, 30.0, 10890.0 * DEGREE)
# Shares of the rated torque, dense near zero, where the contact law is curved.
_CURVE = np.concatenate([[1e-3, 0.003, 0.01], np.linspace(0.03, 1.6, 40)])
_TOUCH_POSES = 240  # six a pin pitch of 40 pins
# The output follows when the other flank carries this share of the rated torque.
_LEAST_FOLLOWING_SHARE = 1e-3
_BINDS = 1e-8  # rad; half a nanometre on the flank
_STEPS_PER_SECOND = 16000  # 3,000 a period of the published drive


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class ReversalRun(Described):
    """The motion of a reversal run and the backlash read from it.

    ``time`` [s], ``input_angle`` [rad], ``lag`` of the output behind the ideal angle [rad] and ``torque`` through the
    stage [N·mm], shape (steps,). For each reversal: ``reversal_time`` of the input [s]; ``follow_time``, when the other
    flank of the output takes the load [s]; and ``backlash`` B_j = (θ_j − θ_j')/i, the input's turn between them over
    the ratio [rad].
    """

    reducer: AsBuiltReducer
    time: FloatArray
    input_angle: FloatArray
    lag: FloatArray
    torque: FloatArray
    reversal_time: FloatArray
    follow_time: FloatArray
    backlash: FloatArray

    def to_frame(self) -> Any:
        """Time [s], input angle, lag [rad] and torque through the stage [N·mm] by step, as a ``pandas.DataFrame``."""
        return frame({name: getattr(self, name) for name in ("time", "input_angle", "lag", "torque")})

    def _key_figures(self) -> dict[str, str]:
        figures = {"duration": f"{self.time[-1]:.4g} s", "reversals": str(self.backlash.size)}
        if self.backlash.size:
            low, high = np.min(self.backlash) / ARCMIN, np.max(self.backlash) / ARCMIN
            figures["backlash"] = f"{low:.4g}′ to {high:.4g}′"
        return figures


@dataclass(frozen=True, eq=False)
class _ContactTorque:
    """Static torque [N·mm] of the stage by the twist beyond first touch of either flank, with contact damping.

    ``touch``, rotation at first touch of the forward and the backward flank at each ``angle`` of a closed turn of the
    output, shape (2, angles) [rad]; ``largest_twist`` of the forward curve [rad].
    """

    forward: Callable[..., Any]
    backward: Callable[..., Any]
    angle: FloatArray
    touch: FloatArray
    largest_twist: float

    def torque(self, output: float, lag: float, lag_rate: float, damping: float) -> float:
        """Torque through the stage at an angle of the output and its ``lag`` behind the ideal angle [rad]."""
        place = float(np.mod(output, 2.0 * math.pi))
        for side, curve, touch in ((1.0, self.forward, self.touch[0]), (-1.0, self.backward, self.touch[1])):
            twist = lag - float(np.interp(place, self.angle, touch))
            if side * twist > 0.0:
                # Damping grows with the contact: it must not pull where the flanks just touch.
                damped = damping * lag_rate * min(1.0, side * 4.0 * twist / self.largest_twist)
                return side * max(0.0, side * (float(curve(twist)) + damped))
        return 0.0


def reversal_run(
    reducer: AsBuiltReducer,
    brake: float = 0.05,
    inertia: float = 0.05,
    damping: float = 0.2,
    duration: float = 1.2,
    speed: tuple[float, float, float] = PUBLISHED_REVERSAL_SPEED,
) -> ReversalRun:
    """Drive the input by v(t) = A sin(ωt) + C, ``speed`` = (A [rad/s], ω [rad/s], C [rad/s]), and record the output.

    ``brake`` is the load against motion as a share of the rated torque, ``inertia`` that of the output [kg·m²],
    ``damping`` the share of critical damping in the contact at rated stiffness, ``duration`` [s].

    Raises ``SolveError`` if the stage finds no equilibrium at some torque, or the integration fails.
    """
    from scipy.integrate import solve_ivp

    rated, ratio = abs(reducer.case.torque), reducer.case.drive.reduction_ratio
    spring = _spring(reducer)
    A, omega, C = speed
    # N·mm and kg·mm² go with mm, kg·m/s² = N: the moment of 1 N·mm turns 1 kg·mm² by 1000 rad/s².
    mass = inertia * 1e6 * 1e-3
    c = 2.0 * damping * math.sqrt(float(spring.forward(spring.largest_twist, 1)) * mass)

    def input_angle(t: FloatArray | float) -> FloatArray:
        return np.asarray(C * t - A / omega * (np.cos(omega * t) - 1.0))

    def input_speed(t: FloatArray | float) -> FloatArray:
        return np.asarray(A * np.sin(omega * t) + C)

    def torque_at(t: float, out: float, out_speed: float) -> float:
        lag_rate = out_speed - float(input_speed(t)) / ratio
        return spring.torque(out, out - float(input_angle(t)) / ratio, lag_rate, c)

    slow = 1e-3 * C / ratio

    def motion(t: float, state: FloatArray) -> list[float]:
        out, out_speed = state
        friction = brake * rated * math.tanh(out_speed / slow)
        return [out_speed, (-torque_at(t, out, out_speed) - friction) / mass]

    steps = np.linspace(0.0, duration, int(_STEPS_PER_SECOND * duration) + 1)
    solved = solve_ivp(
        motion, (0.0, duration), [float(spring.touch[1, 0]), C / ratio], method="LSODA", t_eval=steps, rtol=1e-7,
        atol=[1e-10, 1e-7], max_step=5e-4,
    )  # fmt: skip
    if not solved.success:
        raise SolveError("reversal run", "stopped", f"with '{solved.message}'", "give more damping or inertia", " ")
    out, out_speed = solved.y
    torque = np.array([torque_at(*row) for row in zip(steps, out, out_speed, strict=True)])
    at, after = _followed(steps, input_speed(steps), torque, _LEAST_FOLLOWING_SHARE * rated)
    angle = input_angle(steps)
    backlash = np.abs(input_angle(after) - input_angle(at)) / ratio
    return ReversalRun(reducer, steps, angle, out - angle / ratio, torque, at, after, backlash)


def _spring(reducer: AsBuiltReducer) -> _ContactTorque:
    """Torque–twist curves of both flanks, and their first touch over a turn of the output."""
    from scipy.interpolate import PchipInterpolator

    rated = abs(reducer.case.torque)
    shares = np.concatenate([-_CURVE[::-1], _CURVE])
    stage = StageEquilibrium(deviations=reducer.deviations)
    curve = stage.at(reducer.case, np.zeros(shares.size), shares * rated)
    if not curve.converged:
        raise SolveError("reversal run", "not started", "for lack of an equilibrium", "check bearings and torque", " ")
    # Twist beyond first touch of its own flank; the angle of the output decides where that touch is.
    twist = curve.rotation - curve.touch + reducer.series_twist(shares * rated)
    forward = PchipInterpolator(np.append(0.0, twist[_CURVE.size :]), np.append(0.0, _CURVE * rated), extrapolate=True)
    backward = PchipInterpolator(
        np.append(twist[: _CURVE.size], 0.0), np.append(-_CURVE[::-1] * rated, 0.0), extrapolate=True
    )
    touch = touch_angles(reducer, _TOUCH_POSES)
    if np.any(touch[0] < touch[1] - _BINDS):
        raise SolveError(
            "reversal run", "not started", "because the reducer binds somewhere", "make more clearance", " "
        )
    angle = 2.0 * math.pi * np.arange(_TOUCH_POSES + 1) / _TOUCH_POSES
    return _ContactTorque(forward, backward, angle, np.append(touch, touch[:, :1], axis=1), float(twist[-1]))


def _followed(time: FloatArray, speed: FloatArray, torque: FloatArray, least: float) -> tuple[FloatArray, FloatArray]:
    """Times of the reversals of the input, and at which the other flank takes up the load afterwards [s].

    Reversals without a flank change before the next reversal are omitted.
    """
    crossing = np.flatnonzero(speed[:-1] * speed[1:] < 0.0)
    turned = time[crossing] - speed[crossing] * (time[1] - time[0]) / (speed[crossing + 1] - speed[crossing])
    at, after = [], []
    for k, (i, t) in enumerate(zip(crossing, turned, strict=True)):
        end = crossing[k + 1] if k + 1 < crossing.size else time.size
        # A backward input drives the output by a positive torque on the stage, a forward input by a negative one.
        driving = -np.sign(speed[i + 1]) * torque[i:end] > least
        if np.any(driving) and not driving[0]:
            at.append(t)
            after.append(time[i + int(np.argmax(driving))])
    return np.array(at), np.array(after)
