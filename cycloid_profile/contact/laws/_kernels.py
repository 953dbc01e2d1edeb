"""Response of one contact to its approach under any law, compiled by numba; imported inside functions only.

One function serves the moment balance of a disc, the energy of the stage and the tolerance study. A law is a
``CompiledLaw``; a contact enters it by one number, its ``contact_constant``.
"""

from __future__ import annotations

import math

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.compiled import inlined, inner, kernel
from cycloid_profile.contact.laws.compiled import (
    HALLEY_STEPS,
    LOGARITHM,
    POWER,
    STENCIL,
    CompiledLaw,
)

_SPRING_STEPS = 40
_INNER = STENCIL // 2 - 1  # the middle interval of a stencil


@inner
def contact_constant(law: CompiledLaw, curvature: float) -> float:  # pragma: no cover - compiled
    """Number that describes a contact to its law: K + ln G for a logarithm, the row for a table, 0 for a power law."""
    if law.kind == LOGARITHM:
        size = max(abs(curvature), law.least_curvature)
        if law.tooth_radius_exponent != 1.0:  # like bodies need no power, which costs more than all the rest
            size **= law.tooth_radius_exponent
        constant: float = law.exponent + math.log(abs(law.pin_curvature - curvature) / size) + math.log(law.factor)
        return constant
    return 0.0 if law.kind == POWER else _row(law, curvature)


@inlined
def response(law: CompiledLaw, constant: float, approach: float) -> tuple[float, float, float]:  # pragma: no cover
    """Force [N], tangent stiffness [N/mm] and energy ∫F dδ [N·mm] at an ``approach`` > 0 [mm]."""
    found: tuple[float, float, float]
    if law.kind == LOGARITHM and law.spring == 0.0:
        # The usual law, inline: a call would cost a tenth of the time.
        found = _of_logarithm(law.factor, constant, approach)
    else:
        found = _on_spring(law, constant, approach) if law.spring > 0.0 else _without_spring(law, constant, approach)
    return found


@inlined
def _of_logarithm(G: float, constant: float, approach: float) -> tuple[float, float, float]:  # pragma: no cover
    """Response under δ = G F v with v = K − ln F."""
    # v is the root above 1 of v − ln v = c; each step of Halley triples the digits.
    c = max(constant - math.log(approach), 1.0 + 1e-9)
    v = c + math.log(c) * c / (c - 1.0)
    for _ in range(HALLEY_STEPS):
        error, slope = v - math.log(v) - c, 1.0 - 1.0 / v
        v -= error / (slope - 0.5 * error / (v * v * slope))
    F = approach / (G * v)
    return F, 1.0 / (G * (v - 1.0)), 0.5 * G * F * F * (v - 0.5)


@inner
def _on_spring(law: CompiledLaw, constant: float, approach: float) -> tuple[float, float, float]:  # pragma: no cover
    """Response of the contact and the spring in series."""
    # The force is convex in the approach of the contact alone: Newton from the whole approach descends.
    spring, own = law.spring, approach
    for _ in range(_SPRING_STEPS):
        F, k, _ = _without_spring(law, constant, own)
        step = (own + spring * F - approach) / (1.0 + spring * k)
        own = max(own - step, 1e-6 * own)
        if not abs(step) > 1e-15 * approach:
            break
    F, k, energy = _without_spring(law, constant, own)
    return F, k / (1.0 + spring * k), energy + 0.5 * spring * F * F


@inlined
def force_step(
    law: CompiledLaw, constant: float, approach: float, force: float, known: float, rate: float
) -> tuple[float, float, float]:  # pragma: no cover
    """One Newton step: a force F near that at ``approach`` [N], its exact approach δ [mm] and dδ/d(ln F) [mm].

    The previous step gave ``force``, its approach ``known`` and its ``rate`` dδ/d(ln F); force 0 starts the search.
    A law in series with a spring, or not of logarithmic form, is solved exactly.
    """
    if law.kind == LOGARITHM and law.spring == 0.0:
        if force == 0.0:
            # v = K − ln F is c + ln v; ln v is 2.75 within a few hundredths of v for any pin.
            F = approach / (law.factor * (constant - math.log(approach) + 2.75))
        else:
            F = force * max(0.1, 1.0 + (approach - known) / rate)
        slack = constant - math.log(law.factor * F)
        return F, law.factor * F * slack, law.factor * F * (slack - 1.0)
    F, k, _ = response(law, constant, approach)
    return F, approach, F / k


@inner
def approach_bound(law: CompiledLaw, constant: float, force: float) -> float:  # pragma: no cover
    """An approach at which the contact carries at least ``force`` > 0 [mm]; exact for a logarithm."""
    if law.kind == LOGARITHM:
        return law.factor * force * (constant - math.log(law.factor * force)) + law.spring * force
    bound = 1e-4
    while bound < 1e3 and response(law, constant, bound)[0] < force:
        bound *= 2.0
    return bound


