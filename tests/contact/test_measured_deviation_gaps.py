"""Gaps of a tooth with a measured deviation: against 40 digits, a brute-force search, and known formulas.

The references put pin and disc in the plane themselves and know nothing of lobes: the disc is one closed curve of
z_c turns of the phase, its centre at a e^{iφ}, itself turned by −φ/z_c. The spline is scipy's own, taken by its
polynomials.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from cycloid_profile.contact.mesh import gaps, mesh, mesh_cycle
from cycloid_profile.errors import GeometryError
from cycloid_profile.geometry import ToothProfile, Trochoid
from cycloid_profile.modification import Equidistant, MeasuredDeviation, NormalDeviation, RadialMoving, modify

UM = 1e-3
PIN_RADIUS = 3.0
TROCHOID = Trochoid(40, 64.0, 1.3)
Z_P, Z_C = TROCHOID.pins, TROCHOID.lobes
K1 = TROCHOID.short_width_ratio


def spread(points, lobes):
    """Phases evenly round ``lobes`` lobes, from a root."""
    return np.linspace(0.0, 2.0 * math.pi * lobes, points, endpoint=False)


def uneven(points, lobes, rng):
    """Rising phases that are neither even nor begin at 0, as a measuring machine gives them."""
    step = 2.0 * math.pi * lobes / points
    return spread(points, lobes) + rng.uniform(-0.3, 0.3, points) * step + rng.uniform(-5.0, 5.0)


@dataclass(frozen=True)
class Curve:
    """The reference tooth: generating pin of ``radius`` and removals by spline, in numpy or in mpmath."""

    radius: float
    curves: tuple[NormalDeviation, ...]

    def splines(self):
        for curve in self.curves:
            period = 2.0 * math.pi * curve.lobes
            knots = np.append(curve.phase, curve.phase[0] + period)
            yield CubicSpline(knots, np.append(curve.removal, curve.removal[0]), bc_type="periodic"), period

    def removal(self, psi):
        return sum(spline((psi - spline.x[0]) % period + spline.x[0]) for spline, period in self.splines())

    def point(self, psi):
        """P(ψ) in the disc's frame (Eq. 7), ψ all round the disc."""
        slow, fast = np.exp(-1j * psi / Z_C), np.exp(-1j * psi * Z_P / Z_C)
        S = 1.0 / np.sqrt(1.0 + K1**2 - 2.0 * K1 * np.cos(psi))
        return 64.0 * slow - 1.3 * fast - (self.radius + self.removal(psi)) * S * (slow - K1 * fast)

    def exact_removal(self, psi):
        """The polynomial of the interval, in mpmath."""
        total = mp.mpf(0)
        for spline, period in self.splines():
            x = mp.mpf(psi) - mp.floor((mp.mpf(psi) - mp.mpf(spline.x[0])) / mp.mpf(period)) * mp.mpf(period)
            i = min(int(np.searchsorted(spline.x, float(x), side="right")) - 1, spline.x.size - 2)
            total += mp.polyval([mp.mpf(c) for c in spline.c[:, i]], x - mp.mpf(spline.x[i]))
        return total

    def exact_point(self, psi):
        a, k = mp.mpf(1.3), mp.mpf(1.3) * Z_P / 64
        slow, fast = mp.expj(-psi / Z_C), mp.expj(-psi * Z_P / Z_C)
        S = 1 / mp.sqrt(1 + k**2 - 2 * k * mp.cos(psi))
        return 64 * slow - a * fast - (mp.mpf(self.radius) + self.exact_removal(psi)) * S * (slow - k * fast)

    def tooth(self) -> ToothProfile:
        """The same tooth of the package."""
        tooth = ToothProfile(TROCHOID, self.radius)
        for curve in self.curves:
            tooth = MeasuredDeviation(curve).apply(tooth)
        return tooth

    def nearest(self, pin):
        """Phase and distance of the nearest point of the tooth, by a grid and a finer one about the best of it."""
        # The polar angle of a point gives its phase but for a z_c/r_p, some 0.8 rad.
        psi = -Z_C * np.angle(pin) + np.linspace(-2.0, 2.0, 16_001)
        for _ in range(2):
            distance = np.abs(pin - self.point(psi))
            best, step = psi[int(np.argmin(distance))], psi[1] - psi[0]
            psi = best + np.linspace(-2.0 * step, 2.0 * step, 2001)
        return best, float(np.min(distance))

    def exact_distance(self, pin):
        """The same with 40 digits: the foot is where the distance is stationary."""
        start, _ = self.nearest(pin)
        with mp.workdps(40):
            p = mp.mpc(pin)

            def slope(psi):
                return mp.re(mp.conj(p - self.exact_point(psi)) * mp.diff(self.exact_point, psi))

            foot = mp.findroot(slope, (mp.mpf(start), mp.mpf(start) + mp.mpf("1e-6")), tol=1e-50)
            assert abs(float(foot) - start) < 1e-5
            return float(abs(p - self.exact_point(foot)))


