"""Independence of the blind generator, and its distance from the rig.

Only this file imports both. Distances are those of noiseless files, registered as by ``compare``.
"""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import numpy as np
import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis.model.candidate import OF_PLASTICS, ONLY_TOLERANCES
from cycloid_profile.effects import EFFECTS, apply_effects, effect_from_table
from cycloid_profile.measurement import HYSTERESIS, PROFILE_SCAN, read_measurement
from cycloid_profile.rig import Settings, measurement_residual, simulate
from cycloid_profile.spec import read_spec
from tests.diagnosis.blind import (
    KINDS,
    OUTSIDE,
    Hidden,
    Noise,
    Reducer,
    Stage,
    draw_case,
    loop,
    lost_motion,
    scan,
    spec_text,
    transmission_error,
)
from tests.diagnosis.blind.friction import left_over

HERE = Path(__file__).parent
MEASURED = HERE.parent / "rig" / "measured"
DRAWING = Reducer()
# Every effect at its manufacturing tolerance, on parts other than the first.
AT_TOLERANCE = [
    Hidden("equidistant_error", {"amount_um": 2.0}),
    Hidden("equidistant_error", {"amount_um": -2.0, "disc": 2}),
    Hidden("radial_moving_error", {"amount_um": 2.0}),
    Hidden("generating_eccentricity_error", {"amount_um": 1.0}),
    Hidden("thermal_growth", {"temperature_k": 3.0}),
    Hidden("disc_runout", {"amplitude_um": 3.0, "phase_deg": 40.0}),
    Hidden("disc_runout", {"amplitude_um": 3.0, "phase_deg": 40.0, "disc": 2}),
    Hidden("disc_runout", {"amplitude_um": 3.0, "phase_deg": 40.0, "form": 2}),
    Hidden("disc_oval", {"amplitude_um": 2.0, "phase_deg": 25.0}),
    Hidden("disc_oval", {"amplitude_um": 2.0, "phase_deg": 25.0, "disc": 1}),
    Hidden("cumulative_pitch_error", {"amplitude_um": 3.0, "phase_deg": 70.0}),
    Hidden("cumulative_pitch_error", {"amplitude_um": 3.0, "phase_deg": 70.0, "disc": 2}),
    Hidden("wheel_wear_drift", {"amount_um": 1.0, "first_lobe": 7}),
    Hidden("grinding_chatter", {"amplitude_um": 0.3, "waves_per_turn": 1000.0, "phase_deg": 33.0, "disc": 1}),
    Hidden("grinding_chatter", {"amplitude_um": 0.3, "waves_per_turn": 321.4, "phase_deg": 33.0, "disc": 2}),
    Hidden("missing_deformation_compensation", {"amount_um": 2.0}),
    Hidden("flank_wear", {"amount_um": 2.0}),
    Hidden("flank_wear", {"amount_um": 2.0, "flank": 2, "disc": 2}),
    Hidden("single_tooth_error", {"amount_um": 1.0, "lobe": 5}),
    Hidden("single_tooth_error", {"amount_um": -1.0, "lobe": 12, "disc": 2}),
    Hidden("pin_radius_error", {"amount_um": 1.0}),
    Hidden("pin_circle_radius_error", {"amount_um": 3.0}),
    Hidden("pin_ring_runout", {"amplitude_um": 5.0, "phase_deg": 33.0}),
    Hidden("pin_ring_oval", {"amplitude_um": 3.0, "phase_deg": 33.0}),
    Hidden("pin_ring_cumulative_pitch", {"amplitude_um": 4.0, "phase_deg": 33.0}),
    Hidden("single_pin_error", {"amount_um": 1.0, "pin": 8}),
    Hidden("crank_eccentricity_error", {"amount_um": 3.0}),
    Hidden("crank_eccentricity_error", {"amount_um": 3.0, "crank": 2, "disc": 1}),
    Hidden("crank_phase_error", {"angle_arcmin": 5.0}),
    Hidden("crank_phase_error", {"angle_arcmin": 5.0, "crank": 3}),
    Hidden("crank_hole_error", {"amplitude_um": 3.0, "direction_deg": 50.0, "crank": 3, "disc": 2}),
    Hidden("crank_bearing_clearance", {"radial_um": 2.0}),
    Hidden("planet_runout", {"amplitude_um": 10.0, "phase_deg": 20.0, "planet": 2}),
    Hidden("series_compliance", {"stiffness_nm_per_arcmin": 150.0}),
    Hidden("crank_bearing_compliance", {"added_um_per_kn": 1.0}),
    Hidden("pin_support_compliance", {"added_um_per_kn": 1.0}),
    Hidden("coulomb_friction", {"torque_nm": 5.0}),
    Hidden("load_proportional_friction", {"coefficient": 0.03}),
    Hidden("encoder_eccentricity", {"amplitude_arcsec": 5.0, "phase_deg": 77.0}),
]
FLANKS = [one for one in AT_TOLERANCE if "scan" in KINDS[one.name].shows]
QUICK = ["disc_runout", "pin_ring_oval", "crank_hole_error", "crank_bearing_clearance", "load_proportional_friction"]


