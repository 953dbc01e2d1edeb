"""The picture of a program shows every rapid, approach and cutting move where it happens."""

from __future__ import annotations

import numpy as np
import pytest

from cycloid_profile import plot
from cycloid_profile.export.nc import Blank, built_in_machine, interpret

PROGRAM = """%
G17 G21 G40 G49 G54 G80 G90 G91.1 G94
T1 M6
S3000 M3
G43 H1
G0 Z30.00000
G0 X30.00000 Y0.00000
G1 Z-1.00000 F500
G1 X20.00000 Y0.00000
G3 X-20.00000 Y0.00000 I-20.00000 J0.00000 F100
G0 Z30.00000
M5
M30
%
"""


def test_moves_are_drawn_by_kind() -> None:
    program = interpret(PROGRAM, built_in_machine("linuxcnc"))
    plan, height = np.ravel(plot.nc_program(program, Blank(20.0, 10.0)))
    lines = {line.get_label(): np.asarray(line.get_xydata()) for line in plan.get_lines()}
    assert set(lines) == {"blank", "rapid", "approach and retract", "in the blank"}
    cut = lines["in the blank"]
    cut = cut[~np.isnan(cut[:, 0])]
    # Half a circle through the upper side.
    assert np.hypot(*cut.T) == pytest.approx(20.0)
    assert np.max(cut[:, 1]) == pytest.approx(20.0)
    assert np.min(cut[:, 1]) > -1e-9
    air = lines["approach and retract"]
    assert np.nanmax(air[:, 0]) == 30.0
    z = {line.get_label(): line.get_ydata() for line in height.get_lines()}["Z of the tool"]
    assert (float(np.min(z)), float(np.max(z))) == (-1.0, 30.0)
