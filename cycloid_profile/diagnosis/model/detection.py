"""Detection: one p-value from many tests of the whitened residual, and the places that are significant.

Each family of tests is standard normal or chi-square under the null hypothesis: sums over windows of rows, lobes,
phases of a lobe and orders, chi² of a file, and every effect of the library. The p-value of a family is corrected for
its number of tests (Šidák), the smallest of all families for their number (Bonferroni bound). The rate of false alarms
is at most ``FALSE_ALARM``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.data.noise import SCATTER_OF_ESTIMATE, sidak, upper_tail
from cycloid_profile.diagnosis.data.recording import Recording
from cycloid_profile.diagnosis.model._model_error import orders_of_turn
from cycloid_profile.diagnosis.model.candidate import Candidate, places
from cycloid_profile.diagnosis.model.chatter_spectrum import chatter_spectrum
from cycloid_profile.diagnosis.model.residuals import nuisance_fitted
from cycloid_profile.diagnosis.model.unscanned_waves import UnscannedWaves, unscanned
from cycloid_profile.diagnosis.model.whitened import NormalEquations, Whitened
from cycloid_profile.effects import GrindingChatter
from cycloid_profile.measurement import HYSTERESIS, PROFILE_SCAN
from cycloid_profile.units import DEGREE

FALSE_ALARM = 0.005  # of a whole diagnosis: one in 200 without an effect raises an alarm
_WINDOWS = (4, 12, 40, 120)  # rows, each about three times the one before
_ALONE = 3.0  # standard deviations: a row seldom exceeds them by chance
_TAKEN_OVER = 1e-9  # of the square of a column: the rest is rounding
_PHASE_BINS = 24  # of 15° of ψ
# The simulation error may be larger in the amplitude of a wave, and larger still at one place, than over a file.
_WAVE_LIMIT = math.sqrt(2.0)
_LOCAL_LIMIT = 5.0  # times the accuracy, which is a root mean square over the file


@dataclass(frozen=True)
class Finding:
    """Most significant place of one family in one file.

    ``coordinate`` with its range ``start`` to ``end``. ``amplitude``: mean deviation there in the unit of the file, or
    the coordinate of an effect. ``p_value``: corrected for the tests of its own family. ``over_accuracy``: size
    relative to the accuracy of the simulation; at 1 or less the simulation error may explain it.
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
    """Findings of all families, least probable first; ``p_value`` is corrected for the number of ``families``."""

    p_value: float
    families: int
    findings: tuple[Finding, ...]

    @property
    def significant(self) -> bool:
        """Whether the p-value is below the stated rate of false alarms."""
        return self.p_value < FALSE_ALARM

    @property
    def significant_findings(self) -> tuple[Finding, ...]:
        """Findings that are significant and exceed the accuracy of the simulation."""
        return tuple(
            f for f in self.findings if sidak(f.p_value, self.families) < FALSE_ALARM and f.over_accuracy > 1.0
        )


def detect(
    blocks: Sequence[Whitened],
    equations: NormalEquations | None,
    fitted: Sequence[FloatArray] | None = None,
    within_accuracy: bool = False,
) -> Detection:
    """Test all families. ``fitted``: columns of effects fitted freely before the tests, one array for each block.

    ``within_accuracy``: datum and drift are fitted only within their accuracy. Use it to show places, not for p-values.
    """
    findings: list[Finding] = []
    for i, block in enumerate(blocks):
        z = block.white(nuisance_fitted(block.residuals)) if within_accuracy else block.projected(block.z)
        if fitted is not None and fitted[i].size:
            columns = block.projected(fitted[i])
            z = z - columns @ np.linalg.lstsq(columns, z, rcond=None)[0]
        findings += _block_findings(block, z)
        if block.residuals.recording.kind is PROFILE_SCAN:
            findings += _chatter_findings(block, z)
    if equations is not None:
        findings += [*_library_findings(equations), *_unscanned_wave_findings(blocks)]
    findings.sort(key=lambda f: f.p_value)
    least = findings[0].p_value if findings else 1.0
    return Detection(
        float(-math.expm1(len(findings) * math.log1p(-min(least, 1.0 - 1e-16)))), len(findings), tuple(findings)
    )


