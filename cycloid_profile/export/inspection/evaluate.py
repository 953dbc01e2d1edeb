"""Evaluation of a scan: pitch, runout and profile deviation of every flank, against the tolerances of the plan.

In the middle of every flank the deviation along the normal n is fitted by that of a turn β and a radial displacement ρ
of the tooth, β·lever + ρ·n·r̂. Its value at the pitch point, as an arc at the pitch radius, is the flank's position.
Tooth spaces are fitted in the same way about their roots: there ρ is the radial position of a ball seated in the space.
"""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass

import numpy as np

from cycloid_profile._display import Described
from cycloid_profile.arrays import BoolArray, FloatArray
from cycloid_profile.design import DesignRecord
from cycloid_profile.errors import MeasurementError
from cycloid_profile.export.inspection.plan import Check, InspectionPlan, inspection_plan
from cycloid_profile.measurement import Measurement
from cycloid_profile.rig import RegisteredScan, register_scan
from cycloid_profile.units import UM

FLANKS = ("left", "right")  # of the tooth, seen from the upper face with its tip up
_PITCH_ZONE = 0.5  # of the longest lever: the zone about the pitch point in which a flank is placed
_ROOT_ZONE = 0.5 * math.pi  # rad, phase about the root in which a ball would be seated
_FEWEST = 3  # points in a zone
_MAD = 1.4826 / math.sqrt(2.0)  # from the median step between neighbours to the deviation of one point
_DRAWS = 400  # of noise alone; its mean extremes are then known within a hundredth


@dataclass(frozen=True, slots=True)
class CheckResult(Check):
    """A check of the plan with its largest ``value`` and the standard ``uncertainty`` of it [mm].

    ``noise_alone``: the value that this noise would show on an ideal disc, on average [mm]. ``value`` is None where
    the scan cannot show it, such as runout without the datum.
    """

    value: float | None
    uncertainty: float
    noise_alone: float

    @property
    def passed(self) -> bool | None:
        """Whether the value is within its tolerance; None without a value."""
        return None if self.value is None else self.value <= self.tolerance


@dataclass(frozen=True, eq=False, repr=False)
class Inspection(Described):
    """A scan evaluated, arrays of shape (lobes, 2) for the flanks in the order of ``FLANKS``.

    ``position`` of every flank, an arc at the pitch radius, mean zero [mm], positive anticlockwise; ``low`` and
    ``high`` deviation along the normal, positive outwards [mm]; ``radial`` position of the tooth spaces, mean zero,
    shape (lobes,) [mm]; ``noise`` of a point [mm].
    """

    scan: Measurement
    registered: RegisteredScan
    plan: InspectionPlan
    checks: tuple[CheckResult, ...]
    position: FloatArray
    low: FloatArray
    high: FloatArray
    radial: FloatArray
    noise: float

    def _key_figures(self) -> dict[str, str]:
        values = {c.symbol: "not shown" if c.value is None else f"{c.value / UM:.2f} µm" for c in self.checks}
        return values | {"result": "passed" if self.passed else "failed"}

    @property
    def passed(self) -> bool:
        """Whether no check failed."""
        return all(check.passed is not False for check in self.checks)

    @property
    def single_pitch(self) -> FloatArray:
        """Deviation of every flank from the same flank of the lobe before, shape (lobes, 2) [mm]."""
        return self.position - np.roll(self.position, 1, axis=0)


