"""Is there anything beyond the noise, and where: one p-value from many looks at the whitened residual.

Each look is a family of statistics that are standard normal or chi-square where nothing is hidden: sums over windows
of rows, lobes, phases of a lobe and orders, the whole of a file, and every effect of the library. A family pays for
its number, and the least p-value pays for the number of families (Bonferroni), so that the chance of a false alarm is
at most as stated.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtrc

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.candidates import places
from cycloid_profile.discrepancy.chance import several, tail
from cycloid_profile.discrepancy.chatter_waves import chatter_spectrum
from cycloid_profile.discrepancy.laid import settled
from cycloid_profile.discrepancy.noise import SCATTER_OF_ESTIMATE
from cycloid_profile.discrepancy.normal import Normal, Whitened
from cycloid_profile.discrepancy.waves_under_pins import WavesUnderPins, unscanned
from cycloid_profile.units import DEGREE

FALSE_ALARM = 0.005
_WINDOWS = (4, 12, 40, 120)
_PHASE_BINS = 24
_LOW_ORDERS = 12
_MULTIPLES = 6
# The simulation errs by its accuracy all over; by more in a wave's amplitude, by still more in a narrow place.
_WAVE_LIMIT = math.sqrt(2.0)
_LOCAL_LIMIT = 5.0


@dataclass(frozen=True)
class Finding:
    """The most striking place of one family in one file.

    ``coordinate`` with its range ``start`` to ``end``; ``amplitude``, mean deviation there in the unit of the file
    (of an effect its coordinate); ``p_value`` after paying for the number of looks of its own family;
    ``over_accuracy``, how it compares with what the simulation can be trusted for: below 1 it may be the simulation's
    own error.
    """

    file: str
    unit: str
    coordinate: str
    start: float
    end: float
    amplitude: float
    p_value: float
    over_accuracy: float = math.inf


@dataclass(frozen=True)
class Detection:
    """All families, the least likely first; ``p_value`` pays for all of them. ``families``, their number."""

    p_value: float
    families: int
    findings: tuple[Finding, ...]

    @property
    def significant(self) -> bool:
        """Whether chance alone makes this less often than the stated rate of false alarms."""
        return self.p_value < FALSE_ALARM

    @property
    def striking(self) -> tuple[Finding, ...]:
        """Findings that chance does not make and the error of the simulation does not either."""
        return tuple(
            f for f in self.findings if several(f.p_value, self.families) < FALSE_ALARM and f.over_accuracy > 1.0
        )


def detect(
    blocks: Sequence[Whitened],
    equations: Normal | None,
    fitted: Sequence[FloatArray] | None = None,
    settle: bool = False,
) -> Detection:
    """Look everywhere. ``fitted`` columns of effects already named, one array a block, count as fitted freely.

    With ``settle`` datum and drift only take what their accuracy allows: for places to show, not for p-values.
    """
    findings: list[Finding] = []
    for i, block in enumerate(blocks):
        z = block.white(settled(block.laid)) if settle else block.projected(block.z)
        if fitted is not None and fitted[i].size:
            columns = block.projected(fitted[i])
            z = z - columns @ np.linalg.lstsq(columns, z, rcond=None)[0]
        findings += _of_block(block, z)
        if block.laid.recording.kind == "profile_scan":
            findings += _of_chatter(block, z)
    if equations is not None:
        findings += [*_of_library(equations), *_of_waves_under_pins(blocks)]
    findings.sort(key=lambda f: f.p_value)
    least = findings[0].p_value if findings else 1.0
    return Detection(
        float(-math.expm1(len(findings) * math.log1p(-min(least, 1.0 - 1e-16)))), len(findings), tuple(findings)
    )


def _of_library(equations: Normal) -> list[Finding]:
    """The best place of every effect."""
    count = places(equations.candidates)
    best: dict[str, Finding] = {}
    for i, candidate in enumerate(equations.candidates):
        if candidate.name == "grinding_chatter":
            continue  # chosen by its spectrum, which is looked at by itself
        k = candidate.coordinates
        R = equations.R[2 * i : 2 * i + k, 2 * i : 2 * i + k]
        if float(np.trace(R)) < 1e-6:
            continue
        b = equations.b[2 * i : 2 * i + k]
        u = np.linalg.lstsq(R, b, rcond=1e-9)[0]
        p = several(float(chdtrc(k, max(float(u @ b), 0.0))), count[candidate.name])
        size = float(np.hypot(*np.append(u, 0.0)[:2])) * candidate.width
        padded = np.append(u, 0.0)[:2]
        over = equations.contribution([i], padded, 0)
        found = Finding("", "", f"shape of {candidate.name}", 0.0, 0.0, size, p, over)
        if candidate.name not in best or p < best[candidate.name].p_value:
            best[candidate.name] = found
    return list(best.values())


def _of_chatter(block: Whitened, z: FloatArray) -> list[Finding]:
    grid, power = chatter_spectrum(block, z)
    top = int(np.argmax(power))
    p = several(float(np.exp(-0.5 * power[top])), grid.size)
    recording = block.laid.recording
    amplitude = math.sqrt(2.0 * float(power[top]) / block.z.size) * recording.noise.sigma
    over = amplitude / (_WAVE_LIMIT * recording.accuracy)
    return [Finding(recording.name, "um", "waves per turn", float(grid[top]), float(grid[top]), amplitude, p, over)]


def _of_waves_under_pins(blocks: Sequence[Whitened]) -> list[Finding]:
    """The strongest wave on each disc that was not scanned, by the turns of a bench."""
    found = []
    for disc in unscanned(blocks):
        for peak in WavesUnderPins(blocks, (), disc).strongest()[:1]:
            base = Finding("", "", f"waves on disc {disc}", peak.waves, peak.waves, 0.0, peak.p_value)
            found.append(replace(base, over_accuracy=peak.over_accuracy))
    return found


def _of_block(block: Whitened, z: FloatArray) -> list[Finding]:
    recording = block.laid.recording
    position = block.laid.position[block.chosen]
    n = z.size
    sigma = recording.noise.sigma
    base = Finding(recording.name, recording.unit, "file", 0.0, 0.0, 0.0, 1.0)
    excess = float(z @ z) / n - 1.0
    rms = sigma * math.sqrt(max(excess, 0.0))
    p = tail(excess / math.sqrt((2.0 + SCATTER_OF_ESTIMATE) / n))
    found = [replace(base, amplitude=rms, p_value=p)]
    for width in _WINDOWS:
        if n >= 4 * width:
            found.append(_windows(replace(base, coordinate=_coordinate(recording.kind)), z, position, width, sigma))
    if recording.kind == "profile_scan":
        lobes = block.laid.built.case.drive.trochoid.lobes
        lobe, phase = block.laid.lobe[block.chosen].astype(int), block.laid.phase[block.chosen]
        found.append(_bins(replace(base, coordinate="lobe"), z, lobe, np.arange(1.0, lobes + 1.0), 0.0, sigma))
        bins = np.floor((phase / (2.0 * np.pi) % 1.0) * _PHASE_BINS).astype(int) % _PHASE_BINS
        step = 360.0 / _PHASE_BINS
        edges = np.arange(float(_PHASE_BINS)) * step
        edges = np.asarray(np.where(edges >= 180.0, edges - 360.0, edges), dtype=np.float64)
        found.append(_bins(replace(base, coordinate="psi_deg"), z, bins, edges, step, sigma))
        t = (position - np.pi) / lobes
        found.append(_orders(replace(base, coordinate="waves per turn"), block, t, np.arange(1.0, _LOW_ORDERS + 1.0)))
    elif recording.kind != "hysteresis":
        trochoid = block.laid.built.case.drive.trochoid
        multiples = np.arange(1.0, _MULTIPLES + 1.0)
        orders = np.unique(
            np.concatenate(
                [
                    np.arange(1.0, _LOW_ORDERS + 1.0),
                    trochoid.lobes * multiples,
                    trochoid.pins * multiples,
                    [float(trochoid.lobes * trochoid.pins)],
                ]
            )
        )
        found.append(_orders(replace(base, coordinate="order"), block, position, orders))
    limits = {"waves per turn": _WAVE_LIMIT, "order": _WAVE_LIMIT, "psi_deg": 2.0, "file": 1.0}
    return [
        replace(f, over_accuracy=abs(f.amplitude) / (limits.get(f.coordinate, _LOCAL_LIMIT) * recording.accuracy))
        for f in found
    ]


def _coordinate(kind: str) -> str:
    return {"profile_scan": "lobe", "hysteresis": "row"}.get(kind, "output_angle_deg")


def _windows(base: Finding, z: FloatArray, position: FloatArray, width: int, sigma: float) -> Finding:
    total = np.concatenate([[0.0], np.cumsum(z)])
    start = np.arange(0, z.size - width + 1, max(width // 2, 1))
    sums = (total[start + width] - total[start]) / math.sqrt(width)
    worst = int(np.argmax(np.abs(sums)))
    p = several(2.0 * tail(abs(float(sums[worst]))), start.size)
    a, b = position[start[worst]], position[min(start[worst] + width, z.size - 1)]
    scale = {"lobe": 1.0 / (2.0 * np.pi), "row": 1.0}.get(base.coordinate, 1.0 / DEGREE)
    # Lobe 1 reaches from half a lobe before its root to half a lobe behind it.
    shift = 1.0 if base.coordinate == "lobe" else 0.0
    amplitude = float(sums[worst]) / math.sqrt(width) * sigma
    return replace(base, start=float(a) * scale + shift, end=float(b) * scale + shift, amplitude=amplitude, p_value=p)


def _bins(base: Finding, z: FloatArray, number: np.ndarray, starts: FloatArray, step: float, sigma: float) -> Finding:
    count = np.bincount(number, minlength=starts.size)[: starts.size]
    sums = np.bincount(number, weights=z, minlength=starts.size)[: starts.size]
    score = np.where(count > 0, sums / np.sqrt(np.maximum(count, 1)), 0.0)
    worst = int(np.argmax(np.abs(score)))
    p = several(2.0 * tail(abs(float(score[worst]))), int(np.count_nonzero(count)))
    amplitude = float(sums[worst]) / max(int(count[worst]), 1) * sigma
    start = float(starts[worst])
    return replace(base, start=start, end=start + (step or 1.0), amplitude=amplitude, p_value=p)


def _orders(base: Finding, block: Whitened, angle: FloatArray, orders: FloatArray) -> Finding:
    full = np.zeros((block.laid.residual.size, orders.size))
    turned = full.copy()
    full[block.chosen], turned[block.chosen] = np.cos(np.outer(angle, orders)), np.sin(np.outer(angle, orders))
    z = block.z
    c, s = block.white(full), block.white(turned)
    best, p_best, amplitude = 0, 1.0, 0.0
    for i in range(orders.size):
        G = np.stack([c[:, i], s[:, i]], axis=1)
        R, b = block.product(G, G), block.product(G, z)
        u = np.linalg.lstsq(R, b, rcond=1e-6)[0]
        p = float(chdtrc(2, max(float(u @ b), 0.0)))
        if p < p_best or i == 0:
            best, p_best, amplitude = i, p, float(np.hypot(*u))
    order = float(orders[best])
    return replace(base, start=order, end=order, amplitude=amplitude, p_value=several(p_best, orders.size))
