"""Scatter from reducer to reducer: effects whose sizes are distributions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from cycloid_profile.effects import Coordinates, Effect
from cycloid_profile.tolerance.inputs.distribution import Distribution, Rayleigh, Uniform

# Parts that can each have their own size; the parameter of an effect that numbers them has the same name.
PARTS = ("pin", "disc", "crank", "lobe", "planet")


@dataclass(frozen=True, slots=True)
class Cost:
    """Cost of a tolerance: ``fixed`` + ``at_drawing``·(1/r)^``exponent`` at r times the tolerance of the drawing.

    ``finest`` and ``coarsest`` bound r.
    """

    at_drawing: float
    exponent: float = 1.0
    fixed: float = 0.0
    finest: float = 0.2
    coarsest: float = 5.0

    def value(self, ratio: float) -> float:
        """Cost at ``ratio`` times the tolerance."""
        return float(self.fixed + self.at_drawing * ratio**-self.exponent)

    def slope(self, ratio: float) -> float:
        """Derivative of the cost by the ratio."""
        return float(-self.exponent * self.at_drawing * ratio ** (-self.exponent - 1.0))


@dataclass(frozen=True, kw_only=True)
class Scatter:
    """One effect that scatters.

    ``choices``, parts the effect applies to; each part gets an independent random size. ``size`` and ``angle_deg``,
    their distributions; the angle is None where the effect has none. ``plus_minus``, tolerance on the drawing in the
    unit of the size; None where only a standard deviation is given. ``batch_share`` of the variance is common to a
    batch; sizes correlate over ``neighbours`` neighbouring parts.
    """

    kind: type[Effect]
    axes: Coordinates
    choices: tuple[Mapping[str, Any], ...]
    size: Distribution
    angle_deg: Distribution | None
    plus_minus: float | None = None
    batch_share: float = 0.0
    neighbours: float = 0.0
    cost: Cost | None = None
    label: str = ""

    @property
    def parameter(self) -> str:
        """Effect and size as one word, such as ``single_pin_error.amount_um``."""
        return f"{self.kind.name}.{self.axes.size.name}"

    @property
    def unit(self) -> str:
        """Unit of the size."""
        ending = self.axes.size.name.rsplit("_", 1)[-1]
        return {"um": "µm", "arcmin": "arcmin", "deg": "°"}.get(ending, ending)

    @property
    def components(self) -> bool:
        """Whether both components are plain normal numbers: an offset in any direction, none of them rejected."""
        free = isinstance(self.angle_deg, Uniform) and self.angle_deg.half_width >= 180.0
        return free and isinstance(self.size, Rayleigh) and math.isinf(self.size.limit)

    def scaled(self, factor: float) -> Scatter:
        """The same with a tolerance ``factor`` times as wide."""
        wide = None if self.plus_minus is None else self.plus_minus * factor
        return replace(self, size=self.size.scaled(factor), plus_minus=wide)


@dataclass(frozen=True, slots=True)
class Correlation:
    """Correlation ``value`` between the normal numbers of two scatters, by their index."""

    first: int
    second: int
    value: float


@dataclass(frozen=True)
class Tolerances:
    """All scatters and their correlations."""

    scatters: tuple[Scatter, ...]
    correlations: tuple[Correlation, ...] = ()
    assumed: bool = field(default=False)

    def scaled(self, factors: Sequence[float]) -> Tolerances:
        """The same with each scatter's tolerance times its factor."""
        return replace(
            self, scatters=tuple(one.scaled(factor) for one, factor in zip(self.scatters, factors, strict=True))
        )