def label(one):
    return "-".join([one.name, *(f"{key}{value}" for key, value in one.parameters.items() if isinstance(value, int))])


@pytest.fixture(scope="module")
def reducer(tmp_path_factory):
    """The reducer of the generator's own spec file, as the package reads it."""
    spec = tmp_path_factory.mktemp("drawing") / "spec.toml"
    spec.write_text(spec_text(DRAWING), encoding="utf-8")
    drawn = as_built_reducer(read_spec(spec))
    return lambda effects: apply_effects(drawn.case, [effect_from_table(one.table()) for one in effects])


@pytest.fixture
def read(tmp_path):
    def reading(text):
        file = tmp_path / "measured.csv"
        file.write_text(text, encoding="utf-8")
        return read_measurement(file)

    return reading


@pytest.fixture
def distance(reducer, read):
    """Root mean square of generator minus rig after registration; loops without the rows inside the backlash."""

    def between(text, effects, disc=1):
        measured = read(text)
        residual = measurement_residual(reducer(effects), measured, disc - 1).residual
        if measured.kind is HYSTERESIS:
            residual = residual[np.abs(measured["torque_nm"]) > 0.06 * DRAWING.rated_torque_nm]
            residual = residual - np.mean(residual)
        assert np.all(np.isfinite(residual))
        return float(np.sqrt(np.mean(residual**2)))

    return between


def test_generator_imports_nothing_of_the_package():
    files = sorted((HERE / "blind").glob("*.py"))
    assert len(files) > 10
    for file in files:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                roots = {name.name.split(".")[0] for name in node.names}
            elif isinstance(node, ast.ImportFrom):
                roots = set() if node.level else {node.module.split(".")[0]}
            else:
                continue
            assert roots <= {"numpy", "scipy"} | sys.stdlib_module_names, f"{file.name} imports {roots}"
            assert "importlib" not in roots


def test_every_effect_of_the_contract_can_be_drawn():
    # Joints that stiffen have another law in the generator, which is not of the contract.
    measured = set(EFFECTS) - ONLY_TOLERANCES - OF_PLASTICS - {"nonlinear_series_compliance"}
    assert set(KINDS) == measured
    assert {one.name for one in AT_TOLERANCE} == measured
    assert all(name.startswith("x_") for name in OUTSIDE)


@pytest.mark.slow
@pytest.mark.parametrize("one", FLANKS, ids=label)
def test_scans_are_within_five_nanometres_of_the_rig(one, distance):
    # A file has seven digits: 0.03 nm. The generator displaces the tooth, the rig removes along the normal: 3 nm at the
    # largest curvature. Wear ends with an edge in the generator, with a spline in the rig.
    limit = 8e-3 if one.name == "flank_wear" else 2e-3 if one.name == "disc_runout" else 1e-4
    for disc in (1, 2):
        assert distance(scan(DRAWING, [one], disc=disc, turn_deg=3.2), [one], disc) < limit


@pytest.mark.slow
@pytest.mark.parametrize(
    "one", [None, *(one for one in AT_TOLERANCE if one.name in QUICK)], ids=lambda o: o and label(o)
)
def test_bench_files_agree_with_the_rig(one, distance):
    effects = [] if one is None else [one]
    stage = Stage(DRAWING, tuple(effects))
    assert distance(transmission_error(DRAWING, effects, torque_nm=412.0, rows=240, stage=stage), effects) < 0.004
    assert distance(transmission_error(DRAWING, effects, torque_nm=12.36, rows=240, stage=stage), effects) < 0.004
    assert distance(lost_motion(DRAWING, effects, rows=120, stage=stage), effects) < 2e-4
    assert distance(loop(DRAWING, effects, rows=120, output_angle_deg=17.0, stage=stage), effects) < 2e-4