def pins_on_disc(crank, disc=0, discs=1, shift=0.0, turn=0.0, pin_shift=0.0):
    """All pins in the frame of one disc, x + iy."""
    own = crank + 2.0 * math.pi * disc / discs
    pin = 64.0 * np.exp(2j * math.pi * np.arange(Z_P) / Z_P) + pin_shift
    return (pin - 1.3 * np.exp(1j * own) - shift) * np.exp(-1j * (turn - own / Z_C))


def random_curves(kind):
    rng = np.random.default_rng(11)
    lobe = NormalDeviation(uneven(16, 1, rng), rng.uniform(-2.0 * UM, 2.0 * UM, 16), 1)
    disc = NormalDeviation(uneven(8 * Z_C, Z_C, rng), rng.uniform(-2.0 * UM, 2.0 * UM, 8 * Z_C), Z_C)
    return {"lobe": (lobe,), "disc": (disc,), "both": (lobe, disc)}[kind]


@pytest.mark.parametrize("kind", ["lobe", "disc", "both"])
def test_gaps_agree_with_a_forty_digit_foot_point(kind):
    curve = Curve(3.006, random_curves(kind))
    rng = np.random.default_rng(5)
    poses = 3
    crank = rng.uniform(-300.0, 300.0, poses)
    shift = rng.uniform(-0.01, 0.01, (poses, 2)) + 1j * rng.uniform(-0.01, 0.01, (poses, 2))
    turn = rng.uniform(-2e-4, 2e-4, (poses, 2))
    moved = 2.0 * UM * (rng.uniform(-1.0, 1.0, Z_P) + 1j * rng.uniform(-1.0, 1.0, Z_P))
    found = gaps(curve.tooth(), PIN_RADIUS, mesh(TROCHOID, crank, 2), shift, turn, moved)
    for i in range(poses):
        for j in range(2):
            pins = pins_on_disc(crank[i], j, 2, shift[i, j], turn[i, j], moved)
            for k in rng.integers(0, Z_P, 4):
                exact = curve.exact_distance(complex(pins[k])) - PIN_RADIUS
                # 64 mm and crank angles of 300 rad in double precision.
                assert found.gap[i, j, k] == pytest.approx(exact, abs=1e-11)


@pytest.mark.slow
@given(
    st.integers(6, 30),
    st.floats(0.2, 3.0),
    st.floats(0.0, 6.3),
    st.sampled_from([1, Z_C]),
    st.floats(-100.0, 100.0),
    st.floats(-2e-4, 2e-4),
)
@settings(max_examples=15)
def test_gap_of_a_wavy_tooth_is_that_of_the_nearest_foot(waves, amplitude, at, lobes, crank, turn):
    # Waves of a few micrometres hollow the flank more sharply than the pin: it rests on two crests and has a foot on
    # either side of every trough in its bed. Of two feet that are nearly as near the further may be taken: never more
    # than 0.15 µm, at most at one pin or two of a pose, and never a point that is nearer than the curve.
    phase = spread(12 * waves * lobes, lobes)
    curve = Curve(3.006, (NormalDeviation(phase, amplitude * UM * np.sin(waves * phase + at), lobes),))
    found = gaps(curve.tooth(), PIN_RADIUS, mesh(TROCHOID, [crank]), rotation=[[turn]]).gap[0, 0]
    searched = [curve.nearest(pin)[1] - PIN_RADIUS for pin in pins_on_disc(crank, turn=turn)]
    excess = found - searched
    assert np.all(excess > -1e-10)
    assert np.all(excess < 0.15 * UM)
    assert np.count_nonzero(excess > 1e-10) <= 2


