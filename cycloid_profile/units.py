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
