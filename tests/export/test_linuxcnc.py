"""LinuxCNC's interpreter reads the programs: contour, its own wheel compensation and gouge check, polar grinding.

Slow, and skipped where the interpreter is not installed (see ``linuxcnc.py``).
"""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from independent import ExactCurve
from linuxcnc import arc_points, interpreted

from cycloid_profile.design import DesignRecord
from cycloid_profile.export.nc import GcodeExporter, PolarExporter, WireExporter
from cycloid_profile.spec.model import GrindingSpec

pytestmark = pytest.mark.slow
TOLERANCE, ROUNDED = 5e-5, 1.5e-5


@pytest.fixture(scope="module")
def exact(rv40e_record: DesignRecord) -> ExactCurve:
    assert rv40e_record.compensation is not None
    return ExactCurve(equidistant=0.006, delta_max=rv40e_record.compensation.delta_max)


def asked(record: DesignRecord, **keys: Any) -> DesignRecord:
    """The same design with other keys under ``[export]``, ground in one pass."""
    keys = {"grinding": GrindingSpec(stock_um=0.0, spark_out_turns=0)} | keys
    export = msgspec.structs.replace(record.spec.export, **keys)
    return replace(record, spec=msgspec.structs.replace(record.spec, export=export))


def arcs_of(moves: list[tuple[Any, ...]], per_arc: int = 3) -> list[np.ndarray]:
    """Points inside every arc, shape (per_arc, 2) each."""
    here, found = np.zeros(2), []
    for move in moves:
        if move[0] == "arc":
            found.append(arc_points(here, move, per_arc))
        here = np.array(move[1:3])
    return found


@pytest.mark.parametrize(("compensation", "radius"), [("none", 0.0), ("G41", 2.4), ("G42", 2.4)])
def test_contour_and_its_compensation(
    rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path, compensation: str, radius: float
) -> None:
    record = asked(rv40e_record, wheel_compensation=compensation, wheel_radius_mm=radius or None)
    GcodeExporter().write(record, tmp_path)
    found = interpreted(tmp_path / "grinding.nc", tmp_path)
    assert found.error is None
    # First and last arc are lead-in and lead-out.
    points = np.concatenate(arcs_of(found.moves)[1:-1])
    off = exact.distance(points) - radius
    assert np.max(np.abs(off)) <= TOLERANCE + ROUNDED
    rotated = np.unwrap(np.arctan2(points[:, 1], points[:, 0]))
    assert abs(rotated[-1] - rotated[0]) == pytest.approx(2.0 * math.pi, abs=1e-2)


