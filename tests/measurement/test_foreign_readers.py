"""Readers: round trips through every dialect and public format, their refusals, and readers of plug-ins."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.design import DesignRecord
from cycloid_profile.errors import MeasurementError, PluginError
from cycloid_profile.export.points import VdaExporter
from cycloid_profile.export.points.nominal_points import measuring_points
from cycloid_profile.measurement import SourceTable, format_measurement, read_measurement, register_reader
from cycloid_profile.measurement.foreign import measurement_of, parse_columns, read_source, readers
from tests.measurement.foreign.make_files import qif

FILES = Path(__file__).parent / "foreign" / "files"
# Names of torque and angle with their units, and the sizes of the units in N·m and arcmin.
HEADERS = {
    "Torque [Nm]|Angle [arcmin]": (1.0, 1.0),
    "Drehmoment in N·m|Verdrehung in °": (1.0, 60.0),
    "torque_nmm|twist_arcsec": (1e-3, 1.0 / 60.0),
    "转矩(N·m)|转角(°)": (1.0, 60.0),
    "T (kNm)|phi (mrad)": (1e3, 60.0 * 180.0 / np.pi * 1e-3),
}
DELIMITERS = {"semicolon": ";", "tab": "\t", "bar": "|", "comma": ","}
ROWS = st.lists(
    st.tuples(st.floats(-1e3, 1e3), st.floats(-1e2, 1e2)).map(lambda row: tuple(round(v, 6) for v in row)),
    min_size=4, max_size=20,
)  # fmt: skip


@given(
    rows=ROWS,
    header=st.sampled_from(sorted(HEADERS)),
    delimiter=st.sampled_from(sorted(DELIMITERS)),
    decimal=st.sampled_from(".,"),
    encoding=st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "cp1252", "gb18030"]),
    newline=st.sampled_from(["\n", "\r\n", "\r"]),
)
def test_a_table_of_any_dialect_keeps_its_values(
    rows: list[tuple[float, float]], header: str, delimiter: str, decimal: str, encoding: str, newline: str
) -> None:
    sign = DELIMITERS[delimiter]
    if sign == decimal or (encoding == "cp1252" and "转" in header):
        return
    lines = [sign.join(header.split("|")), *(sign.join(f"{v:.6f}".replace(".", decimal) for v in row) for row in rows)]
    data = newline.join(lines).encode(encoding)
    found = measurement_of(read_source(data, "loop.csv"))
    for column, values, size in zip(found.kind.columns, zip(*rows, strict=True), HEADERS[header], strict=True):
        np.testing.assert_allclose(found[column], np.array(values) * size, rtol=1e-12, atol=1e-12)


@given(st.binary(max_size=200) | st.text(max_size=200).map(str.encode))
def test_whatever_a_file_holds_is_read_or_refused(data: bytes) -> None:
    with suppress(MeasurementError, UnicodeError):
        found = measurement_of(read_source(data, "any"))
        assert found.rows >= 2
        assert all(np.all(np.isfinite(values)) for values in found.columns.values())


@pytest.mark.parametrize("long", ["x" + " " * 200_000 + "y", "[" * 200_000, "Torque" + ";" * 200_000, "1" * 200_000])
def test_a_line_without_end_is_no_header(long: str) -> None:
    with pytest.raises(MeasurementError):
        measurement_of(read_source(f"{long}\n1 2\n3 4\n5 6\n".encode(), "any"))


@given(st.dictionaries(st.sampled_from(["x", "y", "torque", "angle", "deviation"]), st.sampled_from(
    ["X", "-Y [mm]", "3", "Kraft, gemessen", "转角", "a b"]), min_size=1))  # fmt: skip
def test_a_mapping_comes_back_from_its_text(columns: dict[str, str]) -> None:
    text = ",".join(f'"{role}={name.replace(" [mm]", "")}"' for role, name in columns.items()) + ",datum=free"
    mapping = parse_columns(text)
    assert parse_columns(str(mapping)) == mapping


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x,y\n59,694,0,012\n59,690,0,112\n59,100,0,212\n", "export with semicolons"),
        ("Torque: 412 Nm\nTorque: 12 Nm\nangle [°];TE [arcsec]\n0;1\n9;2\n", "'412' and '12' are two values"),
        ("Rated torque: 412 Nm\nangle [°];TE [arcsec]\n0;1\n9;2\n", "torque_nm = not given"),
        ("angle [°];TE [arcsec];Torque [Nm]\n0;1;400\n9;2;12\n", "was not held"),
        ("Torque: 12 Nm\nangle [°];TE [arcsec];Torque [Nm]\n0;1;400\n9;2;400\n", "was not held at 12 N·m"),
        ("x [mm];y [mm]\n1,5;2.5\n1,6;2,6\n1,7;2,7\n", "decimal comma"),
        ("x [mm];y [mm]\n１.5;2.5\n1.6;2.6\n1.7;2.7\n", "is not a finite number"),
        ("5_9.7 0.0 5.75\n59.7 0.0 5.75\n0.0 59.7 5.75\n-59.7 0.0 5.75\n0.0 -59.7 5.75\n", "line 1 = '5_9.7'"),
        ("x [mm];y [mm]\n1.6;2.6\n1e999;2.6\n1.7;2.7\n", "is not a finite number"),
        ("x [mm];y [mm]\n1.6;2.6\n", "rows = 1 are too few"),
        ("kind: te_curve\nx [mm];y [mm]\n1.6;2.6\n1.6;2.6\n", "kind = 'te_curve' is not known"),
    ],
)
def test_a_doubtful_table_is_refused(text: str, said: str) -> None:
    with pytest.raises(MeasurementError) as refused:
        measurement_of(read_source(text.encode(), "any.csv"))
    assert said in str(refused.value)
    assert str(refused.value).startswith("any.csv: ")


def test_a_torque_that_the_file_states_otherwise_is_refused() -> None:
    table = read_source("Torque: 412 Nm\nangle [°];TE [arcsec]\n0;1\n9;2\n".encode(), "te.csv")
    assert measurement_of(table, parse_columns("torque_nm=412.0")).number("torque_nm") == 412.0
    with pytest.raises(MeasurementError, match="is not the 412 that the file states"):
        measurement_of(table, parse_columns("torque_nm=12"))


def test_vda_fs_of_the_exporter_comes_back(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    VdaExporter().write(rv40e_record, tmp_path)
    found = read_measurement(tmp_path / "cmm_nominal.vda")
    points, _ = measuring_points(rv40e_record)
    np.testing.assert_allclose(found["x_mm"] + 1j * found["y_mm"], points.position, rtol=0.0, atol=1e-9)
    assert "VDA-FS" in found.notes[0]


def test_units_of_public_formats() -> None:
    z = 50.0 * np.exp(1j * np.linspace(0.0, 6.0, 20))
    text = qif(z / 25.4).replace("0.001", "0.0254").replace("0.5<", f"{0.5 / 25.4}<")
    found = measurement_of(read_source(text.encode(), "p.qif"))
    np.testing.assert_allclose(found["x_mm"], z.real, atol=2e-5)
    assert found.pending is not None
    assert found.pending.probe_radius == pytest.approx(0.5)
    dmis = (FILES / "cmm_output.dmo").read_text(encoding="utf-8")
    inch = measurement_of(read_source(dmis.replace("UNITS/MM", "UNITS/INCH").encode(), "p.dmo"))
    np.testing.assert_allclose(inch["x_mm"], 25.4 * read_measurement(FILES / "cmm_output.dmo")["x_mm"])


@pytest.mark.parametrize(
    ("name", "old", "new", "said"),
    [
        ("cmm_points.qif", "<QIFDocument", '<!DOCTYPE a [<!ENTITY b "c">]><QIFDocument', "declares XML entities"),
        ("cmm_points.qif", "</QIFDocument>", "", "is no XML"),
        ("cmm_points.qif", "<Factor>0.001<", "<Factor>0.3048<", "LinearUnit factor = 0.3048 is not known"),
        ("cmm_points.qif", "<ProbeRadius>0.5<", "<ProbeRadius>0.7<", "several probe radii"),
        ("cmm_points.qif", "MeasurePoint ", "Other ", "is no XML"),
        ("cmm_pset.vda", "PSET / 200", "PSET / 201", "are not 3 for each of 201 points"),
        ("cmm_output.dmo", "UNITS/MM", "UNITS/FEET", "UNITS = 'FEET' is not known"),
        ("cmm_output.dmo", "CART,5", "CART,5_", "point"),
    ],
)
def test_a_damaged_file_is_refused(name: str, old: str, new: str, said: str, tmp_path: Path) -> None:
    text = (FILES / name).read_text(encoding="utf-8")
    assert old in text
    (tmp_path / name).write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(MeasurementError, match=said) as refused:
        read_measurement(tmp_path / name)
    assert name in str(refused.value)


@dataclass(frozen=True)
class Tagged:
    """A reader of a plug-in: lines of ``angle:torque`` after a tag."""

    name: str = "tagged"

    def recognises(self, data: bytes) -> bool:
        return data.startswith(b"@tagged")

    def read(self, data: bytes, name: str) -> SourceTable:
        rows = [(n, line.split(":")) for n, line in enumerate(data.decode().splitlines(), 1) if n > 1]
        return SourceTable(name, ("angle", "torque"), ("arcmin", "N·m"), rows)


@pytest.fixture
def _without_plugins(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(readers, "_registered", [])


@pytest.mark.usefixtures("_without_plugins")
def test_a_registered_reader_is_asked_first(tmp_path: Path) -> None:
    file = tmp_path / "loop.tag"
    file.write_text("@tagged\n0.5:10\n0.7:20\n0.5:10\n", encoding="utf-8")
    with pytest.raises(MeasurementError):
        read_measurement(file)
    register_reader(Tagged())
    found = read_measurement(file)
    np.testing.assert_array_equal(found["torque_nm"], [10.0, 20.0, 10.0])
    assert "tagged" in found.notes[0]
    # It becomes a file of our own format.
    own = tmp_path / "loop.csv"
    own.write_text(format_measurement(found), encoding="utf-8")
    np.testing.assert_array_equal(read_measurement(own)["angle_arcmin"], found["angle_arcmin"])
    with pytest.raises(PluginError, match="is no reader"):
        register_reader("tagged")


def test_an_installed_reader_is_found_and_a_broken_one_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    good = EntryPoint("tagged", f"{__name__}:Tagged", readers.READER_GROUP)
    broken = EntryPoint("broken", "no_such_module:Reader", readers.READER_GROUP)
    monkeypatch.setattr(EntryPoint, "load", lambda one: Tagged if one.name == "tagged" else int("x"))
    monkeypatch.setattr(readers, "entry_points", lambda group: [good, broken] if group == readers.READER_GROUP else [])
    monkeypatch.setattr(readers, "_installed", readers._installed.__wrapped__)
    with pytest.warns(UserWarning, match="the reader 'broken' .* is left out"):
        table = read_source(b"@tagged\n0.5:10\n0.7:20\n", "loop.tag")
    assert table.layout == "tagged"
