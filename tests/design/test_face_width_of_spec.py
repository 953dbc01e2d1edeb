"""Slices over the face width by the spec: keys, figures, checks, and what ignores them."""

from __future__ import annotations

import numpy as np
import pytest

from cycloid_profile.contact.stage import StageEquilibrium, energy_about
from cycloid_profile.design import (
    CheckStatus,
    DesignRecord,
    conventional_profile,
    design_disc,
    drive_of,
    load_case,
    summary,
)
from cycloid_profile.design.from_spec import face_width
from cycloid_profile.errors import LoadError
from cycloid_profile.plot import pictures
from cycloid_profile.report.design import terminal_tables
from cycloid_profile.spec import parse_spec
from cycloid_profile.spec.model import Spec
from tests.spec_texts import CRANKS, DRIVE


def spec_of(load: str = "", modification: str = "", drive: str = "") -> Spec:
    return parse_spec(
        f'{DRIVE}{CRANKS}{drive}\n[load]\nrated_torque_nm = 412.0\ndisc_body = "rigid"\n{load}\n'
        f"[modification]\nequidistant_um = 6.0\n{modification}\n"
    )


@pytest.fixture(scope="module")
def plain() -> DesignRecord:
    return design_disc(spec_of())


@pytest.fixture(scope="module")
def sliced() -> DesignRecord:
    return design_disc(spec_of("width_slices = 6", "crowning_um = 3.0\nflank_taper_um = 4.0"))


def test_keys_in_base_units() -> None:
    bearing = (
        "[drive.crank_bearing]\noffset_mm = 0.5\ntilt_stiffness_nm_per_mrad = 2.0\n[drive.pin_relief]\ntaper_um = -1"
    )
    spec = spec_of("width_slices = 6", "edge_relief_um = 8.0\nedge_relief_length_mm = 1.5", bearing)
    width = face_width(spec, drive_of(spec))
    assert width is not None
    assert (width.slices, width.bearing_offset) == (6, 0.5)
    # 2 N·m in a thousandth of a radian.
    assert width.tilt_stiffness == pytest.approx(2.0e6)
    assert (width.tooth.edge_relief, width.tooth.edge_length) == (pytest.approx(0.008), 1.5)
    assert width.pin.taper == pytest.approx(-0.001)
    assert face_width(spec_of(), drive_of(spec)) is None


def test_a_bearing_without_data_tilts_as_its_rollers_lie() -> None:
    spec = spec_of("width_slices = 6", drive="[drive.crank_bearing]\nroller_length_mm = 9.0\n")
    drive = drive_of(spec)
    width = face_width(spec, drive)
    assert width is not None
    assert width.tilt_stiffness == pytest.approx(drive.support.bearing_stiffness * 81.0 / 12.0)


def test_figures_appear_with_slices_alone(plain: DesignRecord, sliced: DesignRecord) -> None:
    before, after = summary(plain)["under_load"], summary(sliced)["under_load"]
    added = {"width_slices", "max_edge_pressure_mpa", "max_tilt_mrad"}
    assert set(after) - set(before) == added
    assert after["max_edge_pressure_mpa"] > after["max_pressure_mpa"]
    assert after["max_edge_pressure_mpa"] == float(np.max(sliced.under_load.edge_pressure))
    assert 0.0 < after["max_tilt_mrad"] < 4.0 / 11.5
    rows = {row[0] for table in terminal_tables(summary(sliced)) for row in table.rows}
    assert "peak pressure over the face width [MPa]" in rows
    assert "pressure_over_width" in [one.name for one in pictures(sliced)]
    assert "pressure_over_width" not in [one.name for one in pictures(plain)]


def test_the_pressure_check_takes_the_largest_over_the_width(sliced: DesignRecord) -> None:
    check = next(one for one in sliced.checks if one.name == "peak pressure")
    assert f"{sliced.under_load.max_edge_pressure:.0f} MPa over the face width" in check.value
    assert f"{sliced.under_load.max_pressure:.0f} MPa under an even load" in check.value


def test_relief_without_slices_is_said_to_be_ignored(plain: DesignRecord) -> None:
    found = design_disc(spec_of("", "crowning_um = 5.0"))
    (check,) = (one for one in found.checks if one.name == "relief along the face width")
    assert check.status is CheckStatus.NOT_CHECKED
    assert "load.width_slices" in check.sentence
    np.testing.assert_array_equal(found.under_load.force, plain.under_load.force)
    assert not any(one.name.startswith("relief") for one in plain.checks)


def test_a_central_eccentric_lets_its_discs_tilt_as_well() -> None:
    load = '[load]\nrated_torque_nm = 200.0\ndisc_body = "rigid"\nwidth_slices = 4'
    text = f"{DRIVE}\n{load}\n[modification]\nflank_taper_um = 3.0"
    found = design_disc(parse_spec(text)).under_load
    assert found.converged
    assert found.stage is not None
    assert found.stage.tilt is not None
    assert np.max(np.abs(found.stage.tilt)) > 1e-5


@pytest.mark.parametrize(
    ("load", "drive", "words"),
    [
        ("width_slices = 1", "", "load.width_slices = 1 is below 2"),
        (
            "width_slices = 6",
            "[drive.crank_bearing]\noffset_mm = 20.0",
            "crank_bearing.offset_mm = 20.0 mm lies",
        ),
    ],
)
def test_impossible_slices_name_their_key(load: str, drive: str, words: str) -> None:
    spec = spec_of(load, drive=drive)
    with pytest.raises(LoadError, match=words):
        face_width(spec, drive_of(spec))


def test_slices_work_with_rollers_and_elastic_supports() -> None:
    drive = (
        '[drive.crank_bearing]\nmodel = "rollers"\noffset_mm = 1.0\n[drive.pin_seat]\ncontact = true\n[drive.ring]\n'
    )
    spec = spec_of("width_slices = 6", "crowning_um = 2.0\nflank_taper_um = 4.0", drive)
    nominal = drive_of(spec)
    case = load_case(spec, nominal, conventional_profile(spec, nominal))
    crank = np.linspace(0.0, 6.0, 5)
    found, more, less = (StageEquilibrium(tolerance=1e-12).at(case, crank, 412e3 * s) for s in (1.0, 1.0005, 0.9995))
    assert found.converged
    assert found.stage is not None
    assert found.stage.tilt is not None
    assert np.max(np.abs(found.stage.tilt)) > 1e-5
    slope = (more.torque - less.torque) / (more.rotation - less.rotation)
    np.testing.assert_allclose(slope, found.torsional_stiffness, rtol=5e-3)
    about = energy_about(found)
    assert float(np.max(about.imbalance(about.at(np.zeros((5, about.arm.size)))))) < 1e-9