def test_wheel_almost_as_large_as_the_root(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    record = asked(rv40e_record, wheel_compensation="G41", wheel_radius_mm=3.05)
    # Without a deformation compensation the root is round.
    GcodeExporter().write(replace(record, profile=record.conventional), tmp_path)
    found = interpreted(tmp_path / "grinding.nc", tmp_path)
    assert found.error is None
    off = ExactCurve(0.006, 0.0).distance(np.concatenate(arcs_of(found.moves)[1:-1])) - 3.05
    assert np.max(np.abs(off)) <= TOLERANCE + ROUNDED


def test_the_gouge_at_a_groove_is_stated_in_the_program(
    rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path
) -> None:
    # This control runs every offset arc to its end, also at a groove: the wheel gouges the other flank.
    GcodeExporter().write(asked(rv40e_record, wheel_compensation="G41", wheel_radius_mm=3.0), tmp_path)
    program = tmp_path / "grinding.nc"
    stated = re.search(r"MAY CUT IN BY ([\d.]+) MICROMETRE", program.read_text(encoding="ascii"))
    assert stated is not None
    found = interpreted(program, tmp_path)
    # The deepest place is the end of an arc.
    off = exact.distance(np.concatenate(arcs_of(found.moves, 101)[1:-1])) - 3.0
    assert np.max(off) <= TOLERANCE + ROUNDED
    assert -np.min(off) == pytest.approx(1e-3 * float(stated[1]), abs=5e-5)
    assert float(stated[1]) > 0.05


def test_its_gouge_check_agrees_with_ours(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    # LinuxCNC refuses the same wheels: the program is written for a wheel that fits, then given one that does not.
    GcodeExporter().write(asked(rv40e_record, wheel_compensation="G41", wheel_radius_mm=3.0), tmp_path)
    program = tmp_path / "grinding.nc"
    text = program.read_text(encoding="ascii")
    assert "G41.1 D6.00000" in text
    program.write_text(text.replace("G41.1 D6.00000", "G41.1 D6.40000"), encoding="ascii")
    found = interpreted(program, tmp_path)
    assert found.error is not None
    assert "compensation" in found.error.lower() or "gouge" in found.error.lower() or "radius" in found.error.lower()


def test_polar_program(rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path) -> None:
    PolarExporter().write(asked(rv40e_record, wheel_radius_mm=2.4, grinding=GrindingSpec()), tmp_path)
    found = interpreted(tmp_path / "grinding_polar.nc", tmp_path)
    assert found.error is None
    # Down and near in air before the first turn, away after the last.
    cutting = found.moves[3:-2]
    lines = np.array([move[1:4] for move in cutting if move[0] == "line"])
    x, c = lines[:, 0], lines[:, 2]
    turns = 6
    assert c[-1] - c[0] == pytest.approx(360.0 * turns, abs=1e-6)
    assert np.all(np.diff(c) >= 0.0)
    # The last turn, spark-out, between its steps as well.
    count = int(np.count_nonzero(c > c[-1] - 360.0 + 1e-9))
    last_x, last_c = x[-count - 1 :], np.radians(c[-count - 1 :])
    assert last_x[0] == pytest.approx(last_x[-1], abs=1e-8)
    for share in (0.0, 0.5):
        wheel = (last_x[:-1] + share * np.diff(last_x)) * np.exp(-1j * (last_c[:-1] + share * np.diff(last_c)))
        points = np.stack([wheel.real, wheel.imag], axis=-1)[::5]
        assert np.max(np.abs(exact.distance(points) - 2.4)) <= TOLERANCE + 6e-6


def test_passes_and_the_way_between_them(rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path) -> None:
    record = asked(rv40e_record, wheel_compensation="G41", wheel_radius_mm=2.4, grinding=GrindingSpec())
    GcodeExporter().write(record, tmp_path)
    found = interpreted(tmp_path / "grinding.nc", tmp_path)
    assert found.error is None
    passes: list[list[tuple[Any, ...]]] = []
    height = None
    for move in found.moves:
        if move[0] == "rapid":
            # Fast at the safe height alone, or straight up to it.
            assert move[4] == pytest.approx(31.5)
            passes.append([])
        elif move[0] == "line":
            height = move[4]
        passes[-1].append(move)
    assert height == pytest.approx(-1.0)
    rounds = [one for one in passes if any(move[0] == "arc" for move in one)]
    for one, left in zip(rounds, (0.015, 0.010, 0.005, 0.0, 0.0, 0.0), strict=True):
        off = exact.distance(np.concatenate(arcs_of(one, 1)[1:-1])[::7]) - 2.4 - left
        assert np.max(np.abs(off)) <= TOLERANCE + ROUNDED


def test_wire_program(rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path) -> None:
    WireExporter().write(rv40e_record, tmp_path)
    found = interpreted(tmp_path / "wire_edm.nc", tmp_path)
    assert found.error is None
    points = np.concatenate(arcs_of(found.moves))
    teeth = points[np.hypot(*points.T) > 59.0]
    off = exact.distance(teeth)
    assert np.min(off) >= 0.14 - TOLERANCE - ROUNDED
    assert np.all(np.min(np.abs(off[:, np.newaxis] - [0.14, 0.15, 0.18]), axis=1) <= TOLERANCE + ROUNDED)
