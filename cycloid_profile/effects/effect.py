"""What every effect is: a name, parameters with units and bounds, and how it changes a reducer."""

from __future__ import annotations

import dataclasses
from enum import Enum
from typing import Any, ClassVar, NamedTuple

from cycloid_profile.effects.built import Built
from cycloid_profile.errors import SpecError


class Place(Enum):
    """Where an effect acts."""

    FLANK = "disc flank"
    RING = "pin ring"
    CRANK = "crank or disc body"
    COMPLIANCE = "compliance"
    FRICTION = "friction"
    SENSOR = "drive train or sensor"


class Parameter(NamedTuple):
    """One parameter of an effect, in the unit its name ends with.

    ``tolerance`` is what a good workshop holds, a standard width for a size; None for a direction or a part.
    ``optional`` where None is a value of its own: all parts.
    """

    name: str
    text: str
    low: float
    high: float
    tolerance: float | None
    required: bool
    whole: bool
    optional: bool


def size(text: str, tolerance: float, low: float, high: float, default: Any = dataclasses.MISSING) -> Any:
    """A field that holds the size of an effect, with what a good workshop holds."""
    return _field(text, low, high, tolerance, default)


def angle(text: str) -> Any:
    """A field that holds a direction or phase in degrees, 0 unless given."""
    return _field(text, -3600.0, 3600.0, None, 0.0)


def part(text: str, default: Any = None, most: int = 1000) -> Any:
    """A field that holds the number of a part counted from 1, or of a choice; None, if the default, for all of them."""
    return _field(text, 1, most, None, default)


def _field(text: str, low: float, high: float, tolerance: float | None, default: Any) -> Any:
    meta = {"text": text, "low": low, "high": high, "tolerance": tolerance}
    if default is dataclasses.MISSING:
        return dataclasses.field(metadata=meta)
    return dataclasses.field(default=default, metadata=meta)


class Effect:
    """Base of all effects: frozen, comparable, bounds checked.

    Raises
    ------
    SpecError
        If a parameter is not a number or outside its bounds.
    """

    name: ClassVar[str]
    place: ClassVar[Place]

    def __post_init__(self) -> None:
        for parameter in parameters(type(self)):
            value = getattr(self, parameter.name)
            if value is None and parameter.optional:
                continue
            # Whole numbers of a spec file can be larger than any float.
            number = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300
            if not number or (parameter.whole and value != int(value)):
                kind = "a whole number" if parameter.whole else "a number"
                raise SpecError(f"{self.name}.{parameter.name}", repr(value), f"is not {kind}", parameter.text)
            if not parameter.low <= value <= parameter.high:
                raise SpecError(
                    f"{self.name}.{parameter.name}",
                    f"{value:g}",
                    f"is outside {parameter.low:g} to {parameter.high:g}",
                    parameter.text,
                )

    def apply(self, built: Built) -> Built:
        """The reducer with this effect."""
        raise NotImplementedError


def parameters(kind: type[Effect]) -> tuple[Parameter, ...]:
    """Parameters of a kind of effect, in the order of its fields."""
    return tuple(
        Parameter(
            name=field.name,
            text=field.metadata["text"],
            low=field.metadata["low"],
            high=field.metadata["high"],
            tolerance=field.metadata["tolerance"],
            required=field.default is dataclasses.MISSING,
            whole="int" in str(field.type),
            optional=field.default is None,
        )
        for field in dataclasses.fields(kind)  # type: ignore[arg-type]
    )


def chosen(effect: Effect, name: str, number: int | None, count: int) -> tuple[int, ...]:
    """Indices of the parts that ``number`` means, counted from 0; raises ``SpecError`` beyond ``count``."""
    if number is None:
        return tuple(range(count))
    if number > count:
        raise SpecError(f"{effect.name}.{name}", number, f"is more than there are, {count}", f"give 1 to {count}")
    return (int(number) - 1,)
