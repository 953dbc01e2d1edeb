"""Radial force of a bearing compiled by numba: a spring with play, or rollers; imported inside functions only.

The law of rollers is the closed form of Sjövall's integral by Gauss's hypergeometric function ₂F₁(a, b; c; z)
(docs/theory.md, Eqs. 107–110). The two that occur have c − a − b = ν + ½ with ν = 19/9.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.compiled import inlined, inner, kernel

# ISO/TS 16281:2008: force of a line contact ∝ δ^(10/9), its energy ∝ δ^ν.
NU = 19.0 / 9.0
_KAPPA = NU + 0.5
# Degree of a polynomial on half the range of z, so that it errs by rounding; beyond z = ½ its coefficients grow.
_DEGREE, _DEGREE_BEYOND = 16, 28
_INVERSE_STEPS = 100


class CompiledBearing(NamedTuple):
    """``stiffness`` of a spring [N/mm]; or ``rollers``, number times constant c_L [N/mm^(10/9)], 0 for a spring, and
    ``compliance`` in series with them [mm/N].
    """

    stiffness: float
    rollers: float
    compliance: float


def _on_half(a: float, b: float, c: float, degree: int = _DEGREE) -> FloatArray:
    """₂F₁ on 0 ≤ z ≤ ½ as a polynomial in 4z − 1, highest power last, shape (1 + largest degree,)."""
    nodes = np.polynomial.chebyshev.chebpts1(degree + 1)
    z, term, total = 0.25 * (nodes + 1.0), np.ones_like(nodes), np.ones_like(nodes)
    for k in range(80):  # 2^−80 is below any rounding
        term = term * z * ((a + k) * (b + k) / ((c + k) * (1.0 + k)))
        total += term
    return powers_of(np.asarray(np.polynomial.chebyshev.chebfit(nodes, total, degree), dtype=np.float64))


def powers_of(series: FloatArray) -> FloatArray:
    """A Chebyshev series as a polynomial, highest power last, shape (1 + largest degree,).

    numpy drops a last coefficient that is zero, which depends on how the processor rounds.
    """
    powers = np.polynomial.chebyshev.cheb2poly(series)
    found = np.zeros(1 + _DEGREE_BEYOND)
    found[: powers.size] = powers
    return found


def _on_both_halves(a: float, b: float, c: float) -> FloatArray:
    """Polynomials of ₂F₁ = P₀(z) up to z = ½, and beyond it P₁(1 − z) + (1 − z)^(c−a−b) P₂(1 − z), shape (3, powers).

    Abramowitz and Stegun (1972), 15.3.6.
    """
    d, gamma = c - a - b, math.gamma
    regular = gamma(c) * gamma(d) / (gamma(c - a) * gamma(c - b)) * _on_half(a, b, 1.0 - d, _DEGREE_BEYOND)
    singular = gamma(c) * gamma(-d) / (gamma(a) * gamma(b)) * _on_half(c - a, c - b, 1.0 + d, _DEGREE_BEYOND)
    return np.stack([_on_half(a, b, c), regular, singular])


# Some rollers loaded; all rollers loaded.
_SOME, _ALL = _on_both_halves(0.5, 0.5, NU + 1.5), _on_both_halves(-0.5 * NU, 0.5 * (1.0 - NU), 1.0)
_SOME_FACTOR = math.gamma(0.5) * math.gamma(NU + 1.0) / math.gamma(NU + 1.5) / (NU * math.pi)


@inlined
def bearing_response(  # pragma: no cover - compiled, out of the sight of the coverage tool
    bearing: CompiledBearing, play: float, length: float
) -> tuple[float, float, float]:
    """Force over displacement F/r and tangent stiffness dF/dr [N/mm], and energy [N·mm], at a radial displacement r of
    ``length`` [mm]; ``play`` is negative under preload.
    """
    if bearing.rollers > 0.0:
        found: tuple[float, float, float] = _of_rollers(bearing, play, length)
        return found
    if length > play:
        beyond = length - play
        energy = 0.5 * bearing.stiffness * beyond * beyond
        return bearing.stiffness * beyond / length, bearing.stiffness, energy
    free = bearing.stiffness if play == 0.0 else 0.0
    return free, free, 0.0


@inner
def _of_rollers(bearing: CompiledBearing, play: float, length: float) -> tuple[float, float, float]:  # pragma: no cover
    """Response of rollers, and of the compliance in series with them."""
    if length <= play:
        return 0.0, 0.0, 0.0
    c = bearing.compliance
    if c == 0.0:
        found: tuple[float, float, float] = rollers_alone(bearing.rollers, play, length)
        return found
    # The displacement of the rollers alone, by Newton within a bracket: their force rises with it.
    own, low, high = length, 0.0, length
    secant, tangent, energy = rollers_alone(bearing.rollers, play, own)
    for _ in range(_INVERSE_STEPS):
        step = (own + c * secant * own - length) / (1.0 + c * tangent)
        if not abs(step) > 1e-15 * length:
            break
        if step > 0.0:
            high = own
        else:
            low = own
        own -= step
        if not low < own < high:
            own = 0.5 * (low + high)
        secant, tangent, energy = rollers_alone(bearing.rollers, play, own)
    force = secant * own
    shared = secant / (1.0 + c * secant)
    return shared, tangent / (1.0 + c * tangent), energy + 0.5 * c * force * force


@inner
def rollers_alone(rollers: float, play: float, r: float) -> tuple[float, float, float]:  # pragma: no cover
    """F/r, dF/dr and energy of rollers, evenly spread and averaged over the angle of their cage (Eqs. 108–110)."""
    if r <= play:
        return 0.0, 0.0, 0.0
    if r < -play:
        h = (r / play) * (r / play)  # squares of tiny plays would be zero
        g0, g1, g2 = _hypergeometric(_ALL, h)
        size = rollers / NU * (-play) ** (NU - 2.0)
        return 2.0 * size * g1, 2.0 * size * (g1 + 2.0 * h * g2), size * play * play * g0
    if r == 0.0:
        return 0.0, 0.0, 0.0
    s = r - play
    eps = 0.5 * s / r
    g0, g1, g2 = _hypergeometric(_SOME, eps)
    m = 1.0 - 2.0 * eps
    first, second = (0.5 * g0 + eps * g1) * m, (-0.25 * g0 + eps * (g1 + eps * g2)) * m * m
    size = rollers * _SOME_FACTOR * s ** (NU - 2.0) * math.sqrt(eps)
    tangent = NU * (NU - 1.0) * g0 + (2.0 * NU - 4.0 * eps) * first + second
    return size * s / r * (NU * g0 + first), size * tangent, size * s * s * g0


@inner
def _hypergeometric(halves: FloatArray, z: float) -> tuple[float, float, float]:  # pragma: no cover
    """₂F₁ with two derivatives by z, 0 ≤ z ≤ 1."""
    if z <= 0.5:
        found: tuple[float, float, float] = _polynomial(halves[0], _DEGREE, z)
        return found
    y = 1.0 - z
    a0, a1, a2 = _polynomial(halves[1], _DEGREE_BEYOND, y)
    b0, b1, b2 = _polynomial(halves[2], _DEGREE_BEYOND, y)
    p2 = y ** (_KAPPA - 2.0)
    p1, p0 = p2 * y, p2 * y * y
    second = a2 + p0 * b2 + 2.0 * _KAPPA * p1 * b1 + _KAPPA * (_KAPPA - 1.0) * p2 * b0
    return a0 + p0 * b0, -(a1 + p0 * b1 + _KAPPA * p1 * b0), second


@inner
def _polynomial(coefficients: FloatArray, degree: int, z: float) -> tuple[float, float, float]:  # pragma: no cover
    """A polynomial in x = 4z − 1 with two derivatives by z, after Horner."""
    x = 4.0 * z - 1.0
    p, first, second = 0.0, 0.0, 0.0
    for k in range(degree, -1, -1):
        second = second * x + first
        first = first * x + p
        p = p * x + coefficients[k]
    return p, 4.0 * first, 32.0 * second


@kernel
def bearing_responses(  # pragma: no cover
    bearing: CompiledBearing, play: FloatArray, length: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """``bearing_response`` of many, all of one shape (n,)."""
    secant, tangent, energy = np.empty(length.size), np.empty(length.size), np.empty(length.size)
    for i in range(length.size):
        secant[i], tangent[i], energy[i] = bearing_response(bearing, play[i], length[i])
    return secant, tangent, energy


@kernel
def displacements(bearing: CompiledBearing, play: FloatArray, force: FloatArray) -> FloatArray:  # pragma: no cover
    """Displacement under each force ≥ 0, the play where it is zero, shape (n,) [mm]."""
    found = np.empty(force.size)
    for i in range(force.size):
        low = max(play[i], 0.0)
        high = low + 1e-3
        while bearing_response(bearing, play[i], high)[0] * high < force[i] and high < 1e6:
            high += 2.0 * (high - low)
        r = high if force[i] > 0.0 else low
        for _ in range(_INVERSE_STEPS):
            if force[i] <= 0.0:
                break
            secant, tangent, _energy = bearing_response(bearing, play[i], r)
            miss = secant * r - force[i]
            if miss > 0.0:
                high = r
            else:
                low = r
            step = miss / tangent
            if not abs(step) > 1e-15 * r:
                break
            r = r - step if low < r - step < high else 0.5 * (low + high)
        found[i] = r
    return found
