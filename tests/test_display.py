"""How results introduce themselves: short ``repr``, HTML with key figures and picture, tables for pandas."""

from __future__ import annotations

import dataclasses
import html
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import msgspec
import numpy as np
import pytest

from cycloid_profile import plot
from cycloid_profile._display import MOST_FIGURES, Described, figure_text, frame
from cycloid_profile.design import DesignRecord, as_built_reducer, design_disc, tolerance_record
from cycloid_profile.diagnosis import diagnose
from cycloid_profile.errors import CycloidError
from cycloid_profile.rig import Settings, simulate
from cycloid_profile.spec import parse_spec, read_spec
from cycloid_profile.tolerance.study import Threads

RV40E = Path(__file__).parents[1] / "examples" / "rv40e.toml"
RUNOUT = '\n[[effects]]\nname = "disc_runout"\namplitude_um = 3.0\n'
PINS = '\n[[tolerance.effects]]\nname = "single_pin_error"\neach = "pin"\namount_um = { plus_minus = 1.0 }\n'
LONGEST_REPR = 2000  # characters


@dataclasses.dataclass(frozen=True, repr=False)
class Sample(Described):
    """A result with markup in a value and more figures than fit."""

    count: int = 3

    def _key_figures(self) -> dict[str, str]:
        return {"a < b": "<script>\n&", **{f"figure {i}": figure_text(float(i), "mm") for i in range(self.count)}}


def described_parts(result: Any, seen: set[int] | None = None) -> Iterator[Described]:
    """A result and all results inside it that describe themselves."""
    seen = set() if seen is None else seen
    if id(result) in seen or isinstance(result, np.ndarray | str):
        return
    seen.add(id(result))
    if isinstance(result, Described):
        yield result
    parts: list[Any] = []
    if dataclasses.is_dataclass(result):
        parts = [getattr(result, field.name) for field in dataclasses.fields(result)]
    elif isinstance(result, msgspec.Struct):
        parts = list(msgspec.structs.asdict(result).values())
    elif isinstance(result, tuple | list):
        parts = list(result)
    for part in parts:
        yield from described_parts(part, seen)


@pytest.fixture(scope="module")
def record() -> DesignRecord:
    """The RV-40E with one effect."""
    return design_disc(parse_spec(RV40E.read_text(encoding="utf-8") + RUNOUT))


@pytest.fixture(scope="module")
def results(record: DesignRecord) -> dict[str, Described]:
    """One result of each class that describes itself, by its name."""
    reducer = as_built_reducer(read_spec(RV40E))
    kinds = ("profile_scan", "hysteresis", "transmission_error", "lost_motion_map")
    measured = [simulate(reducer, kind, Settings(points=400)) for kind in kinds]
    return {type(part).__name__: part for part in described_parts([record, reducer, *measured])}


def test_sample_has_one_line_for_each_figure_and_escaped_html() -> None:
    lines = repr(Sample()).splitlines()
    assert lines[0] == "Sample"
    assert lines[1] == "  a < b     <script> &"
    assert lines[2] == "  figure 0  0 mm"
    assert len(repr(Sample(40)).splitlines()) == MOST_FIGURES + 1 == 15


def test_figures_carry_their_unit() -> None:
    assert figure_text(12.34567, "mm") == "12.35 mm"
    assert figure_text(0.81234, "′") == "0.8123′"
    assert figure_text(1e-12, "µm") == "0 µm"
    assert figure_text(None) == figure_text(float("nan"), "N") == "–"


def test_results_cover_the_design_and_its_accuracy(results: dict[str, Described]) -> None:
    assert {"DesignRecord", "Accuracy", "AsBuiltAccuracy"} <= set(results)


def test_repr_of_every_result_is_short_and_has_units(results: dict[str, Described]) -> None:
    for name, result in results.items():
        text = repr(result)
        assert text.startswith(name)
        assert 2 <= len(text.splitlines()) <= 15, text
        assert len(text) < LONGEST_REPR, text
        assert "array(" not in text


def test_design_record_shows_its_key_figures(record: DesignRecord) -> None:
    text = repr(record)
    for part in (
        "RV-40E",
        "39 lobes, 40 pins",
        "412 N·m",
        "disc_runout",
        "9 passed; 4 not checked",
        "→",
        "N·m/′",
        "MPa",
    ):
        assert part in text


