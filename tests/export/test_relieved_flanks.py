"""Flanks with crowning, edge relief and taper: point cloud, measuring points and notes, against the textbook tooth."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cycloid_profile.contact import LoadCase
from cycloid_profile.design import DesignRecord, drive_of, flank_relief, load_case
from cycloid_profile.errors import SpecError
from cycloid_profile.export.nc import GcodeExporter, PolarExporter, WireExporter
from cycloid_profile.export.points import CmmExporter, ProfileCsvExporter
from cycloid_profile.spec import parse_spec
from cycloid_profile.spec.model import Spec

KEYS = {"crowning_um": 5.0, "edge_relief_um": 8.0, "edge_relief_length_mm": 1.5, "flank_taper_um": 2.0}


def relieved(record: DesignRecord, **keys: float) -> DesignRecord:
    spec = record.spec
    for key, value in keys.items():
        spec = spec.replace(f"modification.{key}", value)
    return replace(record, spec=spec)


def removed(z: np.ndarray) -> np.ndarray:
    """Relief of KEYS at heights above the lower face of 11.5 mm, written once more [mm]."""
    up = z / 5.75 - 1.0
    near = np.clip((np.abs(z - 5.75) - 4.25) / 1.5, 0.0, None)
    return 5e-3 * up**2 + 8e-3 * near**2 + 1e-3 * up


def test_cloud_is_the_tooth_less_its_relief(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    files = ProfileCsvExporter().write(relieved(rv40e_record, **KEYS), tmp_path)
    assert [file.name for file in files] == ["profile.csv", "profile_width.csv"]
    assert files[1].deviation is not None
    assert files[1].deviation.largest < 2e-9
    header = (tmp_path / "profile_width.csv").read_text(encoding="ascii").splitlines()[0]
    assert header == "psi_rad,z_mm,x_mm,y_mm,nx,ny,nz"
    psi, z, x, y, nx, ny, nz = np.loadtxt(tmp_path / "profile_width.csv", delimiter=",", skiprows=1).T
    assert {0.0, 1.5, 5.75, 10.0, 11.5} < set(np.unique(z))
    np.testing.assert_allclose(nx**2 + ny**2 + nz**2, 1.0, atol=1e-8)
    exact = rv40e_record.profile.at(psi)
    along = ((x + 1j * y - exact.position) * np.conj(exact.normal)).real
    # At the corners of root and tip the phase as written decides the normal.
    np.testing.assert_allclose(along, -removed(z), atol=1e-7)
    # The normal stands square on the surface: it leans as the relief grows.
    lean = (removed(z + 1e-6) - removed(z - 1e-6)) / 2e-6
    np.testing.assert_allclose(nz, lean / np.hypot(1.0, lean), atol=2e-6)


def test_tooth_without_relief_has_no_cloud(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    assert len(ProfileCsvExporter().write(rv40e_record, tmp_path)) == 1


def test_measuring_points_gain_heights_only_with_relief(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    (plain,) = CmmExporter().write(rv40e_record, tmp_path)
    before = np.loadtxt(tmp_path / "cmm_nominal.csv", delimiter=",", skiprows=1)
    (file,) = CmmExporter().write(relieved(rv40e_record, crowning_um=5.0), tmp_path)
    table = np.loadtxt(tmp_path / "cmm_nominal.csv", delimiter=",", skiprows=1)
    assert "heights" not in plain.entities
    assert file.entities["heights"] == 3
    np.testing.assert_array_equal(table[: len(before)], before)
    np.testing.assert_array_equal(np.unique(table[:, 5]), [1.15, 5.75, 10.35])
    np.testing.assert_array_equal(table[:, 0], np.arange(1, 3 * len(before) + 1))
    off = np.abs(table[len(before) : 2 * len(before), 3:5] - before[:, 3:5])
    np.testing.assert_allclose(np.hypot(*off.T), 5e-3 * 0.8**2, atol=3e-9)


@pytest.mark.parametrize("exporter", [GcodeExporter(), PolarExporter(), WireExporter()], ids=lambda one: one.format)
def test_programs_say_what_they_do_not_cut(rv40e_record: DesignRecord, tmp_path: Path, exporter) -> None:
    # Chords of 1 µm: only the notes are read.
    plain = replace(rv40e_record, spec=rv40e_record.spec.replace("export.chord_tolerance_um", 1.0))
    exporter.write(relieved(plain, **KEYS), tmp_path)
    text = (tmp_path / exporter.filenames[0]).read_text(encoding="ascii")
    # 11.5²/(8·0.005) and atan(0.002/11.5).
    for words in ("CONTOUR AT MID-HEIGHT", "RADIUS 3306 MM", "EDGE RELIEF 8 MICROMETRE", "35.9 ARC SECONDS"):
        assert words in text
    exporter.write(plain, tmp_path)
    assert "MID-HEIGHT" not in (tmp_path / exporter.filenames[0]).read_text(encoding="ascii")


def spec_of(**keys: float) -> Spec:
    lines = "\n".join(f"{key} = {value}" for key, value in keys.items())
    drive = "pins = 11\npin_circle_radius_mm = 30.0\npin_radius_mm = 3.0\neccentricity_mm = 1.5\ndisc_width_mm = 8.0"
    return parse_spec(f'[drive]\n{drive}\ndiscs = 2\n[load]\ndisc_body = "rigid"\n[modification]\n{lines}\n')


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"edge_relief_um": 5.0}, "does not go with a length of 0 mm"),
        ({"edge_relief_length_mm": 1.0}, "edge_relief_um"),
        ({"edge_relief_um": 5.0, "edge_relief_length_mm": 4.1}, "longer than half the face width, 4 mm"),
        ({"crowning_um": -1.0}, "must be >= 0"),
    ],
)
def test_impossible_relief_is_refused_in_one_sentence(keys: dict[str, float], words: str) -> None:
    def case() -> LoadCase:
        spec = spec_of(**keys)
        return load_case(spec, drive_of(spec), drive_of(spec).theoretical_profile)

    with pytest.raises(SpecError, match=words):
        case()


def test_relief_of_a_spec_in_base_units() -> None:
    assert flank_relief(spec_of(crowning_um=5.0)).crowning == pytest.approx(0.005)
    assert not flank_relief(spec_of())
