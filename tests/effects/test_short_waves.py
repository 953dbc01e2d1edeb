"""Physics of chatter: pins on waves shorter than their own bed, against a search along the whole flank."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cycloid_profile.contact.mesh import gaps, mesh
from cycloid_profile.rig import measurement_residual, simulate, transmission_error
from cycloid_profile.units import UM

REACH = 0.5  # rad to either side of the pin's phase; the flank is bent too much for feet further off
STEPS = 4001


CHATTER = [
    {"name": "grinding_chatter", "amplitude_um": amplitude, "waves_per_turn": waves}
    for amplitude, waves in [(5.0, 200.0), (0.3, 1000.0), (1.0, 1000.0), (1.0, 2000.0)]
]
STEEP = [
    {"name": "tooth_form_error", "amplitude_um": 8.0, "waves": 20},
    {"name": "wheel_wear_drift", "amount_um": 20.0, "blend_rad": 0.05},
]


@pytest.mark.parametrize("table", CHATTER + STEEP, ids=lambda table: " ".join(map(str, table.values())))
def test_a_pin_rests_on_the_highest_wave(built_with, case, table):
    # With waves as steep as the pin is round it has a foot on each; the gap is the distance of the nearest.
    tooth = built_with(table).teeth[0]
    meshing = mesh(case.drive.trochoid, np.linspace(0.0, 240.0, 12))
    found = gaps(tooth, case.drive.pin_radius, meshing).gap
    nearest = np.full(found.shape, np.inf)
    for offset in np.linspace(-REACH, REACH, STEPS):
        points = tooth.at(meshing.phase + offset, None, meshing.lobe).position
        nearest = np.minimum(nearest, np.abs(meshing.pin_centre - points))
    # The search steps by 0.25 mrad, some 2 µm at most along the flank: it stops short by less than 10 nm.
    np.testing.assert_allclose(found, nearest - case.drive.pin_radius, rtol=0.0, atol=1e-5)


def test_a_reducer_with_chatter_still_turns(built_with):
    rough = built_with({"name": "grinding_chatter", "amplitude_um": 2.0, "waves_per_turn": 1000.0})
    assert np.all(np.isfinite(transmission_error(rough, rough.case.torque, 60).error))


def test_a_scan_of_waves_that_do_not_come_out_even_lies_on_its_own_disc(built_with):
    # Of 100.5 waves the last gives way to the first round the tip before the first lobe.
    rough = built_with({"name": "grinding_chatter", "amplitude_um": 1.0, "waves_per_turn": 100.5})
    residual = measurement_residual(rough, simulate(rough, "profile_scan")).residual
    assert np.max(np.abs(residual)) < 1e-6
    before, after = rough.teeth[0].removal(np.array([-math.pi + 1e-9, -math.pi - 1e-9])).value
    assert before == pytest.approx(after, abs=1e-11)
    # The joint is half a radian wide on either side: beyond it the waves are whole.
    turned = 100.5 / 39.0 * np.array([-math.pi + 0.6, 77.0 * math.pi - 0.6])
    near = rough.teeth[0].removal(np.array([-math.pi + 0.6, -math.pi - 0.6])).value
    assert near == pytest.approx(UM * np.cos(turned), abs=1e-9)


def test_no_pose_is_lost_where_the_waves_meet(built_with):
    uneven = {"waves_per_turn": 518.109, "phase_deg": 228.3, "disc": 2}
    rough = built_with({"name": "grinding_chatter", "amplitude_um": 0.324} | uneven)
    assert np.all(np.isfinite(transmission_error(rough, 12.36e3, 400).error))