@pytest.mark.parametrize("coarse", [False, True], ids=["alone", "with a curve of few points"])
def test_feet_on_waves_that_differ_from_lobe_to_lobe(coarse):
    # Of several feet the nearest is that of the pin's own lobe, whose waves no other has.
    phase = spread(288 * Z_C, Z_C)
    turn = np.random.default_rng(6).uniform(0.0, 6.3, Z_C)[(phase // (2.0 * math.pi)).astype(int)]
    waves = NormalDeviation(phase, 2.0 * UM * np.sin(24.0 * phase + turn), Z_C)
    curve = Curve(3.006, (waves, NormalDeviation(spread(12, 1), 0.2 * UM * np.sin(spread(12, 1)), 1))[: 1 + coarse])
    found = gaps(curve.tooth(), PIN_RADIUS, mesh(TROCHOID, [0.3])).gap[0, 0]
    excess = found - [curve.nearest(pin)[1] - PIN_RADIUS for pin in pins_on_disc(0.3)]
    assert np.all(excess > -1e-10)
    assert np.all(excess < 0.15 * UM)
    assert np.count_nonzero(excess > 1e-10) <= 2


def test_waves_do_give_several_feet():
    # The case above is what it says: many pins have another minimum of the distance within 3 µm of the least.
    phase = spread(12 * 24, 1)
    curve = Curve(3.006, (NormalDeviation(phase, 2.0 * UM * np.sin(24.0 * phase), 1),))
    several = 0
    for pin in pins_on_disc(0.3):
        foot, least = curve.nearest(pin)
        distance = np.abs(pin - curve.point(foot + np.linspace(-0.5, 0.5, 4001)))
        lowest = (distance[1:-1] < distance[:-2]) & (distance[1:-1] < distance[2:])
        several += np.count_nonzero(distance[1:-1][lowest] < least + 3.0 * UM) >= 2
    assert several >= 5


@pytest.mark.slow
@given(st.integers(0, Z_C - 1), st.floats(0.3, 5.9), st.floats(-300.0, 300.0), st.integers(0, 1))
def test_a_bump_is_felt_by_the_pin_that_works_there(lobe, at, crank, disc):
    # 2 µm on one radian of one lobe. Where each pin's foot lies on the disc follows from the geometry alone.
    phase = spread(24 * Z_C, Z_C)
    x = np.clip(phase - 2.0 * math.pi * lobe - at, -0.6, 0.6) / 0.6
    bump = NormalDeviation(phase, -2.0 * UM * np.cos(0.5 * math.pi * x) ** 2, Z_C)
    plain, bumped = Curve(3.006, ()), Curve(3.006, (bump,))
    meshing, pins = mesh(TROCHOID, [crank], 2), pins_on_disc(crank, disc, 2)
    found = gaps(bumped.tooth(), PIN_RADIUS, meshing).gap[0, disc]
    felt = found - gaps(plain.tooth(), PIN_RADIUS, meshing).gap[0, disc]
    expected = bumped.removal(np.array([plain_foot(pin) for pin in pins]))
    # To first order; next to the root, which fits the pin closely, the slope of the bump moves the foot.
    np.testing.assert_allclose(felt, expected, rtol=0.0, atol=0.15 * UM)
    assert np.count_nonzero(expected < -0.15 * UM) <= 2
    for k in np.flatnonzero(expected):
        assert found[k] == pytest.approx(bumped.nearest(pins[k])[1] - PIN_RADIUS, abs=1e-10)


def plain_foot(pin):
    """Foot on the tooth without deviation: the pin stands on its path but for the equal offset."""
    psi = -Z_C * np.angle(pin) + np.linspace(-2.0, 2.0, 4001)
    path = 64.0 * np.exp(-1j * psi / Z_C) - 1.3 * np.exp(-1j * psi * Z_P / Z_C)
    return psi[int(np.argmin(np.abs(pin - path)))]


def test_every_lobe_meets_its_pins_in_turn():
    # A bump on one lobe comes back to a given pin after z_c turns of the crank and not before.
    phase = spread(24 * Z_C, Z_C)
    bump = NormalDeviation(phase, np.where(np.abs(phase - 2.0 * math.pi * 5.5) < 2.0, -2.0 * UM, 0.0), Z_C)
    plain, bumped = Curve(3.006, ()).tooth(), Curve(3.006, (bump,)).tooth()
    meshing = mesh(TROCHOID, 2.0 * math.pi * np.arange(2 * Z_C) + 0.4)
    felt = (gaps(bumped, PIN_RADIUS, meshing).gap - gaps(plain, PIN_RADIUS, meshing).gap)[:, 0]
    times = np.sum(np.abs(felt) > 1.0 * UM, axis=0)
    # Pins that stand on the bump's part of a lobe at this crank angle: once in z_c turns each.
    assert set(times) == {0, 2}
    np.testing.assert_allclose(felt[Z_C:], felt[:Z_C], rtol=0.0, atol=1e-12)


@given(st.floats(-0.02, 0.05), st.sampled_from([1, Z_C]), st.floats(0.0, 6.2))
def test_a_constant_deviation_is_an_equidistant_change(amount, lobes, crank):
    constant = NormalDeviation(spread(8 * lobes, lobes), np.full(8 * lobes, amount), lobes)
    tooth = MeasuredDeviation(constant).apply(ToothProfile(TROCHOID, PIN_RADIUS))
    ground = modify(ToothProfile(TROCHOID, PIN_RADIUS), Equidistant(amount))
    meshing = mesh(TROCHOID, [crank], 2)
    one, other = gaps(tooth, PIN_RADIUS, meshing, rotation=1e-5), gaps(ground, PIN_RADIUS, meshing, rotation=1e-5)
    np.testing.assert_allclose(one.gap, other.gap, rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(one.lever, other.lever, rtol=0.0, atol=1e-7)


def radial_moving(amount):
    return RadialMoving(amount).apply(ToothProfile(TROCHOID, PIN_RADIUS + 0.006)), 0.0


def generating_eccentricity(amount):
    return ToothProfile(Trochoid(Z_P, 64.0, 1.3 + amount), PIN_RADIUS + 0.006), 0.0


def rigid_rotation(amount):
    # h = a z_c β sinψ S with β = amount/(a z_c), which is a disc turned clockwise by β.
    return ToothProfile(TROCHOID, PIN_RADIUS + 0.006), -amount / TROCHOID.longest_lever


REMOVAL = {
    radial_moving: lambda psi, S: (1.0 - K1 * np.cos(psi)) * S,
    generating_eccentricity: lambda psi, S: (np.cos(psi) - K1) * S,
    rigid_rotation: lambda psi, S: np.sin(psi) * S,
}


@pytest.mark.parametrize("cause", REMOVAL, ids=lambda cause: cause.__name__)
def test_sampled_formula_gives_the_gaps_of_its_cause_to_second_order(cause):
    # The removal of each cause is its first order in the amount: what is left goes with the square.
    phase = spread(1024, 1)
    S = 1.0 / np.sqrt(1.0 + K1**2 - 2.0 * K1 * np.cos(phase))
    meshing = mesh(TROCHOID, mesh_cycle(TROCHOID, 5))
    amounts, errors = np.array([2e-3, 4e-3, 8e-3, 16e-3]), []
    for amount in amounts:
        curve = NormalDeviation(phase, amount * REMOVAL[cause](phase, S), 1)
        sampled = MeasuredDeviation(curve).apply(ToothProfile(TROCHOID, PIN_RADIUS + 0.006))
        tooth, turn = cause(amount)
        # Pins off the root, where the tooth is bent most and orders settle later.
        away = np.abs(meshing.phase) > 0.25
        error = gaps(sampled, PIN_RADIUS, meshing).gap - gaps(tooth, PIN_RADIUS, meshing, rotation=turn).gap
        errors.append(np.max(np.abs(error[away])))
    assert np.polyfit(np.log(amounts), np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.15)
    assert errors[0] < 0.01 * amounts[0]


@given(st.integers(1, 2), st.floats(-500.0, 500.0))
def test_a_curve_repeats_after_its_period_and_not_before(whole, psi):
    lobes = 1 if whole == 1 else Z_C
    rng = np.random.default_rng(3)
    curve = NormalDeviation(uneven(10 * lobes, lobes, rng), rng.uniform(-UM, UM, 10 * lobes), lobes)

    def value(at):
        return float(curve.derivatives(np.array([at]), np.ones(1), TROCHOID).value[0])

    assert value(psi + curve.period) == pytest.approx(value(psi), abs=1e-12)
    assert value(psi) == pytest.approx(float(Curve(3.0, (curve,)).removal(psi)), abs=1e-12)


GOOD = spread(8, 1)


@pytest.mark.parametrize(
    ("phase", "removal", "value", "limit", "remedy"),
    [
        (GOOD, np.where(np.arange(8) == 2, math.nan, 0.0), "point 3 of 8", "is not finite", "leave such points out"),
        (GOOD, np.where(np.arange(8) == 7, math.inf, 0.0), "point 8 of 8", "is not finite", "leave such points out"),
        (
            np.where(np.arange(8) == 4, math.nan, GOOD),
            np.zeros(8),
            "point 5 of 8",
            "is not finite",
            "leave such points",
        ),
        (GOOD[::-1], np.zeros(8), "5.49779 to 0 rad", "does not rise", "sort the points"),
        (np.array([0.0, 1.0, 1.0, 2.0]), np.zeros(4), "0 to 2 rad", "does not rise", "sort the points"),
        (
            np.linspace(0.0, 2.0 * math.pi, 8),
            np.zeros(8),
            "0 to 6.28319 rad",
            "within one period",
            "leave the repeated",
        ),
        (np.linspace(0.0, 9.0, 8), np.zeros(8), "0 to 9 rad", "within one period of 6.28319 rad", "sort the points"),
        (GOOD[:3], np.zeros(3), "(3,)", "at least 4 points", "one removal for each phase"),
        (np.array([]), np.array([]), "(0,)", "at least 4 points", "one removal for each phase"),
        (GOOD, np.zeros(7), "(8,) and removals (7,)", "is no curve", "one removal for each phase"),
        (GOOD.reshape(2, 4), np.zeros((2, 4)), "(2, 4)", "is no curve", "one removal for each phase"),
    ],
)
def test_points_that_are_no_curve_are_refused(phase, removal, value, limit, remedy):
    with pytest.raises(GeometryError) as refused:
        NormalDeviation(phase, removal, 1)
    error = refused.value
    assert "deviation" in error.what
    assert value in str(error.value)
    assert limit in error.limit
    assert remedy in error.remedy
    assert str(error) == f"{error.what} = {error.value} {error.limit}: {error.remedy}"


@pytest.mark.parametrize("lobes", [2, 38, 40])
def test_a_curve_over_another_number_of_lobes_is_refused(lobes):
    curve = NormalDeviation(spread(8 * lobes, lobes), np.zeros(8 * lobes), lobes)
    with pytest.raises(GeometryError) as refused:
        MeasuredDeviation(curve).apply(ToothProfile(TROCHOID, PIN_RADIUS))
    error = refused.value
    assert error.value == lobes
    assert "39 of the disc" in error.limit
    assert "one lobe or over the whole disc" in error.remedy


@pytest.mark.parametrize("lobes", [1, Z_C])
def test_a_deviation_that_turns_the_tooth_back_is_refused(lobes):
    # 2 mm more than the pin's 3 mm undercut this tooth, whose limit is 4.61 mm.
    deep = NormalDeviation(spread(8 * lobes, lobes), np.full(8 * lobes, 2.0), lobes)
    with pytest.raises(GeometryError, match=r"5\.0000 mm makes the tooth curve run backwards.*smaller"):
        MeasuredDeviation(deep).apply(ToothProfile(TROCHOID, PIN_RADIUS))
