"""The library of hypotheses: every effect at every place it can act, as one or two linear coordinates.

An effect with a direction is linear in its two components, amplitude times cosine and sine of the angle (of twice the
angle for an oval); all others in their size. The
numbers of parts (disc, crank, pin, lobe, form) are choices, and each choice is a candidate of its own.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.coordinates import coordinates, repeats
from cycloid_profile.effects.effect import Effect, Parameter, Place, parameters
from cycloid_profile.effects.registry import EFFECTS
from cycloid_profile.errors import CycloidError

# A size is as likely as a normal distribution of twice the workshop tolerance; beyond 3.5 of those it is no workshop's.
_WIDTH_OF_TOLERANCE = 2.0
_LEAST_WIDTH_UM = 1.5
IMPLAUSIBLE = 3.5
# A pin out of place is told as one of another radius; waves of chatter are found by their spectrum.
ONLY_TOLERANCES = frozenset({"pin_position_error"})
_NOT_LISTED = ONLY_TOLERANCES | {"grinding_chatter"}

Variety = tuple[str, bool, int | None, int | None]


@dataclass(frozen=True)
class Candidate:
    """One hypothesis: an effect of ``kind`` with its ``choice`` of parts, its size open.

    ``size`` and ``angle`` name its parameters, ``angle`` None where the size is all; ``width`` is the standard
    deviation of each coordinate before any measurement, in the unit of the coordinate; ``inverse`` where the
    coordinate is the reciprocal of the size; ``one_sided`` where it cannot be negative.
    """

    kind: type[Effect]
    size: str
    angle: str | None
    width: float
    one_sided: bool
    inverse: bool = False
    choice: Mapping[str, Any] = field(default_factory=dict, hash=False)

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.kind.name

    @property
    def coordinates(self) -> int:
        """Number of linear coordinates, 1 or 2."""
        return 1 if self.angle is None else 2

    @property
    def on_all_discs(self) -> bool:
        """Whether all discs have it, or see it in the ring."""
        return self.kind.place is Place.RING or self.choice.get("disc", 0) is None

    @property
    def variety(self) -> Variety:
        """Name, whether all discs have it, flank and form: to first order half as much on both discs does the same as
        on one, and what one flank wears does not do what the other does.
        """
        return self.name, self.on_all_discs, self.choice.get("flank"), self.choice.get("form")

    @property
    def tells_pins_apart(self) -> bool:
        """Whether one pin differs from another with it."""
        return self.kind.place is Place.RING and (self.angle is not None or "pin" in self.choice)

    @property
    def waves(self) -> int:
        """How many times the effect repeats while its angle turns once: an oval does so twice."""
        return repeats(self.kind)

    @property
    def implausible(self) -> float:
        """Size of the coordinates beyond which no workshop makes it."""
        return IMPLAUSIBLE * self.width

    @property
    def label(self) -> str:
        """Name with the choice, for people."""
        parts = ", ".join(
            f"{key.replace('_', ' ')} {value:g}" for key, value in self.choice.items() if value is not None
        )
        return f"{self.name} ({parts})" if parts else self.name

    def parameters(self, x: Sequence[float] | FloatArray) -> dict[str, Any]:
        """Parameters of the effect at coordinates ``x``."""
        values: dict[str, Any] = {key: value for key, value in self.choice.items() if value is not None}
        if self.angle is None:
            values[self.size] = 1.0 / float(x[0]) if self.inverse else float(x[0])
        else:
            values[self.size] = math.hypot(x[0], x[1])
            values[self.angle] = math.degrees(math.atan2(x[1], x[0]) / self.waves) % (360.0 / self.waves)
        return values

    def effect(self, x: Sequence[float] | FloatArray) -> Effect | None:
        """The effect at coordinates ``x``; None where the coordinates mean nothing (a negative compliance)."""
        if self.one_sided and not x[0] > 0.0:
            return None
        try:
            return self.kind(**self.parameters(x))
        except CycloidError:
            return None

    def uncertainty(self, x: FloatArray, covariance: FloatArray) -> dict[str, float]:
        """Standard deviation of size and angle, from that of the coordinates."""
        if self.angle is None:
            sigma = math.sqrt(float(covariance[0, 0]))
            return {self.size: sigma / float(x[0]) ** 2 if self.inverse else sigma}
        A = math.hypot(x[0], x[1])
        along, across = np.array([x[0], x[1]]) / A, np.array([-x[1], x[0]]) / A
        return {
            self.size: math.sqrt(float(along @ covariance @ along)),
            self.angle: math.degrees(min(math.sqrt(float(across @ covariance @ across)) / A, math.pi) / self.waves),
        }

    def turned(self, lobes: int, of: int) -> tuple[dict[str, Any], float]:
        """The same seen with ``lobes`` of ``of`` counted on: its choice, and the turn of its coordinates [rad]."""
        choice = dict(self.choice)
        for key in ("lobe", "first_lobe"):
            if key in choice:
                choice[key] = (choice[key] - 1 + lobes) % of + 1
        t = 2.0 * math.pi * lobes / of
        # Polar angles run against the angle along the disc.
        rates = {"disc_runout": -1.0, "disc_oval": -2.0, "cumulative_pitch_error": 1.0}
        rate = choice["waves_per_turn"] if self.name == "grinding_chatter" else rates.get(self.name, 0.0)
        return choice, rate * t


def candidates(built: Built, scanned: frozenset[int], curves: bool) -> tuple[Candidate, ...]:
    """All hypotheses that the files at hand could show.

    Flank errors of discs in ``scanned``, counted from 0; with ``curves`` those of all discs, alone and together, and
    all other effects. Waves of chatter are found by their spectrum and not listed.
    """
    found: list[Candidate] = []
    for kind in EFFECTS.values():
        if kind.name in _NOT_LISTED or (kind.place is not Place.FLANK and not curves):
            continue
        for choice in _choices(kind, built, scanned, curves):
            candidate = candidate_of(kind, choice)
            if _exists(candidate, built):
                found.append(candidate)
    return tuple(found)


def candidate_of(kind: type[Effect], choice: Mapping[str, Any]) -> Candidate:
    """The hypothesis of one effect with its parts chosen."""
    axes = coordinates(kind, frozenset(choice))
    size = axes.size
    tolerance = float(size.tolerance or 0.0)
    width = _WIDTH_OF_TOLERANCE * (1.0 / tolerance if axes.inverse else tolerance)
    if size.name.endswith("_um"):
        width = max(width, _LEAST_WIDTH_UM)
    return Candidate(
        kind=kind,
        size=size.name,
        angle=None if axes.angle is None else axes.angle.name,
        width=width,
        one_sided=axes.angle is None and size.low >= 0.0,
        inverse=axes.inverse,
        choice=dict(choice),
    )


def places(library: Iterable[Candidate]) -> Counter[str]:
    """At how many places each effect of a library could be."""
    return Counter(candidate.name for candidate in library)


def chatter(waves: float, disc: int | None) -> Candidate:
    """Chatter of a number of waves a turn on a disc, counted from 1, None for all."""
    return candidate_of(EFFECTS["grinding_chatter"], {"waves_per_turn": waves, "disc": disc})


def _choices(kind: type[Effect], built: Built, scanned: frozenset[int], curves: bool) -> Iterator[dict[str, Any]]:
    """All choices of parts of one effect."""
    trochoid = built.case.drive.trochoid
    ranges: dict[str, list[Any]] = {
        "lobe": list(range(1, trochoid.lobes + 1)),
        "first_lobe": list(range(1, trochoid.lobes + 1)),
        "pin": list(range(1, trochoid.pins + 1)),
        "crank": [None, *range(1, built.cranks + 1)],
        "planet": list(range(1, built.cranks + 1)),
        "form": [1, 2],
        "flank": [1, 2],
    }
    if curves:
        discs: list[Any] = list(range(1, built.discs + 1))
        ranges["disc"] = [None, *discs] if built.discs > 1 else [None]
    else:
        # Errors that all discs share show when all of them were scanned.
        ranges["disc"] = [*([None] if len(scanned) == built.discs > 1 else []), *(j + 1 for j in sorted(scanned))]
    known = {p.name: p for p in parameters(kind)}
    names = [name for name in ranges if name in known]
    for values in product(*(_sensible(known[name], ranges[name]) for name in names)):
        yield dict(zip(names, values, strict=True))


def _sensible(parameter: Parameter, values: list[Any]) -> list[Any]:
    """Without those that would mean "all parts" where the effect has one part only."""
    return values if parameter.optional else [value for value in values if value is not None] or [1]


def _exists(candidate: Candidate, built: Built) -> bool:
    """Whether this drive can have it: no crank errors on a central eccentric. Every disc can have any flank error."""
    if candidate.kind.place is Place.FLANK:
        return True
    x = [1e-3 * candidate.width, 0.0]
    try:
        one = candidate.effect(x)
        return one is not None and one.apply(built) is not None
    except CycloidError:
        return False