@inner
def _without_spring(
    law: CompiledLaw, constant: float, approach: float
) -> tuple[float, float, float]:  # pragma: no cover
    """Response of the contact alone, without the spring in series."""
    found: tuple[float, float, float]
    if law.kind == LOGARITHM:
        found = _of_logarithm(law.factor, constant, approach)
        return found
    if law.kind == POWER:
        exponent = law.exponent
        F = (approach / law.factor) ** (1.0 / exponent)
        return F, F / (exponent * approach), exponent / (exponent + 1.0) * F * approach
    found = _from_table(law, constant, approach)
    return found


@inner
def _row(law: CompiledLaw, curvature: float) -> float:  # pragma: no cover
    """Place of a curvature among the rows of a table, ``STENCIL`` times its first row plus the place among them."""
    cap, pin, rows, spacing = law.least_curvature, law.pin_curvature, law.rows, law.row_spacing
    if abs(curvature) <= cap:
        at: float = (curvature / cap + 1.0) * 0.5 * (STENCIL - 1)
        return at
    if curvature < 0.0:
        at, begin = math.log(-curvature / cap) / spacing, STENCIL
    else:
        left = max(pin - curvature, 1e-300)
        at, begin = (math.log(curvature / left) - math.log(cap / (pin - cap))) / spacing, STENCIL + rows
    at = min(at, rows - 1.0)
    first = min(max(int(at) - _INNER, 0), rows - STENCIL)
    place: float = STENCIL * (begin + first) + (at - first)
    return place


@inner
def _from_table(law: CompiledLaw, place: float, approach: float) -> tuple[float, float, float]:  # pragma: no cover
    """From ln E over ln δ by polynomials of degree five: force and stiffness are exact derivatives of the energy."""
    table = law.table
    columns = table.shape[1]
    x = (math.log(approach) - law.first_column) / law.column_spacing
    inside = min(max(x, 0.0), columns - 1.0)
    first_column = min(max(int(inside) - _INNER, 0), columns - STENCIL)
    first_row = int(place / STENCIL)
    value, slope, second = 0.0, 0.0, 0.0
    s, r = inside - first_column, place - STENCIL * first_row
    # Newton's divided differences on evenly spaced nodes, along the row of each curvature and then across.
    across, along = np.empty(STENCIL), np.empty(STENCIL)
    across_slope, across_second = np.empty(STENCIL), np.empty(STENCIL)
    for i in range(STENCIL):
        for j in range(STENCIL):
            along[j] = table[first_row + i, first_column + j]
        across[i], across_slope[i], across_second[i] = _polynomial(along, s)
    value = _polynomial(across, r)[0]
    slope = _polynomial(across_slope, r)[0] / law.column_spacing
    second = _polynomial(across_second, r)[0] / (law.column_spacing * law.column_spacing)
    if x != inside:
        # Beyond the table a power law.
        value, second = value + slope * law.column_spacing * (x - inside), 0.0
    energy = math.exp(value)
    return energy * slope / approach, energy * (slope * slope - slope + second) / (approach * approach), energy


@inner
def _polynomial(values: FloatArray, s: float) -> tuple[float, float, float]:  # pragma: no cover
    """Value and two derivatives at ``s`` of the polynomial through ``values`` at 0, 1, 2 …; overwrites ``values``."""
    for order in range(1, STENCIL):
        for j in range(STENCIL - 1, order - 1, -1):
            values[j] = (values[j] - values[j - 1]) / order
    value, slope, second = values[STENCIL - 1], 0.0, 0.0
    for j in range(STENCIL - 2, -1, -1):
        second = second * (s - j) + 2.0 * slope
        slope = slope * (s - j) + value
        value = value * (s - j) + values[j]
    return value, slope, second


@kernel
def constants(law: CompiledLaw, curvature: FloatArray) -> FloatArray:  # pragma: no cover
    """``contact_constant`` of every contact, in the shape of ``curvature``."""
    found = np.empty(curvature.shape)
    for i in range(curvature.size):
        found.flat[i] = contact_constant(law, curvature.flat[i])
    return found


@kernel
def responses(law: CompiledLaw, curvature: FloatArray, approach: FloatArray) -> FloatArray:  # pragma: no cover
    """Force, stiffness and energy of many contacts, shape (3, contacts); zero where the approach is not positive."""
    found = np.zeros((3, approach.size))
    for i in range(approach.size):
        if approach[i] > 0.0:
            F, k, energy = response(law, contact_constant(law, curvature[i]), approach[i])
            found[0, i], found[1, i], found[2, i] = F, k, energy
    return found
