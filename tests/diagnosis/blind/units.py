"""Factors into mm, N, rad: multiply to come in, divide to leave."""

from __future__ import annotations

import math

UM = 1e-3
DEGREE = math.pi / 180.0
ARCMIN = DEGREE / 60.0
ARCSEC = ARCMIN / 60.0
NEWTON_METRE = 1e3
