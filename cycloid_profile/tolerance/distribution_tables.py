"""How a size or a direction scatters, read from a table such as ``{ plus_minus = 2.0, cp = 1.33 }``."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from cycloid_profile.effects.coordinates import Coordinates
from cycloid_profile.errors import SpecError
from cycloid_profile.tolerance.distribution import Distribution, Normal, Rayleigh, Triangular, Uniform, rayleigh_within
from cycloid_profile.tolerance.table_values import number, refuse_unknown

_ANGLE_KEYS = ("mean", "plus_minus")
_SIZE_KEYS = ("plus_minus", "sigma", "mean", "cp", "distribution", "inspected")


def _normal(mean: float, wide: float, sigma: float, inspected: bool) -> Distribution:
    return Normal(mean, sigma, wide if inspected else math.inf)


_SHAPES: dict[str, Callable[[float, float, float, bool], Distribution]] = {
    "normal": _normal,
    "uniform": lambda mean, wide, _sigma, _inspected: Uniform(mean, wide),
    "triangular": lambda mean, wide, _sigma, _inspected: Triangular(mean, wide),
}


def size_of(value: Mapping[str, Any], axes: Coordinates, where: str) -> tuple[Distribution, float | None]:
    """Distribution of a size, and its tolerance ± as drawn, None where only a standard deviation is given.

    Raises
    ------
    SpecError
        If a key is unknown, a width impossible, or two keys contradict.
    """
    refuse_unknown(value, _SIZE_KEYS, where, "a distribution")
    cp = number(value, "cp", 1.0, where, 1e-3, 100.0)
    directed = axes.angle is not None
    shape = value.get("distribution", "rayleigh" if directed else "normal")
    if shape not in (*_SHAPES, "rayleigh"):
        raise SpecError(f"{where}.distribution", f"'{shape}'", "is not known",
                        f"choose from {', '.join((*_SHAPES, 'rayleigh'))}")  # fmt: skip
    if shape == "rayleigh" and (not directed or value.get("mean")):
        raise SpecError(f"{where}.distribution", "'rayleigh'", "is for a size with a direction and without a mean",
                        "choose normal")  # fmt: skip
    inspected = value.get("inspected", False)
    if not isinstance(inspected, bool):
        raise SpecError(f"{where}.inspected", repr(inspected), "is neither true nor false", "give true or false")
    if "sigma" in value:
        sigma = number(value, "sigma", 0.0, where, 0.0, 1e6)
        if "plus_minus" in value:
            raise SpecError(f"{where}.sigma", sigma, "is given beside plus_minus", "give one of them")
        if "cp" in value:
            raise SpecError(f"{where}.cp", cp, "is given beside sigma, which it has no limits to compare with",
                            "give plus_minus in place of sigma")  # fmt: skip
        if shape not in ("normal", "rayleigh") or inspected:
            raise SpecError(f"{where}.sigma", sigma,
                            f"goes with a distribution without limits, no {shape} or inspected",
                            "give plus_minus")  # fmt: skip
        return (Rayleigh(sigma) if shape == "rayleigh" else Normal(_mean(value, axes, where), sigma)), None
    wide = number(value, "plus_minus", axes.size.tolerance or 1.0, where, 0.0, 1e6)
    if shape == "rayleigh":
        return rayleigh_within(wide, cp, inspected), wide
    return _SHAPES[shape](_mean(value, axes, where), wide, wide / (3.0 * cp), inspected), wide


def direction_of(value: Mapping[str, Any], where: str) -> Distribution:
    """Distribution of a direction [°]: any, unless one is given. Raises ``SpecError`` if a key is unknown."""
    refuse_unknown(value, _ANGLE_KEYS, where, "a direction")
    mean = number(value, "mean", 0.0, where, -3600.0, 3600.0)
    return Uniform(mean, number(value, "plus_minus", 180.0, where, 0.0, 180.0))


def _mean(value: Mapping[str, Any], axes: Coordinates, where: str) -> float:
    return number(value, "mean", 0.0, where, axes.size.low, axes.size.high)
