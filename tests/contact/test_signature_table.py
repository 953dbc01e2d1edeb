"""Signatures of single errors against published numbers: transmission error, lost motion and orders of the RV-40E.

Source: a table of effects computed by direct numerical geometry, 3 µm each unless said, for 6 µm equidistant,
b = 11.5 mm, T = 412 N·m, two discs on three cranks with bearings of 4e5 N/mm. "3 %" and "100 %" are shares of the
torque. Transmission error (TE) is peak to peak in ″; lost motion (LM) is the angle between ±3 % in ′, its mean and
its peak to peak over the output turn.

Tolerances. LM: 10 % of the table, whose numbers have two or three digits; peak to peak below 0.1′ is given to
0.001′. TE at 3 %: 10 %. TE at 100 %: 10 % and 0.16″, because the table's mesh ripple rides on every row and is a large
part of those in which the error itself has almost gone. Its drive without errors shows 0.10″ at 3 % and 0.31″ at
100 %, this package's 0.06″ and 0.16″. The reason is known: where the tooth is straight, Roark's logarithm takes |ρ|
without bound and a pin that passes there shows as a spike, unless |ρ| is capped, here at r_p. With the cap lifted this
package has 0.08″ and 0.3″, and the rows at 100 % agree within 10 % and 0.07″; both are tested. A measured sample of
such a drive at 100 % shows 0.078″ ± 0.006″ at the mesh order 1560; with the cap it is 0.071″ here.

Shapes the table does not give, "random pins", "one tooth high" and "every tooth", get weaker tests: the published
number must lie between those of shapes that fit the words.

By symmetry a housing error repeats after 1/39 of the output turn and every other one after 1/40
(``test_effect_orders``): one such part at the density of 12 480 poses a turn stands for all. Slow tests go all round.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pytest

from cycloid_profile.contact import LoadCase
from cycloid_profile.contact.bodies import NO_DEVIATIONS, PartDeviations
from cycloid_profile.contact.mesh import output_turn
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.geometry import Cranks
from cycloid_profile.modification import Equidistant, MeasuredDeviation, NormalDeviation, modify
from cycloid_profile.units import ARCMIN, ARCSEC

UM = 1e-3
PINS, LOBES = 40, 39
POSES = 12_480  # eight a mesh period, and whole numbers in 1/39 and 1/40 of a turn
HOUSING, CARRIER = LOBES, PINS
PIN_ANGLE = 2.0 * math.pi * np.arange(PINS) / PINS
OUTWARDS = np.exp(1j * PIN_ANGLE)
# What the mesh may add to a row at 100 % with |ρ| capped in Roark's logarithm, and without [″]; said above.
CAPPED, UNCAPPED = 0.16, 0.07


class Signature(NamedTuple):
    """TE over the solved part of the turn at 3 % and at 100 %, and LM there [″, ″, ′]; how often it repeats a turn."""

    light: np.ndarray
    full: np.ndarray
    lost_motion: np.ndarray
    repeats: int

    def orders(self, values, count=1) -> list[int]:
        """The strongest orders per output turn, strongest first."""
        amplitude = np.abs(np.fft.rfft(values - np.mean(values)))
        return [int(k) * self.repeats for k in np.argsort(amplitude)[::-1][:count]]


@dataclass(frozen=True)
class Bench:
    """A drive whose parts are off; solves both directions and full load as one batch."""

    case: LoadCase
    tolerance: float = 1e-9

    def measure(self, reducer: PartDeviations, repeats: int, poses: int = POSES) -> Signature:
        crank = output_turn(self.case.drive.trochoid, poses)[: poses // repeats]
        torque = np.array([0.03, -0.03, 1.0]) * self.case.torque
        solver = StageEquilibrium(tolerance=self.tolerance, deviations=reducer)
        state = solver.at(self.case, np.tile(crank, 3), np.repeat(torque, crank.size))
        # Where scattered pins overlap before any load there is no first touch, but a balance all the same.
        assert np.max(state.residual) < 2.0 * self.tolerance
        light, back, full = state.rotation.reshape(3, -1)
        return Signature(light / ARCSEC, full / ARCSEC, (light - back) / ARCMIN, repeats)

    def tooth(self, removal, ahead=0.0, points_per_lobe=24):
        """The tooth with ``removal(t)`` [mm] of the angle t + ahead along the disc, rising with the phase."""
        phase = np.linspace(0.0, 2.0 * math.pi * LOBES, points_per_lobe * LOBES, endpoint=False)
        curve = NormalDeviation(phase, removal(phase / LOBES + ahead), LOBES)
        return MeasuredDeviation(curve).apply(self.case.profile)

    def one_disc(self, removal, points_per_lobe=24) -> PartDeviations:
        return PartDeviations(teeth=(self.tooth(removal, 0.0, points_per_lobe), self.case.profile))

    def both_discs(self, removal) -> PartDeviations:
        """The same on both discs as the carrier sees them: disc 2 is mounted half a lobe on."""
        return PartDeviations(teeth=(self.tooth(removal), self.tooth(removal, math.pi / LOBES)))

    def every_lobe(self, removal) -> PartDeviations:
        phase = np.linspace(0.0, 2.0 * math.pi, 96, endpoint=False)
        tooth = MeasuredDeviation(NormalDeviation(phase, removal(phase), 1)).apply(self.case.profile)
        return PartDeviations(teeth=(tooth, tooth))


@pytest.fixture(scope="module")
def bench(rv40e, rated_torque) -> Bench:
    return Bench(LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), rated_torque))


def crank_one(value, discs=1):
    """An error of the eccentric or bore of crank 1, in the first disc or in both."""
    shift = np.zeros((2, 3), dtype=np.complex128)
    shift[:discs, 0] = value
    return shift


def runout(t):
    return 3.0 * UM * np.cos(t)


def oval(t):
    return 3.0 * UM * np.cos(2.0 * t)


class Row(NamedTuple):
    """A row of the table: parts, where they are fixed, TE p-p at 3 % and 100 %, orders at 3 %, LM mean, p-p, order."""

    parts: object
    fixed: int
    te: tuple[float, float]
    orders: tuple[int, ...]
    lost_motion: tuple[float, float]
    lost_motion_order: int | None = None


TABLE = {
    "pin ring eccentric": Row(
        lambda _: PartDeviations(pin_shift=np.full(PINS, 3.0 * UM + 0j)),
        HOUSING,
        (7.6, 1.2),
        (78, 156),
        (0.606, 0.249),
        78,
    ),
    "pin ring oval": Row(
        lambda _: PartDeviations(pin_shift=3.0 * UM * np.cos(2.0 * PIN_ANGLE) * OUTWARDS),
        HOUSING,
        (12.2, 11.5),
        (78,),
        (0.750, 0.132),
        156,
    ),
    "pin cumulative pitch": Row(
        lambda _: PartDeviations(pin_shift=3j * UM * np.sin(PIN_ANGLE) * OUTWARDS),
        HOUSING,
        (6.2, 0.7),
        (78,),
        (0.675, 0.058),
    ),
    "one pin +3 µm": Row(
        lambda _: PartDeviations(pin_oversize=np.where(np.arange(PINS) == 5, 3.0 * UM, 0.0)),
        HOUSING,
        (8.6, 1.4),
        (78, 156, 234, 312),
        (0.741, 0.143),
        156,
    ),
    "disc runout, one disc": Row(
        lambda bench: bench.one_disc(runout), CARRIER, (11.8, 11.8), (40,), (0.744, 0.338), 40
    ),
    "disc runout, both": Row(lambda bench: bench.both_discs(runout), CARRIER, (6.8, 1.2), (80,), (0.600, 0.061)),
    "disc oval, both": Row(lambda bench: bench.both_discs(oval), CARRIER, (17.8, 17.9), (80,), (0.651, 0.180)),
    "crank eccentricity, one disc": Row(
        lambda _: PartDeviations(eccentric_shift=crank_one(3.0 * UM)), CARRIER, (5.8, 5.7), (40,), (0.831, 0.040), 80
    ),
    "crank eccentricity, both": Row(
        lambda _: PartDeviations(eccentric_shift=crank_one(3.0 * UM, 2)),
        CARRIER,
        (4.0, 0.45),
        (80,),
        (0.775, 0.132),
        80,
    ),
    "crank hole, one disc": Row(
        lambda _: PartDeviations(bore_shift=crank_one(3j * UM)), CARRIER, (0.9, 4.1), (40,), (0.803, 0.105)
    ),
    # 10 µm of runout on the planet's pitch radius of 27 mm.
    "planet runout 10 µm": Row(
        lambda _: PartDeviations(crank_lead=np.array([10.0 * UM / 27.0, 0.0, 0.0], dtype=np.complex128)),
        CARRIER,
        (1.3, 1.5),
        (40,),
        (0.851, 0.0),
    ),
}


def check(found: Signature, row: Row, ripple: float = CAPPED) -> None:
    light, full = row.te
    assert np.ptp(found.light) == pytest.approx(light, rel=0.1)
    assert np.ptp(found.full) == pytest.approx(full, abs=0.1 * full + ripple)
    assert found.orders(found.light, len(row.orders)) == list(row.orders)
    mean, spread = row.lost_motion
    assert np.mean(found.lost_motion) == pytest.approx(mean, rel=0.1)
    # The mesh leaves 0.0014′ of its own.
    assert np.ptp(found.lost_motion) == pytest.approx(spread, abs=0.1 * spread + 0.0015)
    if row.lost_motion_order is not None:
        assert found.orders(found.lost_motion) == [row.lost_motion_order]


@pytest.fixture
def no_cap(monkeypatch):
    """|ρ| of the tooth up to ten metres."""
    capped = LoadCase.line_contact
    monkeypatch.setattr(LoadCase, "line_contact", lambda case, bend: replace(capped(case, bend), radius_cap=1e4))


def test_nominal_drive(bench):
    nominal = bench.measure(NO_DEVIATIONS, CARRIER)
    assert np.ptp(nominal.light) == pytest.approx(0.06, abs=0.005)
    assert np.ptp(nominal.full) == pytest.approx(0.16, abs=0.01)
    assert np.mean(nominal.lost_motion) == pytest.approx(0.851, abs=5e-4)
    assert nominal.orders(nominal.full) == [PINS * LOBES]
    amplitude = 2.0 * np.abs(np.fft.rfft(nominal.full))[LOBES] / nominal.full.size
    # The measured sample's 0.078″: 3000 readings with a noise of 0.15″ are good to 0.006″.
    assert amplitude == pytest.approx(0.078, abs=0.01)


@pytest.mark.usefixtures("no_cap")
def test_lifted_cap_gives_the_published_ripple(bench):
    # A spike is as narrow as the curvature is close to zero: how much of it is seen depends on the poses.
    nominal = bench.measure(NO_DEVIATIONS, CARRIER, 40 * PINS * LOBES)
    assert 0.07 < np.ptp(nominal.light) < 0.11
    assert np.ptp(nominal.full) == pytest.approx(0.31, abs=0.04)


@pytest.mark.parametrize("name", TABLE)
def test_row_of_the_table(bench, name):
    row = TABLE[name]
    check(bench.measure(row.parts(bench), row.fixed), row)


def test_crank_bearing_play(bench):
    # Radial play of 5 µm: LM 1.79′, flat; TE negligible.
    drive = replace(bench.case.drive, support=Cranks(3, 36.0, 4.0e5, 5.0 * UM))
    found = Bench(replace(bench.case, drive=drive)).measure(NO_DEVIATIONS, CARRIER)
    assert np.mean(found.lost_motion) == pytest.approx(1.79, abs=5e-3)
    assert np.ptp(found.lost_motion) < 0.01 * 1.79
    # Against 1.2″ and more of the errors that count; of the order of the nominal ripple.
    assert max(np.ptp(found.light), np.ptp(found.full)) < 0.31


def test_disc_warmer_than_the_housing(bench):
    # 1 K at 11.5e-6/K: the disc is scaled, the flank grows by Re(n̄ P)·α ΔT.
    nominal = bench.measure(NO_DEVIATIONS, CARRIER)

    def growth(phase):
        points = bench.case.profile.at(phase)
        return -11.5e-6 * (np.conj(points.normal) * points.position).real

    found = bench.measure(bench.every_lobe(growth), CARRIER)
    change = np.mean(found.lost_motion) - np.mean(nominal.lost_motion)
    assert change == pytest.approx(-0.053, abs=1e-3)
    # No TE of its own: what is left is the mesh ripple.
    assert np.ptp(found.light) < 0.10
    assert np.ptp(found.full) < 0.31
    assert found.orders(found.full) == [PINS * LOBES]


def test_random_pins_lie_in_the_range_of_ten_scatters(bench):
    # "Random pins, σ = 2 µm" gives neither the numbers drawn nor their direction. Scatter in x and y with σ = 2 µm
    # each, ten times: every published number lies inside, and 78, 156 and 234 turn up among the strongest three orders.
    te_light, te_full, mean, spread, orders = [], [], [], [], set()
    for seed in range(10):
        rng = np.random.default_rng(seed)
        shift = rng.normal(0.0, 2.0 * UM, PINS) + 1j * rng.normal(0.0, 2.0 * UM, PINS)
        found = bench.measure(PartDeviations(pin_shift=shift), HOUSING, POSES // 4)
        te_light.append(np.ptp(found.light))
        te_full.append(np.ptp(found.full))
        mean.append(np.mean(found.lost_motion))
        spread.append(np.ptp(found.lost_motion))
        orders.update(found.orders(found.light, 3))
    for values, published in ((te_light, 6.9), (te_full, 5.5), (mean, 0.516), (spread, 0.279)):
        assert min(values) < published < max(values)
    assert {78, 156, 234} <= orders
    # Scatter lowers lost motion: the pin that stands out most takes the clearance.
    assert max(mean) < 0.851


def bump_on_lobe_ten(shape):
    """Removal that adds 3 µm·shape(x) on one lobe, x its phase from root to root."""

    def removal(t):
        x = t * LOBES - 2.0 * math.pi * 10.0
        return np.where((x > 0.0) & (x < 2.0 * math.pi), -3.0 * UM * shape(np.clip(x, 0.0, 2.0 * math.pi)), 0.0)

    return removal


def test_one_tooth_high_lies_between_a_hump_and_a_plateau(bench):
    # The table does not say how a high tooth runs into its neighbours. A hump that rises from root to tip keeps its
    # flanks low where pins work; a plateau over the whole lobe between two roots does not. Published: TE 5.3″/1.2″,
    # LM 0.814′/0.136′, a comb of 40.
    def measured(shape):
        return bench.measure(bench.one_disc(bump_on_lobe_ten(shape), 48), CARRIER)

    hump = measured(lambda x: np.sin(0.5 * x))
    plateau = measured(lambda x: np.minimum(1.0, 6.0 * np.sin(0.5 * x)))
    for name, value, ripple in (("light", 5.3, 0.0), ("full", 1.2, CAPPED), ("lost_motion", 0.136, 0.0)):
        low, high = (np.ptp(getattr(found, name)) for found in (hump, plateau))
        assert low < value < high + ripple
    assert np.mean(plateau.lost_motion) < 0.814 < np.mean(hump.lost_motion)
    for found in (hump, plateau):
        # A comb: 40, 80, 120 … falling.
        assert found.orders(found.light, 4) == [40, 80, 120, 160]


@pytest.mark.parametrize("harmonic", [2, 3, 4, 5])
def test_a_form_that_all_teeth_share_shows_the_mesh_order_alone(bench, harmonic):
    # 2 µm on every tooth; the table says 0.1–0.5″, 1560, mean shift only, without the shape. Harmonics of the tooth.
    found = bench.measure(bench.every_lobe(lambda phase: 2.0 * UM * np.cos(harmonic * phase)), CARRIER)
    for values in (found.light, found.full):
        assert all(order % (PINS * LOBES) == 0 for order in found.orders(values, 2))
    assert 0.02 < np.ptp(found.light) < 0.5
    assert np.ptp(found.lost_motion) < 0.02


@pytest.mark.slow
@pytest.mark.parametrize("name", TABLE)
def test_part_of_a_turn_stands_for_the_whole(bench, name):
    row, poses = TABLE[name], PINS * LOBES
    reducer = row.parts(bench)
    part, whole = bench.measure(reducer, row.fixed, poses), bench.measure(reducer, 1, poses)
    for values in ("light", "full", "lost_motion"):
        repeated = np.tile(getattr(part, values), row.fixed)
        np.testing.assert_allclose(getattr(whole, values), repeated, rtol=0.0, atol=1e-5)


@pytest.mark.slow
@pytest.mark.usefixtures("no_cap")
@pytest.mark.parametrize("name", TABLE)
def test_row_of_the_table_with_the_cap_lifted(bench, name):
    # 25 poses a mesh period. Newton ends further off next to a spike.
    row = TABLE[name]
    check(replace(bench, tolerance=1e-6).measure(row.parts(bench), row.fixed, 25 * PINS * LOBES), row, UNCAPPED)
