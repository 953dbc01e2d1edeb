"""Gaps against a foot point solved with 40 digits, and against a search over the whole neighbourhood.

The reference works on the formula of the tooth in mpmath and knows nothing of the package's Newton,
derivatives or branches.
"""

from __future__ import annotations

import itertools
import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.contact import LoadCase
from cycloid_profile.contact.disc.classical import take_up_gap
from cycloid_profile.contact.mesh import capture_radius, gaps, mesh, mesh_cycle, nearest_foot
from cycloid_profile.geometry import CentralEccentric, Drive, ToothProfile, Trochoid, undercut_limit
from cycloid_profile.modification import DeformationCompensation, Equidistant, FlankRotation, RadialMoving, modify

RNG = np.random.default_rng(7)


def point(tooth, psi, side):
    """P(ψ) of Eq. 7 in mpmath; ``side`` is the flank branch of |sinψ|."""
    trochoid = tooth.trochoid
    z_p, r_p, a = trochoid.pins, mp.mpf(trochoid.pin_circle_radius), mp.mpf(trochoid.eccentricity)
    z_c, K1 = z_p - 1, a * z_p / r_p
    S = 1 / mp.sqrt(1 + K1**2 - 2 * K1 * mp.cos(psi))
    h = sum(mp.mpf(removal.amount) for removal in tooth.removals) * side * mp.sin(psi) * S
    normal = S * (mp.expj(-psi / z_c) - K1 * mp.expj(-psi * z_p / z_c))
    return r_p * mp.expj(-psi / z_c) - a * mp.expj(-psi * z_p / z_c) - (tooth.pin_radius + h) * normal


def reference_gap(tooth, centre, start, side):
    """|p − P(ψ*)| − r_rp at the foot on one flank, 40 digits; infinite where the foot leaves the flank."""
    with mp.workdps(40):
        p = mp.mpc(centre)

        def slope(psi):
            return mp.re(mp.conj(p - point(tooth, psi, side)) * mp.diff(lambda t: point(tooth, t, side), psi))

        foot = mp.findroot(slope, (mp.mpf(start), mp.mpf(start) + mp.mpf("1e-4")), tol=1e-50)
        if tooth.corners and side * mp.sin(foot) < 0:
            return math.inf
        return float(abs(p - point(tooth, foot, side)) - 3)


def signed_search(tooth, centre, start, pin_radius, half=0.8):
    """Gap to the nearest of 20 001 points of the tooth; errs by 1e-7 mm at most, towards larger gaps."""
    psi = np.linspace(start - half, start + half, 20001)
    points = tooth.at(psi)
    i = int(np.argmin(np.abs(centre - points.position)))
    return float((np.conj(points.normal[i]) * (centre - points.position[i])).real - pin_radius)


def random_displacements(poses):
    shift = RNG.uniform(-0.01, 0.01, (poses, 1)) + 1j * RNG.uniform(-0.01, 0.01, (poses, 1))
    return shift, RNG.uniform(-2e-4, 2e-4, (poses, 1))


@pytest.mark.parametrize(
    "changes",
    [
        (Equidistant(0.006),),
        (Equidistant(0.05), RadialMoving(-0.0275)),
        (Equidistant(0.006), DeformationCompensation(0.0019)),
        (Equidistant(0.03), DeformationCompensation(0.02)),
    ],
    ids=["equidistant", "pair", "compensated", "strongly compensated"],
)
def test_gaps_agree_with_a_forty_digit_foot_point(theoretical, changes):
    tooth = modify(theoretical, *changes)
    # The pins stand on the nominal path, whatever the tooth was ground on.
    meshing = mesh(theoretical.trochoid, RNG.uniform(0.0, 6.0, 4))
    shift, turn = random_displacements(4)
    found = gaps(tooth, 3.0, meshing, shift, turn)
    centre = meshing.pin_in_lobe(shift, turn)
    for pose, pin in zip(range(4), RNG.integers(0, 40, 4), strict=True):
        for k in (pin, (pin + 13) % 40, (pin + 26) % 40):
            psi = meshing.phase[pose, 0, k]
            start = found.foot[pose, 0, k] if tooth.corners else psi
            sides = (1, -1) if tooth.corners else (1,)
            expected = min(reference_gap(tooth, complex(centre[pose, 0, k]), start, s) for s in sides)
            assert found.gap[pose, 0, k] == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("past", [-0.12, -0.03, 0.03, 0.12])
