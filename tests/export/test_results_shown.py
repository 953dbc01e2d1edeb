"""Results print as a few figures, tables convert to a data frame, and a misspelt format names the nearest one."""

from __future__ import annotations

import numpy as np
import pytest

import cycloid_profile as cp
from cycloid_profile.design import DesignRecord
from cycloid_profile.errors import ExportError


def results(record: DesignRecord) -> list[object]:
    profile = record.profile
    measured = cp.NormalDeviation(np.linspace(0.0, 6.0, 500), np.zeros(500), 1)
    deviating = cp.modify(profile, cp.MeasuredDeviation(measured))
    return [
        profile,
        deviating,
        deviating.removals[-1],
        record.outline,
        profile.at(np.linspace(0.0, 1.0, 5000)),
        profile.at(np.empty(0)),
        cp.geometry.point_cloud(profile, np.linspace(0.0, 1.0, 5000)),
        cp.export.disc_arcs(profile, 1e-3),
        cp.export.disc_splines(profile, 3, 1e-3)[0],
        cp.export.polar_grinding(record),
        cp.export.polar_grinding(record).path,
        cp.export.inspection_plan(record),
    ]


def test_every_large_result_prints_within_fifteen_lines(rv40e_record: DesignRecord) -> None:
    for result in results(rv40e_record):
        lines = repr(result).splitlines()
        assert len(lines) <= 15
        assert max(map(len, lines)) <= 160
        assert lines[0].startswith(type(result).__name__)


def test_points_convert_to_a_data_frame(rv40e_record: DesignRecord) -> None:
    pytest.importorskip("pandas")
    psi = np.linspace(0.0, 1.0, 7)
    for points in (rv40e_record.profile.at(psi), cp.geometry.point_cloud(rv40e_record.profile, psi)):
        frame = points.to_frame()
        assert list(frame.columns) == ["psi_rad", "x_mm", "y_mm", "nx", "ny", "curvature_per_mm"]
        np.testing.assert_array_equal(frame["psi_rad"], psi)
        np.testing.assert_allclose(np.hypot(frame["nx"], frame["ny"]), 1.0, rtol=1e-12)


@pytest.mark.parametrize(("name", "says"), [("dxff", "did you mean dxf?"), ("???", "choose from csv, dxf")])
def test_a_misspelt_format_names_the_nearest_one(name: str, says: str) -> None:
    with pytest.raises(ExportError, match=f"'{name}' is not known".replace("?", r"\?")) as caught:
        cp.export.exporter_for(name)
    assert says in str(caught.value)


def test_formats_are_one_table() -> None:
    assert len(cp.export.EXPORTERS) == 23
    assert all(name == exporter.format for name, exporter in cp.export.EXPORTERS.items())
    names = [name for exporter in cp.export.EXPORTERS.values() for name in exporter.filenames]
    assert len(names) == len(set(names))