def inspect_scan(record: DesignRecord, scan: Measurement) -> Inspection:
    """Evaluate a profile scan against the final tooth of a design.

    Raises ``MeasurementError`` if the scan is of another disc, or does not cover every flank.
    """
    plan = inspection_plan(record)
    at = register_scan(record.profile, scan)
    noise = _noise(scan, at)
    lobes = record.profile.trochoid.lobes
    position, weight, low, high = (np.zeros((lobes, 2)) for _ in range(4))
    middle = np.abs(at.lever) >= _PITCH_ZONE * float(np.max(np.abs(at.lever)))
    for k, sign in enumerate((1.0, -1.0)):
        on_flank = sign * at.foot > 0.0
        fits = _fitted(scan, at, middle & on_flank, lobes)
        point = record.profile.at(sign * plan.pitch_phase)
        lever = float((np.conj(point.position) * point.normal).imag)
        arc = plan.pitch_radius / lever
        position[:, k], weight[:, k] = fits.value(arc * float(point.normal.real), arc * lever)
        for lobe in range(lobes):
            deviation = -at.removal[on_flank & (at.lobe == lobe)]
            low[lobe, k], high[lobe, k] = float(np.min(deviation)), float(np.max(deviation))
    position -= np.mean(position, axis=0)
    radial, radial_weight = _fitted(scan, at, np.abs(at.foot) <= _ROOT_ZONE, lobes).value(1.0, 0.0)
    radial -= np.mean(radial)
    of_pitch, of_radius = weight * noise, radial_weight * noise
    # A free scan is centred on its teeth: its eccentricity is lost.
    runout = None if scan.datum_free else float(np.ptp(radial))
    values = (float(np.max(np.abs(np.stack([low, high])))), *_pitch(position), runout)
    spread = math.sqrt(2.0) * float(np.max(of_pitch)), math.sqrt(2.0) * float(np.max(of_radius))
    uncertain = (noise, spread[0], spread[0], spread[1])
    alone = _noise_alone(noise, at.removal.size, of_pitch, of_radius)
    checks = tuple(
        CheckResult(*astuple(check), *found)
        for check, *found in zip(plan.checks, values, uncertain, alone, strict=True)
    )
    return Inspection(scan, at, plan, checks, position, low, high, radial, noise)


@dataclass(frozen=True, eq=False, slots=True)
class _Fits:
    """Least squares of radial displacement and turn of every lobe: sums of squares and products, shape (lobes,)."""

    rr: FloatArray
    rt: FloatArray
    tt: FloatArray
    r: FloatArray
    t: FloatArray

    def value(self, radial: float, turn: float) -> tuple[FloatArray, FloatArray]:
        """``radial``·ρ + ``turn``·β of every lobe, and its deviation per deviation of a point, shape (lobes,) both."""
        determinant = self.rr * self.tt - self.rt**2
        rho = (self.tt * self.r - self.rt * self.t) / determinant
        beta = (self.rr * self.t - self.rt * self.r) / determinant
        variance = radial**2 * self.tt - 2.0 * radial * turn * self.rt + turn**2 * self.rr
        return radial * rho + turn * beta, np.sqrt(variance / determinant)


def _fitted(scan: Measurement, at: RegisteredScan, chosen: BoolArray, lobes: int) -> _Fits:
    """Fits of the ``chosen`` points of every lobe. Raises ``MeasurementError`` where they are too few."""
    lobe = at.lobe[chosen].astype(np.intp)
    missing = int(np.count_nonzero(np.bincount(lobe, minlength=lobes) < _FEWEST))
    if missing:
        raise MeasurementError(
            f"{scan.name}: flanks", f"{lobes - missing} of {lobes}", "have points enough",
            f"scan the whole disc with {_FEWEST} points or more in the middle of every flank",
        )  # fmt: skip
    # The direction of the root, which lies at the angle −2π k/z_c.
    radial = (np.exp(2j * math.pi * at.lobe / lobes) * at.normal).real[chosen]
    lever, outward = at.lever[chosen], -at.removal[chosen]
    products = (radial**2, radial * lever, lever**2, radial * outward, lever * outward)
    return _Fits(*(np.asarray(np.bincount(lobe, each, lobes), dtype=np.float64) for each in products))


def _pitch(position: FloatArray) -> tuple[float, float]:
    """Single and cumulative pitch deviation of flanks at ``position``, shape (lobes, 2), the larger of both flanks."""
    single = np.abs(position - np.roll(position, 1, axis=0))
    return float(np.max(single)), float(np.max(np.ptp(position, axis=0)))


def _noise_alone(noise: float, points: int, of_pitch: FloatArray, of_radius: FloatArray) -> tuple[float, ...]:
    """Mean values of the four checks on an ideal disc whose points, positions and radii have these deviations [mm]."""
    rng = np.random.default_rng(0)
    draws = [
        (
            float(np.max(np.abs(noise * rng.standard_normal(points)))),
            *_pitch(of_pitch * rng.standard_normal(of_pitch.shape)),
            float(np.ptp(of_radius * rng.standard_normal(of_radius.shape))),
        )
        for _ in range(_DRAWS)
    ]
    return tuple(np.mean(draws, axis=0).tolist())


def _noise(scan: Measurement, at: RegisteredScan) -> float:
    """Noise of a point: as the file states it, else from the steps between neighbours along the disc [mm]."""
    stated = scan.number("noise_um")
    if stated is not None:
        return stated * UM
    steps = np.diff(at.removal[np.argsort(at.along, kind="stable")])
    return float(_MAD * np.median(np.abs(steps - np.median(steps))))
