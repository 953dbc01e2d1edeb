"""Equilibria of many poses from nearby starting points, compiled by numba; imported inside functions only.

The removal from the tooth beyond the parallel curve enters as three terms of its Taylor series about a phase near
each foot.
"""

from __future__ import annotations

import math

import numpy as np

from cycloid_profile.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from cycloid_profile.compiled import inner, kernel
from cycloid_profile.contact.bodies._bearing_kernels import CompiledBearing
from cycloid_profile.contact.laws._kernels import contact_constant
from cycloid_profile.contact.laws.compiled import CompiledLaw
from cycloid_profile.contact.stage._kernels import (
    PoseProblem,
    SlicedWidth,
    energy_at,
    imbalance,
    least_energy,
    times,
    width_at,
    workspace,
)

_FOOT_STEPS, _LAST_STEP, _STEP_LIMIT = 60, 1e-8, 0.2
_UNBALANCED = 0.5  # of the torque
# A search whose imbalance does not fall to this share of its least in so many refreshes goes round in circles.
_FALL, _PATIENCE = 0.7, 10


@kernel
def settle(  # pragma: no cover - compiled, out of the sight of the coverage tool
    tooth: FloatArray,
    capture: FloatArray,
    pin_radius: FloatArray,
    pin_shift: ComplexArray,
    pin_centre: ComplexArray,
    into_lobe: ComplexArray,
    removal: FloatArray,
    about: FloatArray,
    law: CompiledLaw,
    own: IntArray,
    spring_stretch: FloatArray,
    misfit: FloatArray,
    bearing: CompiledBearing,
    play: float,
    torque: FloatArray,
    arm: FloatArray,
    along: FloatArray,
    least_reach: float,
    overclosure: FloatArray,
    tolerance: FloatArray,
    limits: IntArray,
    compliance: FloatArray,
    width: SlicedWidth,
    u: FloatArray,
    load: FloatArray,
    foot: FloatArray,
    gap: FloatArray,
    frame: FloatArray,
    curvature: FloatArray,
    settled: BoolArray,
    begin: int,
    end: int,
) -> None:
    """Fill ``u`` (poses, unknowns), where the search begins as well, ``foot``, ``gap``, ``curvature`` (poses, discs,
    pins), ``frame`` (poses, 3, discs, pins), normal in the housing and lever, and ``settled`` (poses,), of the poses
    from ``begin`` to ``end``.

    ``tooth`` (discs, 6): pins, pin circle radius, eccentricity, K1, lobes and pin radius of the generating motion;
    ``capture`` (poses, discs, pins), capture radius of each pin; ``removal`` (poses, discs, pins, 3),
    value and derivatives at the phase ``about``; ``along`` (poses, unknowns), the motion of all as one;
    ``compliance`` (poses, forces, forces) and ``load`` (poses, forces) of elastic bodies as in ``StageEnergy``;
    ``width``, the slices, their slopes not read; ``tolerance`` (poses,); ``limits``, refreshes and whole steps. The
    others as in ``StageEnergy`` and ``Meshing``.
    """
    _, discs, pins = gap.shape
    bearings, unknowns = spring_stretch.shape[1], arm.size
    elastic = load.shape[1] > 0
    for p in range(begin, end):
        step, work = np.zeros(unknowns), workspace(discs, pins, bearings, unknowns, elastic)
        constant, stretch, still = np.empty((discs, pins)), np.empty((bearings, 2)), np.zeros(unknowns)
        slope, receded = np.zeros((len(width.tilt), 2)), np.zeros(load.shape[1])
        sense = 1.0 if torque[p] > 0.0 else -1.0
        settled[p] = False
        least, idle = np.inf, 0
        for refresh in range(limits[0]):
            found = True
            for a in range(unknowns):
                found &= abs(u[p, a] / arm[a]) < 1.0
            if not found:
                break
            for d in range(discs):
                turn = u[p, own[d, 2]]
                shift = complex(u[p, own[d, 0]], u[p, own[d, 1]])
                swing = complex(math.cos(turn), math.sin(turn))
                for k in range(pins):
                    moved = pin_centre[p, d, k] + (pin_shift[k] - shift) * into_lobe[p, d, k]
                    found &= _touch(tooth[d], capture[p, d, k], pin_radius[k], np.conj(swing) * moved,
                                    swing * np.conj(into_lobe[p, d, k]), removal[p, d, k], about[p, d, k], foot[p, d],
                                    gap[p, d], frame[p, :, d], curvature[p, d], k)  # fmt: skip
                    constant[d, k] = contact_constant(law, curvature[p, d, k])
            if not found:
                break
            for s in range(bearings):
                for i in range(2):
                    stretch[s, i] = misfit[p, s, i]
                    for a in range(unknowns):
                        stretch[s, i] += spring_stretch[p, s, i, a] * u[p, a]
            for d in range(len(slope)):
                for i in range(2):
                    slope[d, i] = u[p, width.tilt[d, i]]
            problem = PoseProblem(law, constant, gap[p], frame[p], own, spring_stretch[p], stretch, bearing, play,
                                  torque[p], u[p, 0], arm, compliance[p], width_at(width, slope))  # fmt: skip
            if elastic:
                times(compliance[p], load[p], receded)
            energy_at(problem, still, receded, work.motions[2], work)
            off = imbalance(problem, work.motions[2], load[p], work)
            step[:] = 0.0
            if off < tolerance[p]:
                settled[p] = True
                break
            if off < _FALL * least:
                least, idle = off, 0
            else:
                idle += 1
            if idle > _PATIENCE or not off < np.inf:
                break
            if refresh == 0 and off > _UNBALANCED:
                # Pressed together a little: Newton then has forces to balance from the start.
                turn = np.inf
                for d in range(discs):
                    x, y, t = along[p, own[d, 0]], along[p, own[d, 1]], along[p, own[d, 2]]
                    for k in range(pins):
                        reach = sense * (frame[p, 0, d, k] * x + frame[p, 1, d, k] * y + frame[p, 2, d, k] * t)
                        if reach > least_reach:
                            turn = min(turn, gap[p, d, k] / reach)
                turn = sense * (turn if turn < np.inf else 0.0) + overclosure[p]
                for a in range(unknowns):
                    step[a] = along[p, a] * turn
            least_energy(problem, 0.1 * tolerance[p], step, load[p], work)
            share = 1.0 if refresh <= limits[1] else 0.5
            for a in range(unknowns):
                u[p, a] += share * step[a]


