"""Qualities of manufacture: the standard tolerances that each holds, ISO 286-1."""

from __future__ import annotations

from bisect import bisect_left
from typing import Literal, NamedTuple

from cycloid_profile.units import GPA, UM

Quality = Literal["ground", "machined", "printed"]  # of manufacture

# Plastics are below this modulus, filled ones too; the softest metal of a gear, magnesium, has 45 GPa.
STIFFEST_PLASTIC = 15.0 * GPA


class ByQuality(NamedTuple):
    """A value for each quality of manufacture."""

    ground: float
    machined: float
    printed: float

    def of(self, quality: Quality) -> float:
        """The value of one quality."""
        return float(getattr(self, quality))


# Grades IT that form, pitch and runout of the teeth hold at the pin circle, and the places of holes at their circle:
# priors of diagnosis, and tolerances where a spec states none; docs/diagnosis.md, "Priors", has the reasons.
FLANK_GRADES = ByQuality(4, 7, 12)
HOLE_GRADES = ByQuality(5, 7, 12)

# Zones of ISO 286-1:2010, Table 1, of sizes up to and including these [mm].
_STEPS = (3, 6, 10, 18, 30, 50, 80, 120, 180, 250, 315, 400, 500, 630, 800, 1000, 1250, 1600, 2000, 2500, 3150)
_ZONES_UM = {
    4: (3, 4, 4, 5, 6, 7, 8, 10, 12, 14, 16, 18, 20, 22, 25, 28, 33, 39, 46, 55, 68),
    5: (4, 5, 6, 8, 9, 11, 13, 15, 18, 20, 23, 25, 27, 32, 36, 40, 47, 55, 65, 78, 96),
    7: (10, 12, 15, 18, 21, 25, 30, 35, 40, 46, 52, 57, 63, 70, 80, 90, 105, 125, 150, 175, 210),
    12: (100, 120, 150, 180, 210, 250, 300, 350, 400, 460, 520, 570, 630, 700, 800, 900, 1050, 1250, 1500, 1750, 2100),
}


def quality_of(stated: Quality | None, modulus: float) -> Quality:
    """Quality of manufacture as ``stated``, else printed for a disc of plastic and ground for one of metal.

    ``modulus`` of the disc [MPa].
    """
    return stated or ("printed" if modulus < STIFFEST_PLASTIC else "ground")


def standard_zone(grade: int, size: float) -> float:
    """Width of the tolerance zone of a grade IT at a ``size`` [mm], as the standard prints it, both [mm].

    Beyond 3150 mm, where the standard ends, the zone is that of its last step.
    """
    return _ZONES_UM[grade][min(bisect_left(_STEPS, size), len(_STEPS) - 1)] * UM
