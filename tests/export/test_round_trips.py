"""Each file read back by a reader that shares no code with its writer, against the textbook formula.

The promised tolerance is 0.05 µm for every curve of the RV-40E (plus half a unit of the last decimal in
the NC program).
"""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from independent import (
    ExactCurve,
    read_dxf_splines,
    read_nc_points,
    sample_spline,
)
from scipy.spatial import cKDTree

from cycloid_profile.design import DesignRecord
from cycloid_profile.export.dxf import DxfExporter
from cycloid_profile.export.nc import GcodeExporter, post_of
from cycloid_profile.export.points import CmmExporter, ProfileCsvExporter

TOLERANCE = 5e-5
CHORDS = 3e-9  # chord error of the polyline in place of the exact curve


@pytest.fixture(scope="module")
def exact(rv40e_record: DesignRecord) -> ExactCurve:
    assert rv40e_record.compensation is not None
    return ExactCurve(equidistant=0.006, delta_max=rv40e_record.compensation.delta_max)


def test_profile_csv_obeys_its_contract(rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path) -> None:
    (written,) = ProfileCsvExporter().write(rv40e_record, tmp_path)
    with (tmp_path / "profile.csv").open(encoding="ascii", newline="") as file:
        rows = list(csv.reader(file))
    assert ",".join(rows[0]) == "psi_rad,x_mm,y_mm,nx,ny,curvature_per_mm"
    psi, x, y, nx, ny, kappa = np.array(rows[1:], float).T
    xy = np.stack([x, y], axis=-1)
    assert np.all(np.diff(psi) > 0.0)
    assert psi[-1] < 39 * 2.0 * math.pi
    assert np.max(exact.distance(xy)) < 2e-9 + CHORDS
    # The formula at the printed ψ gives the printed point: half a unit in ψ is 2e-10 mm of arc.
    assert np.max(np.abs(exact.at(psi) - xy)) < 1.5e-9
    assert np.max(np.abs(np.hypot(nx, ny) - 1.0)) < 2e-8
    assert np.min(nx * x + ny * y) > 0.0
    chords = 0.5 * (xy + np.roll(xy, -1, axis=0))
    assert np.max(exact.distance(chords)) <= TOLERANCE + CHORDS
    assert written.deviation is not None
    assert written.deviation.largest <= TOLERANCE
    # Signed curvature integrates to one clockwise turn, less the sudden turns at the 78 corners.
    ds = np.hypot(*(xy - np.roll(xy, 1, axis=0)).T)
    rotated = float(np.sum(kappa * 0.5 * (ds + np.roll(ds, -1))))
    assert rotated + 39 * np.sum(exact.corner_turns()) == pytest.approx(-2.0 * math.pi, abs=0.1)


def test_dxf_is_a_cubic_spline_of_control_vertices_for_each_flank(
    rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path
) -> None:
    (written,) = DxfExporter().write(rv40e_record, tmp_path)
    splines = read_dxf_splines(tmp_path / "profile.dxf", "PROFILE")
    for degree, flags, knots, control in splines:
        assert degree == 3
        assert flags & 1 == 0, "the closed flag makes several readers drop the curve"
        assert len(knots) == len(control) + degree + 1
    # One chain: each begins at the end of the previous one.
    assert all(np.array_equal(one[3][0], splines[k - 1][3][-1]) for k, one in enumerate(splines))
    off = exact.distance(
        np.concatenate([sample_spline(degree, knots, control) for degree, _, knots, control in splines])
    )
    assert np.max(off) <= TOLERANCE
    assert written.deviation is not None
    assert written.deviation.largest == pytest.approx(np.max(off), rel=0.1)
    # and in the other direction: no part of the curve is missing
    fine = np.concatenate([sample_spline(degree, knots, control, 12) for degree, _, knots, control in splines])
    gap, _ = cKDTree(fine).query(exact.points[::37])
    assert np.max(gap) < 0.05  # mm along the curve between samples
    assert "$INSUNITS" in (tmp_path / "profile.dxf").read_text()


def test_nc_program_follows_the_tooth(rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path) -> None:
    GcodeExporter().write(rv40e_record, tmp_path)
    points, codes = read_nc_points(tmp_path / "grinding.nc")
    assert codes[0] == "G0"
    assert set(codes[1:]) <= {"G1", "G2", "G3"}
    contour = points[3:-2].reshape(-1, 2)
    assert np.max(exact.distance(contour)) <= TOLERANCE + post_of(rv40e_record.spec.export).rounding
    # Lead-in and lead-out stay outside the tooth: nearer to the disc's centre would be a gouge.
    tip = np.max(np.hypot(*exact.points.T))
    assert np.min(np.hypot(*points[[1, 2, -2, -1]].reshape(-1, 2).T)) >= tip - 1e-4
    turns = np.unwrap(np.arctan2(contour[:, 1], contour[:, 0]))
    assert turns[-1] - turns[0] == pytest.approx(-2.0 * math.pi, abs=1e-2)


def test_nc_blocks_are_tangent_where_the_tooth_is(
    rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path
) -> None:
    GcodeExporter().write(rv40e_record, tmp_path)
    points, _ = read_nc_points(tmp_path / "grinding.nc", per_arc=400)
    arcs = points[1:]
    leaving = np.diff(arcs[:, -2:], axis=1)[:, 0]
    entering = np.diff(arcs[:, :2], axis=1)[:, 0]
    angle = np.arctan2(leaving[:, 1], leaving[:, 0])[:-1] - np.arctan2(entering[:, 1], entering[:, 0])[1:]
    turn = np.abs((angle + math.pi) % (2.0 * math.pi) - math.pi)
    # Five decimals turn the tangent of a 0.05 mm arc by up to 0.2 mrad, and half a step of sampling adds as
    # much again; so do the corners of the compensation. A wrong arc would turn it by far more.
    assert np.max(turn) < np.max(np.abs(exact.corner_turns())) + 2e-3
    assert np.median(turn) < 1e-3


def test_cmm_points_lie_on_the_tooth_at_equal_arc(
    rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path
) -> None:
    CmmExporter().write(rv40e_record, tmp_path)
    with (tmp_path / "cmm_nominal.csv").open(encoding="ascii", newline="") as file:
        rows = list(csv.reader(file))
    assert ",".join(rows[0]) == "point,lobe,psi_rad,x_mm,y_mm,z_mm,nx,ny,nz"
    table = np.array(rows[1:], float)
    assert len(table) == 39 * 40
    assert np.array_equal(np.unique(table[:, 1]), np.arange(1, 40))
    assert np.max(exact.distance(table[:, 3:5])) < 2e-9 + CHORDS
    steps = np.linalg.norm(np.diff(table[:40, 3:5], axis=0), axis=1)
    assert np.ptp(steps) < 0.02 * np.mean(steps)  # chords differ from arcs by curvature only
    assert np.all(table[:, 5] == 0.5 * 11.5)