def test_the_foot_does_not_depend_on_where_the_search_begins(theoretical, past):
    # Roots and tips are corners: the search begins on the other flank as often as not.
    tooth = modify(theoretical, Equidistant(0.03), DeformationCompensation(0.02))
    meshing = mesh(theoretical.trochoid, RNG.uniform(0.0, 6.0, 12))
    here = gaps(tooth, 3.0, meshing)
    again = gaps(tooth, 3.0, meshing, start=here.foot + past)
    np.testing.assert_allclose(again.gap, here.gap, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(again.foot, here.foot, rtol=0.0, atol=1e-7)


@pytest.mark.parametrize("turn", [-3e-3, 3e-3])
def test_feet_of_a_turned_disc_lie_across_root_and_tip(theoretical, turn):
    # 3 mrad move a foot by a tenth of a radian: from one flank of a lobe to the other, or to that of the next lobe.
    tooth = modify(theoretical, Equidistant(0.03), DeformationCompensation(0.02))
    meshing = mesh(theoretical.trochoid, [0.002, 0.155])
    found, centre = gaps(tooth, 3.0, meshing, rotation=turn), meshing.pin_in_lobe(0.0, np.full((2, 1), turn))
    assert np.any(np.abs(found.foot) > math.pi)
    assert np.any(found.foot * meshing.phase < 0.0)
    for pose in range(2):
        searched = [signed_search(tooth, centre[pose, 0, k], meshing.phase[pose, 0, k], 3.0, 1.6) for k in range(40)]
        np.testing.assert_allclose(found.gap[pose, 0], searched, atol=1e-6)


@pytest.mark.parametrize("amount", [0.002, 0.02])
def test_a_foot_is_sought_further_from_the_least_concave_radius_on(theoretical, amount):
    # The flank as it is ground, next to the root: what was taken from it counts.
    tooth = modify(theoretical, Equidistant(0.03), DeformationCompensation(amount))
    psi = np.linspace(0.0, 2.0 * math.pi, 2001)[1:-1]
    capture = capture_radius(tooth, psi, None)
    near = np.isfinite(capture) & (psi < math.pi)
    curvature = tooth.at(psi[near], np.ones(np.count_nonzero(near))).curvature
    assert np.ptp(capture[near]) == 0.0
    assert capture[near][0] == pytest.approx(1.0 / np.max(curvature), rel=3e-3)


@pytest.mark.parametrize("crank", [0.0, 1e-3])
def test_gap_at_a_corner_is_that_of_the_nearer_flank(theoretical, crank):
    # Pins 0 and 20 stand in the root and on the tip, where a compensated tooth has re-entrant corners.
    tooth = modify(theoretical, Equidistant(0.03), DeformationCompensation(0.02))
    meshing = mesh(theoretical.trochoid, [crank])
    found, centre = gaps(tooth, 3.0, meshing), meshing.pin_in_lobe()
    for pin in (0, 20):
        starts = itertools.product((1e-3, -1e-3), (1, -1))
        feet = [reference_gap(tooth, complex(centre[0, 0, pin]), found.foot[0, 0, pin] + e, s) for e, s in starts]
        assert found.gap[0, 0, pin] == pytest.approx(min(feet), abs=1e-9)


@given(st.integers(5, 80), st.floats(0.1, 0.85), st.floats(0.1, 0.9), st.floats(0.0, 6.3), st.floats(0.0, 10.0))
def test_theoretical_tooth_touches_every_pin_at_every_pose(pins, K1, share, crank, size):
    r_p = 20.0 + 10.0 * size
    trochoid = Trochoid(pins, r_p, K1 * r_p / pins)
    r_rp = share * min(undercut_limit(trochoid), r_p * math.sin(math.pi / pins))
    found = gaps(ToothProfile(trochoid, r_rp), r_rp, mesh(trochoid, [crank, crank + 0.01], 2))
    np.testing.assert_allclose(found.gap, 0.0, atol=2e-14 * r_p)


@given(st.floats(1e-4, 2e-2), st.floats(0.0, 0.157))
def test_foot_is_where_the_normal_passes_through_the_pin(theoretical, amount, crank):
    tooth = modify(theoretical, Equidistant(amount), RadialMoving(-0.3 * amount))
    meshing = mesh(theoretical.trochoid, [crank])
    centre = meshing.pin_in_lobe(rotation=np.full((1, 1), 1e-5))
    foot, side = nearest_foot(tooth, centre, meshing.phase)
    points = tooth.at(foot, side)
    along = (np.conj(centre - points.position) * points.first).real / np.abs(points.first)
    np.testing.assert_allclose(along, 0.0, atol=1e-11)


def test_gaps_of_a_ground_tooth_are_the_nearest_distances(theoretical):
    tooth = modify(theoretical, Equidistant(0.05), RadialMoving(-0.0275))
    meshing = mesh(theoretical.trochoid, mesh_cycle(theoretical.trochoid, 3))
    found, centre = gaps(tooth, 3.0, meshing).gap, meshing.pin_in_lobe()
    for pose in range(3):
        searched = [signed_search(tooth, centre[pose, 0, k], meshing.phase[pose, 0, k], 3.0) for k in range(40)]
        np.testing.assert_allclose(found[pose, 0], searched, atol=1e-7)


@pytest.mark.parametrize("turned", [0.0, 0.003])
def test_lever_and_normal_are_the_derivatives_of_the_gap(theoretical, turned):
    tooth = modify(theoretical, Equidistant(0.01), DeformationCompensation(0.002))
    meshing = mesh(theoretical.trochoid, [0.04, 0.11], 2)
    here, h = gaps(tooth, 3.0, meshing, rotation=np.full((2, 2), turned)), 1e-6

    def slope(shift, turn):
        moved = [
            gaps(tooth, 3.0, meshing, np.full((2, 2), f * shift), np.full((2, 2), turned + f * turn)) for f in (1, -1)
        ]
        return (moved[0].gap - moved[1].gap) / (2.0 * h)

    # Central differences of 1e-6 mm: rounding of 1e-14 mm leaves 1e-8, curvature h²/R less.
    np.testing.assert_allclose(slope(0.0, h), -here.lever, atol=1e-5)
    np.testing.assert_allclose(slope(h + 0j, 0.0), -here.normal.real, atol=1e-7)
    np.testing.assert_allclose(slope(1j * h, 0.0), -here.normal.imag, atol=1e-7)


def test_first_order_gap_errs_with_the_square_of_the_amount(theoretical, rv40e):
    trochoid = rv40e.trochoid
    meshing = mesh(trochoid, mesh_cycle(trochoid, 3))
    psi = meshing.phase[:, 0]
    # Flank that closes, clear of root and tip where levers change fastest.
    inside = (psi > 0.2) & (psi < 2.8)
    amounts = np.array([1e-3, 2e-3, 4e-3, 8e-3])
    errors = []
    for e in amounts:
        tooth = modify(theoretical, Equidistant(e), RadialMoving(0.5 * e))
        take_up = e * (1.0 + 0.5 * math.sqrt(1.0 - 0.8125**2)) / trochoid.longest_lever
        exact = gaps(tooth, 3.0, meshing, rotation=take_up).gap[:, 0]
        first_order = take_up_gap(LoadCase(rv40e, tooth, 1.0), psi)
        errors.append(np.max(np.abs(exact - first_order)[inside]))
    assert np.polyfit(np.log(amounts), np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("pin", [0, 20])
def test_gap_to_the_ridge_that_a_flank_rotation_leaves(theoretical, pin):
    # Both flanks turned away from their pins leave a ridge at root and tip that nothing was taken from.
    tooth = modify(theoretical, Equidistant(0.03), FlankRotation(0.002 / theoretical.trochoid.longest_lever))
    found = gaps(tooth, 3.0, mesh(theoretical.trochoid, [0.0])).gap[0, 0, pin]
    assert found == pytest.approx(0.03, abs=1e-9)


@pytest.mark.parametrize("crank", [0.0, 0.003])
@pytest.mark.parametrize("changes", [(), (DeformationCompensation(0.002),)], ids=["smooth", "with corners"])
def test_gap_of_a_pin_beyond_the_centre_of_a_sharp_root(crank, changes):
    # K1 = 0.95: the pin-centre path has a radius of 4.3 µm in the root. A pin 10 µm further out is nearer
    # to both flanks than to the root itself.
    trochoid = Trochoid(40, 64.0, 1.52)
    drive = Drive(trochoid, 1.0, 10.0, 1, CentralEccentric(1e5))
    tooth = modify(drive.theoretical_profile, RadialMoving(0.01), *changes)
    meshing = mesh(trochoid, [crank])
    found, centre = gaps(tooth, 1.0, meshing).gap[0, 0], meshing.pin_in_lobe()[0, 0]
    searched = [signed_search(tooth, centre[k], meshing.phase[0, 0, k], 1.0) for k in range(40)]
    np.testing.assert_allclose(found, searched, atol=1e-6)
