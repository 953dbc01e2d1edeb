"""More and more nodes until an approximation keeps its tolerance, by measurement."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from cycloid_profile.arrays import ComplexArray
from cycloid_profile.errors import ExportError
from cycloid_profile.export.deviation import distances
from cycloid_profile.geometry.profile import ToothProfile

_Curve = TypeVar("_Curve")
FIT_SHARE = 0.8  # of the promised tolerance, which fits aim at
_FIRST_COUNT, _GROWTH, _LARGEST_COUNT = 8, 1.12, 2000


def refined(
    profile: ToothProfile,
    tolerance: float,
    through: Callable[[int], _Curve],
    dense: Callable[[_Curve], ComplexArray],
) -> _Curve:
    """The first curve ``through`` enough nodes whose ``dense`` points stay within ``tolerance`` of the tooth [mm].

    Raises
    ------
    ExportError
        If that takes more nodes than is sensible.
    """
    count = _FIRST_COUNT
    while count <= _LARGEST_COUNT:
        curve = through(count)
        if float(np.max(np.abs(distances(profile, dense(curve))))) <= tolerance:
            return curve
        count = math.ceil(_GROWTH * count)
    raise ExportError(
        "export tolerance",
        f"{tolerance * 1e6:g} nm",
        f"needs more than {_LARGEST_COUNT} nodes a piece",
        "raise export.chord_tolerance_um",
    )
