"""Spectrum of waves round a scanned disc, and its peaks, without those of a tooth form."""

from __future__ import annotations

import math

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.diagnosis.data.noise import sidak
from cycloid_profile.diagnosis.model.whitened import Whitened
from cycloid_profile.effects import GrindingChatter

LEAST_WAVES = 13  # one more than the orders of form that ``detection`` tests one by one
SHORTEST_WAVE = 0.25  # mm along the flank: the contact width bridges shorter waves
SPEEDS = tuple(str(one) for one in GrindingChatter.shapes["constant_speed"])
GENERATING = SPEEDS[0]
FORM_WAVES = 20  # from root to root: the most of ``ToothFormError``; what repeats on every lobe above is chatter
AS_GOOD = 9.0  # of chi²: three standard deviations between two waves
PEAK = 0.01  # probability that noise alone produces a peak
_APART = 2.0  # least distance of two peaks, in waves
_TOGETHER = 64  # waves evaluated in one block


def chatter_spectrum(
    block: Whitened, z: FloatArray | None = None, speed: str = GENERATING
) -> tuple[FloatArray, FloatArray]:
    """Numbers of waves round the disc in steps of one half, and the reduction of chi² by each wave.

    ``speed``: motion of constant speed, in which the waves are even. Fewer than ``LEAST_WAVES`` waves are form errors.
    The contact bridges waves shorter than ``SHORTEST_WAVE``.
    """
    radius = block.residuals.reducer.case.drive.trochoid.pin_circle_radius
    highest = min(0.45 * block.residuals.recording.rows.size, 2.0 * math.pi * radius / SHORTEST_WAVE)
    grid = np.arange(2.0 * LEAST_WAVES, 2.0 * highest) / 2.0
    return grid, wave_power(block, grid, z, speed)


def chatter_peaks(block: Whitened, z: FloatArray | None = None, most: int = 3) -> tuple[str, list[float]]:
    """Motion of constant speed in which the waves are even, and their numbers, to a fiftieth of a wave.

    The waves are the strongest significant peaks. The motion is that of the strongest wave; the generating one unless
    another is clearly better.
    """
    lobes = block.residuals.reducer.case.drive.trochoid.lobes
    spectra = {speed: chatter_spectrum(block, z, speed) for speed in SPEEDS}
    # Multiples of the lobes that a tooth form has, and in other motions all, are left out.
    strongest = {
        speed: float(np.max(power[off_lobes(grid, lobes, speed) > 1.0], initial=0.0))
        for speed, (grid, power) in spectra.items()
    }
    speed = max(SPEEDS, key=lambda one: strongest[one])
    speed = speed if strongest[speed] > strongest[GENERATING] + AS_GOOD else GENERATING
    grid, power = spectra[speed]
    off = off_lobes(grid, lobes, speed)
    found: list[float] = []
    for i in np.argsort(power)[::-1][:200]:
        if sidak(float(np.exp(-0.5 * power[i])), grid.size) > PEAK:
            break
        if off[i] > 1.0 and all(abs(grid[i] - other) > _APART for other in found):
            found.append(peak_near(block, float(grid[i]), block.projected(block.z) if z is None else z, speed))
        if len(found) == most:
            break
    return speed, found


def peak_near(block: Whitened, waves: float, z: FloatArray, speed: str = GENERATING, reach: float = 0.5) -> float:
    """Strongest number of waves within ``reach`` of ``waves``, to a fiftieth."""
    near = waves + np.arange(-round(50.0 * reach), round(50.0 * reach) + 1) / 50.0
    return float(near[int(np.argmax(wave_power(block, near, z, speed)))])


def wave_power(block: Whitened, grid: FloatArray, z: FloatArray | None = None, speed: str = GENERATING) -> FloatArray:
    """Reduction of chi² by evenly spaced numbers of waves, shape of ``grid``."""
    z = block.projected(block.z) if z is None else z
    if block.residuals.recording.noise.is_white:
        return power_in_white_noise(block, grid, z, speed)
    return power_one_by_one(block, grid, z, speed)


def power_one_by_one(block: Whitened, grid: FloatArray, z: FloatArray, speed: str = GENERATING) -> FloatArray:
    """The same for correlated noise; a simple reference implementation."""
    along, across = np.empty(grid.size, dtype=np.complex128), np.empty(grid.size, dtype=np.complex128)
    length = np.empty(grid.size)
    step = block.residuals.waves(float(grid[1] - grid[0]), speed)[block.chosen]
    wave = block.residuals.waves(float(grid[0]), speed)[block.chosen]
    whitening = block.whitening
    for k in range(grid.size):
        w = whitening @ wave
        along[k], across[k], length[k] = z @ w, np.sum(w * w), np.sum(np.abs(w) ** 2)
        wave = wave * step
    return chi2_reduction(along, across, length, z.size)


def power_in_white_noise(block: Whitened, grid: FloatArray, z: FloatArray, speed: str = GENERATING) -> FloatArray:
    """The same for white noise, five times as fast: products of block waves and waves within a block."""
    sigma = block.residuals.recording.noise.sigma
    first, step = float(grid[0]), float(grid[1] - grid[0])
    within = np.stack(
        [block.residuals.waves(step * k, speed)[block.chosen] for k in range(min(_TOGETHER, grid.size))], axis=1
    )
    blocks = range(0, grid.size, within.shape[1])
    apart = np.stack([block.residuals.waves(first + step * k, speed)[block.chosen] for k in blocks])
    along = ((apart * z) @ within).ravel()[: grid.size] / sigma
    across = ((apart * apart) @ (within * within)).ravel()[: grid.size] / sigma**2
    return chi2_reduction(along, across, np.full(grid.size, z.size / sigma**2), z.size)


def chi2_reduction(along: ComplexArray, across: ComplexArray, length: FloatArray, rows: int) -> FloatArray:
    """Reduction of chi² by cosine and sine together, from sums of z·wave, of wave² and of |wave|²."""
    fall, det = cosine_and_sine(along, across, length)
    power: FloatArray = fall / np.maximum(det, 1e-9 * rows * rows)
    return power


def cosine_and_sine(along: ComplexArray, across: ComplexArray, length: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Numerator and determinant of the same fall."""
    # Sums of cosine², sine² and cosine·sine from those of the complex wave.
    cc, ss, cs = 0.5 * (length + across.real), 0.5 * (length - across.real), 0.5 * across.imag
    fall: FloatArray = ss * along.real**2 - 2.0 * cs * along.real * along.imag + cc * along.imag**2
    return fall, cc * ss - cs * cs


def off_lobes(waves: FloatArray, lobes: int, speed: str) -> FloatArray:
    """Distance of numbers of waves, even in the motion of constant ``speed``, from the nearest multiple of ``lobes``
    that a tooth form has.

    In another than the generating motion each wave is modulated from lobe to lobe: next to any multiple it has a part
    of one wave a turn, as a runout.
    """
    nearest = np.minimum(np.round(waves / lobes), FORM_WAVES if speed == GENERATING else np.inf)
    off: FloatArray = np.abs(waves - nearest * lobes)
    return off
