"""Waves round a scanned disc that come of no lobe: their spectrum and its peaks."""

from __future__ import annotations

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.chance import several
from cycloid_profile.discrepancy.normal import Whitened

LEAST_WAVES = 13
_PEAK = 0.01  # chance that noise makes a peak of the spectrum
_APART = 2.0  # waves between two peaks


def chatter_spectrum(block: Whitened, z: FloatArray | None = None) -> tuple[FloatArray, FloatArray]:
    """Numbers of waves round the disc, every half, and the fall of chi² by a wave of each.

    Fewer waves than ``LEAST_WAVES`` are form, which lobing of the clamp makes, and no chatter.
    """
    highest = 0.45 * block.laid.recording.rows.size
    grid = np.arange(2.0 * LEAST_WAVES, 2.0 * highest) / 2.0
    return grid, wave_power(block, grid, z)


def chatter_peaks(block: Whitened, z: FloatArray | None = None, most: int = 3) -> list[float]:
    """Numbers of waves of the strongest chatter that chance does not make, to a fiftieth of a wave."""
    grid, power = chatter_spectrum(block, z)
    lobes = block.laid.built.case.drive.trochoid.lobes
    found: list[float] = []
    for i in np.argsort(power)[::-1][:200]:
        if several(float(np.exp(-0.5 * power[i])), grid.size) > _PEAK:
            break
        # What repeats on every lobe is the form of the tooth, not a vibration.
        off_lobes = abs((grid[i] + 0.5 * lobes) % lobes - 0.5 * lobes)
        if off_lobes > 1.0 and all(abs(grid[i] - other) > _APART for other in found):
            fine = grid[i] + np.arange(-25, 26) / 50.0
            found.append(float(fine[int(np.argmax(wave_power(block, fine, z)))]))
        if len(found) == most:
            break
    return found


def wave_power(block: Whitened, grid: FloatArray, z: FloatArray | None = None) -> FloatArray:
    """Fall of chi² by waves of evenly spaced numbers round the disc, shape of ``grid``."""
    n = block.z.size
    z = block.projected(block.z) if z is None else z
    power = np.empty(grid.size)
    step = block.laid.waves(float(grid[1] - grid[0]))
    wave = block.laid.waves(float(grid[0]))
    for k in range(grid.size):
        w = block.white(wave)
        across = complex(np.sum(w * w))
        length = float(np.sum(np.abs(w) ** 2))
        # Sums of squares of cosine and sine, and of their product, from those of the complex wave.
        cc, ss, cs = 0.5 * (length + across.real), 0.5 * (length - across.real), 0.5 * across.imag
        along = complex(z @ w)
        det = max(cc * ss - cs * cs, 1e-9 * n * n)
        power[k] = (ss * along.real**2 - 2.0 * cs * along.real * along.imag + cc * along.imag**2) / det
        wave = wave * step
    return power
