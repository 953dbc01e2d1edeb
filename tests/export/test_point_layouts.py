"""Point files of any layout against the textbook tooth, and the form wheel against the gap it grinds."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from independent import ExactCurve, textbook_curve

from cycloid_profile.design import DesignRecord
from cycloid_profile.errors import ExportError
from cycloid_profile.export import check_deviation
from cycloid_profile.export.points import ProfileCsvExporter, form_wheel
from cycloid_profile.spec.model import FormWheelSpec


def written(record: DesignRecord, folder: Path, **keys: object) -> tuple[list[str], DesignRecord]:
    """Lines of the point file with these keys under ``[export.points]``, its measured deviation checked."""
    asked = replace(record, spec=record.spec.replace({f"export.points.{key}": value for key, value in keys.items()}))
    files = {file.name: file for file in ProfileCsvExporter().write(asked, folder)}
    name = str(keys.get("file", "points.txt"))
    check_deviation(files[name])
    assert set(files) == {"profile.csv", name}
    return (folder / name).read_text(encoding="ascii").splitlines(), asked


def numbers(lines: list[str], separator: str | None = ",") -> np.ndarray:
    return np.array([[float(cell) for cell in line.split(separator)] for line in lines])


@pytest.fixture(scope="module")
def exact(rv40e_record: DesignRecord) -> ExactCurve:
    assert rv40e_record.compensation is not None
    return ExactCurve(0.006, rv40e_record.compensation.delta_max)


def test_whole_disc_as_x_y_z_without_a_header(rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path) -> None:
    lines, _ = written(rv40e_record, tmp_path, total=500, closed=True, separator=" ", z_mm=2.5, decimals=7)
    table = numbers(lines, " ")
    assert table.shape == (501, 3)
    assert np.array_equal(table[0], table[-1])
    assert set(table[:, 2]) == {2.5}
    assert np.max(np.abs(exact.distance(table[:, :2]))) < 1e-6
    # From the root on the x axis, clockwise, at equal arcs; the total need not be a multiple of the lobes.
    angle = np.unwrap(np.arctan2(table[:, 1], table[:, 0]))
    assert angle[0] == 0.0
    assert angle[-1] == pytest.approx(-2.0 * math.pi)
    steps = np.hypot(*np.diff(table[:, :2], axis=0).T)
    # Chords are shorter than arcs where the tooth bends most.
    assert np.max(steps) / np.median(steps) < 1.02


@pytest.mark.parametrize("sense", ["clockwise", "anticlockwise"])
def test_start_and_sense(rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path, sense: str) -> None:
    lines, _ = written(
        rv40e_record, tmp_path, per_lobe=10, start="tip", sense=sense, coordinates="polar", header=True, separator=";",
        file="points_polar.csv",
    )  # fmt: skip
    assert lines[0] == "r;angle;z"
    table = numbers(lines[1:], ";")
    assert table.shape == (390, 3)
    assert table[0, 0] == np.max(table[:, 0])
    turned = np.unwrap(np.radians(table[:, 1]))
    assert np.sign(turned[-1] - turned[0]) == (-1.0 if sense == "clockwise" else 1.0)
    xy = table[:, :1] * np.stack([np.cos(turned), np.sin(turned)], axis=1)
    assert np.max(np.abs(exact.distance(xy))) < 2e-6


def test_one_gap_from_tip_to_tip_with_a_line_template(
    rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path
) -> None:
    lines, _ = written(rv40e_record, tmp_path, total=21, range="gap", template="N{n} X{x:.4f} Y{y:.4f} Z{z:.4f}")
    assert lines[0].startswith("N1 X")
    assert [line.split()[0] for line in lines] == [f"N{k}" for k in range(1, 22)]
    table = np.array([[float(word[1:]) for word in line.split()[1:]] for line in lines])
    assert np.max(np.abs(exact.distance(table[:, :2]))) < 1e-4
    angle = np.degrees(np.arctan2(table[:, 1], table[:, 0]))
    assert (angle[0], angle[10], angle[-1]) == pytest.approx((180.0 / 39, 0.0, -180.0 / 39), abs=1e-4)


def test_density_follows_the_chord_tolerance_without_a_number(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    lines, record = written(rv40e_record, tmp_path, decimals=9)
    profile = np.loadtxt(tmp_path / "profile.csv", delimiter=",", skiprows=1)
    assert len(lines) == len(profile)
    assert record.spec.export.points is not None
    assert np.max(np.abs(numbers(lines)[:, :2] - profile[:, 1:3])) < 1e-8


@pytest.mark.parametrize(
    ("keys", "fault"),
    [
        ({"total": 100, "per_lobe": 10}, "total = 100 is given with per_lobe: give one"),
        ({"template": "X{radius:.3f}"}, r"cannot be filled in \(radius\): use n, x, y"),
        ({"template": "X{x:q}"}, "cannot be filled in"),
        ({"template": "{x}{y}"}, "cannot be read back: separate the numbers"),
    ],
)
def test_faults_are_one_sentence(
    rv40e_record: DesignRecord, tmp_path: Path, keys: dict[str, object], fault: str
) -> None:
    with pytest.raises(ExportError, match=fault):
        written(rv40e_record, tmp_path, **keys)


@pytest.mark.parametrize("inclination", [0.0, 4.0])
def test_the_form_wheel_touches_the_whole_gap_and_cuts_nowhere(rv40e_record: DesignRecord, inclination: float) -> None:
    wheel_radius, swivel = 60.0, math.radians(inclination)
    wheel = form_wheel(rv40e_record, FormWheelSpec(wheel_radius_mm=wheel_radius, inclination_deg=inclination))
    # The groove at the root turns the normals there by half a milliradian.
    assert np.max(wheel.section.imag) == pytest.approx(wheel_radius, abs=1e-6)
    delta = rv40e_record.compensation.delta_max if rv40e_record.compensation else 0.0
    fine = textbook_curve(np.linspace(-1.2 * math.pi, 1.2 * math.pi, 60_001), 0.006, delta) @ [1.0, 1j]
    axis_x = float(fine[np.argmin(np.abs(fine.imag) + (fine.real < 0))].real) + wheel_radius
    axis = np.array([0.0, math.cos(swivel), math.sin(swivel)])
    across = np.array([0.0, -math.sin(swivel), math.cos(swivel)])
    turn = np.linspace(-0.12, 0.12, 4801)
    for z, radius in zip(wheel.section.real[::400], wheel.section.imag[::400], strict=True):
        # A circle of the wheel, seen along the axis of the disc: it is tangent to the gap from outside.
        x = axis_x + z * axis[0] - radius * np.cos(turn)
        y = z * axis[1] + radius * np.sin(turn) * across[1]
        near = np.abs(fine[:, np.newaxis] - (x + 1j * y)[::40])
        k, m = np.unravel_index(int(np.argmin(near)), near.shape)
        around = (x + 1j * y)[max(0, 40 * m - 60) : 40 * m + 61]
        close = np.min(np.abs(fine[max(0, k - 3000) : k + 3000, np.newaxis] - around))
        assert close < 6e-5
        inside = np.interp(y[::40], fine.imag[np.argsort(fine.imag)], fine.real[np.argsort(fine.imag)])
        assert np.min(x[::40] - inside) > -1e-4


def test_form_wheel_files_and_the_path_of_the_dresser(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    keys = {"wheel_radius_mm": 60.0, "dresser_radius_mm": 0.5, "template": "N{n} X{x:.4f} Z{z:.4f}"}
    record = replace(rv40e_record, spec=rv40e_record.spec.replace("export.form_wheel", keys))
    files = {file.name: file for file in ProfileCsvExporter().write(record, tmp_path)}
    assert set(files) == {"profile.csv", "form_wheel.csv", "form_wheel.txt"}
    z, radius, nz, nr, dresser_z, dresser_radius = np.loadtxt(tmp_path / "form_wheel.csv", delimiter=",", skiprows=1).T
    assert np.hypot(nz, nr) == pytest.approx(1.0, abs=1e-8)
    assert np.hypot(dresser_z - z, dresser_radius - radius) == pytest.approx(0.5, abs=1e-8)
    # Outside the wheel everywhere: no nearer to any point of its section than the tip's radius.
    section, centre = z + 1j * radius, dresser_z + 1j * dresser_radius
    assert min(np.min(np.abs(section - one)) for one in centre[::7]) > 0.5 - 1e-6
    lines = (tmp_path / "form_wheel.txt").read_text(encoding="ascii").splitlines()
    assert lines[0] == f"N1 X{dresser_radius[0]:.4f} Z{dresser_z[0]:.4f}"
    assert len(lines) == z.size


def test_a_dresser_that_does_not_fit_is_refused(rv40e_record: DesignRecord) -> None:
    with pytest.raises(ExportError, match="dresser_radius_mm = 50 does not fit the concave parts of the wheel"):
        form_wheel(rv40e_record, FormWheelSpec(wheel_radius_mm=60.0, dresser_radius_mm=50.0))
