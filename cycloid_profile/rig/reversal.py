"""A run in the time domain whose input changes direction again and again (docs/rig.md, "Reversal run").

One degree of freedom: the output's inertia hangs on the stage, whose static torque–twist curve acts between it
and the input; the flank it rests on changes when the direction does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.meshing import output_turn
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.effects.built import Built
from cycloid_profile.errors import SolveError
from cycloid_profile.units import DEGREE

# The article's drive V = 15000 sin(30 t) + 10890, whose unit is deg/s: 10890/6/121 = 15 rpm of the output.
ARTICLE_SPEED = (15000.0 * DEGREE, 30.0, 10890.0 * DEGREE)
_CURVE = np.concatenate([[1e-3, 0.003, 0.01], np.linspace(0.03, 1.6, 40)])
_TOUCH_POSES = 240
# The output follows when the other flank carries this share of the rated torque.
_FOLLOWS = 1e-3
_BINDS = 1e-8  # rad; half a nanometre on the flank


@dataclass(frozen=True, slots=True)
class ReversalRun:
    """The run and what was read of it.

    ``time`` [s], ``input_angle`` [rad], ``lag`` of the output behind the ideal angle [rad] and ``torque`` through the
    stage [N·mm], shape (steps,). For each reversal: ``reversal_time`` of the input [s]; ``follow_time``, when the other
    flank of the output takes the load [s]; and ``backlash`` B_j = (θ_j − θ_j')/i, the input's turn between them over
    the ratio [rad].
    """

    built: Built
    time: FloatArray
    input_angle: FloatArray
    lag: FloatArray
    torque: FloatArray
    reversal_time: FloatArray
    follow_time: FloatArray
    backlash: FloatArray


def reversal_run(
    built: Built,
    brake: float = 0.05,
    inertia: float = 0.05,
    damping: float = 0.2,
    duration: float = 1.2,
    speed: tuple[float, float, float] = ARTICLE_SPEED,
) -> ReversalRun:
    """Turn the input by v(t) = A sin(ωt) + C, ``speed`` = (A [rad/s], ω [rad/s], C [rad/s]), and watch the output.

    ``brake`` is the load against motion as a share of the rated torque, ``inertia`` that of the output [kg·m²],
    ``damping`` the share of critical damping in the contact at rated stiffness, ``duration`` [s].

    Raises
    ------
    SolveError
        If the stage finds no equilibrium at some torque, or the integration fails.
    """
    from scipy.integrate import solve_ivp
    from scipy.interpolate import PchipInterpolator

    rated = abs(built.case.torque)
    ratio = built.case.drive.reduction_ratio
    stage = StageEquilibrium(as_built=built.parts)
    shares = np.concatenate([-_CURVE[::-1], _CURVE])
    curve = stage.at(built.case, np.zeros(shares.size), shares * rated)
    if not curve.converged:
        raise SolveError("reversal run", "not started", "for lack of an equilibrium", "check bearings and torque", " ")
    # Twist beyond the touch of its own flank; where the touches stand depends on the angle of the output.
    twist = curve.rotation - curve.touch + built.series_compliance * shares * rated
    forward = PchipInterpolator(np.append(0.0, twist[_CURVE.size :]), np.append(0.0, _CURVE * rated), extrapolate=True)
    backward = PchipInterpolator(
        np.append(twist[: _CURVE.size], 0.0), np.append(-_CURVE[::-1] * rated, 0.0), extrapolate=True
    )
    angle, touch_forward, touch_backward = _touches(built, stage)
    if np.any(touch_forward < touch_backward - _BINDS):
        raise SolveError(
            "reversal run", "not started", "because the reducer binds somewhere", "make more clearance", " "
        )
    A, omega, C = speed
    kg_mm2 = inertia * 1e6
    stiffness = float(forward(twist[-1], 1))
    # N·mm and kg·mm² go with mm, kg·m/s² = N: the moment of 1 N·mm turns 1 kg·mm² by 1000 rad/s².
    mass = kg_mm2 * 1e-3
    c = 2.0 * damping * math.sqrt(stiffness * mass)

    def input_angle(t: FloatArray | float) -> FloatArray:
        turned: FloatArray = np.asarray(C * t - A / omega * (np.cos(omega * t) - 1.0))
        return turned

    def input_speed(t: FloatArray | float) -> FloatArray:
        rate: FloatArray = np.asarray(A * np.sin(omega * t) + C)
        return rate

    def stage_torque(t: float, out: float, out_speed: float) -> float:
        lag = out - float(input_angle(t)) / ratio
        place = float(np.mod(out, 2.0 * math.pi))
        high = lag - float(np.interp(place, angle, touch_forward))
        low = lag - float(np.interp(place, angle, touch_backward))
        rate = out_speed - float(input_speed(t)) / ratio
        if high > 0.0:
            pushed: float = float(forward(high)) + c * rate * min(1.0, 4.0 * high / twist[-1])
            return max(0.0, pushed)
        if low < 0.0:
            pulled: float = float(backward(low)) + c * rate * min(1.0, -4.0 * low / twist[-1])
            return min(0.0, pulled)
        return 0.0

    slow = 1e-3 * C / ratio
    held = brake * rated

    def motion(t: float, state: FloatArray) -> list[float]:
        out, out_speed = state
        return [out_speed, (-stage_torque(t, out, out_speed) - held * math.tanh(out_speed / slow)) / mass]

    start = float(np.interp(0.0, angle, touch_backward))
    steps = np.linspace(0.0, duration, int(16000 * duration) + 1)
    solved = solve_ivp(
        motion, (0.0, duration), [start, C / ratio], method="LSODA", t_eval=steps, rtol=1e-7, atol=[1e-10, 1e-7],
        max_step=5e-4,
    )  # fmt: skip
    if not solved.success:
        raise SolveError("reversal run", "stopped", f"with '{solved.message}'", "give more damping or inertia", " ")
    out, out_speed = solved.y
    torque = np.array([stage_torque(*row) for row in zip(steps, out, out_speed, strict=True)])
    at, after = _followed(steps, input_speed(steps), torque, _FOLLOWS * rated)
    return ReversalRun(
        built=built,
        time=steps,
        input_angle=input_angle(steps),
        lag=out - input_angle(steps) / ratio,
        torque=torque,
        reversal_time=at,
        follow_time=after,
        backlash=np.abs(input_angle(after) - input_angle(at)) / ratio,
    )


def _touches(built: Built, stage: StageEquilibrium) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Output angles over a turn and where either flank touches there, the turn closed [rad]."""
    crank = output_turn(built.case.drive.trochoid, _TOUCH_POSES)
    small = 1e-3 * abs(built.case.torque)
    solved = stage.at(built.case, np.tile(crank, 2), np.repeat([small, -small], _TOUCH_POSES))
    forward, backward = solved.touch.reshape(2, _TOUCH_POSES)
    angle = 2.0 * math.pi * np.arange(_TOUCH_POSES + 1) / _TOUCH_POSES
    return angle, np.append(forward, forward[0]), np.append(backward, backward[0])


def _followed(time: FloatArray, speed: FloatArray, torque: FloatArray, least: float) -> tuple[FloatArray, FloatArray]:
    """Times at which the input turns, and at which the other flank takes up the load after it [s].

    A reversal after which it does not, before the input turns again, is left out.
    """
    crossing = np.flatnonzero(speed[:-1] * speed[1:] < 0.0)
    turned = time[crossing] - speed[crossing] * (time[1] - time[0]) / (speed[crossing + 1] - speed[crossing])
    at, after = [], []
    for k, (i, t) in enumerate(zip(crossing, turned, strict=True)):
        end = crossing[k + 1] if k + 1 < crossing.size else time.size
        # An input that turns backwards drives the output by a positive torque on the stage, and the other way round.
        driving = -np.sign(speed[i + 1]) * torque[i:end] > least
        if np.any(driving) and not driving[0]:
            at.append(t)
            after.append(time[i + int(np.argmax(driving))])
    return np.array(at), np.array(after)
