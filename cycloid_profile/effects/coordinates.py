"""In which numbers an effect is linear: its size, or the two components of a size with a direction.

Amplitude times cosine and sine of the angle, of twice the angle for an oval; the reciprocal of a stiffness.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.effects.effect import Effect, Parameter, parameters


@dataclass(frozen=True)
class Coordinates:
    """Linear coordinates of a ``kind`` of effect: ``size`` is its one parameter with a tolerance, ``angle`` its
    direction, None where it has none.
    """

    kind: type[Effect]
    size: Parameter
    angle: Parameter | None

    @property
    def count(self) -> int:
        """Number of coordinates, 1 or 2."""
        return 1 if self.angle is None else 2

    @property
    def waves(self) -> int:
        """How many times the effect repeats while its angle turns once: an oval does so twice."""
        return repeats(self.kind)

    @property
    def inverse(self) -> bool:
        """Whether the coordinate is the reciprocal of the size: a stiffness in series."""
        return self.kind.name == "series_compliance"

    def of(self, size: FloatArray, angle_deg: FloatArray | float = 0.0) -> FloatArray:
        """Coordinates of sizes and angles, shape (…, count), in the unit of the size or its reciprocal."""
        if self.inverse:
            return np.asarray(1.0 / size)[..., np.newaxis]
        if self.angle is None:
            return np.asarray(size, dtype=np.float64)[..., np.newaxis]
        turned = np.asarray(angle_deg) * (math.pi / 180.0 * self.waves)
        return np.stack([size * np.cos(turned), size * np.sin(turned)], axis=-1)

    def effect(self, x: FloatArray, choice: Mapping[str, Any]) -> Effect:
        """The effect at coordinates ``x``, shape (count,), with its parts chosen."""
        values = dict(choice)
        if self.angle is None:
            values[self.size.name] = 1.0 / float(x[0]) if self.inverse else float(x[0])
        else:
            values[self.size.name] = math.hypot(x[0], x[1])
            values[self.angle.name] = math.degrees(math.atan2(x[1], x[0]) / self.waves)
        return self.kind(**values)


def repeats(kind: type[Effect]) -> int:
    """How many times an effect repeats while its angle turns once: an oval does so twice."""
    return 2 if kind.name.endswith("_oval") else 1


def coordinates(kind: type[Effect], fixed: frozenset[str] = frozenset()) -> Coordinates:
    """Linear coordinates of an effect; parameters named in ``fixed`` are choices, as the waves of chatter are."""
    known = parameters(kind)
    (size,) = (p for p in known if p.tolerance is not None and p.name not in fixed)
    angles = [p for p in known if p.name.endswith("_deg") and p.name not in fixed]
    return Coordinates(kind, size, angles[0] if angles else None)
