"""What each measurement could tell before it is made: smallest detectable and smallest identifiable sizes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.candidates import Candidate, candidates, places
from cycloid_profile.discrepancy.detectable import detectable, noncentrality
from cycloid_profile.discrepancy.evidence import ALIAS
from cycloid_profile.discrepancy.laid import Laid
from cycloid_profile.discrepancy.noise import Noise
from cycloid_profile.discrepancy.normal import Normal, Whitened, coordinates, normal
from cycloid_profile.discrepancy.recording import Recording, hold_nothing_out, record
from cycloid_profile.discrepancy.seen_on_exact import exact_size, shown
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.effect import Place
from cycloid_profile.errors import CycloidError
from cycloid_profile.rig.simulate import Settings, simulate

SECOND_TEMPERATURE = "profile_scan at a second temperature"
_FAMILIES = 30
_TRIED = 0.25  # of the width of a coordinate
_LITTLE = 0.05  # of it: below, linear equations do not err
_TURNED = 0.1  # output angle of the loops [rad], where no pin stands in a root


@dataclass(frozen=True)
class Design:
    """A measurement that could be made: its ``name``, ``kind``, ``settings`` and the noise it is likely to have.

    ``torque_share`` of the rated torque, None for what is usual for the kind.
    """

    name: str
    kind: str
    points: int
    noise: float
    torque_share: float | None = None


DESIGNS = (
    Design("profile_scan", "profile_scan", 5000, 0.3),
    Design("transmission_error at rated torque", "transmission_error", 1200, 0.15, 1.0),
    Design("transmission_error at 3 % torque", "transmission_error", 1200, 0.15, 0.03),
    Design("lost_motion_map", "lost_motion_map", 600, 0.004, 0.03),
    Design("hysteresis", "hysteresis", 250, 0.004, 1.0),
)


@dataclass(frozen=True)
class Visibility:
    """Of one effect and one set of measurements: smallest ``detectable`` and ``identifiable`` size, with its unit in
    ``size``; ``rival``, the effect it is hardest to tell from, and the sine of the angle between them.
    """

    effect: str
    measurements: str
    size: str
    detectable: float
    identifiable: float
    rival: str
    sine: float


def visibility(built: Built, tell: Callable[[str], None] = lambda _: None) -> list[Visibility]:
    """The table of all effects against every single measurement, and against all of them together."""
    library = candidates(built, frozenset({0}), True)
    parts = []
    for design in DESIGNS:
        tell(f"what a {design.name} shows")
        parts.append(information(built, design, library))
    together = replace(
        parts[0], R=np.sum([part.R for part in parts], axis=0), b=np.sum([part.b for part in parts], axis=0)
    )
    tables = [*((d.name, p) for d, p in zip(DESIGNS, parts, strict=True)), ("all of these", together)]
    linear = [pair for name, equations in tables for pair in _visible(name, equations)]
    tell("what shows at that size, and what only to second order")
    return [_on_the_exact_model(built, library, row, candidate) for row, candidate in linear]


def information(built: Built, design: Design, library: Sequence[Candidate]) -> Normal:
    """Normal equations of a measurement of the reducer as it is, without its noise."""
    return normal([Whitened(_laid(built, design))], library)


def separating_measurement(
    built: Built,
    recordings: Sequence[Recording],
    member: Candidate,
    rivals: Sequence[Candidate],
    tell: Callable[[str], None] = lambda _: None,
) -> str | None:
    """The further measurement that tells a member from its rivals best; None where there are none.

    The one that raises the least sine between their patterns most, of what is known now and the new file together.
    """
    if not rivals:
        return None
    if "thermal_growth" in {member.name, *(r.name for r in rivals)}:
        # A change of temperature is the one thing that only thermal growth follows.
        return SECOND_TEMPERATURE
    library = [member, *rivals]
    now = normal([Whitened(Laid(hold_nothing_out(r), built)) for r in recordings], library).R
    best = ("a scan of a second specimen", _TOO_CLOSE)
    for design in DESIGNS:
        tell(f"would a {design.name} tell them apart?")
        try:
            R = now + information(built, design, library).R
        except CycloidError:
            continue  # this reducer would bind on that bench
        sine = min(_sine(R, 0, i) for i in range(1, len(library)))
        if sine > best[1] * 1.05:
            best = (design.name, sine)
    return best[0]


_TOO_CLOSE = math.sqrt(1.0 - ALIAS**2)


@lru_cache(maxsize=16)
def _laid(built: Built, design: Design) -> Laid:
    """A measurement of the reducer as it is, without its noise."""
    torque = None if design.torque_share is None else design.torque_share * abs(built.case.torque)
    settings = Settings(torque=torque, points=design.points, output_angle=_TURNED)
    measured = simulate(built, design.kind, settings)
    ready = hold_nothing_out(record(built, replace(measured, name=design.name)))
    return Laid(replace(ready, noise=Noise(design.noise)), built)


def _visible(name: str, equations: Normal) -> list[tuple[Visibility, Candidate]]:
    """What linear equations say of each effect, at the place where it shows best."""
    found = []
    shown = [i for i in range(len(equations.candidates)) if equations.R[2 * i, 2 * i] > 1e-6]
    count = places(equations.candidates)
    chosen: dict[str, tuple[float, int]] = {}
    for i, candidate in enumerate(equations.candidates):
        own = equations.R[2 * i : 2 * i + 2, 2 * i : 2 * i + 2]
        least = detectable(candidate, own, _FAMILIES * count[candidate.name])
        if candidate.name not in chosen or least < chosen[candidate.name][0]:
            chosen[candidate.name] = (least, i)
    for least, i in chosen.values():
        candidate = equations.candidates[i]
        rival, sine = "", 1.0
        for j in shown if least < math.inf else []:
            if equations.candidates[j].name != candidate.name:
                s = _sine(equations.R, i, j)
                if s < sine:
                    rival, sine = equations.candidates[j].name, s
        identifiable = least / sine if sine > _TOO_CLOSE else math.inf
        row = Visibility(candidate.name, name, candidate.size, least, identifiable, rival, sine)
        found.append((row, candidate))
    return found


def _on_the_exact_model(
    built: Built, library: Sequence[Candidate], row: Visibility, candidate: Candidate
) -> Visibility:
    """The row with the size that shows as much on the exact model; none where no workshop makes as much."""
    if row.detectable == math.inf:
        return _to_second_order(built, library, row)
    size = row.detectable
    if size > candidate.implausible:
        size = math.inf
    elif candidate.angle is None and row.measurements != DESIGNS[0].name and size > _LITTLE * candidate.width:
        needed = noncentrality(candidate.coordinates, _FAMILIES * places(library)[candidate.name])
        size = exact_size(_measured(built, row), candidate, size, needed)
    identifiable = row.identifiable * (size / row.detectable)
    return replace(
        row, detectable=size, identifiable=identifiable if identifiable < candidate.implausible else math.inf
    )


def _measured(built: Built, row: Visibility) -> list[Laid]:
    """The measurements of a row."""
    return [_laid(built, d) for d in DESIGNS if row.measurements in (d.name, "all of these")]


def _to_second_order(built: Built, library: Sequence[Candidate], row: Visibility) -> Visibility:
    """The row of an effect that cancels to first order and shows with the square of its size (a ring off its axis)."""
    candidate = next(c for c in library if c.name == row.effect)
    tried = _TRIED * candidate.width
    if candidate.angle is None or candidate.kind.place is not Place.RING or candidate.effect([tried, 0.0]) is None:
        return row
    squares = shown([m for m in _measured(built, row) if m.recording.kind != "profile_scan"], candidate, tried)
    if squares < 1.0:
        return row
    size = tried * (noncentrality(candidate.coordinates, _FAMILIES) / squares) ** 0.25
    return replace(row, detectable=size, identifiable=size, rival="", sine=1.0)


def _sine(R: FloatArray, i: int, j: int) -> float:
    """Least sine between a pattern of one candidate and all patterns of another."""
    own, other = coordinates([i]), coordinates([j])
    cross = R[np.ix_(own, other)]
    left = R[np.ix_(own, own)] - cross @ np.linalg.pinv(R[np.ix_(other, other)], rcond=1e-9) @ cross.T
    sizes = np.diagonal(R)[own]
    shares = [left[c, c] / sizes[c] for c in range(2) if sizes[c] > 1e-9]
    return math.sqrt(max(min(shares, default=0.0), 0.0))