def _library_findings(equations: NormalEquations) -> list[Finding]:
    """Best location of every effect."""
    from scipy.special import chdtrc

    count = places(equations.candidates)
    best: dict[str, Finding] = {}
    for i, candidate in enumerate(equations.candidates):
        if candidate.kind is GrindingChatter:
            continue  # the spectrum selects its waves, and is tested separately
        k = candidate.coordinates
        R = equations.R[2 * i : 2 * i + k, 2 * i : 2 * i + k]
        if float(np.trace(R)) < 1e-6:
            continue
        b = equations.b[2 * i : 2 * i + k]
        u = np.linalg.lstsq(R, b, rcond=1e-9)[0]
        p = sidak(float(chdtrc(k, max(float(u @ b), 0.0))), count[candidate.name])
        size = float(np.hypot(*np.append(u, 0.0)[:2])) * candidate.width
        padded = np.append(u, 0.0)[:2]
        over = equations.contribution([i], padded, 0)
        found = Finding("", "", f"shape of {candidate.name}", 0.0, 0.0, size, p, over)
        if candidate.name not in best or p < best[candidate.name].p_value:
            best[candidate.name] = found
    return list(best.values())


def _chatter_findings(block: Whitened, z: FloatArray) -> list[Finding]:
    grid, power = chatter_spectrum(block, z)
    top = int(np.argmax(power))
    p = sidak(float(np.exp(-0.5 * power[top])), grid.size)
    recording = block.residuals.recording
    amplitude = math.sqrt(2.0 * float(power[top]) / block.z.size) * recording.noise.sigma
    over = amplitude / (_WAVE_LIMIT * recording.accuracy)
    return [Finding(recording.name, "um", "waves per turn", float(grid[top]), float(grid[top]), amplitude, p, over)]


def _unscanned_wave_findings(blocks: Sequence[Whitened]) -> list[Finding]:
    """Strongest wave on each disc without a scan, from bench turns."""
    found = []
    for disc in unscanned(blocks):
        for peak in UnscannedWaves(blocks, (), disc).strongest()[:1]:
            base = Finding("", "", f"waves on disc {disc}", peak.waves, peak.waves, 0.0, peak.p_value)
            found.append(replace(base, over_accuracy=peak.over_accuracy))
    return found


def _block_findings(block: Whitened, z: FloatArray) -> list[Finding]:
    recording = block.residuals.recording
    position = block.residuals.position[block.chosen]
    n = z.size
    sigma = recording.noise.sigma
    base = Finding(recording.name, recording.unit, "file", 0.0, 0.0, 0.0, 1.0)
    excess = float(z @ z) / n - 1.0
    rms = sigma * math.sqrt(max(excess, 0.0))
    p = upper_tail(excess / math.sqrt((2.0 + SCATTER_OF_ESTIMATE) / n))
    found = [replace(base, amplitude=rms, p_value=p)]
    for width in _WINDOWS:
        if n >= 4 * width:
            found.append(_windows(replace(base, coordinate=recording.kind.coordinate), z, position, width, sigma))
    if recording.kind is PROFILE_SCAN:
        lobes = block.residuals.reducer.case.drive.trochoid.lobes
        lobe, phase = block.residuals.lobe[block.chosen].astype(int), block.residuals.phase[block.chosen]
        found.append(_bins(replace(base, coordinate="lobe"), z, lobe, np.arange(1.0, lobes + 1.0), 0.0, sigma))
        bins = np.floor((phase / (2.0 * np.pi) % 1.0) * _PHASE_BINS).astype(int) % _PHASE_BINS
        step = 360.0 / _PHASE_BINS
        edges = np.arange(float(_PHASE_BINS)) * step
        edges = np.asarray(np.where(edges >= 180.0, edges - 360.0, edges), dtype=np.float64)
        found.append(_bins(replace(base, coordinate="psi_deg"), z, bins, edges, step, sigma))
        t = (position - np.pi) / lobes
        found.append(
            _orders(replace(base, coordinate="waves per turn"), block, t, np.arange(1.0, tuned.LOW_ORDERS + 1.0))
        )
    elif recording.kind is not HYSTERESIS:
        orders = orders_of_turn(block.residuals.reducer.case.drive.trochoid)
        found.append(_orders(replace(base, coordinate="order"), block, position, orders))
    limits = {"waves per turn": _WAVE_LIMIT, "order": _WAVE_LIMIT, "psi_deg": 2.0, "file": 1.0}
    found = [
        replace(f, over_accuracy=abs(f.amplitude) / (limits.get(f.coordinate, _LOCAL_LIMIT) * recording.accuracy))
        for f in found
    ]
    return [*found, *_drift_findings(base, recording, position)]


def _drift_findings(base: Finding, recording: Recording, position: FloatArray) -> list[Finding]:
    """The drift of a curve, which is found though it is fitted: beyond some noise it is no reading error."""
    drift, sigma = recording.shown_drift, recording.noise.sigma
    if not (recording.kind.is_curve and drift):
        return []
    scale = 1.0 if recording.kind is HYSTERESIS else 1.0 / DEGREE
    start, end = (float(x) * scale for x in position[[0, -1]])
    drifts = replace(base, coordinate=recording.kind.coordinate, start=start, end=end, amplitude=drift)
    # One reading of such an error is less probable than the whole path: an upper bound.
    return [replace(drifts, p_value=2.0 * upper_tail(drift / sigma), over_accuracy=drift / (tuned.DRIFT * sigma))]


