"""The corrected disc in every format of a design, read back by other readers and compared with its dense polygon."""

from __future__ import annotations

import json
import math
import re
import zipfile
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import ezdxf
import msgspec
import numpy as np
import pytest
from scipy.spatial import cKDTree

from cycloid_profile.correction import Correction, correction
from cycloid_profile.correction.json_output import correction_to_json
from cycloid_profile.design import as_built_reducer
from cycloid_profile.effects import effect_from_table
from cycloid_profile.errors import ExportError
from cycloid_profile.export import interpret, machine_of, read_svg_tooth, read_table
from cycloid_profile.export.formats import WITH_KERNEL
from cycloid_profile.export.nc.polar import last_turn
from cycloid_profile.report.diagnosis import corrected_disc, write_correction
from cycloid_profile.spec import parse_spec
from cycloid_profile.spec.model import FormWheelSpec, PointsSpec, Spec
from cycloid_profile.units import UM
from tests.diagnosis.correcting import found, named

TOLERANCE = 0.5 * UM
MACHINE = 'name = "mill in the corner"\ncontrol = "fanuc"\n[numbers]\ndecimals = 5\n[tool]\nnumber = 77\n'
SPEC = """name = "Nine lobes"
[drive]
pins = 10
pin_circle_radius_mm = 30.0
pin_radius_mm = 3.0
eccentricity_mm = 1.5
disc_width_mm = 8.0
discs = 2
[drive.cranks]
count = 3
circle_radius_mm = 15.0
[load]
rated_torque_nm = 20.0
disc_body = "rigid"
[modification]
equidistant_um = 10.0
[export]
chord_tolerance_um = 0.5
wheel_compensation = "G41"
machine = "{machine}"
"""
OF_THE_DISC = ("csv", "dxf", "dxf-arcs", "dxf-offset", "svg", "step", "3mf", "stl", "gcode", "gcode-path",
               "gcode-polar", "gcode-wire")  # fmt: skip
OF_THE_AIM = ("drawing", "cmm", "dmis", "qif", "vdafs", "step-assembly", "parts-step", "parts-dxf", "parts-3mf",
              "parts-stl", "bom")  # fmt: skip
LARGEST = 2.0 * UM


class Written(NamedTuple):
    """A correction with its folder, and the JSON object of its files."""

    found: Correction
    spec: Spec
    folder: Path
    values: dict[str, Any]

    @property
    def polygon(self) -> np.ndarray:
        """The corrected tooth by chords within 2 nm [mm]."""
        return dense(self.found)

    def off(self, z: np.ndarray) -> np.ndarray:
        """Distance of points from the corrected tooth [mm]."""
        return from_polygon(self.polygon, np.ravel(z))


@lru_cache
def dense(one: Correction) -> np.ndarray:
    return one.program.at(np.linspace(0.0, one.program.trochoid.phase_period, 90_001)).position


