"""Files of other programs: each is read to the values that were written, or refused with the remedy.

``make_files.py`` wrote them, most by the programs themselves, from one set of values that ``reference/`` holds in our
own format. Values agree to the last digit that a file prints, surface points of ball centres to 0.2 µm: the normals are
those of the nominal tooth.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import screen_files
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.errors import MeasurementError
from cycloid_profile.measurement import Measurement, parse_measurement, read_measurement
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Reducer, spec_text

HERE = Path(__file__).parent
FILES = HERE / "files"


class Read(NamedTuple):
    """A file that is read: its reference, words of the sentence on it, and ``--columns`` if it needs them."""

    reference: str
    said: tuple[str, ...]
    columns: tuple[str, ...] = ()
    tolerance: float = 2e-6  # [mm, N·m, arcmin, arcsec or degrees]


class Refused(NamedTuple):
    """A file that is refused, by its reader or by the rules for the drive: words of the sentence."""

    said: tuple[str, ...]
    columns: tuple[str, ...] = ()


BORE = "datum bore, as nothing else is said"
CASES: list[tuple[str, Read | Refused]] = [
    # numpy, pandas, csv
    ("numpy_savetxt.txt", Read("scan", ("x=1,y=2", "blanks", "no unit stated, taken as x in mm", BORE))),
    ("numpy_header.csv", Read("scan", ("x=x,y=y", "commas, decimal points", BORE))),
    ("numpy_loop.csv", Read("loop", ("hysteresis", "semicolons"))),
    ("pandas_index.csv", Read("scan", ("x=x[mm],y=y[mm]",))),
    ("pandas_x_y_dev.csv", Read("scan", ("semicolons, decimal commas", "measured points", BORE))),
    ("pandas_utf16.txt", Read("te", ("UTF-16", "tabs", "torque 412 N·m"))),
    ("pandas_te_without_torque.csv", Refused(("torque_nm", "add --columns torque_nm="))),
    ("pandas_te_without_torque.csv", Read("te", ("torque 412 N·m",), ("torque_nm=412",))),
    ("pandas_lost.csv", Read("lost", ("lost motion map", "angle=angle[°]"), ("torque_nm=12.36",))),
    ("pandas_missing.csv", Refused(("line 5 = '#N/A'", "line 11", "line 32", "delete the row"))),
    ("csv_excel_bom.csv", Read("scan", ("x=x[mm],y=y[mm]", "UTF-8"))),
    ("csv_quoted_commas.csv", Read("loop", ("commas, decimal commas",))),
    # workbooks and LibreOffice
    ("openpyxl_scan.xlsx", Read("scan", ("sheet 'Scan'", "not used: Point, Remark"))),
    ("openpyxl_errors.xlsx", Refused(("row 9 = '#DIV/0!'", "row 29", "row 49"))),
    ("libreoffice_loop.csv", Read("loop", ("semicolons",))),
    ("libreoffice_loop.xlsx", Read("loop", ("sheet 'libreoffice_loop'",))),
    ("libreoffice_loop.ods", Refused(("save it as .xlsx or .csv",))),
    ("libreoffice_loop.xls", Refused(("save it as .xlsx or .csv",))),
    ("libreoffice_loop.html", Refused(("no rows of two numbers", "export a table"))),
    # gnuplot, Octave, R, LabVIEW
    ("gnuplot_table.dat", Refused(("points = 61 are too few", "x=x,y=y"))),
    ("gnuplot_table.dat", Read("loop", ("torque=x[Nm],angle=y[arcmin]",), ("torque=x[Nm],angle=y[arcmin]",))),
    ("octave_save.txt", Read("scan", ("x=1,y=2", "blanks"))),
    ("octave_dlmwrite.csv", Read("scan", ("x=1,y=2", "commas"))),
    ("octave_fprintf.txt", Read("loop", ("torque=torque[Nm],angle=angle[arcmin]",), tolerance=1e-5)),
    ("octave_save.mat", Refused(("is no text file", "save it as CSV in UTF-8"))),
    ("r_write_table.txt", Read("loop", ("torque=torque[nm]",))),
    ("bench_labview.lvm", Refused(("unit of column 'Angle'", "--columns 'torque=Torque,angle=Angle[arcmin]'"))),
    ("bench_labview.lvm", Read("loop", ("tabs",), ("torque=Torque,angle=Angle[arcmin]",))),
    # measuring machines
    ("cmm_xyzijk.asc", Read("scan", ("x=1,y=2", BORE))),
    ("cmm_labels.txt", Read("scan", ("not used: Punkt, Z-Koordinate",), tolerance=6e-6)),
    ("cmm_inch.csv", Read("scan", ("x=Actual X[in]", "not used: Nominal X, Nominal Y", "measured points"))),
    ("cmm_inch_silent.csv", Refused(("in inch, not in mm", "--columns unit=inch"))),
    ("cmm_inch_silent.csv", Read("scan", ("x=x,y=y",), ("unit=inch",))),
    ("cmm_nominal_normals.csv", Read("scan", ("deviation=Abw.[µm]", "cp1252"))),
    ("cmm_nominal_x_y_dev.csv", Read("scan", ("coordinates are nominal",))),
    ("cmm_polar.csv", Read("scan", ("polar_angle=Polarwinkel[°]", "cp1252"))),
    ("cmm_chinese.csv", Read("scan", ("GB18030", "x=x坐标[mm]"))),
    ("cmm_two_of_each.csv", Refused(("'X', 'Y'", "choose with --columns"))),
    ("cmm_two_of_each.csv", Read("scan", ("x=3,y=4",), ("x=3,y=4,unit=mm",))),
    ("cmm_unnamed.csv", Refused(("'Q1', 'Q2'", "--columns, such as x=X,y=Y,unit=mm"))),
    ("cmm_unnamed.csv", Read("scan", ("x=Q1,y=Q2",), ("x=Q1,y=Q2,unit=mm",))),
    ("cmm_ball_centres.csv", Refused(("0.5 mm outside the tooth", "--columns probe_radius_mm=0.5"))),
    ("cmm_ball_centres.csv", Read("scan", ("probe radius of 0.5 mm was removed",), ("probe_radius_mm=0.5",), 2e-4)),
    ("cmm_origin_off.csv", Refused(("off the bore axis", "# datum: free", "--columns datum=free"))),
    ("cmm_pset.vda", Read("scan", ("VDA-FS",))),
    ("cmm_output.dmo", Read("scan", ("DMIS",))),
    ("cmm_nominal.dmo", Refused(("no measured points",))),
    ("cmm_points.qif", Read("scan", ("QIF", "probe radius of 0.5 mm was removed"), tolerance=2e-4)),
    # test benches
    ("bench_german.csv", Read("loop", ("decimal commas, cp1252", "angle=Verdrehung[°]", "not used: Temp."))),
    ("bench_chinese.csv", Read("loop", ("GB18030",))),
    ("bench_imperial.csv", Read("loop", ("torque=Output torque[lbf·in],angle=Twist[mrad]",), tolerance=1e-5)),
    ("bench_n_mm.csv", Read("loop", ("torque=Torque[N·mm],angle=Angle[arcsec]",))),
    ("bench_inverted.csv", Refused(("signs of torque and angle", "--columns 'angle=-Angle[arcmin]'"))),
    ("bench_inverted.csv", Read("loop", ("angle=-Angle[arcmin]",), ("angle=-Angle[arcmin]",))),
    ("bench_no_units.csv", Refused(("unit of column 'Angle' = not given", "angle=Angle[arcmin]"))),
    ("bench_no_units.csv", Read("loop", ("taken as torque in N·m",), ("unit=arcmin",))),
    ("bench_units_row.txt", Read("loop", ("torque=Torque[Nm],angle=Angle[arcmin]", "not used: Time"))),
    ("bench_be.txt", Read("loop", ("UTF-16",))),
    ("bench_te.csv", Read("te", ("output_angle=Abtriebswinkel[°],error=Drehfehler[″]", "torque 412 N·m"))),
    ("bench_lost.txt", Read("lost", ("bars", "torque 12.36 N·m"), tolerance=1e-5)),
    ("faults_thousands.csv", Refused(("line 3", "without thousands separators"))),
    ("faults_many.csv", Refused(("line 6 = '5_9.694'", "line 11 = ''", "line 22 = '#N/A'", "line 35 = 'mean'"))),
    ("not_a_table.json", Refused(("--columns",))),
    # words, signs and encodings of other languages
    ("bench_torsion_chinese.csv", Read("loop", ("angle=扭转角[″]", "GB18030", "not used: 序号"))),
    ("bench_te_chinese.csv", Read("te", ("torque 412 N·m",))),
    ("bench_lost_chinese.txt", Read("lost", ("UTF-16", "torque 12.36 N·m"))),
    ("bench_japanese.csv", Read("loop", ("torque=トルク[N·m],angle=ねじれ角[分]",))),
    ("bench_shift_jis.csv", Refused(("is no text file", "save it as CSV in UTF-8"))),
    ("bench_bogenminuten.csv", Read("loop", ("angle=Winkel[Bogenminuten]",))),
    ("bench_belastung.csv", Read("te", ("error=Übertragungsfehler[Winkelsekunden]", "torque 412 N·m"))),
    ("cmm_polar_chinese.csv", Read("scan", ("radius=极径[mm],polar_angle=极角[°]",))),
    # cells, columns and ends
    ("faults_thousands_swiss.csv", Refused(("line 3", "34'333.333'", "without thousands separators"))),
    ("faults_thousands_german.csv", Refused(("line 3", "'34.333,333'", "without thousands separators"))),
    ("faults_thousands_french.csv", Refused(("line 3", "without thousands separators"))),
    ("faults_units_in_cells.csv", Refused(("line 2 = '59,696402 mm'", "write the unit into the header"))),
    ("delimiter_at_the_end.csv", Read("scan", ("x=X[mm],y=Y[mm]", "semicolons, decimal commas"))),
    ("dos_end_of_file.csv", Read("scan", ("x=x[mm],y=y[mm]",))),
    ("matlab_writetable.txt", Read("loop", ("torque=torque[Nm],angle=angle[deg]",))),
    ("axis_and_unit.csv", Read("scan", ("x=X[mm],y=Y[mm]",))),
    ("bench_no_header.csv", Refused(("no names of its columns", "torque=1,angle=2[deg]"))),
    ("bench_no_header.csv", Read("loop", ("torque=1,angle=2[deg]",), ("torque=1,angle=2[deg]",))),
    ("empty.csv", Refused(("in an empty file", "export it again"))),
    ("openpyxl_formulas.xlsx", Refused(("formulas without their values", "save it again"))),
    # signs and units that the file does not say
    ("cmm_nominal_dev_in_um.csv", Refused(("2.12 mm rms", "unit of the deviations", "'deviation=dev[um]'"))),
    ("cmm_nominal_dev_in_um.csv", Read("scan", ("coordinates are nominal",), ("deviation=dev[um]",))),
    ("cmm_measured_dev_in_um.csv", Refused(("unit of the deviations", "--columns 'deviation=dev[um]'"))),
    ("cmm_measured_dev_in_um.csv", Read("scan", ("measured points",), ("deviation=dev[um]",))),
    ("bench_lost_degrees.csv", Read("lost", ("lost_motion=lost motion[deg]", "torque 12.36 N·m"))),
    ("bench_lost_inverted.csv", Refused(("rotate the output back", "--columns 'lost_motion=-lost motion[arcmin]'"))),
    ("bench_lost_inverted.csv", Read("lost", ("torque 12.36 N·m",), ("lost_motion=-lost motion[arcmin]",))),
]  # fmt: skip


@cache
def reducer() -> AsBuiltReducer:
    return as_built_reducer(parse_spec(spec_text(Reducer())))


@cache
def reference(name: str) -> Measurement:
    return parse_measurement((HERE / "reference" / f"{name}.csv").read_text(encoding="utf-8"), f"{name}.csv")


def read(name: str, columns: tuple[str, ...]) -> Measurement:
    """The file after the rules that all commands share."""
    if name.endswith(".xlsx"):
        pytest.importorskip("openpyxl")
    (found,), _ = screen_files(reducer(), [read_measurement(FILES / name, columns)])
    return found


@pytest.mark.parametrize(("name", "expected"), CASES, ids=lambda value: value if isinstance(value, str) else "")
def test_file_is_read_right_or_refused_with_the_remedy(name: str, expected: Read | Refused) -> None:
    if isinstance(expected, Refused):
        with pytest.raises(MeasurementError) as refusal:
            read(name, expected.columns)
        sentence = str(refusal.value)
        assert name in sentence
        assert "\n" not in sentence
    else:
        found, true = read(name, expected.columns), reference(expected.reference)
        assert found.kind is true.kind
        for column in true.kind.columns:
            np.testing.assert_allclose(found[column], true[column], rtol=0.0, atol=expected.tolerance)
        assert all(found.keys[key] == true.keys[key] for key in ("datum",) if key in true.keys)
        sentence = "; ".join(found.notes)
    for word in expected.said:
        assert word in sentence


def test_every_file_has_an_expectation() -> None:
    assert {name for name, _ in CASES} == {file.name for file in FILES.iterdir()}
    assert len({name for name, _ in CASES}) >= 40


def test_origin_off_the_axis_is_read_as_free() -> None:
    found = read("cmm_origin_off.csv", ("datum=free",))
    assert found.datum_free