def test_html_of_a_record_holds_picture_and_figures(record: DesignRecord) -> None:
    text = record._repr_html_()
    assert "<svg" in text
    for name, value in record._key_figures().items():
        assert html.escape(name) in text
        assert html.escape(value) in text


def test_html_of_specs_load_sharings_and_diagnoses_holds_a_picture(record: DesignRecord) -> None:
    reducer = as_built_reducer(record.spec)
    found = diagnose(reducer, [simulate(reducer, "profile_scan", Settings(points=2000, noise=0.1))])
    for result in (record.spec, record.equilibrium, record.under_load, found):
        assert "<svg" in result._repr_html_(), type(result)
    assert all(ax.has_data() for ax in plot.file_residuals(found, file=0)[:2])


def test_html_is_well_formed(monkeypatch: pytest.MonkeyPatch, results: dict[str, Described]) -> None:
    monkeypatch.setattr(plot, "figure_of", lambda _: None, raising=False)
    for result in (Sample(), *results.values()):
        page = ElementTree.fromstring(f"<div>{result._repr_html_()}</div>")
        cells = [(row[0].text, row[1].text) for row in page.iter("tr")]
        assert cells == result._rows()


def test_picture_is_inline_svg_without_xml_header(monkeypatch: pytest.MonkeyPatch) -> None:
    from matplotlib.figure import Figure

    monkeypatch.setattr(plot, "figure_of", lambda _: Figure(), raising=False)
    text = Sample()._repr_html_()
    assert "<svg" in text
    assert "<?xml" not in text
    assert "<script>" not in text


def test_frame_needs_pandas(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> Any:
        raise ImportError(name)

    monkeypatch.setattr("cycloid_profile._display.import_module", missing)
    with pytest.raises(CycloidError, match=r"^pandas is not installed: install it with pip install pandas$"):
        frame({"a": [1]})


def test_tables_become_frames(results: dict[str, Described], record: DesignRecord) -> None:
    pytest.importorskip("pandas")
    table = record.compensated_accuracy.to_frame()
    assert list(table.columns) == ["torque_nm", "crank_angle_deg", "rotation_arcmin"]
    assert len(table) == record.compensated_accuracy.rotation.size
    loaded = table[table["torque_nm"] > 411.0]["rotation_arcmin"]
    assert loaded.max() - loaded.min() == pytest.approx(record.compensated_accuracy.transmission_error * 3437.747)
    for result in results.values():
        if hasattr(result, "to_frame"):
            assert len(result.to_frame()) > 0


@pytest.mark.slow
def test_tolerance_record_describes_itself(tmp_path: Path) -> None:
    tables = f"[tolerance]\nloaded_samples = 0\nsamples = 1000\n[tolerance.limits]\nbacklash_arcmin = 0.55\n{PINS}"
    spec = parse_spec(RV40E.read_text(encoding="utf-8") + "\n" + tables)
    found = tolerance_record(spec, tmp_path, Threads(1))
    lines = repr(found).splitlines()
    assert lines[0] == "ToleranceRecord"
    assert "<svg" in found._repr_html_()
    assert "<svg" in found.backlash._repr_html_()
    assert len(lines) <= 15
    assert any("yield" in line and "%" in line for line in lines)
    columns = found.columns()
    assert columns["quantity"] == ["backlash_arcmin", "least_backlash_arcmin"]
    assert columns["at_most"] == [0.55, None]
    assert {len(values) for values in columns.values()} == {2}
    pandas = pytest.importorskip("pandas")
    assert isinstance(found.to_frame(), pandas.DataFrame)


@pytest.mark.parametrize(
    ("value", "digits", "shown"),
    [(9999.4, 4, "9999"), (9999.7, 4, "10,000"), (99.96, 2, "100"), (13280.4, 4, "13,280"), (0.52584, 4, "0.5258")],
)
def test_a_figure_that_rounds_up_to_the_limit_has_no_power_of_ten(value: float, digits: int, shown: str) -> None:
    assert figure_text(value, "", digits) == shown