def _windows(base: Finding, z: FloatArray, position: FloatArray, width: int, sigma: float) -> Finding:
    start = np.arange(0, z.size - width + 1, max(width // 2, 1))
    rows = np.lib.stride_tricks.sliding_window_view(z, width)[start]
    sums = _bounded_sums(rows) / math.sqrt(width)
    worst = int(np.argmax(np.abs(sums)))
    p = sidak(2.0 * upper_tail(abs(float(sums[worst]))), start.size)
    a, b = position[start[worst]], position[min(start[worst] + width, z.size - 1)]
    scale = {"lobe": 1.0 / (2.0 * np.pi), "row": 1.0}.get(base.coordinate, 1.0 / DEGREE)
    # Lobe 1 extends from half a lobe before its root to half a lobe after it.
    shift = 1.0 if base.coordinate == "lobe" else 0.0
    amplitude = float(np.mean(rows[worst])) * sigma
    return replace(base, start=float(a) * scale + shift, end=float(b) * scale + shift, amplitude=amplitude, p_value=p)


def _bounded_sums(rows: FloatArray) -> FloatArray:
    """Sum over each window of ``rows``, shape (windows, width), in which no row stands out alone.

    The largest counts as much as the second largest, or ``_ALONE``: one row far from the others is a reading error.
    """
    limit = np.maximum(np.partition(np.abs(rows), -2, axis=1)[:, -2:-1], _ALONE)
    found: FloatArray = np.clip(rows, -limit, limit).sum(axis=1)
    return found


def _bins(base: Finding, z: FloatArray, number: np.ndarray, starts: FloatArray, step: float, sigma: float) -> Finding:
    count = np.bincount(number, minlength=starts.size)[: starts.size]
    sums = np.bincount(number, weights=z, minlength=starts.size)[: starts.size]
    score = np.where(count > 0, sums / np.sqrt(np.maximum(count, 1)), 0.0)
    worst = int(np.argmax(np.abs(score)))
    p = sidak(2.0 * upper_tail(abs(float(score[worst]))), int(np.count_nonzero(count)))
    amplitude = float(sums[worst]) / max(int(count[worst]), 1) * sigma
    start = float(starts[worst])
    return replace(base, start=start, end=start + (step or 1.0), amplitude=amplitude, p_value=p)


def _orders(base: Finding, block: Whitened, angle: FloatArray, orders: FloatArray) -> Finding:
    from scipy.linalg import pinvh
    from scipy.special import chdtrc

    cosines = np.zeros((block.residuals.residual.size, orders.size))
    sines = cosines.copy()
    cosines[block.chosen], sines[block.chosen] = np.cos(np.outer(angle, orders)), np.sin(np.outer(angle, orders))
    z = block.z
    c, s = block.white(cosines), block.white(sines)
    best, p_best, amplitude = 0, 1.0, 0.0
    for i in range(orders.size):
        G = np.stack([c[:, i], s[:, i]], axis=1)
        R, b = block.product(G, G), block.product(G, z)
        # An order that the nuisances take over leaves rounding only, however large it looks against itself.
        u = pinvh(R, atol=_TAKEN_OVER * float(np.sum(G * G)), rtol=1e-6) @ b
        p = float(chdtrc(2, max(float(u @ b), 0.0)))
        if p < p_best or i == 0:
            best, p_best, amplitude = i, p, float(np.hypot(*u))
    order = float(orders[best])
    return replace(base, start=order, end=order, amplitude=amplitude, p_value=sidak(p_best, orders.size))


def detect_given(blocks: Sequence[Whitened], members: Sequence[Candidate]) -> Detection:
    """Test all families on a residual, with the columns of ``members`` fitted freely."""
    return detect(blocks, None, [block.columns(members) for block in blocks] if members else None)


def largest_gain(equations: NormalEquations) -> float:
    """Largest reduction of chi² by one effect alone, linear."""
    n = len(equations.candidates)
    own = np.einsum("icid->icd", equations.R.reshape(n, 2, n, 2))
    b = equations.b.reshape(n, 2)
    u = np.einsum("icd,id->ic", np.linalg.pinv(own, rcond=1e-9, hermitian=True), b)
    return float(np.max(np.sum(u * b, axis=1), initial=0.0))


def largest_finding(detection: Detection) -> Finding:
    """Largest significant place; a whole file only if no place is significant."""
    places = [f for f in detection.significant_findings if f.file and f.coordinate != "file"]
    return max(places or detection.significant_findings, key=lambda f: abs(f.amplitude))