@pytest.mark.slow
@pytest.mark.parametrize("one", AT_TOLERANCE, ids=label)
def test_every_effect_on_the_bench(one, distance):
    stage = Stage(DRAWING, (one,))
    wear = 10.0 if one.name == "flank_wear" else 1.0
    for torque, rows in ((412.0, 1000), (12.36, 1000), (-206.0, 300)):
        text = transmission_error(DRAWING, [one], torque_nm=torque, rows=rows, stage=stage)
        assert distance(text, [one]) < 0.01 * wear
    assert distance(lost_motion(DRAWING, [one], rows=200, stage=stage), [one]) < 1e-4 * wear
    for angle in (0.0, 133.7):
        assert distance(loop(DRAWING, [one], output_angle_deg=angle, stage=stage), [one]) < 2e-4 * wear


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_two_effects_of_several_tolerances(seed, reducer):
    names = [name for name in KINDS if name not in {"flank_wear", "grinding_chatter"}]
    case = draw_case(seed, files=("te_light",), effects=2, sizes=(1.0, 4.0), names=names)
    stage = Stage(DRAWING, tuple(case.truth))
    text = transmission_error(DRAWING, case.truth, torque_nm=12.36, rows=240, stage=stage)
    mine = np.array([row.split(",") for row in text.split("\n")[4:-1]], dtype=float)[:, 1]
    rig = simulate(reducer(case.truth), "transmission_error", Settings(torque=12.36e3, points=240))
    assert np.std(mine - rig["error_arcsec"]) < 0.05


@pytest.mark.slow
def test_another_generator_had_the_same_reducer():
    """Samples with white noise of 0.15″ and 0.004′: the residual is that noise."""
    for file, noise, text in (
        ("te_rated", 0.15, transmission_error(DRAWING, torque_nm=412.0)),
        ("te_light", 0.15, transmission_error(DRAWING, torque_nm=12.36)),
        ("lost_motion", 0.004, lost_motion(DRAWING)),
    ):
        sample = read_measurement(MEASURED / "te_none" / f"{file}.csv")
        column = list(sample.columns)[1]
        mine = np.array([row.split(",") for row in text.split("\n")[4:-1]], dtype=float)
        assert np.allclose(mine[:, 0], sample["output_angle_deg"], atol=1e-6)
        left = sample[column] - mine[:, 1]
        assert np.std(left) == pytest.approx(noise, rel=3.0 / np.sqrt(2.0 * left.size))


def test_noise_has_the_stated_parameters():
    draw = np.random.default_rng(3)
    for kind in ("normal", "t5"):
        column = Noise(0.3, rho=0.6, kind=kind).draw(100_000, draw)
        assert np.std(column) == pytest.approx(0.3, rel=0.02)
        assert np.corrcoef(column[1:], column[:-1])[0, 1] == pytest.approx(0.6, abs=0.02)
    hit = np.abs(Noise(0.3, outliers=0.02, outlier_size=20.0).draw(100_000, draw)) > 4.0
    assert np.mean(hit) == pytest.approx(0.02, rel=0.1)
    with pytest.raises(ValueError, match="not known"):
        Noise(0.3, kind="pink").draw(10, draw)


def test_files_contain_required_keys_only(read):
    reported = read(scan(DRAWING, noise=Noise(0.3, declare=True), points=2000, missing_lobes=(4, 5), datum="free"))
    assert reported.number("noise_um") == 0.3
    assert reported.keys["datum"] == "free"
    lobe = np.mod(np.round(-np.arctan2(reported["y_mm"], reported["x_mm"]) * 39 / (2.0 * np.pi)).astype(int), 39) + 1
    assert set(range(1, 40)) - set(lobe.tolist()) == {4, 5}
    silent = read(loop(DRAWING, noise=Noise(0.004), rows=60))
    assert silent.number("noise_arcmin") is None
    assert np.max(silent["torque_nm"]) == 412.0
    assert np.min(silent["torque_nm"]) == -412.0


