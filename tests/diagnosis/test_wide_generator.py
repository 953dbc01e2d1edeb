"""Options of the blind generator that the package does not share: laws, bodies, shapes, drives, ways to measure."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.measurement import parse_measurement
from cycloid_profile.rig import measurement_residual
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import (
    KINDS,
    OUTSIDE,
    REDUCERS,
    Body,
    Hidden,
    Noise,
    PowerLaw,
    Reducer,
    ReferenceDepth,
    Roark,
    Stage,
    draw_wide,
    loop,
    lost_motion,
    scan,
    spec_text,
    transmission_error,
)
from tests.diagnosis.blind.contact import at_rated
from tests.diagnosis.blind.friction import left_over
from tests.diagnosis.blind.removals import Blank
from tests.diagnosis.blind.tooth import ground
from tests.diagnosis.blind.wide import NOISES, SIZES, WORKSHOP, typical

LAWS = (Roark(), PowerLaw(10.0 / 9.0), PowerLaw(1.2, 0.9), PowerLaw(1.0), ReferenceDepth(5.0))
DRIVES = list(REDUCERS.items())


@pytest.mark.parametrize("law", LAWS, ids=repr)
@pytest.mark.parametrize("seat", [0.0, 2e-6])
def test_force_and_stiffness_are_slopes_of_the_energy(law, seat):
    delta = np.linspace(1e-4, 2e-2, 40)
    one = law.of(Reducer(), np.full(40, -0.05), np.full(40, 3.0), seat)
    h = 1e-7
    ahead, back = one.answer(delta + h), one.answer(delta - h)
    force, stiffness, _ = one.answer(delta)
    np.testing.assert_allclose((ahead[2] - back[2]) / (2.0 * h), force, rtol=1e-5)
    np.testing.assert_allclose((ahead[0] - back[0]) / (2.0 * h), stiffness, rtol=1e-4)
    assert all(np.all(of == 0.0) for of in one.answer(-delta))


@pytest.mark.parametrize("exponent", [1.0, 10.0 / 9.0, 1.25])
def test_power_laws_deflect_like_roark_at_the_rated_load(exponent):
    load, approach = at_rated(Reducer())
    force, _, _ = PowerLaw(exponent).of(Reducer(), np.zeros(1), np.full(1, 3.0), 0.0).answer(np.array([approach]))
    assert force[0] == pytest.approx(load)


def test_elastic_discs_give_and_have_a_rigid_limit():
    load, approach = at_rated(Reducer())
    output, torque = 2.0 * np.pi * np.arange(24) / 24, np.full(24, 412e3)
    rigid, almost, soft = (
        Stage(Reducer(), (), Roark(), Body(share * approach / load, 2.0)).twist(output, torque)
        for share in (0.0, 1e-6, 0.25)
    )
    np.testing.assert_allclose(almost, rigid, rtol=1e-6)
    assert 1.03 < np.mean(soft) / np.mean(rigid) < 1.2


def test_a_push_is_that_of_the_other_forces():
    """Pins in line push each other by c exp(−d/reach) F; a pin does not push itself, one at right angles nobody."""
    body = Body(own=1e-6, reach=2.0)
    pins, normal = np.array([[0, 1, 39, 20]]), np.array([[1.0 + 0j, 1.0, 1.0, 1j]])
    push = body.push(pins, 40, normal, np.array([[100.0, 0.0, 50.0, 70.0]]))
    near, next_but_one = math.exp(-0.5), math.exp(-1.0)
    np.testing.assert_allclose(push[0], [50e-6 * near, 1e-4 * near + 50e-6 * next_but_one, 1e-4 * near, 0.0])


@pytest.mark.parametrize(("name", "reducer"), DRIVES, ids=[name for name, _ in DRIVES])
def test_the_package_reads_every_drive_and_the_same_tooth(name, reducer):
    drawn = as_built_reducer(parse_spec(spec_text(reducer)))
    read = parse_measurement(scan(reducer, points=2000, turn_deg=100.0, anticlockwise=True), f"{name}.csv")
    assert measurement_residual(drawn, read, 0).rms < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("reducer", REDUCERS.values(), ids=list(REDUCERS))
def test_rigid_benches_of_every_drive_agree_with_the_rig(reducer):
    """Same law and springs, other equations: what is left is rounding and registration."""
    drawn = as_built_reducer(parse_spec(spec_text(reducer)))
    stage, rated = Stage(reducer, ()), reducer.rated_torque_nm
    texts = {
        "te": (transmission_error(reducer, torque_nm=rated, rows=197, stage=stage), 0.01),
        "te_light": (transmission_error(reducer, torque_nm=0.03 * rated, rows=197, stage=stage), 0.01),
        "lost_motion": (lost_motion(reducer, torque_nm=0.03 * rated, rows=97, stage=stage), 4e-4),
    }
    for file, (text, limit) in texts.items():
        assert measurement_residual(drawn, parse_measurement(text, f"{file}.csv"), 0).rms < limit, file
    read = parse_measurement(loop(reducer, rows=90, output_angle_deg=33.0, stage=stage), "loop.csv")
    residual = measurement_residual(drawn, read, 0).residual[np.abs(read["torque_nm"]) > 0.06 * rated]
    assert np.std(residual) < 4e-4


def test_noise_of_the_other_classes_has_the_stated_parameters():
    draw = np.random.default_rng(8)
    column = Noise(0.3, rho=0.7, rho2=-0.4).draw(200_000, draw)
    assert np.std(column) == pytest.approx(0.3, rel=0.02)
    assert np.corrcoef(column[1:], column[:-1])[0, 1] == pytest.approx(0.7 / 1.4, abs=0.02)
    still = Noise(1e-3, drift=1000.0).draw(5000, draw)
    assert np.std(still) == pytest.approx(1.0, rel=0.01)
    assert np.std(np.diff(still)) < 0.01
    read = Noise(0.2, quantum=2.0).read(np.linspace(0.0, 3.0, 1000), draw)
    np.testing.assert_allclose(read / 0.4, np.round(read / 0.4), atol=1e-9)


def test_stribeck_friction_turns_smoothly_and_breaks_away_above_its_sliding_value():
    torque = np.interp(np.linspace(0.0, 5.0, 4001), [0.0, 1.0, 3.0, 5.0], [0.0, 100.0, -100.0, 100.0])
    friction = torque - left_over(torque, 8.0, 0.0, "stribeck")
    assert np.median(np.abs(friction)) == pytest.approx(8.0, rel=0.01)
    assert 8.4 < np.max(np.abs(friction)) < 9.3
    turn = np.argmax(torque)
    assert friction[turn] == 0.0
    assert np.all(np.diff(np.abs(friction[turn : turn + 4])) > 0.0)


def test_wear_grows_with_a_power_of_the_lever_and_spares_the_other_flank():
    psi = np.linspace(-math.pi, math.pi, 4001)
    plain = Reducer()
    drawing = ground(plain, [], 1).points(psi)
    depth = {}
    for exponent in (1.0, 1.5):
        worn = [Hidden("flank_wear", {"amount_um": 5.0, "x_exponent": exponent})]
        depth[exponent] = np.abs(ground(plain, worn, 1).points(psi) - drawing) * 1e3
        assert np.max(depth[exponent]) == pytest.approx(5.0, rel=1e-3)
        assert np.max(depth[exponent][psi < 0.0]) < 1e-9
    part = depth[1.0] > 0.1
    np.testing.assert_allclose(depth[1.5][part] / 5.0, (depth[1.0][part] / 5.0) ** 1.5, rtol=1e-3)


@pytest.mark.parametrize("angle", [0.0, 2.0, 5.0])
def test_wheel_wear_may_jump_anywhere(angle):
    one = Hidden("wheel_wear_drift", {"amount_um": 4.0, "first_lobe": 5, "x_start_rad": angle, "x_blend_rad": 0.2})
    psi = np.linspace(0.0, Reducer().period, 40_000, endpoint=False)
    low = np.abs(ground(Reducer(), [one], 1).points(psi) - ground(Reducer(), [], 1).points(psi))
    jump = psi[np.argmax(np.abs(np.diff(low)))]
    assert jump == pytest.approx(2.0 * math.pi * 4 - math.pi + angle, abs=0.25)


@pytest.mark.parametrize("kind", ["polar", "arc"])
def test_every_clock_takes_a_turn_and_never_runs_back(kind):
    blank = Blank(Reducer(), 0.0, Reducer().short_width_ratio)
    psi = np.linspace(-math.pi, math.pi, 3001)
    clock, even = blank.clock(kind, psi), blank.along(psi)
    np.testing.assert_allclose(clock[[0, 1500, -1]], even[[0, 1500, -1]], atol=1e-6)
    assert np.all(np.diff(clock) > 0.0)
    assert np.max(np.abs(clock - even)) > 0.01 * 2.0 * math.pi / 39
    # Even on its own clock: equal steps of polar angle, or of arc.
    z = ground(replace(Reducer(), equidistant_um=0.0), [], 1).points(psi)
    own = -np.unwrap(np.angle(z)) if kind == "polar" else np.concatenate([[0.0], np.cumsum(np.abs(np.diff(z)))])
    ratio = np.diff(own) / np.diff(clock)
    np.testing.assert_allclose(ratio, np.mean(ratio), rtol=5e-3)


def test_a_seed_determines_a_wide_case():
    first, again, other = (draw_wide(seed, effects=2) for seed in (4, 4, 5))
    assert first.files == again.files
    assert first.truth == again.truth
    assert first.forms == again.forms
    assert first.files != other.files


@pytest.mark.slow
def test_wide_scans_have_all_forms_and_sizes_of_the_workshop():
    forms: Counter[tuple[str, str]] = Counter()
    for seed in range(60):
        case = draw_wide(seed, effects=1)
        (one,) = case.truth
        size = abs(one[KINDS[one.name].key]) / typical(one.name, case.reducer)
        assert SIZES[0] - 1e-9 <= size <= SIZES[1] + 1e-9
        forms.update(case.forms.items())
    assert {form for kind, form in forms if kind == "reducer"} == set(REDUCERS)
    assert {form for kind, form in forms if kind == "noise"} == set(NOISES)
    assert set(WORKSHOP) <= {*KINDS, *OUTSIDE}
    for name in (*KINDS, *OUTSIDE):
        assert typical(name, Reducer()) > 0.0


def test_a_central_eccentric_has_no_errors_of_crank_shafts():
    seen = {case.truth[0].name for case in (draw_wide(s, files=("scan",), effects=1) for s in range(12))}
    assert seen <= set(KINDS)
    eccentric = REDUCERS["19 lobes, eccentric"]
    assert "[drive.eccentric]" in spec_text(eccentric)
    assert "[drive.first_stage]" not in spec_text(eccentric)
    assert eccentric.crank_per_carrier == 0.0
