"""Waves round a scanned disc that come of no lobe: their spectrum and its peaks."""

from __future__ import annotations

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.discrepancy.chance import several
from cycloid_profile.discrepancy.normal import Whitened

LEAST_WAVES = 13
PEAK = 0.01  # chance that noise makes a peak of the spectrum
_APART = 2.0  # waves between two peaks
_TOGETHER = 64  # waves


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
    off = off_lobes(grid, block.laid.built.case.drive.trochoid.lobes)
    found: list[float] = []
    for i in np.argsort(power)[::-1][:200]:
        if several(float(np.exp(-0.5 * power[i])), grid.size) > PEAK:
            break
        if off[i] > 1.0 and all(abs(grid[i] - other) > _APART for other in found):
            found.append(peak_near(block, float(grid[i]), block.projected(block.z) if z is None else z))
        if len(found) == most:
            break
    return found


def peak_near(block: Whitened, waves: float, z: FloatArray) -> float:
    """The strongest number of waves within half a wave of ``waves``, to a fiftieth."""
    near = waves + np.arange(-25, 26) / 50.0
    return float(near[int(np.argmax(wave_power(block, near, z)))])


def wave_power(block: Whitened, grid: FloatArray, z: FloatArray | None = None) -> FloatArray:
    """Fall of chi² by waves of evenly spaced numbers round the disc, shape of ``grid``."""
    z = block.projected(block.z) if z is None else z
    if block.laid.recording.noise.rho == 0.0:
        return power_in_white_noise(block, grid, z)
    return power_one_by_one(block, grid, z)


def power_one_by_one(block: Whitened, grid: FloatArray, z: FloatArray) -> FloatArray:
    """The same in noise of any colour: the readable reference."""
    along, across = np.empty(grid.size, dtype=np.complex128), np.empty(grid.size, dtype=np.complex128)
    length = np.empty(grid.size)
    step = block.laid.waves(float(grid[1] - grid[0]))
    wave = block.laid.waves(float(grid[0]))
    for k in range(grid.size):
        w = block.white(wave)
        along[k], across[k], length[k] = z @ w, np.sum(w * w), np.sum(np.abs(w) ** 2)
        wave = wave * step
    return fall_of_chi2(along, across, length, z.size)


def power_in_white_noise(block: Whitened, grid: FloatArray, z: FloatArray) -> FloatArray:
    """The same where rows share no noise, six times as fast: waves a block apart times waves within one."""
    sigma = block.laid.recording.noise.sigma
    first, step = float(grid[0]), float(grid[1] - grid[0])
    within = np.stack([block.laid.waves(step * k)[block.chosen] for k in range(min(_TOGETHER, grid.size))], axis=1)
    blocks = range(0, grid.size, within.shape[1])
    apart = np.stack([block.laid.waves(first + step * k)[block.chosen] for k in blocks])
    along = ((apart * z) @ within).ravel()[: grid.size] / sigma
    across = ((apart * apart) @ (within * within)).ravel()[: grid.size] / sigma**2
    return fall_of_chi2(along, across, np.full(grid.size, z.size / sigma**2), z.size)


def fall_of_chi2(along: ComplexArray, across: ComplexArray, length: FloatArray, rows: int) -> FloatArray:
    """Fall of chi² by cosine and sine together, from sums of z times a wave, of its square and of its square's size."""
    fall, det = cosine_and_sine(along, across, length)
    power: FloatArray = fall / np.maximum(det, 1e-9 * rows * rows)
    return power


def cosine_and_sine(along: ComplexArray, across: ComplexArray, length: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The same fall times the determinant of the two equations, and that determinant."""
    # Sums of squares of cosine and sine, and of their product, from those of the complex wave.
    cc, ss, cs = 0.5 * (length + across.real), 0.5 * (length - across.real), 0.5 * across.imag
    fall: FloatArray = ss * along.real**2 - 2.0 * cs * along.real * along.imag + cc * along.imag**2
    return fall, cc * ss - cs * cs


def off_lobes(waves: FloatArray, lobes: int) -> FloatArray:
    """How far numbers of waves are from repeating on every lobe, which is the form of the tooth and no vibration."""
    off: FloatArray = np.abs((waves + 0.5 * lobes) % lobes - 0.5 * lobes)
    return off