def test_friction_of_other_forms_is_close_to_coulombs():
    torque = np.interp(np.linspace(0.0, 5.0, 2001), [0.0, 1.0, 3.0, 5.0], [0.0, 100.0, -100.0, 100.0])
    play = left_over(torque, 8.0, 0.02, "coulomb")
    for form in ("smooth", "elastoslide"):
        other = left_over(torque, 8.0, 0.02, form)
        assert 0.05 < np.max(np.abs(other - play)) < 3.1
        # Once it slides, both are equal.
        sliding = np.abs(torque - play) > 0.999 * (8.0 + 0.02 * np.abs(torque))
        assert np.median(np.abs(other - play)[sliding]) < 0.02
        assert np.all(np.abs(torque - other) < 8.0 + 0.02 * np.abs(torque) + 1e-9)
    with pytest.raises(ValueError, match="not known"):
        left_over(torque, 8.0, 0.0, "viscous")


@pytest.mark.parametrize("name", sorted(OUTSIDE))
def test_what_is_outside_the_library_shows_in_its_files(name, read):
    one = OUTSIDE[name].draw(name, DRAWING, 1.0, (1,), np.random.default_rng(5))
    kind = next(kind for kind in ("scan", "loop", "te") if kind in OUTSIDE[name].shows)
    rows = {
        "scan": lambda effects: scan(DRAWING, effects),
        "loop": lambda effects: loop(DRAWING, effects, rows=80),
        "te": lambda effects: transmission_error(DRAWING, effects, torque_nm=412.0, rows=60),
    }[kind]
    column = {"scan": "x_mm", "loop": "angle_arcmin", "te": "error_arcsec"}[kind]
    change = read(rows([one]))[column] - read(rows([]))[column]
    assert np.max(np.abs(change)) > {"scan": 4e-4, "loop": 0.02, "te": 1.0}[kind]


def test_a_seed_determines_the_case(tmp_path, read):
    first, again, other = (draw_case(seed, files=("scan", "loop"), effects=2) for seed in (11, 11, 12))
    assert first.files == again.files
    assert first.truth == again.truth
    assert first.files != other.files
    assert set(first.files) == {"scan", "loop"}
    assert len({one.name for one in first.truth}) == 2
    assert all(read(text).kind in {PROFILE_SCAN, HYSTERESIS} for text in first.files.values())
    first.write(tmp_path / "case")
    assert {file.name for file in (tmp_path / "case").iterdir()} == {"spec.toml", "scan.csv", "loop.csv"}
    read_spec(tmp_path / "case" / "spec.toml")
    assert first.truth[0].name not in "".join(first.files.values())


def test_invisible_effects_are_not_drawn():
    for seed in range(40):
        (one,) = draw_case(seed, sizes=(1.0, 1.5)).truth
        assert "scan" in KINDS[one.name].shows
        assert one.parameters.get("disc", 1) == 1
        assert effect_from_table(one.table()).name == one.name
    assert draw_case(0, effects=0).truth == []
    assert draw_case(3, effects=0, outside=1).truth[0].name.startswith("x_")
    with pytest.raises(ValueError, match="show only"):
        draw_case(0, files=("loop",), effects=1, names=("encoder_eccentricity",))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "shown"), [(n, k) for n, kind in KINDS.items() for k in ("loop", "te") if k in kind.shows]
)
def test_effects_listed_as_visible_change_bench_files(name, shown):
    """Twice the tolerance changes the file by more than a tenth of its noise, root mean square."""
    stage = [Stage(DRAWING, ()), None]
    draw = np.random.default_rng(2)
    one = KINDS[name].draw(name, DRAWING, 2.0, (1, 2), draw)
    stage[1] = Stage(DRAWING, (one,))
    columns = []
    for effects, of in zip(([], [one]), stage, strict=True):
        if shown == "loop":
            text = loop(DRAWING, effects, rows=60, output_angle_deg=25.0, stage=of)
        else:
            text = transmission_error(DRAWING, effects, torque_nm=12.36, rows=97, stage=of)
        columns.append(
            np.array([row.split(",") for row in text.split("\n") if row[:1] in "-0123456789" and row], float)[:, 1]
        )
    change = columns[1] - columns[0]
    assert np.std(change) > {"loop": 0.0004, "te": 0.015}[shown]
