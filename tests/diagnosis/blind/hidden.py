"""A hidden effect: a name of docs/effects.md, or one of our own that begins with ``x_``, and its sizes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Hidden:
    """An effect by name with its parameters as a spec file writes them; ``disc`` absent means all discs."""

    name: str
    parameters: dict[str, Any] = field(default_factory=dict)

    def __getitem__(self, key: str) -> float:
        return float(self.parameters[key])

    def get(self, key: str, absent: float = 0.0) -> float:
        """The parameter, or ``absent``."""
        value = self.parameters.get(key)
        return absent if value is None else float(value)

    def number(self, key: str) -> int | None:
        """Number of a part, counted from 1; None for all of them."""
        value = self.parameters.get(key, 1 if (self.name, key) in _FIRST else None)
        return None if value is None else int(value)

    def on(self, key: str, part: int) -> bool:
        """Whether the part with this number, counted from 1, has the effect."""
        chosen = self.number(key)
        return chosen is None or chosen == part

    def table(self) -> dict[str, Any]:
        """As a table of a spec file."""
        return {"name": self.name} | self.parameters


# Effects of one part: the first one, if nothing is said.
_FIRST = {
    ("single_tooth_error", "disc"),
    ("single_tooth_error", "lobe"),
    ("wheel_wear_drift", "first_lobe"),
    ("single_pin_error", "pin"),
    ("crank_hole_error", "disc"),
    ("crank_hole_error", "crank"),
    ("planet_runout", "planet"),
    ("x_pit", "disc"),
    ("x_pit", "lobe"),
}


def named(effects: Iterable[Hidden], *names: str) -> Iterator[Hidden]:
    """Those of the effects that have one of the names."""
    return (one for one in effects if one.name in names)
