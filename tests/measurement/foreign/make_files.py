"""Writes ``files/`` and ``reference/``: one set of measured values in the formats of many programs.

Run ``python -m tests.measurement.foreign.make_files``. numpy, pandas, csv, openpyxl, gnuplot, Octave and LibreOffice
write their own files; formats of instruments without a writer here are written in their dialect. The values come from
the generator in ``tests/diagnosis/blind``, which shares no code with the package.
"""

from __future__ import annotations

import csv
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from tests.diagnosis.blind import Hidden, Noise, Reducer, loop, lost_motion, transmission_error
from tests.diagnosis.blind.tooth import ground

HERE = Path(__file__).parent
FILES, REFERENCE = HERE / "files", HERE / "reference"
REDUCER = Reducer()
RUNOUT = (Hidden("disc_runout", {"amplitude_um": 3.0, "phase_deg": 40.0, "disc": 1}),)
SOFT = (Hidden("series_compliance", {"stiffness_nm_per_arcmin": 134.0}),)
POINTS, ROWS = 200, 60
PROBE_RADIUS = 0.5
LBF_IN, DEGREE = 0.112984829, np.pi / 180.0
Table = dict[str, np.ndarray]


def scan_points() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Measured points, nominal points and outward normals of one disc, complex, shape (POINTS,) [mm]."""
    real, nominal = ground(REDUCER, RUNOUT, 1), ground(REDUCER, (), 1)
    psi = np.linspace(0.0, REDUCER.period, POINTS, endpoint=False)
    along = nominal.points(psi + 1e-6) - nominal.points(psi - 1e-6)
    normal = 1j * along / np.abs(along)
    normal *= np.sign(np.real(normal * np.conj(nominal.points(psi))))
    # Each point lies on the normal of its nominal point, as a machine that follows nominal normals reports it.
    outwards = np.real(np.conj(normal) * (real.points(psi) - nominal.points(psi)))
    outwards += np.random.default_rng(1).normal(0.0, 0.3e-3, POINTS)
    return nominal.points(psi) + outwards * normal, nominal.points(psi), normal


def reference() -> dict[str, str]:
    """The same values in the format of the package."""
    z, _, _ = scan_points()
    rows = "\n".join(f"{p.real:.7f},{p.imag:.7f}" for p in z)
    quiet = {"rows": ROWS, "seed": 1}
    return {
        "scan": f"# format: cycloid-profile measurement 1\n# kind: profile_scan\n# datum: bore\nx_mm,y_mm\n{rows}\n",
        "loop": loop(REDUCER, SOFT, noise=Noise(0.004), **quiet),
        "te": transmission_error(REDUCER, RUNOUT, torque_nm=412.0, noise=Noise(0.15), **quiet),
        "lost": lost_motion(REDUCER, RUNOUT, noise=Noise(0.004), **quiet),
    }


def columns(text: str) -> Table:
    """Columns of a reference file by name."""
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    values = np.array([line.split(",") for line in lines[1:]], dtype=float)
    return dict(zip(lines[0].split(","), values.T, strict=True))


def write(name: str, text: str, encoding: str = "utf-8") -> None:
    (FILES / name).write_bytes(text.encode(encoding))


def lines(rows: Iterable[Sequence[float]], delimiter: str = ",", decimal: str = ".", form: str = "%.7f") -> str:
    return "".join(delimiter.join((form % value).replace(".", decimal) for value in row) + "\n" for row in rows)


def numpy_files(xy: np.ndarray, loops: np.ndarray) -> None:
    np.savetxt(FILES / "numpy_savetxt.txt", xy)
    np.savetxt(FILES / "numpy_header.csv", xy, delimiter=",", header="x,y")
    np.savetxt(FILES / "numpy_loop.csv", loops, delimiter=";", header="torque_nm;angle_arcmin", comments="")


def pandas_files(xy: np.ndarray, deviation: np.ndarray, te: np.ndarray, lost: np.ndarray) -> None:
    index = pd.DataFrame(xy, columns=["x [mm]", "y [mm]"])
    index.to_csv(FILES / "pandas_index.csv")
    german = pd.DataFrame(np.column_stack([xy, deviation]), columns=["X", "Y", "dev"])
    dialect = {"sep": ";", "decimal": ",", "encoding": "cp1252"}
    german.to_csv(FILES / "pandas_x_y_dev.csv", index=False, float_format="%.6f", **dialect)
    frame = pd.DataFrame(te, columns=["Output angle [deg]", "TE [arcsec]"])
    frame.assign(**{"Torque [Nm]": 412.0}).to_csv(FILES / "pandas_utf16.txt", sep="\t", encoding="utf-16", index=False)
    frame.to_csv(FILES / "pandas_te_without_torque.csv", index=False)
    pd.DataFrame(lost, columns=["angle (°)", "lost motion (')"]).to_csv(FILES / "pandas_lost.csv", index=False)
    missing = pd.DataFrame(te, columns=["Output angle [deg]", "TE [arcsec]"])
    missing.loc[[3, 9, 30], "TE [arcsec]"] = np.nan
    missing.assign(torque=412.0).to_csv(FILES / "pandas_missing.csv", index=False, na_rep="#N/A")


def csv_files(xy: np.ndarray, loops: np.ndarray) -> None:
    with (FILES / "csv_excel_bom.csv").open("w", encoding="utf-8-sig", newline="") as stream:
        writer = csv.writer(stream, dialect="excel")
        writer.writerows([["x (mm)", "y (mm)"], *xy.tolist()])
    with (FILES / "csv_quoted_commas.csv").open("w", encoding="utf-8", newline="") as stream:
        quoted = csv.writer(stream, quoting=csv.QUOTE_ALL)
        quoted.writerow(["Torque [Nm]", "Angle [arcmin]"])
        quoted.writerows([[f"{value:.6f}".replace(".", ",") for value in row] for row in loops])


def workbooks(xy: np.ndarray, loops: np.ndarray) -> None:
    from openpyxl import Workbook

    book = Workbook()
    sheet = book.active
    sheet.title = "Scan"
    for row in (["Report of disc 1"], [], ["Point", "X", "Y", "Remark"], ["", "mm", "mm", ""]):
        sheet.append(row)
    for number, point in enumerate(xy.tolist(), 1):
        sheet.append([f"P{number}", *point, None])
    book.create_sheet("Notes").append(["nothing here"])
    book.save(FILES / "openpyxl_scan.xlsx")
    faulty = Workbook()
    faulty.active.append(["Torque [Nm]", "Angle [arcmin]"])
    for number, row in enumerate(loops.tolist()):
        faulty.active.append(["#DIV/0!", row[1]] if number % 20 == 7 else row)
    faulty.save(FILES / "openpyxl_errors.xlsx")


def libreoffice_files(loops: np.ndarray) -> None:
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "libreoffice_loop.csv"
        source.write_text("Torque [Nm],Angle [arcmin]\n" + lines(loops, form="%.6f"), encoding="utf-8")
        for target in ("xlsx", "ods", "xls", "html", "csv:Text - txt - csv (StarCalc):59,34,1,1,,1031,true,false"):
            command = ["soffice", "--headless", f"-env:UserInstallation=file://{folder}/profile"]
            command += ["--convert-to", target, "--outdir", f"{folder}/out", str(source)]
            subprocess.run(command, check=True, capture_output=True, timeout=180)
        for file in (Path(folder) / "out").iterdir():
            shutil.copy(file, FILES / file.name)


def gnuplot_files(loops: np.ndarray) -> None:
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "loop.dat"
        np.savetxt(source, loops)
        script = f"set table '{FILES / 'gnuplot_table.dat'}'; set format '%.7f'; plot '{source}' using 1:2"
        subprocess.run(["gnuplot", "-e", script], check=True, timeout=60)


def octave_files(xy: np.ndarray, loops: np.ndarray) -> None:
    with tempfile.TemporaryDirectory() as folder:
        for name, values in (("xy", xy), ("loop", loops)):
            np.savetxt(Path(folder) / f"{name}.txt", values)
        script = f"""
            xy = load("{folder}/xy.txt"); loop = load("{folder}/loop.txt"); cd("{FILES}");
            save -text octave_save.txt xy
            save -7 octave_save.mat xy
            dlmwrite("octave_dlmwrite.csv", xy, "precision", "%.7f");
            f = fopen("octave_fprintf.txt", "w");
            fprintf(f, "%% torque [Nm]  angle [arcmin]\\n");
            fprintf(f, "%12.5f %12.6f\\n", loop'); fclose(f);
        """
        subprocess.run(["octave", "--no-gui", "--no-init-file", "--eval", script], check=True, timeout=120)


def machine_files(xy: np.ndarray) -> None:
    z, nominal, n = scan_points()
    deviation = np.real(np.conj(n) * (z - nominal))
    height = np.full(POINTS, 5.75)
    parts = np.column_stack
    write("cmm_xyzijk.asc", lines(parts([xy, height, n.real, n.imag, 0.0 * height]), " "))
    table = lines(parts([xy, height]), ";", ",", "%.5f").splitlines()
    write("cmm_labels.txt", "Punkt;X-Koordinate [mm];Y-Koordinate [mm];Z-Koordinate [mm]\n"
          + "".join(f"P{i:04d};{row}\n" for i, row in enumerate(table, 1)), "cp1252")  # fmt: skip
    inch = parts([nominal.real, nominal.imag, xy, deviation]) / 25.4
    names = "Nominal X [in],Nominal Y [in],Actual X [in],Actual Y [in],Deviation [in]\n"
    write("cmm_inch.csv", names + lines(inch, form="%.8f"))
    soll = parts([nominal.real, nominal.imag, n.real, n.imag, 1e3 * deviation])
    write("cmm_nominal_normals.csv", "X Soll;Y Soll;nx;ny;Abw. [µm]\n" + lines(soll, ";", ","), "cp1252")
    write("cmm_nominal_x_y_dev.csv", "X;Y;dev\n" + lines(parts([nominal.real, nominal.imag, deviation]), ";", ","))
    ball = z + PROBE_RADIUS * n
    write("cmm_ball_centres.csv", "x [mm],y [mm]\n" + lines(parts([ball.real, ball.imag])))
    write("cmm_origin_off.csv", "x [mm],y [mm]\n" + lines(xy + np.array([0.3, 0.0])))
    write("cmm_inch_silent.csv", "x,y\n" + lines(xy / 25.4, form="%.8f"))
    polar = lines(parts([np.abs(z), np.angle(z) / DEGREE]), ";", ",", "%.8f")
    write("cmm_polar.csv", "Radius [mm];Polarwinkel [°]\n" + polar, "cp1252")
    write("cmm_chinese.csv", "x坐标(mm),y坐标(mm)\n" + lines(xy), "gb18030")
    write("cmm_two_of_each.csv", "x,y,X,Y\n" + lines(parts([xy, xy])))
    write("cmm_unnamed.csv", "Q1;Q2\n" + lines(xy, ";"))
    vda = ",".join(f"{value:.7f}" for value in parts([xy, height]).ravel())
    packed = f"SCAN = HEADER / 1\nMEASURED POINTS\nPS1 = PSET / {POINTS},{vda}\nSCANEND = END"
    pieces = [line[i : i + 72] for line in packed.splitlines() for i in range(0, len(line), 72)]
    write("cmm_pset.vda", "".join(f"{piece:<72}{number:08d}\n" for number, piece in enumerate(pieces, 1)))
    actual = [f"FA(P{i})=FEAT/POINT,CART,{p.real:.6f},{p.imag:.6f},5.75,$\n{m.real:.6f},{m.imag:.6f},0.0\n"
              for i, (p, m) in enumerate(zip(z, n, strict=True), 1)]  # fmt: skip
    write("cmm_output.dmo", "DMISMN/'SCAN',05.0\nUNITS/MM,ANGDEC\n" + "".join(actual) + "ENDFIL\n")
    write("cmm_nominal.dmo", "DMISMN/'SCAN',05.0\nUNITS/MM,ANGDEC\nF(P1)=FEAT/POINT,CART,59.7,0,5.75,1,0,0\nENDFIL\n")
    write("cmm_points.qif", qif(ball))


def qif(points: np.ndarray) -> str:
    """Points that are not compensated, as in the results of a QIF document."""
    head = '<?xml version="1.0" encoding="UTF-8"?>\n'
    head += '<QIFDocument xmlns="http://qifstandards.org/xsd/qif3" versionQIF="3.0.0">'
    factor = "<UnitConversion><Factor>0.001</Factor></UnitConversion>"
    unit = f"<LinearUnit><SIUnitName>meter</SIUnitName><UnitName>mm</UnitName>{factor}</LinearUnit>"
    head += f"<FileUnits><PrimaryUnits>{unit}</PrimaryUnits></FileUnits>"
    body = "".join(
        f'<MeasurePoint id="{i}"><Point>{p.real:.6f} {p.imag:.6f} 5.75</Point><Compensated>false</Compensated>'
        f"<ProbeRadius>{PROBE_RADIUS}</ProbeRadius></MeasurePoint>\n"
        for i, p in enumerate(points, 10)
    )
    results = f"<MeasurementsResults><MeasurePoints>\n{body}</MeasurePoints></MeasurementsResults>"
    return f"{head}{results}</QIFDocument>\n"


def bench_files(loops: np.ndarray, te: np.ndarray, lost: np.ndarray) -> None:
    torque, angle = loops.T
    both = np.column_stack
    time = np.arange(float(len(torque)))
    degrees = both([torque, angle / 60.0, 21.5 + 0.0 * time])
    text = "Prüfstand 3\nDatum;12.03.2026\n\nDrehmoment [Nm];Verdrehung [°];Temp. [°C]\n"
    write("bench_german.csv", text + lines(degrees, ";", ",", "%.9f"), "cp1252")
    write("bench_chinese.csv", "转矩[N·m],转角[′]\n" + lines(loops), "gb18030")
    write("bench_imperial.csv", "Output torque (lbf·in),Twist (mrad)\n"
          + lines(both([torque / LBF_IN, angle / 60.0 * DEGREE * 1e3]), form="%.9f"))  # fmt: skip
    write("bench_n_mm.csv", "Torque [N·mm];Angle [arcsec]\n" + lines(both([1e3 * torque, 60.0 * angle]), ";"))
    write("bench_inverted.csv", "Torque [Nm],Angle [arcmin]\n" + lines(both([torque, -angle])))
    write("bench_no_units.csv", "Torque,Angle\n" + lines(loops))
    write("bench_units_row.txt", "Time\tTorque\tAngle\n[s]\t[Nm]\t[arcmin]\n" + lines(both([time, loops]), "\t"))
    lvm = "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\n***End_of_Header***\t\n\n"
    lvm += "X_Value\tTorque\tAngle\tComment\n"
    write("bench_labview.lvm", lvm + lines(both([time, loops]), "\t"))
    r = "".join(f'"{i}" {row}' for i, row in enumerate(lines(loops, " ").splitlines(keepends=True), 1))
    write("r_write_table.txt", '"torque_nm" "angle_arcmin"\n' + r)
    write("bench_be.txt", "torque [Nm]\tangle [arcmin]\n" + lines(loops, "\t"), "utf-16-be")
    write("bench_te.csv", "Torque: 412 Nm\nAbtriebswinkel [°];Drehfehler [″]\n" + lines(te, ";", ","), "utf-8")
    write("bench_lost.txt", "Load torque = 12,36 Nm\noutput angle / rad | lost motion / arcmin\n"
          + lines(both([lost[:, 0] * DEGREE, lost[:, 1]]), " | ", form="%.9f"))  # fmt: skip
    write("faults_thousands.csv", "Torque [N·mm];Angle [arcmin]\n" + "".join(
        f"{t * 1e3:,.3f};{a:.6f}\n" for t, a in loops))  # fmt: skip
    rows = lines(loops).splitlines()
    rows[4], rows[9], rows[20], rows[33] = "5_9.694,0.1", "12.0,", "#N/A,#N/A", "mean,0.2"
    write("faults_many.csv", "Torque [Nm],Angle [arcmin]\n" + "\n".join(rows) + "\n")
    write("not_a_table.json", '{"torque": [1, 2, 3], "angle": [0.1, 0.2, 0.3]}\n')


def letters_of_the_world(scan: np.ndarray, loops: np.ndarray, te: np.ndarray, lost: np.ndarray) -> None:
    """Words, signs and encodings of other languages."""
    torque, angle = loops.T
    both = np.column_stack
    seconds = lines(both([torque, 60.0 * angle])).splitlines()
    text = "".join(f"{i},{row}\n" for i, row in enumerate(seconds, 1))
    write("bench_torsion_chinese.csv", "序号,扭矩(Nm),扭转角(″)\n" + text, "gb18030")
    write("bench_te_chinese.csv", "负载转矩：412 N·m\n输出角度(°),角度传动误差(角秒)\n" + lines(te), "gb18030")
    write("bench_lost_chinese.txt", "测试转矩：12.36 Nm\n输出轴角度(°)\t空程(arcmin)\n" + lines(lost, "\t"), "utf-16")
    write("bench_japanese.csv", "トルク[N·m],ねじれ角[分]\n" + lines(loops))
    write("bench_shift_jis.csv", "トルク[N・m],ねじれ角[分]\n" + lines(loops), "shift_jis")
    write("bench_bogenminuten.csv", "Drehmoment [Nm];Winkel [Bogenminuten]\n" + lines(loops, ";", ","), "cp1252")
    names = "Abtriebswinkel in Grad;Übertragungsfehler in Winkelsekunden\n"
    write("bench_belastung.csv", "Belastung = 412 Nm\n" + names + lines(te, ";", ","), "cp1252")
    z = scan[:, 0] + 1j * scan[:, 1]
    polar = lines(both([np.angle(z) / DEGREE, np.abs(z)]), form="%.8f")
    write("cmm_polar_chinese.csv", "极角(°),极径(mm)\n" + polar, "gb18030")


def thousands(value: float, group: str, decimal: str) -> str:
    return f"{value:,.3f}".translate(str.maketrans(",.", group + decimal))


def odd_cells(scan: np.ndarray, loops: np.ndarray) -> None:
    """Tables whose cells, columns or ends need more than a delimiter."""
    torque, angle = loops.T
    both = np.column_stack
    for name, group, decimal in (("swiss", "'", "."), ("german", ".", ","), ("french", "\u202f", ",")):
        cells = [(thousands(1e3 * t, group, decimal), f"{a:.6f}".replace(".", decimal)) for t, a in loops]
        text = "".join(f"{t};{a}\n" for t, a in cells)
        write(f"faults_thousands_{name}.csv", "Torque [N·mm];Angle [arcmin]\n" + text)
    rows = "".join(f"{x:.6f} mm;{y:.6f} mm\n" for x, y in scan)
    write("faults_units_in_cells.csv", "X;Y\n" + rows.replace(".", ","))
    write("delimiter_at_the_end.csv", "X [mm];Y [mm]\n" + lines(scan, ";", ",").replace("\n", ";\n"))
    write("dos_end_of_file.csv", "x [mm];y [mm]\n" + lines(scan, ";") + "\x1a" + "\0" * 64)
    write("matlab_writetable.txt", "torque_Nm_,angle_deg_\n" + lines(both([torque, angle / 60.0]), form="%.9f"))
    write("axis_and_unit.csv", "Xmm,Ymm\n" + lines(scan))
    write("bench_no_header.csv", lines(both([torque, angle / 60.0]), ";", ",", "%.9f"))
    write("empty.csv", "")


def formulas(scan: np.ndarray) -> None:
    """A workbook of a program that does not compute: formulas without values."""
    from openpyxl import Workbook

    book = Workbook()
    book.active.append(["X", "Y"])
    for x, y in scan.tolist():
        book.active.append([f"={x}*1", f"={y}*1"])
    book.save(FILES / "openpyxl_formulas.xlsx")


def signs_and_units(lost: np.ndarray) -> None:
    """Deviations and lost motion whose unit or sign the file does not say."""
    z, nominal, n = scan_points()
    deviation = 1e3 * np.real(np.conj(n) * (z - nominal))
    both = np.column_stack
    for name, at in (("nominal", nominal), ("measured", z)):
        table = lines(both([at.real, at.imag, deviation]), ";", ",")
        write(f"cmm_{name}_dev_in_um.csv", "X;Y;dev\n" + table)
    head = "Torque: ±12.36 Nm\nOutput angle [deg],lost motion [deg]\n"
    write("bench_lost_degrees.csv", head + lines(both([lost[:, 0], lost[:, 1] / 60.0]), form="%.9f"))
    head = "Torque: 12.36 Nm\nOutput angle [deg],lost motion [arcmin]\n"
    write("bench_lost_inverted.csv", head + lines(both([lost[:, 0], -lost[:, 1]])))


def main() -> None:
    for folder in (FILES, REFERENCE):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
    texts = reference()
    for name, text in texts.items():
        (REFERENCE / f"{name}.csv").write_text(text, encoding="utf-8")
    scan, loops, te, lost = (np.column_stack(list(columns(text).values())) for text in texts.values())
    z, nominal, n = scan_points()
    steps: tuple[Callable[[], None], ...] = (
        lambda: numpy_files(scan, loops),
        lambda: pandas_files(scan, np.real(np.conj(n) * (z - nominal)), te, lost),
        lambda: csv_files(scan, loops),
        lambda: workbooks(scan, loops),
        lambda: libreoffice_files(loops),
        lambda: gnuplot_files(loops),
        lambda: octave_files(scan, loops),
        lambda: machine_files(scan),
        lambda: bench_files(loops, te, lost),
        lambda: letters_of_the_world(scan, loops, te, lost),
        lambda: odd_cells(scan, loops),
        lambda: formulas(scan),
        lambda: signs_and_units(lost),
    )
    for step in steps:
        step()


if __name__ == "__main__":
    main()
