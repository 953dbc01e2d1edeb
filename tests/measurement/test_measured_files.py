"""Measured files: there and back, what a spreadsheet makes of them, and one sentence for each that is none."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cycloid_profile.cli.main import run
from cycloid_profile.errors import MeasurementError
from cycloid_profile.measurement import (
    FORMAT,
    HYSTERESIS,
    KINDS,
    Measurement,
    format_measurement,
    parse_measurement,
    read_measurement,
)
from cycloid_profile.measurement._strict import finite_number

RV40E = Path(__file__).parents[2] / "examples" / "rv40e.toml"
NEEDED = {"transmission_error": {"torque_nm": "412"}, "lost_motion_map": {"torque_nm": "12.36"}}
GOOD = f"""# format: {FORMAT}
# kind: hysteresis
# output_angle_deg: 5.0
# input: locked
torque_nm,angle_arcmin
0.0,0.0
412.0,1.5
0.0,0.6
-412.0,-1.0
0.0,-0.1
412.0,1.5
"""
every_kind = pytest.mark.parametrize("kind", sorted(KINDS))
# Lengths, angles and torques of any machine; seven decimals are written.
values = st.floats(-1e6, 1e6)
words = st.text(
    st.characters(whitelist_categories=["L", "N"], whitelist_characters=" _-/.µ′"), min_size=1, max_size=20
).map(str.strip)
keys = st.dictionaries(
    st.from_regex(r"[a-z][a-z_]{0,14}", fullmatch=True).filter(
        lambda key: (
            key not in {"format", "kind", "torque_nm", "output_angle_deg", "temperature_c"} and "noise" not in key
        )
    ),
    words.filter(bool),
    max_size=4,
)


def measured(kind, table, extra=None) -> Measurement:
    columns = dict(zip(KINDS[kind].columns, table.T, strict=True))
    return Measurement(KINDS[kind], columns, {**NEEDED.get(kind, {}), **(extra or {})})


@every_kind
@given(arrays(np.float64, st.tuples(st.integers(2, 30), st.just(2)), elements=values), keys)
def test_a_file_comes_back_as_it_was(kind, table, extra):
    written = measured(kind, table, extra)
    read = parse_measurement(format_measurement(written), "file.csv")
    assert read.kind is KINDS[kind]
    assert read.name == "file.csv"
    for name in KINDS[kind].columns:
        np.testing.assert_allclose(read[name], written[name], rtol=0.0, atol=0.51e-7)
    assert {**written.keys, "format": FORMAT, "kind": kind} == read.keys
    # Once rounded it does not change any more.
    assert format_measurement(read) == format_measurement(parse_measurement(format_measurement(read)))


@every_kind
def test_rows_stay_in_the_order_of_measurement(kind):
    table = np.array([[3.0, 1.0], [1.0, 2.0], [2.0, 3.0], [1.0, 2.0]])
    read = parse_measurement(format_measurement(measured(kind, table)))
    np.testing.assert_array_equal(np.column_stack([read[name] for name in KINDS[kind].columns]), table)


def test_a_file_has_no_minus_zero():
    written = format_measurement(measured("hysteresis", np.array([[-0.0, -1e-12], [1.0, 2.0]])))
    assert "-0.0" not in written


def test_numbers_among_the_keys():
    text = GOOD.replace("# input", "# noise_arcmin: 4e-3\n# temperature_c: 21.5\n# input")
    read = parse_measurement(text)
    assert read.number("output_angle_deg") == 5.0
    assert read.number("noise_arcmin") == 0.004
    assert read.number("torque_nm") is None


@pytest.mark.parametrize(
    "change",
    [
        pytest.param(lambda text: text, id="as it is"),
        pytest.param(lambda text: "\ufeff" + text, id="byte order mark"),
        pytest.param(lambda text: text.replace("\n", "\r\n"), id="lines of Windows"),
        pytest.param(lambda text: text.replace("\n", "\r"), id="lines of an old Macintosh"),
        pytest.param(lambda text: text.replace("\n", "\n\n"), id="empty lines"),
        pytest.param(lambda text: text + "\n# the end\n", id="comment at the end"),
        pytest.param(lambda text: text.replace("0.0,0.6", "# paused here\n0.0,0.6"), id="comment between rows"),
        pytest.param(lambda text: "# measured on a Friday\n" + text, id="comment in front"),
        pytest.param(lambda text: text.replace(",", " , "), id="blanks about commas"),
        pytest.param(lambda text: text.replace("# ", "#   "), id="blanks about keys"),
        pytest.param(lambda text: text.replace("# kind", "# KIND"), id="capital keys"),
        pytest.param(lambda text: text.rstrip("\n"), id="no last line end"),
        pytest.param(lambda text: text.replace("412.0,1.5", "+4.12e2,.15E+1"), id="other ways to write numbers"),
        pytest.param(lambda text: text.removeprefix(f"# format: {FORMAT}\n"), id="no format"),
    ],
)
def test_changes_by_editors_and_spreadsheets_do_not_matter(tmp_path: Path, change: Callable[[str], str]):
    path = tmp_path / "loop.csv"
    path.write_bytes(change(GOOD).encode("utf-8"))
    read, plain = read_measurement(path), parse_measurement(GOOD)
    assert read.kind is HYSTERESIS
    assert read.name == "loop.csv"
    for name in HYSTERESIS.columns:
        np.testing.assert_array_equal(read[name], plain[name])
    assert read.keys["input"] == "locked"
    assert read.number("output_angle_deg") == 5.0


def test_unknown_keys_are_kept():
    read = parse_measurement(GOOD.replace("# input", "# operator: Ms Müller, night shift: 2\n# input"))
    assert read.keys["operator"] == "Ms Müller, night shift: 2"


TE = GOOD.replace("hysteresis", "transmission_error").replace("torque_nm,angle_arcmin", "output_angle_deg,error_arcsec")
REFUSED = {
    "wrong header": (GOOD.replace("angle_arcmin", "angle_deg"), "header", "torque_nm,angle_arcmin"),
    "columns swapped": (GOOD.replace("torque_nm,angle_arcmin", "angle_arcmin,torque_nm"), "header", "torque_nm,angle"),
    "semicolons": (GOOD.replace(",", ";"), "header", "torque_nm,angle_arcmin"),
    "no header": (GOOD.replace("torque_nm,angle_arcmin\n", ""), "header", "torque_nm,angle_arcmin"),
    "nothing but keys": (GOOD.split("torque_nm")[0], "header", "torque_nm,angle_arcmin"),
    "unknown kind": (GOOD.replace("hysteresis", "histeresis"), "kind", "hysteresis"),
    "no kind": (GOOD.replace("# kind: hysteresis\n", ""), "kind", "hysteresis"),
    "empty": ("", "kind", "hysteresis"),
    "another format": (GOOD.replace("measurement 1", "measurement 2"), "format", FORMAT),
    "no torque": (TE, "torque_nm", "write '# torque_nm: '"),
    "no torque of a map": (
        TE.replace("transmission_error", "lost_motion_map").replace("error_arcsec", "lost_motion_arcmin"),
        "torque_nm",
        "write '# torque_nm: '",
    ),
    "torque with its unit": (TE.replace("# input", "# torque_nm: 412 N·m\n# input"), "torque_nm", "without its unit"),
    "torque that is no number": (TE.replace("# input", "# torque_nm: nan\n# input"), "torque_nm", "without its unit"),
    "noise that is endless": (GOOD.replace("# input", "# noise_um: inf\n# input"), "noise_um", "without its unit"),
    "not a number": (GOOD.replace("0.0,0.6", "0.0,nan"), "line 8", "numbers"),
    "endless": (GOOD.replace("0.0,0.6", "inf,0.6"), "line 8", "numbers"),
    "too large for a float": (GOOD.replace("0.0,0.6", "1e999,0.6"), "line 8", "numbers"),
    "text": (GOOD.replace("0.0,0.6", "0.0,broken"), "line 8", "numbers"),
    "decimal commas": (GOOD.replace("0.0,0.6", "0,0,0,6"), "line 8", "numbers"),
    "one column": (GOOD.replace("0.0,0.6", "0.0"), "line 8", "numbers"),
    "an empty cell": (GOOD.replace("0.0,0.6", "0.0,"), "line 8", "numbers"),
    "an underscore among digits": (GOOD.replace("412.0,1.5", "4_12.0,1.5"), "line 7", "numbers"),
    "full-width digits": (GOOD.replace("0.0,0.6", "0.0,０.６"), "line 8", "numbers"),
    "hexadecimal": (GOOD.replace("0.0,0.6", "0.0,0x6"), "line 8", "numbers"),
    "an error value first": (GOOD.replace("0.0,0.6", "#DIV/0!,0.6"), "line 8", "numbers"),
    "a row of error values": (GOOD.replace("0.0,0.6", "#N/A,#N/A"), "line 8", "numbers"),
    "a German error value": (GOOD.replace("0.0,0.6", "#NV"), "line 8", "numbers"),
    "a column too narrow": (GOOD.replace("0.0,0.6", "#####,0.6"), "line 8", "numbers"),
    "a key twice": (GOOD.replace("# input", "# output_angle_deg: 7.0\n# input"), "line 4", "keep one"),
    "a number of a key with an underscore": (GOOD.replace("5.0", "5_0"), "output_angle_deg", "without its unit"),
    "header twice": (GOOD.replace("0.0,0.6", "torque_nm,angle_arcmin"), "line 8", "numbers"),
    "one row": ("\n".join(GOOD.splitlines()[:6]) + "\n", "rows", "at least two"),
    "no row": ("\n".join(GOOD.splitlines()[:5]) + "\n", "rows", "at least two"),
}


@pytest.mark.parametrize("fault", REFUSED)
def test_a_faulty_file_is_refused_with_place_and_remedy(fault):
    text, place, remedy = REFUSED[fault]
    with pytest.raises(MeasurementError) as refused:
        parse_measurement(text, "loop.csv")
    error = refused.value
    assert error.what == f"loop.csv: {place}"
    assert remedy in error.remedy
    assert error.exit_code == 2


def test_all_faults_of_a_file_are_in_one_sentence():
    text = GOOD.replace("5.0", "5°").replace("0.0,0.6", "0.0,").replace("0.0,-0.1", "#N/A,-0.1")
    with pytest.raises(MeasurementError) as refused:
        parse_measurement(text, "loop.csv")
    sentence = str(refused.value)
    assert "\n" not in sentence
    for part in ("loop.csv: output_angle_deg = '5°'", "line 8 = '0.0,'", "line 10 = '#N/A,-0.1'"):
        assert part in sentence


def test_many_faults_are_counted():
    rows = "\n".join(f"{n}.0,broken" for n in range(30))
    with pytest.raises(MeasurementError, match=r"line 6 = .*line 13 = .* and 22 more"):
        parse_measurement(GOOD.split("0.0,0.0")[0] + rows, "loop.csv")


@given(st.text(max_size=12) | st.floats().map(repr) | st.integers().map("{:_}".format))
def test_only_plain_decimal_numbers_are_numbers(text):
    value = finite_number(text)
    if value is not None:
        assert value == float(text)
        assert set(text.strip()) <= set("0123456789.+-eE")


@pytest.mark.parametrize("comment", ["# paused, then resumed", "#paused", "#", "######", "#END", "# #N/A"])
def test_comments_between_rows_stay_comments(comment):
    read = parse_measurement(GOOD.replace("0.0,0.6", f"{comment}\n0.0,0.6"))
    assert read.rows == 6


@pytest.mark.parametrize("fault", ["wrong header", "unknown kind", "no torque", "not a number", "one row"])
def test_the_command_refuses_it_in_one_sentence(fault, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    text, place, _ = REFUSED[fault]
    path = tmp_path / "loop.csv"
    path.write_text(text, encoding="utf-8")
    out = tmp_path / "out"
    assert run(["compare", str(RV40E), str(path), "--out", str(out)]) == 2
    out_text, complaint = capsys.readouterr()
    assert out_text == ""
    assert complaint.count("\n") == 1
    assert complaint.startswith(f"cycloid-profile: loop.csv: {place}")
    assert not out.exists()


def test_missing_and_binary_files_are_refused(tmp_path: Path):
    binary = tmp_path / "scan.csv"
    binary.write_bytes(b"\xff\xfe\x00\x01\x80")
    for path in (tmp_path / "nothing.csv", tmp_path, binary):
        with pytest.raises(MeasurementError, match="cannot be read") as refused:
            read_measurement(path)
        assert str(path) in str(refused.value)