@inner
def _touch(  # pragma: no cover
    tooth: FloatArray,
    capture: float,
    pin_radius: float,
    centre: complex,
    into_housing: complex,
    removal: FloatArray,
    about: float,
    foot: FloatArray,
    gap: FloatArray,
    frame: FloatArray,
    curvature: FloatArray,
    k: int,
) -> bool:
    """Fill foot, gap, frame and curvature of pin ``k`` on one disc; false where Newton finds no foot or there might be
    a nearer one."""
    z_p, r_p, a, K1, z_c, q = tooth[0], tooth[1], tooth[2], tooth[3], tooth[4], tooth[5]
    c, path_curvature = r_p / z_c, K1 * (z_p + 1.0)
    psi = foot[k]
    step = 1.0
    position, away, n, first = 0j, 0j, 0j, 0j
    kappa, outside = 0.0, 1.0
    for _ in range(_FOOT_STEPS):
        sin_half, cos_half = math.sin(0.5 * psi), math.cos(0.5 * psi)
        sin, versine = 2.0 * sin_half * cos_half, 2.0 * sin_half * sin_half
        slow = complex(math.cos(psi / z_c), -math.sin(psi / z_c))
        w2 = (1.0 - K1) * (1.0 - K1) + 2.0 * K1 * versine
        w = math.sqrt(w2)
        turn = ((path_curvature - (1.0 + z_p * K1 * K1)) - path_curvature * versine) / (z_c * w2)
        turn_rate = -K1 * sin * ((z_p + 1.0) / z_c + 2.0 * turn) / w2
        n = slow * complex(((1.0 - K1) + K1 * versine) / w, K1 * sin / w)
        d = psi - about
        Q = q + removal[0] + d * (removal[1] + 0.5 * d * removal[2])
        rise, rise_rate = removal[1] + d * removal[2], removal[2]
        g = c * w + Q * turn
        g_rate = c * K1 * sin / w + rise * turn + Q * turn_rate
        position = slow * complex((r_p - a) + a * versine, a * sin) - Q * n
        first = n * complex(-rise, -g)
        away = centre - position
        way = np.conj(n) * away
        out, across = way.real, way.imag
        speed2 = g * g + rise * rise
        slope = -g * across - rise * out
        second = out * (turn * g - rise_rate) - across * (g_rate + turn * rise) - speed2
        kappa = (rise * (g_rate + turn * rise) + g * (turn * g - rise_rate)) / (speed2 * math.sqrt(speed2))
        outside = -1.0 if out * g - across * rise < 0.0 else 1.0
        step = -slope / (second if second < 0.0 else -speed2)
        step = min(max(step, -_STEP_LIMIT), _STEP_LIMIT)
        if abs(step) < _LAST_STEP:
            break
        psi += step
    position += first * step
    away -= first * step
    length = abs(away)
    foot[k], curvature[k] = psi + step, kappa
    distance = outside * length
    normal = away / distance
    gap[k] = distance - pin_radius
    housing = normal * into_housing
    frame[0, k], frame[1, k] = housing.real, housing.imag
    frame[2, k] = position.real * normal.imag - position.imag * normal.real
    return abs(step) < _LAST_STEP and length < capture
