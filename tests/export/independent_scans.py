"""Scans of an RV-40E disc by the textbook formula of its tooth, with known errors; no code of the package."""

from __future__ import annotations

import numpy as np

PINS, LOBES, RING, PIN, ECCENTRICITY, EQUIDISTANT = 40, 39, 64.0, 3.0, 1.3, 0.006
LONGEST_LEVER = ECCENTRICITY * LOBES  # of a turn of the disc [mm]
PER_LOBE = 120


def drawn_points(seed: int, noise: float, pitch: float = 0.0, runout: float = 0.0) -> np.ndarray:
    """Points x + iy of the tooth [mm], turned by an unknown angle.

    ``pitch``: lobes turned once per turn of the disc, amplitude along the normal where the lever is longest;
    ``runout``: teeth moved along x; ``noise`` along the normal, all [mm].
    """
    rng = np.random.default_rng(seed)
    psi = np.linspace(0.0, 2.0 * np.pi * LOBES, PER_LOBE * LOBES, endpoint=False)
    t = psi / LOBES
    # The pin centres' path in the frame of the disc, and its offset by the pin.
    path = RING * np.exp(-1j * t) - ECCENTRICITY * np.exp(-1j * PINS * t)
    rate = -1j * RING * np.exp(-1j * t) + 1j * PINS * ECCENTRICITY * np.exp(-1j * PINS * t)
    inward = rate / np.abs(rate) * -1j
    inward *= -np.sign((np.conj(path) * inward).real)
    tooth = path + (PIN + EQUIDISTANT) * inward
    turned = tooth * np.exp(1j * pitch / LONGEST_LEVER * np.cos(t - 0.9))
    return (turned + runout - inward * noise * rng.standard_normal(psi.size)) * np.exp(0.03j)
