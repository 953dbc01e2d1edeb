"""Curves of elastic discs to first order in their compliance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.effects import AsBuiltReducer, as_drawn
from cycloid_profile.measurement import HYSTERESIS, LOST_MOTION_MAP, TRANSMISSION_ERROR, Measurement
from cycloid_profile.rig import LinearisedCurve, predict_curve
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Reducer, spec_text


@pytest.fixture(scope="module")
def elastic() -> AsBuiltReducer:
    return as_built_reducer(parse_spec(spec_text(Reducer(disc_body="elastic"))))


def files() -> dict[str, Measurement]:
    angle = np.linspace(0.0, 20.0, 12)
    torque = 4.12 * np.array([10, 55, 100, 60, 20, -20, -70, -100, -50, -10, 30, 100.0])
    empty = np.zeros(12)
    return {
        "turn": Measurement(
            TRANSMISSION_ERROR, {"output_angle_deg": angle, "error_arcsec": empty}, {"torque_nm": "412"}, "turn"
        ),
        "map": Measurement(
            LOST_MOTION_MAP, {"output_angle_deg": angle, "lost_motion_arcmin": empty}, {"torque_nm": "30"}, "map"
        ),
        "loop": Measurement(
            HYSTERESIS,
            {"torque_nm": torque, "angle_arcmin": empty},
            {"output_angle_deg": "11", "input": "locked"},
            "loop",
        ),
    }


@pytest.mark.parametrize("kind", ["turn", "map", "loop"])
def test_softer_discs_turn_the_output_as_new_equilibria_say(elastic, kind):
    """With both discs softer by 2 %; the rest is of second order."""
    softer, case = 0.02, elastic.case
    after = as_drawn(replace(case, disc_bodies=tuple(one.scaled(1.0 + softer) for one in case.disc_bodies)))
    file = files()[kind]
    before = predict_curve(elastic, file)
    exact = predict_curve(after, file).on_last_flank - before.on_last_flank
    by = tuple(one.scaled(softer) for one in case.disc_bodies)
    found = LinearisedCurve(before).softened(by)
    np.testing.assert_allclose(found, exact, rtol=0.0, atol=0.02 * np.max(np.abs(exact)))
