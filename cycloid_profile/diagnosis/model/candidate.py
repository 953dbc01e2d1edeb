"""Library of hypotheses: every effect at every location where it can act, in one or two linear coordinates.

An effect with a direction has two coordinates: amplitude times cosine and sine of the angle (of twice the angle for an
oval). Every other effect has its size as one coordinate. Part numbers (disc, crank, pin, lobe, form) are discrete
choices; each choice is a candidate of its own.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis.model.priors import Priors, priors_of
from cycloid_profile.effects import (
    EFFECTS,
    AsBuiltReducer,
    Effect,
    EffectLocation,
    GrindingChatter,
    NonlinearSeriesCompliance,
    Parameter,
    coordinates,
    parameters,
    shape_choices,
)
from cycloid_profile.errors import CycloidError

IMPLAUSIBLE = 3.5  # prior widths: one of 2,000 normal sizes is larger
# Simulated, toleranced and, on the flanks, corrected, but not yet proposed: the search, its thresholds and the blind
# cases were validated without them (docs/diagnosis.md, "Limits").
NOT_YET_PROPOSED = frozenset({
    "tooth_form_error", "pin_ring_three_lobed", "ring_mounting_ovality", "carrier_bore_error", "common_planet_runout",
    "sun_runout", "input_runout", "elastoslide_friction", "stribeck_friction",
})  # fmt: skip
OF_PLASTICS = frozenset({"viscoelastic_creep"})
# A displaced pin is an alias of a pin with another radius. The spectrum proposes the waves of chatter.
ONLY_TOLERANCES = NOT_YET_PROPOSED | {"pin_position_error"}
_NOT_LISTED = ONLY_TOLERANCES | {"grinding_chatter"}

_MACHINED = 2.0  # log odds against a change that takes machining
# Effects that run-in, wear, preload, lubrication and temperature change.
IN_SERVICE = frozenset({
    "crank_bearing_clearance", "flank_wear", "thermal_growth", "coulomb_friction", "load_proportional_friction",
    "series_compliance", "nonlinear_series_compliance", "viscoelastic_creep", "crank_bearing_compliance",
    "pin_support_compliance",
})  # fmt: skip

_PARTS = 10  # of the step between two shapes of the library: the error in between is below that of the form

Variety = tuple[str, bool, bool, int | None, int | None]


@dataclass(frozen=True)
class Candidate:
    """One hypothesis: an effect of ``kind`` with its ``choice`` of parts, its size unknown.

    ``size`` and ``angle`` name its parameters; ``angle`` is None for an effect without direction. ``width`` is the
    prior standard deviation of each coordinate, in the unit of the coordinate. ``inverse``: the coordinate is the
    reciprocal of the size. ``one_sided``: the coordinate cannot be negative. ``changed``: the candidate whose amount
    rises by this one between two measurements; None of an amount itself. ``log_odds``: added to its log prior.
    ``size_error``: standard deviation of what the model itself errs in the size, in widths.
    """

    kind: type[Effect]
    size: str
    angle: str | None
    width: float
    one_sided: bool
    inverse: bool = False
    choice: Mapping[str, Any] = field(default_factory=dict)
    changed: Candidate | None = None
    log_odds: float = 0.0
    size_error: float = 0.0

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return hash((self.kind, *sorted(self.choice.items(), key=str)))

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.kind.name

    @property
    def is_change(self) -> bool:
        """Whether this is the change of an amount."""
        return self.changed is not None

    @property
    def amount(self) -> Candidate:
        """The candidate itself, or the one whose amount changes."""
        return self.changed or self

    @property
    def change(self) -> Candidate:
        """Change of this candidate's amount between two measurements; it has either sign.

        Service changes some effects, only machining the others. What the model errs in the size is the same before and
        after.
        """
        odds = 0.0 if self.name in IN_SERVICE else -_MACHINED
        return replace(self, one_sided=False, changed=self, log_odds=odds, size_error=0.0)

    @property
    def coordinates(self) -> int:
        """Number of linear coordinates, 1 or 2."""
        return 1 if self.angle is None else 2

    @property
    def on_all_discs(self) -> bool:
        """Whether the effect acts on all discs, or on the ring, which all discs share."""
        return self.kind.location is EffectLocation.RING or self.choice.get("disc", 0) is None

    @property
    def same_at_180(self) -> bool:
        """Whether discs mounted 180° apart respond nearly equally to the effect and to it rotated by 180°.

        It is common to all discs and has one period per turn.
        """
        return self.on_all_discs and self.angle is not None and self.waves == 1

    @property
    def is_friction_torque(self) -> bool:
        """Whether it is an amount, not a change, of a torque of friction, which opens a loop as wide everywhere."""
        return self.kind.location is EffectLocation.FRICTION and self.size == "torque_nm" and not self.is_change

    @property
    def variety(self) -> Variety:
        """Name, whether it is a change, whether all discs have the effect, flank and form: candidates that differ in
        these differ to first order.
        """
        return self.name, self.is_change, self.on_all_discs, self.choice.get("flank"), self.choice.get("form")

    @property
    def along(self) -> float | None:
        """Place along the disc or the ring, in lobes or pins; None of an effect without one."""
        number = next((float(self.choice[key]) for key in ("lobe", "first_lobe", "pin") if key in self.choice), None)
        return None if number is None else number + float(self.choice.get("start_in_lobe", 0.0))

    @cached_property
    def numeric_shapes(self) -> tuple[str, ...]:
        """Names of the shapes that are numbers, so that others lie between those of the library."""
        return tuple(key for key in self.kind.shapes if not isinstance(self.choice.get(key, ""), str))

    @property
    def listed(self) -> bool:
        """Whether its shapes are those of the library."""
        return all(self.choice[key] in self.kind.shapes[key] for key in self.numeric_shapes)

    def near_shapes(self, parts: float) -> tuple[Candidate, ...]:
        """The same with one shape ``parts`` of the proposed steps away, on either side."""
        tried = [
            replace(self, choice={**self.choice, key: round(self.choice[key] + parts * step, 9)})
            for key in self.numeric_shapes
            for step in _steps(self.choice[key], self.kind.shapes[key])
        ]
        return tuple(one for one in tried if one.effect(np.full(2, one.width)) is not None)

    def shape_order(self, key: str) -> tuple[tuple[tuple[str, Any], ...], float]:
        """What candidates that differ in the shape ``key`` alone have in common, and the value that orders them.

        A shape that is part of a place is counted along the disc, across lobes.
        """
        of_place = self.is_place(key)
        left_out = {key, "first_lobe"} if of_place else {key}
        common = tuple(sorted(((k, v) for k, v in self.choice.items() if k not in left_out), key=str))
        return common, self.along if of_place and self.along is not None else float(self.choice[key])

    def between(self, key: str, other: Candidate, share: float) -> Candidate:
        """The same with the shape ``key`` moved by a ``share`` of the way to that of ``other``, the next one."""
        step = other.shape_order(key)[1] - self.shape_order(key)[1]
        if self.is_place(key):
            step %= 1.0
        parts = round(_PARTS * share) / _PARTS
        return replace(self, choice={**self.choice, key: round(float(self.choice[key]) + parts * step, 9)})

    @staticmethod
    def is_place(key: str) -> bool:
        """Whether a shape continues from lobe to lobe, as a place."""
        return key == "start_in_lobe"

    @property
    def waves(self) -> int:
        """Periods of the effect per turn of its angle: two for an oval."""
        return self.kind.harmonic

    @property
    def implausible(self) -> float:
        """Largest plausible size, in the unit of the coordinate."""
        return IMPLAUSIBLE * self.width

    @property
    def title(self) -> str:
        """Name, said to be a change where it is one."""
        return f"{self.name} (change)" if self.is_change else self.name

    @property
    def label(self) -> str:
        """Name with the choice of parts."""
        parts = ", ".join(
            f"{key.replace('_', ' ')} {value if isinstance(value, str) else f'{value:g}'}"
            for key, value in self.choice.items()
            if value is not None
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
        """The effect at coordinates ``x``; None for impossible coordinates, such as a negative compliance."""
        if self.one_sided and not x[0] > 0.0:
            return None
        try:
            return self.kind(**self.parameters(x))
        except CycloidError:
            return None

    def uncertainty(self, x: FloatArray, covariance: FloatArray) -> dict[str, float]:
        """Standard deviation of size and angle, from the covariance of the coordinates."""
        if self.angle is None:
            sigma = math.sqrt(float(covariance[0, 0]))
            return {self.size: sigma / float(x[0]) ** 2 if self.inverse else sigma}
        A = math.hypot(x[0], x[1])
        along, across = np.array([x[0], x[1]]) / A, np.array([-x[1], x[0]]) / A
        return {
            self.size: math.sqrt(float(along @ covariance @ along)),
            self.angle: math.degrees(min(math.sqrt(float(across @ covariance @ across)) / A, math.pi) / self.waves),
        }

    def reindexed(self, lobes: int, of: int) -> tuple[dict[str, Any], float]:
        """Choice of parts and rotation of the coordinates [rad] after raising the lobe index by ``lobes`` of ``of``."""
        choice = dict(self.choice)
        for key in ("lobe", "first_lobe"):
            if key in choice:
                choice[key] = (choice[key] - 1 + lobes) % of + 1
        t = 2.0 * math.pi * lobes / of
        # Polar angles increase against the angle along the disc.
        rate = choice["waves_per_turn"] if self.kind is GrindingChatter else self.kind.phase_per_lobe_index
        return choice, rate * t


def _steps(value: float, shapes: Iterable[float | str]) -> tuple[float, float]:
    """Proposed steps down and up from ``value``: parts of the distance of the two ``shapes`` around it."""
    values = np.unique([float(one) for one in shapes])
    distance = np.diff(values) / _PARTS
    below = int(np.clip(np.searchsorted(values, value) - 1, 0, distance.size - 1))
    above = int(np.clip(np.searchsorted(values, value, side="right") - 1, 0, distance.size - 1))
    return -float(distance[below]), float(distance[above])


def candidates(reducer: AsBuiltReducer, scanned: frozenset[int], curves: bool) -> tuple[Candidate, ...]:
    """All hypotheses that the files can show.

    Flank errors of the discs in ``scanned``, counted from 0. With ``curves``, flank errors of all discs, alone and
    together, and all other effects. Chatter is not listed: the spectrum proposes its waves.
    """
    found: list[Candidate] = []
    priors = priors_of(reducer)
    for kind in EFFECTS.values():
        if kind.name in _NOT_LISTED or (kind.location is not EffectLocation.FLANK and not curves):
            continue
        for choice in _choices(kind, reducer, scanned, curves):
            candidate = candidate_of(kind, choice, priors)
            if (priors.quality == "printed" or not _of_plastics(candidate)) and _exists(candidate, reducer):
                found.append(candidate)
    return tuple(found)


def _of_plastics(candidate: Candidate) -> bool:
    """Whether the effect needs a plastic: metal does not creep at these loads, and its joints stiffen, not soften."""
    softens = candidate.kind is NonlinearSeriesCompliance and candidate.choice["exponent"] >= 1.0
    return softens or candidate.name in OF_PLASTICS


def candidate_of(kind: type[Effect], choice: Mapping[str, Any], priors: Priors) -> Candidate:
    """Hypothesis of one effect with its parts chosen, its width from the ``priors`` of the reducer."""
    axes = coordinates(kind, frozenset(choice))
    size = axes.size
    return Candidate(
        kind=kind,
        size=size.name,
        angle=None if axes.angle is None else axes.angle.name,
        width=priors.width(kind, size, axes.reciprocal),
        one_sided=axes.angle is None and size.low >= 0.0,
        inverse=axes.reciprocal,
        choice=dict(choice),
        size_error=priors.size_error(kind),
    )


def places(library: Iterable[Candidate]) -> Counter[str]:
    """Number of locations of each effect in a library."""
    return Counter(candidate.name for candidate in library if candidate.listed and not candidate.is_change)


def chatter(waves: float, disc: int | None, priors: Priors, constant_speed: str = "generating") -> Candidate:
    """Chatter with a number of waves per turn on a disc, counted from 1; None for all discs."""
    choice = {"waves_per_turn": waves, "disc": disc, "constant_speed": constant_speed}
    return candidate_of(EFFECTS["grinding_chatter"], choice, priors)


def _choices(
    kind: type[Effect], reducer: AsBuiltReducer, scanned: frozenset[int], curves: bool
) -> Iterator[dict[str, Any]]:
    """All choices of parts of one effect."""
    trochoid = reducer.case.drive.trochoid
    ranges: dict[str, list[Any]] = {
        "lobe": list(range(1, trochoid.lobes + 1)),
        "first_lobe": list(range(1, trochoid.lobes + 1)),
        "pin": list(range(1, trochoid.pins + 1)),
        "crank": [None, *range(1, reducer.cranks + 1)],
        "planet": list(range(1, reducer.cranks + 1)),
        "form": [1, 2],
        "flank": [1, 2],
    }
    if curves:
        discs: list[Any] = list(range(1, reducer.discs + 1))
        ranges["disc"] = [None, *discs] if reducer.discs > 1 else [None]
    else:
        # A candidate on all discs is visible only if every disc was scanned.
        ranges["disc"] = [*([None] if len(scanned) == reducer.discs > 1 else []), *(j + 1 for j in sorted(scanned))]
    known = {p.name: p for p in parameters(kind)}
    # A removal of both flanks may be on one; the validated library has it on both.
    names = [name for name in ranges if name in known and not (name == "flank" and known[name].optional)]
    for values in product(*(_sensible(known[name], ranges[name]) for name in names)):
        for shape in shape_choices(kind):
            yield dict(zip(names, values, strict=True)) | shape


def _sensible(parameter: Parameter, values: list[Any]) -> list[Any]:
    """Values without "all parts" where the effect acts on a single part."""
    return values if parameter.optional else [value for value in values if value is not None] or [1]


def _exists(candidate: Candidate, reducer: AsBuiltReducer) -> bool:
    """Whether the drive can have the effect: a central eccentric has no crank errors, every disc has flanks."""
    if candidate.kind.location is EffectLocation.FLANK:
        return True
    x = [1e-3 * candidate.width, 0.0]
    try:
        one = candidate.effect(x)
        return one is not None and one.apply(reducer) is not None
    except CycloidError:
        return False
