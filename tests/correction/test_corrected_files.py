"""Files of a corrected tooth, read back and measured, on lobes that differ."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from cycloid_profile.correction import correction
from cycloid_profile.correction._deviation import deviation_from_nominal
from cycloid_profile.correction._profile import correction_profile
from cycloid_profile.design import DesignRecord
from cycloid_profile.export import exporter_for, write_formats
from cycloid_profile.export.curves import SpecifiedProfile, distances
from cycloid_profile.export.nc import GcodeExporter, read_gcode
from cycloid_profile.export.points import CmmExporter, ProfileCsvExporter, read_table
from cycloid_profile.modification import NormalDeviation
from cycloid_profile.spec import read_spec
from cycloid_profile.units import UM
from tests.diagnosis.correcting import HIDDEN, LOBES, NOISE, drawn, found, named, of_table, reground

ROOT = Path(__file__).parents[2]


def path_of(program: Any) -> SpecifiedProfile:
    """A grinding path with the spec of the RV-40E."""
    spec = read_spec(ROOT / "examples" / "rv40e.toml")
    return SpecifiedProfile(spec, drawn().case.drive, program)


def from_chords(chords: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Distance of each point from the nearest chord near its nearest corner [mm]."""
    _, i = cKDTree(np.stack([chords.real, chords.imag], axis=-1)).query(np.stack([z.real, z.imag], axis=-1))
    off = np.full(z.size, np.inf)
    for a in (np.maximum(i - 1, 0), np.minimum(i, chords.size - 2)):
        b = a + 1
        way = chords[b] - chords[a]
        share = np.clip((np.conj(way) * (z - chords[a])).real / np.abs(way) ** 2, 0.0, 1.0)
        off = np.minimum(off, np.abs(z - chords[a] - share * way))
    return off


@pytest.mark.slow
@pytest.mark.parametrize("number", [7, 9])
def test_files_with_different_lobes_meet_their_tolerance(number: int, tmp_path: Path) -> None:
    program = correction(found(drawn(), [named(of_table(HIDDEN[number]))])).program
    assert not program.identical_lobes
    path = path_of(program)
    for exporter in (ProfileCsvExporter(), GcodeExporter(filename="corrected.nc"), CmmExporter()):
        (written,) = exporter.write(path, tmp_path)
        assert written.deviation is not None
        assert written.tolerance is not None
        assert written.deviation.largest <= written.tolerance
    arcs, _ = read_gcode(tmp_path / "corrected.nc")
    nc = replace(arcs, ends=arcs.ends[2:-2], curvature=arcs.curvature[2:-2]).points()
    csv = read_table(tmp_path / "profile.csv")[:, 1] + 1j * read_table(tmp_path / "profile.csv")[:, 2]
    cmm = read_table(tmp_path / "cmm_nominal.csv")[:, 3] + 1j * read_table(tmp_path / "cmm_nominal.csv")[:, 4]
    # Measured without the package's foot points, on chords within 2 nm of the exact curve.
    chords = program.at(np.linspace(0.0, 2.0 * math.pi * LOBES, LOBES * 12000 + 1)).position
    for z, promise in ((nc, 0.065), (csv, 0.002), (cmm, 0.002)):
        assert np.max(from_chords(chords, z)) < promise * UM
    # The file holds the corrected curve, not the drawing.
    largest = deviation_from_nominal(drawn().teeth[0], program).largest
    assert np.max(np.abs(distances(drawn().teeth[0], nc))) == pytest.approx(largest, abs=0.07 * UM)
    # The path ends at its start, at a tip.
    assert abs(arcs.ends[2] - arcs.ends[-3]) < 2e-5
    assert abs(arcs.ends[2]) > 0.999 * np.max(np.abs(nc))


@pytest.mark.slow
def test_a_non_integer_wave_is_cancelled_at_its_seam(tmp_path: Path) -> None:
    error = of_table({"name": "grinding_chatter", "amplitude_um": 0.5, "waves_per_turn": 300.5})
    result = correction(found(drawn(), [named(error)]))
    assert result.residual < 1e-6
    assert reground(result, [error]) < 1.03 * NOISE
    (written,) = GcodeExporter().write(path_of(result.program), tmp_path)
    assert written.deviation is not None
    assert written.deviation.largest <= 0.065 * UM


@pytest.mark.slow
def test_step_contains_every_lobe(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    pytest.importorskip("OCP", reason="the CAD kernel is not installed")
    along = np.arange(0.0, 2.0 * math.pi * LOBES, 0.25)
    program = correction_profile(rv40e_record.profile, replace(rv40e_record.profile, removals=(
        *rv40e_record.profile.removals, NormalDeviation(along, 2.0 * UM * np.sin(along / LOBES), LOBES),
    )))  # fmt: skip
    record_of_disc = replace(rv40e_record, profile=program)
    assert not program.identical_lobes
    (step, _), skipped = write_formats(record_of_disc, ("step",), tmp_path)
    assert not skipped
    assert step.entities["tooth_edges"] == 2 * LOBES
    assert step.deviation is not None
    # Against the drawing it deviates by the whole removal.
    assert step.deviation.largest <= 0.05 * UM
    assert deviation_from_nominal(rv40e_record.profile, program).largest == pytest.approx(2.0 * UM, rel=0.01)


def test_files_with_identical_lobes_are_unchanged(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    bare = SpecifiedProfile(rv40e_record.spec, rv40e_record.drive, rv40e_record.profile)
    for name in ("csv", "gcode", "cmm"):
        exporter: Any = exporter_for(name)
        exporter.write(bare, tmp_path)
        committed = (ROOT / "exports" / "rv40e" / exporter.filename).read_text(encoding="ascii").splitlines()
        mine = (tmp_path / exporter.filename).read_text(encoding="ascii").splitlines()
        # Another processor may round a last digit differently; the number of points must agree.
        assert len(mine) == len(committed)
        assert sum(a != b for a, b in zip(mine, committed, strict=True)) <= 0.05 * len(mine)