def from_polygon(polygon: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Distance of each point from the chords at its nearest corner [mm]."""
    _, i = cKDTree(np.stack([polygon.real, polygon.imag], axis=-1)).query(np.stack([z.real, z.imag], axis=-1))
    off = np.full(z.size, np.inf)
    for a in (i - 1, i):
        start, way = polygon[a % (polygon.size - 1)], np.diff(polygon)[a % (polygon.size - 1)]
        share = np.clip((np.conj(way) * (z - start)).real / np.abs(way) ** 2, 0.0, 1.0)
        off = np.minimum(off, np.abs(z - start - share * way))
    return off


def correction_of(spec: Spec, effect: dict[str, Any]) -> Correction:
    return correction(found(as_built_reducer(spec), [named(effect_from_table(effect))]), effect["disc"] - 1)


def spec_of(folder: Path) -> Spec:
    (folder / "machine.toml").write_text(MACHINE, encoding="utf-8")
    return parse_spec(SPEC.format(machine=folder / "machine.toml"))


PITCH = {"name": "cumulative_pitch_error", "amplitude_um": 2.0, "phase_deg": 100.0, "disc": 2}
EQUIDISTANT = {"name": "equidistant_error", "amount_um": 2.0, "disc": 2}
# Formats of the CAD kernel, which takes seconds to load, are slow.
CASES = [
    pytest.param((PITCH, [name for name in OF_THE_DISC if name not in WITH_KERNEL]), id="whole disc"),
    pytest.param((PITCH, OF_THE_DISC), marks=pytest.mark.slow, id="whole disc, all formats"),
    pytest.param((EQUIDISTANT, OF_THE_DISC), marks=pytest.mark.slow, id="each lobe, all formats"),
]


@pytest.fixture(scope="module", params=CASES)
def written(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Written:
    """Disc 2 corrected of an error of every lobe, or of one that repeats once a turn, in many formats."""
    place = tmp_path_factory.mktemp("corrected")
    spec = spec_of(place)
    effect, formats = request.param
    if set(formats) & WITH_KERNEL:
        pytest.importorskip("OCP", reason="the CAD kernel is not installed")
    one = correction_of(spec, effect)
    values = correction_to_json(one, found(None, []), spec.name, 10.0, False)  # type: ignore[arg-type]
    folder = place / "out"
    return Written(
        one, spec, folder, write_correction(one, values, spec, 3600, folder, formats=[*formats, *OF_THE_AIM])
    )


def test_a_file_for_every_format_of_a_disc_and_a_sentence_for_the_others(written: Written) -> None:
    formats = {file["format"] for file in written.values["files"] if "format" in file}
    assert formats == set(OF_THE_DISC) - (set() if "step" in formats else WITH_KERNEL)
    assert set(written.values["skipped"]) == set(OF_THE_AIM)
    for reason in written.values["skipped"].values():
        assert reason.endswith("nominal; use that of build")
    assert {path.name for path in written.folder.iterdir()} == {file["path"] for file in written.values["files"]}
    assert json.loads((written.folder / "correction.json").read_text(encoding="utf-8")) == written.values
    programs = [file for file in written.values["files"] if "format" in file]
    assert all("_corrected." in file["path"] for file in programs)
    assert all(file["deviation_um"] <= file["tolerance_um"] for file in programs)
    # The correction itself exceeds every tolerance: a file of the nominal tooth would fail below.
    drawing = written.found.drawing
    nominal = drawing.at(np.linspace(0.0, drawing.trochoid.phase_period, 5000)).position
    assert np.max(written.off(nominal)) > 3.0 * TOLERANCE


def test_points_and_splines_lie_on_the_corrected_tooth(written: Written) -> None:
    csv = read_table(written.folder / "profile_corrected.csv")
    assert np.max(written.off(csv[:, 1] + 1j * csv[:, 2])) < TOLERANCE
    path = read_table(written.folder / "grinding_path_corrected.csv")
    assert np.max(written.off(path[:, 1] + 1j * path[:, 2])) < TOLERANCE
    poles = read_svg_tooth(written.folder / "profile_corrected.svg")
    u = np.linspace(0.0, 1.0, 9)
    bernstein = np.stack([(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u), u**3])
    assert np.max(written.off(poles @ bernstein)) < TOLERANCE
    arcs = doc_arcs(written.folder / "profile_arcs_corrected.dxf", "PROFILE")
    assert np.max(written.off(arcs)) < TOLERANCE
    wire = written.spec.export.wire
    centre = doc_arcs(written.folder / "profile_offset_corrected.dxf", "PROFILE")
    offset = 0.5 * wire.wire_diameter_mm + wire.spark_gap_um * UM
    assert np.max(np.abs(written.off(centre) - offset)) < TOLERANCE


@pytest.mark.slow
def test_splines_of_dxf_lie_on_the_corrected_tooth(written: Written) -> None:
    with_kernel(written)
    doc = ezdxf.readfile(written.folder / "profile_corrected.dxf")
    splines = doc.modelspace().query('SPLINE[layer=="PROFILE"]')
    assert len(splines) == 2 * written.found.program.trochoid.lobes
    z = np.array([complex(p.x, p.y) for one in splines for p in one.construction_tool().approximate(40)])
    assert np.max(written.off(z)) < TOLERANCE


def with_kernel(written: Written) -> None:
    if not (written.folder / "disc_corrected.step").exists():
        pytest.skip("the formats of the CAD kernel are in the slow cases")


def doc_arcs(path: Path, layer: str) -> np.ndarray:
    """Points along the arcs of the polyline on a layer, by ezdxf."""
    (polyline,) = ezdxf.readfile(path).modelspace().query(f'LWPOLYLINE[layer=="{layer}"]')
    found = []
    for piece in polyline.virtual_entities():
        if piece.dxftype() == "ARC":
            found += [complex(p.x, p.y) for p in piece.vertices(piece.angles(9))]
        else:
            found += [complex(piece.dxf.start.x, piece.dxf.start.y)]
    return np.array(found)


def test_programs_run_on_the_corrected_tooth_with_the_machine_of_the_file(written: Written) -> None:
    machine = machine_of(written.spec.export)

    def run(name: str) -> Any:
        text = (written.folder / name).read_text(encoding="ascii")
        assert text.startswith("%\nO0001")
        assert "CORRECTED NINE LOBES" in text
        assert "DISC 2: ROOT 1 ON THE X AXIS, OPENINGS" in text
        assert ("LOBES DIFFER" in text) != written.found.program.identical_lobes
        return interpret(text, machine, name)

    rounding = math.sqrt(2.0) * 1e-5
    contour = run("grinding_corrected.nc")
    assert {motion.state.tool for motion in contour.motions} == {77}
    cutting = [m.end.plane for m in contour.motions if m.kind in ("clockwise", "anticlockwise") and m.state.side]
    # The last pass, without its leads, is a whole turn on the tooth.
    last = np.array(cutting[-len(cutting) // 8 :])
    assert np.sum(written.off(last) < TOLERANCE + rounding) >= last.size - 2
    x, c = last_turn(run("grinding_polar_corrected.nc"))
    centre = x * np.exp(-1j * np.radians(c))
    radius = np.median(written.off(centre))
    assert np.max(np.abs(written.off(centre) - radius)) < TOLERANCE + 3.0 * rounding
    wire = written.spec.export.wire
    program = run("wire_edm_corrected.nc")
    outside = np.array([m.end.plane for m in program.motions if m.kind == "clockwise"])
    off = written.off(outside[np.abs(outside) > 25.0])
    finishing = 0.5 * wire.wire_diameter_mm + wire.spark_gap_um * UM
    # Other cuts leave 10 µm and more.
    on = np.abs(off - finishing) < 5.0 * UM
    assert np.sum(on) > 50
    assert np.max(np.abs(off[on] - finishing)) < TOLERANCE + rounding


def test_solids_have_the_corrected_tooth_and_the_openings_of_disc_2(written: Written) -> None:
    import trimesh

    turn = math.pi / written.found.program.trochoid.lobes
    mesh = trimesh.load_mesh(written.folder / "disc_corrected.stl")
    assert mesh.is_watertight
    with zipfile.ZipFile(written.folder / "disc_corrected.3mf") as archive:
        model = archive.read("3D/3dmodel.model").decode("utf-8")
    vertices = re.findall(r'<vertex x="([^"]*)" y="([^"]*)"', model)
    of_3mf = np.array([complex(float(x), float(y)) for x, y in vertices])
    for corners in (mesh.vertices[:, 0] + 1j * mesh.vertices[:, 1], of_3mf):
        teeth = corners[np.abs(corners) > 24.0]
        assert teeth.size > 200
        # Corners are on the tooth; their coordinates hold 24 bits.
        assert np.max(written.off(teeth)) < 1e-5
    doc = ezdxf.readfile(written.folder / "profile_arcs_corrected.dxf")
    holes = [complex(c.dxf.center.x, c.dxf.center.y) for c in doc.modelspace().query('CIRCLE[layer=="HOLES"]')]
    crank = min((z for z in holes if abs(z) > 1.0), key=lambda z: abs(np.angle(z)))
    assert np.angle(crank) == pytest.approx(turn, abs=1e-9)


@pytest.mark.slow
def test_step_is_a_sound_solid_of_the_corrected_tooth(written: Written) -> None:
    with_kernel(written)
    from build123d import Axis, import_step

    (solid,) = import_step(written.folder / "disc_corrected.step").solids()
    assert solid.is_valid
    edges = solid.faces().sort_by(Axis.Z)[-1].outer_wire().edges()
    assert len(edges) == 2 * written.found.program.trochoid.lobes
    z = np.array([complex(p.X, p.Y) for edge in edges for p in edge.positions(np.linspace(0.0, 1.0, 60).tolist())])
    assert np.max(written.off(z)) < TOLERANCE


def test_one_gap_does_not_stand_for_lobes_that_differ(tmp_path: Path) -> None:
    spec = spec_of(tmp_path)
    more = msgspec.structs.replace(
        spec.export, form_wheel=FormWheelSpec(wheel_radius_mm=100.0), points=PointsSpec(range="gap", per_lobe=50)
    )
    spec = msgspec.structs.replace(spec, export=more)
    drift = {"name": "wheel_wear_drift", "amount_um": 2.0, "first_lobe": 3, "disc": 1}
    for effect, names in (
        ({"name": "radial_moving_error", "amount_um": 2.0, "disc": 1}, set()),
        (drift, {"form_wheel.csv", "points.txt"}),
    ):
        disc, skipped = corrected_disc(correction_of(spec, effect), spec)
        assert set(skipped) == names
        assert (disc.spec.export.form_wheel is None) == bool(names)
        assert (disc.spec.export.points is None) == bool(names)


def test_the_wheel_of_the_option_is_that_of_the_programs(tmp_path: Path) -> None:
    spec = spec_of(tmp_path)
    one = correction_of(spec, {"name": "equidistant_error", "amount_um": 2.0, "disc": 1})
    assert corrected_disc(one, spec, 2.5)[0].spec.export.wheel_radius_mm == 2.5
    assert corrected_disc(one, spec)[0].spec.export.wheel_radius_mm is None
    with pytest.raises(ExportError, match="wheel_radius_mm"):
        write_correction(one, {}, spec, 3600, tmp_path / "out", formats=("gcode-polar",), wheel_radius=25.0)
    assert not (tmp_path / "out").exists()
