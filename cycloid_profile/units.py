"""Factors between base units (mm, N, MPa, rad, N·mm) and the units people read.

Multiply to come into base units, divide to leave them: ``gap_um * UM`` is in mm,
``twist / ARCMIN`` is in arc minutes.
"""

from __future__ import annotations

import math

UM = 1e-3
NM = 1e-6
ARCMIN = math.pi / (180.0 * 60.0)
ARCSEC = ARCMIN / 60.0
DEGREE = math.pi / 180.0
NEWTON_METRE = 1e3
GPA = 1e3

# Units as names end with them (``amount_um``), and their signs.
SIGNS = {
    "um": "µm",
    "arcmin": "′",
    "arcsec": "″",
    "deg": "°",
    "k": "K",
    "nm": "N·m",
    "nm_per_arcmin": "N·m/′",
    "um_per_kn": "µm/kN",
    "mpa": "MPa",
    "nm_arcmin": "N·m·′",
}


def unit_of(name: str) -> str:
    """Unit that a name ends with, the longest of ``SIGNS``; empty for a plain number."""
    return max((unit for unit in SIGNS if name.endswith(f"_{unit}")), key=len, default="")


def sign_of(name: str) -> str:
    """Sign of the unit that a name ends with; empty for a plain number."""
    return SIGNS.get(unit_of(name), "")
