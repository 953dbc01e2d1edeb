"""Base of all effects: name, parameters with units and bounds, change of a reducer, linear coordinates."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Mapping
from enum import Enum
from itertools import product
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.effects.reducer import AsBuiltReducer
from cycloid_profile.errors import SpecError, did_you_mean

DISC_PART = "number of the disc, 1 for the first; all discs if absent"
# Bounds refuse what no drive can have, printed and large ones included; a tolerance says what is usual.
LARGEST_UM = 5000.0
_LARGEST = 1e300  # whole numbers of a spec file can be larger than any float


class EffectLocation(Enum):
    """Where an effect acts."""

    FLANK = "disc flank"
    RING = "pin ring"
    CRANK = "crank or disc body"
    COMPLIANCE = "compliance"
    FRICTION = "friction"
    SENSOR = "drive train or sensor"


class Parameter(NamedTuple):
    """One parameter of an effect, in the unit its name ends with.

    ``tolerance`` is the usual manufacturing tolerance, a standard width of a size; None for an angle or a part.
    ``whole`` for part numbers; ``is_angle`` for directions and phases; ``optional`` where None means all parts.
    ``options``, the words that a choice allows; it has no bounds.
    """

    name: str
    text: str
    low: float
    high: float
    tolerance: float | None
    required: bool
    optional: bool
    whole: bool = False
    is_angle: bool = False
    options: tuple[str, ...] = ()


def size_field(text: str, tolerance: float, low: float, high: float) -> Any:
    """A required field that holds the size of an effect, with its usual manufacturing tolerance."""
    return dataclasses.field(metadata={"text": text, "low": low, "high": high, "tolerance": tolerance})


def angle_field(text: str) -> Any:
    """A field that holds a direction or phase in degrees, 0 unless given."""
    meta = {"text": text, "low": -3600.0, "high": 3600.0, "tolerance": None, "is_angle": True}
    return dataclasses.field(default=0.0, metadata=meta)


def shape_field(text: str, default: float, low: float, high: float) -> Any:
    """A field that holds a number without unit which shapes an effect, such as an exponent."""
    return dataclasses.field(default=default, metadata={"text": text, "low": low, "high": high, "tolerance": None})


def choice_field(text: str, *options: str) -> Any:
    """A field that holds one of some words, the first unless given."""
    meta = {"text": text, "low": 0.0, "high": 0.0, "tolerance": None, "options": options}
    return dataclasses.field(default=options[0], metadata=meta)


def part_field(text: str, default: int | None = None, most: int = 1000) -> Any:
    """A field that holds the number of a part counted from 1, or of a choice; a default of None means all parts."""
    meta = {"text": text, "low": 1, "high": most, "tolerance": None, "whole": True}
    return dataclasses.field(default=default, metadata=meta)


class Effect:
    """Base of all effects: frozen, comparable, bounds checked.

    ``name`` in files and commands is that of the class in lower case: ``DiscRunout`` is ``disc_runout``. ``remedy`` at
    the machine. The effect repeats ``harmonic`` times while its angle turns once; its linear coordinates
    rotate by ``phase_per_lobe_index`` lobe pitches when the lobe index shifts by one. The response is linear in the
    size or ``linear_in_reciprocal``. ``shapes``, parameters that shape an effect of one cause, each with values that
    span what is found in practice, its default first. ``law_varies``: the response to the torque has that form in one
    drive and another in the next, as of joints.

    Raises ``SpecError`` if a parameter is not a number or outside its bounds.
    """

    name: ClassVar[str]
    location: ClassVar[EffectLocation]
    remedy: ClassVar[str]
    harmonic: ClassVar[int] = 1
    phase_per_lobe_index: ClassVar[float] = 0.0
    linear_in_reciprocal: ClassVar[bool] = False
    shapes: ClassVar[Mapping[str, tuple[float | str, ...]]] = MappingProxyType({})
    law_varies: ClassVar[bool] = False

    def __init_subclass__(cls) -> None:
        cls.name = re.sub(r"(?<!^)(?=[A-Z])", "_", cls.__name__).lower()

    def __post_init__(self) -> None:
        for parameter in parameters(type(self)):
            value = getattr(self, parameter.name)
            if value is None and parameter.optional:
                continue
            what = f"{self.name}.{parameter.name}"
            if parameter.options:
                _refuse_other_words(what, value, parameter.options)
                continue
            number = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < _LARGEST
            if not number or (parameter.whole and value != int(value)):
                wanted = "a whole number" if parameter.whole else "a number"
                raise SpecError(what, repr(value), f"is not {wanted}", parameter.text)
            if not parameter.low <= value <= parameter.high:
                limit = f"is outside {parameter.low:g} to {parameter.high:g}"
                raise SpecError(what, f"{value:g}", limit, parameter.text)

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        """The reducer with this effect."""
        raise NotImplementedError


def _refuse_other_words(what: str, value: Any, options: tuple[str, ...]) -> None:
    if value not in options:
        known = ", ".join(options)
        remedy = did_you_mean(value, options, f"choose from {known}") if isinstance(value, str) else f"choose {known}"
        raise SpecError(what, repr(value), "is not a choice", remedy)


def shape_choices(kind: type[Effect]) -> tuple[dict[str, float | str], ...]:
    """All combinations of the ``shapes`` of a kind of effect, the default first; one empty choice without any."""
    return tuple(dict(zip(kind.shapes, values, strict=True)) for values in product(*kind.shapes.values()))


def parameters(kind: type[Effect]) -> tuple[Parameter, ...]:
    """Parameters of a kind of effect, in the order of its fields."""
    return tuple(
        Parameter(
            name=field.name,
            required=field.default is dataclasses.MISSING,
            optional=field.default is None,
            **field.metadata,
        )
        for field in dataclasses.fields(kind)  # type: ignore[arg-type]
    )


def part_indices(effect: Effect, name: str, number: int | None, count: int) -> tuple[int, ...]:
    """Indices of the parts that ``number`` means, counted from 0; raises ``SpecError`` beyond ``count``."""
    if number is None:
        return tuple(range(count))
    if number > count:
        raise SpecError(f"{effect.name}.{name}", number, f"is more than there are, {count}", f"give 1 to {count}")
    return (int(number) - 1,)


@dataclasses.dataclass(frozen=True)
class Coordinates:
    """Linear coordinates of a ``kind`` of effect: its size, or its reciprocal; size times cosine and sine of an angle.

    ``size`` is its one parameter with a tolerance, ``angle`` its direction, None where it has none.
    """

    kind: type[Effect]
    size: Parameter
    angle: Parameter | None

    @property
    def count(self) -> int:
        """Number of coordinates, 1 or 2."""
        return 1 if self.angle is None else 2

    @property
    def harmonic(self) -> int:
        """Repetitions of the effect while its angle turns once: 2 of an oval."""
        return self.kind.harmonic

    @property
    def reciprocal(self) -> bool:
        """Whether the coordinate is the reciprocal of the size: a stiffness in series."""
        return self.kind.linear_in_reciprocal

    def of(self, size: FloatArray, angle_deg: FloatArray | float = 0.0) -> FloatArray:
        """Coordinates of sizes and angles, shape (…, count), in the unit of the size or its reciprocal."""
        if self.reciprocal:
            return np.asarray(1.0 / size)[..., np.newaxis]
        if self.angle is None:
            return np.asarray(size, dtype=np.float64)[..., np.newaxis]
        turned = np.asarray(angle_deg) * (math.pi / 180.0 * self.harmonic)
        return np.stack([size * np.cos(turned), size * np.sin(turned)], axis=-1)

    def effect(self, x: FloatArray, choice: Mapping[str, Any]) -> Effect:
        """The effect with coordinates ``x``, shape (count,); ``choice`` gives its other parameters."""
        values = dict(choice)
        if self.angle is None:
            values[self.size.name] = 1.0 / float(x[0]) if self.reciprocal else float(x[0])
        else:
            values[self.size.name] = math.hypot(x[0], x[1])
            values[self.angle.name] = math.degrees(math.atan2(x[1], x[0]) / self.harmonic)
        return self.kind(**values)


def coordinates(kind: type[Effect], fixed: frozenset[str] = frozenset()) -> Coordinates:
    """Linear coordinates of an effect; parameters named in ``fixed`` are choices, as the waves of chatter are."""
    known = parameters(kind)
    (size,) = (p for p in known if p.tolerance is not None and p.name not in fixed)
    angles = [p for p in known if p.is_angle and p.name not in fixed]
    return Coordinates(kind, size, angles[0] if angles else None)
