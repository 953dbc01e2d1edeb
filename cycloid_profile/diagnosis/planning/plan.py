"""Planning: smallest detectable and smallest identifiable sizes of each measurement, before it is made."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis.data.noise import Noise
from cycloid_profile.diagnosis.data.recording import record, use_all_rows
from cycloid_profile.diagnosis.model.candidate import Candidate, candidates, places
from cycloid_profile.diagnosis.model.evidence import ALIAS
from cycloid_profile.diagnosis.model.residuals import Residuals
from cycloid_profile.diagnosis.model.whitened import NormalEquations, Whitened, coordinates, normal_equations
from cycloid_profile.diagnosis.planning.detectable import detectable, exact_size, noncentrality, noncentrality_of
from cycloid_profile.effects import AsBuiltReducer, EffectLocation
from cycloid_profile.errors import CycloidError
from cycloid_profile.measurement import HYSTERESIS, LOST_MOTION_MAP, PROFILE_SCAN, TRANSMISSION_ERROR, MeasurementKind
from cycloid_profile.rig import LOST_MOTION_SHARE, Settings, simulate

SECOND_TEMPERATURE = "profile_scan at a second temperature"
_FAMILIES = 30  # tests of a typical diagnosis that share the rate of false alarms
_TRIAL = 0.25  # prior widths
_LINEAR_LIMIT = 0.05  # prior widths: linear equations hold below this size
_OUTPUT_ANGLE = 0.1  # output angle of the loops [rad], where no pin is in a root


@dataclass(frozen=True)
class Design:
    """Planned measurement: ``name``, ``kind``, number of ``points`` and expected ``noise`` in the unit of the column.

    ``torque_share``: share of the rated torque, None for the default of the kind.
    """

    name: str
    kind: MeasurementKind
    points: int
    noise: float
    torque_share: float | None = None


DESIGNS = (
    Design("profile_scan", PROFILE_SCAN, 5000, 0.3),
    Design("transmission_error at rated torque", TRANSMISSION_ERROR, 1200, 0.15, 1.0),
    Design("transmission_error at 3 % torque", TRANSMISSION_ERROR, 1200, 0.15, LOST_MOTION_SHARE),
    Design("lost_motion_map", LOST_MOTION_MAP, 600, 0.004, LOST_MOTION_SHARE),
    Design("hysteresis", HYSTERESIS, 250, 0.004, 1.0),
)


@dataclass(frozen=True)
class Detectability:
    """Smallest ``detectable`` and ``identifiable`` size of one effect in one set of measurements.

    ``size``: name of the parameter with its unit. ``most_similar``: name of the effect with the most similar
    pattern; ``sine`` of the angle between the patterns.
    """

    effect: str
    measurements: str
    size: str
    detectable: float
    identifiable: float
    most_similar: str
    sine: float


def detectability(reducer: AsBuiltReducer, progress: Callable[[str], None] = lambda _: None) -> list[Detectability]:
    """Detectable and identifiable sizes of all effects for each measurement of ``DESIGNS``, and for all together."""
    library = candidates(reducer, frozenset({0}), True)
    parts = []
    for design in DESIGNS:
        progress(f"sensitivity of {design.name}")
        parts.append(information(reducer, design, library))
    together = replace(
        parts[0], R=np.sum([part.R for part in parts], axis=0), b=np.sum([part.b for part in parts], axis=0)
    )
    tables = [*((d.name, p) for d, p in zip(DESIGNS, parts, strict=True)), ("all of these", together)]
    linear = [pair for name, equations in tables for pair in _from_linear_equations(name, equations)]
    progress("checking the sizes with the exact model")
    return [_on_the_exact_model(reducer, library, row, candidate) for row, candidate in linear]


def information(reducer: AsBuiltReducer, design: Design, library: Sequence[Candidate]) -> NormalEquations:
    """Normal equations of a measurement of the reducer, without its noise."""
    return normal_equations([Whitened(_simulated(reducer, design))], library)


def separating_measurement(
    reducer: AsBuiltReducer,
    residuals: Sequence[Residuals],
    member: Candidate,
    alternatives: Sequence[Candidate],
    progress: Callable[[str], None] = lambda _: None,
) -> str | None:
    """Further measurement that separates a member from its alternatives best; None without alternatives.

    The one that gives the largest minimum sine between their patterns, together with what was measured: ``residuals``
    on the ``reducer``.
    """
    if not alternatives:
        return None
    if "thermal_growth" in {member.name, *(r.name for r in alternatives)}:
        # Of all effects, only thermal growth follows the temperature.
        return SECOND_TEMPERATURE
    library = [member, *alternatives]
    now = normal_equations([Whitened(one) for one in residuals], library).R
    best = ("a scan of a second specimen", _TOO_CLOSE)
    for design in DESIGNS:
        progress(f"separation by {design.name}")
        try:
            R = now + information(reducer, design, library).R
        except CycloidError:
            continue  # the reducer has no equilibrium on this bench
        sine = min(_sine(R, 0, i) for i in range(1, len(library)))
        if sine > best[1] * 1.05:
            best = (design.name, sine)
    return best[0]


_TOO_CLOSE = math.sqrt(1.0 - ALIAS**2)


@lru_cache(maxsize=16)
def _simulated(reducer: AsBuiltReducer, design: Design) -> Residuals:
    """Residuals of a simulated measurement of the reducer without noise."""
    torque = None if design.torque_share is None else design.torque_share * abs(reducer.case.torque)
    settings = Settings(torque=torque, points=design.points, output_angle=_OUTPUT_ANGLE)
    measured = simulate(reducer, design.kind, settings)
    ready = use_all_rows(record(reducer, replace(measured, name=design.name)))
    return Residuals(replace(ready, noise=Noise(design.noise)), reducer)


def _from_linear_equations(name: str, equations: NormalEquations) -> list[tuple[Detectability, Candidate]]:
    """Row of each effect from linear equations, at its most visible location."""
    found = []
    noncentrality_of = [i for i in range(len(equations.candidates)) if equations.R[2 * i, 2 * i] > 1e-6]
    count = places(equations.candidates)
    chosen: dict[str, tuple[float, int]] = {}
    for i, candidate in enumerate(equations.candidates):
        own = equations.R[2 * i : 2 * i + 2, 2 * i : 2 * i + 2]
        least = detectable(candidate, own, _FAMILIES * count[candidate.name])
        if candidate.name not in chosen or least < chosen[candidate.name][0]:
            chosen[candidate.name] = (least, i)
    for least, i in chosen.values():
        candidate = equations.candidates[i]
        most_similar, sine = "", 1.0
        for j in noncentrality_of if least < math.inf else []:
            if equations.candidates[j].name != candidate.name:
                s = _sine(equations.R, i, j)
                if s < sine:
                    most_similar, sine = equations.candidates[j].name, s
        identifiable = least / sine if sine > _TOO_CLOSE else math.inf
        row = Detectability(candidate.name, name, candidate.size, least, identifiable, most_similar, sine)
        found.append((row, candidate))
    return found


def _on_the_exact_model(
    reducer: AsBuiltReducer, library: Sequence[Candidate], row: Detectability, candidate: Candidate
) -> Detectability:
    """The row with the size of equal detectability on the exact model; infinite beyond the plausible size."""
    if row.detectable == math.inf:
        return _to_second_order(reducer, library, row)
    size = row.detectable
    if size > candidate.implausible:
        size = math.inf
    elif candidate.angle is None and row.measurements != DESIGNS[0].name and size > _LINEAR_LIMIT * candidate.width:
        needed = noncentrality(candidate.coordinates, _FAMILIES * places(library)[candidate.name])
        size = exact_size(_measurements_of(reducer, row), candidate, size, needed)
    identifiable = row.identifiable * (size / row.detectable)
    return replace(
        row, detectable=size, identifiable=identifiable if identifiable < candidate.implausible else math.inf
    )


def _measurements_of(reducer: AsBuiltReducer, row: Detectability) -> list[Residuals]:
    """The measurements of a row."""
    return [_simulated(reducer, d) for d in DESIGNS if row.measurements in (d.name, "all of these")]


def _to_second_order(reducer: AsBuiltReducer, library: Sequence[Candidate], row: Detectability) -> Detectability:
    """The row of an effect that cancels to first order and grows with the square of its size, such as ring runout."""
    candidate = next(c for c in library if c.name == row.effect)
    tried = _TRIAL * candidate.width
    if (
        candidate.angle is None
        or candidate.kind.location is not EffectLocation.RING
        or candidate.effect([tried, 0.0]) is None
    ):
        return row
    curves = [m for m in _measurements_of(reducer, row) if m.recording.kind.is_curve]
    squares = noncentrality_of(curves, candidate, tried)
    if squares < 1.0:
        return row
    size = tried * (noncentrality(candidate.coordinates, _FAMILIES) / squares) ** 0.25
    return replace(row, detectable=size, identifiable=size, most_similar="", sine=1.0)


def _sine(R: FloatArray, i: int, j: int) -> float:
    """Smallest sine between a pattern of one candidate and the span of another."""
    own, other = coordinates([i]), coordinates([j])
    cross = R[np.ix_(own, other)]
    left = R[np.ix_(own, own)] - cross @ np.linalg.pinv(R[np.ix_(other, other)], rcond=1e-9) @ cross.T
    sizes = np.diagonal(R)[own]
    shares = [left[c, c] / sizes[c] for c in range(2) if sizes[c] > 1e-9]
    return math.sqrt(max(min(shares, default=0.0), 0.0))
