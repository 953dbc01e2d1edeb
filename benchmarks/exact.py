"""The RV-40E to 30 digits, sharing no code with the package: formulas of the tooth, feet by root finding.

One disc on a held crank. Pins are fixed at 2πk/z_p, the disc's centre at a·e^{iφ}, turned by −φ/z_c.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import mpmath as mp

mp.mp.dps = 30

Real, Complex = Any, Any  # mpmath has no types
Z_P, Z_C = 40, 39
R_P, R_RP, A, WIDTH = mp.mpf(64), mp.mpf(3), mp.mpf("1.3"), mp.mpf("11.5")
GROUND = mp.mpf("3.006")  # radius of the generating pin
K1 = A * Z_P / R_P
YOUNG, POISSON = mp.mpf(210_000), mp.mpf("0.3")
COMPLIANCE = 2 * (1 - POISSON**2) / YOUNG
TORQUE = mp.mpf(206_000)  # of one disc


class Contact(NamedTuple):
    """One pin at one place of the disc: gap, lever arm, curvature of the tooth."""

    gap: Real
    lever: Real
    curvature: Real


class Sharing(NamedTuple):
    """Equilibrium at one pose: turn of the disc, pin forces, dT/dβ."""

    rotation: Real
    force: list[Real]
    stiffness: Real


def trochoid(psi: Real) -> Complex:
    """Path of the pin centre seen from the disc."""
    return R_P * mp.expj(-psi / Z_C) - A * mp.expj(-psi * Z_P / Z_C)


def normal(psi: Real) -> Complex:
    """Outward unit normal of tooth and path."""
    n = mp.expj(-psi / Z_C) - K1 * mp.expj(-psi * Z_P / Z_C)
    return n / abs(n)


def tooth(psi: Real) -> Complex:
    """Point of the ground tooth: the exact parallel curve."""
    return trochoid(psi) - GROUND * normal(psi)


def curvature(psi: Real) -> Real:
    """Signed curvature of the tooth, convex negative."""
    w2 = 1 + K1**2 - 2 * K1 * mp.cos(psi)
    return 1 / (R_P * mp.power(w2, mp.mpf(3) / 2) / (K1 * (Z_P + 1) * mp.cos(psi) - (1 + Z_P * K1**2)) + GROUND)


def contact(pin: int, crank: Real, shift: Complex = 0, turn: Real = 0) -> Contact:
    """Pin against a disc moved by ``shift`` and turned by ``turn`` from its nominal place."""
    alpha = 2 * mp.pi * pin / Z_P
    p = (R_P * mp.expj(alpha) - A * mp.expj(crank) - shift) * mp.expj(crank / Z_C - turn)
    # The foot, where the way to the pin has no part across the normal.
    psi = mp.findroot(lambda s: mp.im(mp.conj(normal(s)) * (p - tooth(s))), -(Z_C * alpha + crank))
    foot, n = tooth(psi), normal(psi)
    return Contact(mp.re(mp.conj(n) * (p - foot)) - R_RP, mp.im(mp.conj(foot) * n), curvature(psi))


def pin_force(approach: Real, bend: Real) -> Real:
    """Inverse of Johnson's δ = F C_E/(2π b)·Σ[2 ln(4 R_i/h) − 1] = G F (K − ln F), by Lambert's function."""
    if approach <= 0:
        return mp.mpf(0)
    relative = 1 / abs(1 / R_RP - bend)
    body = 1 / max(abs(bend), 1 / R_P)  # a body no larger than the pin circle, as both packages take it
    h2_per_force = 4 * relative * COMPLIANCE / (mp.pi * WIDTH)
    G, K = COMPLIANCE / (mp.pi * WIDTH), mp.log(16 * R_RP * body / h2_per_force) - 1
    return mp.exp(K + mp.re(mp.lambertw(-approach / G * mp.exp(-K), -1)))


def load_sharing(crank: Real, sense: int = -1) -> Sharing:
    """Turn of the disc at which its pins carry the torque, everything taken where the disc then stands."""
    pins = [k for k in range(Z_P) if sense * contact(k, crank).lever > 0]

    def forces(turn: Real) -> list[tuple[Real, Real]]:
        found = (contact(k, crank, turn=turn) for k in pins)
        return [(pin_force(-c.gap, c.curvature), sense * c.lever) for c in found]

    def excess(turn: Real) -> Real:
        return mp.fsum(force * lever for force, lever in forces(turn)) - TORQUE

    turn = mp.findroot(excess, (sense * mp.mpf("1.5e-4"), sense * mp.mpf("1.6e-4")), tol=mp.mpf("1e-30"))
    force = [mp.mpf(0)] * Z_P
    for k, (value, _) in zip(pins, forces(turn), strict=True):
        force[k] = value
    step = mp.mpf("1e-12")
    stiffness = abs(excess(turn + step) - excess(turn - step)) / (2 * step)
    return Sharing(turn, force, stiffness)
