"""A measuring program in DMIS 5.2 (ISO 22093), and the inspection plan as Markdown."""

from __future__ import annotations

import cmath
import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray, IntArray
from cycloid_profile.design import DesignRecord
from cycloid_profile.errors import ExportError
from cycloid_profile.export.curves import deviation
from cycloid_profile.export.inspection.plan import InspectionPlan, inspection_plan, plan_rows
from cycloid_profile.export.points import POINT_RESOLUTION, measuring_points
from cycloid_profile.export.writing import WrittenFile, plain_name
from cycloid_profile.geometry import ToothPoints

_APPROACH = 1.0  # mm, before and after a touch; exceeds the depth between neighbouring points
_CLEARANCE = 20.0  # mm above the disc and outside its tips, for moves between features
_TURNED = 1e-9  # °, of a crank hole away from the x axis
_OUTLINE, _CHORDS = 20_000, 1e-2  # points of the teeth, and mm of chords, of the face on which places are sought
_MARGINS = (3.0, 2.0, 1.0, 0.5, 0.2)  # mm between the ball and an edge of the face, tried in order
_LETTERS = {"FACE": "C", "BORE": "A", "CRANK1": "B"}
_NOMINAL = re.compile(r"^F\((\d+)\)=FEAT/POINT,CART,(.*)$", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class DmisExporter:
    """Writes ``cmm.dmi``, the measuring program, and ``inspection_plan.md``."""

    format: str = "dmis"
    filenames: tuple[str, ...] = ("cmm.dmi", "inspection_plan.md")

    def write(self, record: DesignRecord, folder: Path) -> tuple[WrittenFile, ...]:
        """Write, and read the nominal points back."""
        program, page = (folder / name for name in self.filenames)
        plan = inspection_plan(record)
        program.write_text("\n".join(_program(record, plan)) + "\n", encoding="ascii", newline="\n")
        title = f"# Inspection plan: {record.spec.name}"
        page.write_text("\n".join([title, "", *plan_rows(plan)]) + "\n", encoding="utf-8", newline="\n")
        back = read_nominals(program)
        found = deviation(record.profile, back[:, 0] + 1j * back[:, 1])
        return (
            WrittenFile(program.name, self.format, POINT_RESOLUTION, found, "own reader", {"points": len(back)}),
            WrittenFile(page.name, self.format),
        )


def read_nominals(path: Path) -> FloatArray:
    """Nominal points x, y, z and normals i, j, k of a program, shape (points, 6) [mm]."""
    found = _NOMINAL.findall(path.read_text(encoding="ascii"))
    return np.array([values.split(",") for _, values in found], dtype=np.float64)


def _program(record: DesignRecord, plan: InspectionPlan) -> list[str]:
    points, lobe = measuring_points(record)
    radius = np.abs(points.position)
    outside = complex(points.position[0]) / radius[0] * (float(np.max(radius)) + _CLEARANCE)
    return [
        f"DMISMN/'{plain_name(record.spec.name)} TEETH',05.2",
        "UNITS/MM,ANGDEC",
        "WKPLAN/XYPLAN",
        "PRCOMP/ON",
        "TECOMP/OFF",
        "$$ INSPECTION PLAN",
        *(f"$$ {row}".encode("ascii", "replace").decode("ascii") for row in _plain(plan_rows(plan))),
        f"$$ SELECT A CALIBRATED PROBE WITH A BALL OF RADIUS {plan.probe_radius:g} MM BEFORE THIS LINE",
        f"SNSET/APPRCH,{_APPROACH:g}",
        f"SNSET/RETRCT,{_APPROACH:g}",
        *_alignment(record, plan),
        *_tolerances(plan),
        *_descend(outside, plan),
        *_flank_points(points, lobe, plan),
        *_retract(outside, plan),
        *_pitch_and_runout(points, lobe, plan),
        "ENDFIL",
    ]


def _alignment(record: DesignRecord, plan: InspectionPlan) -> list[str]:
    """Alignment by hand, without a move of the program, then the same features again in automatic mode."""
    datums = _datum_features(record, plan)
    rotation = math.degrees(plan.hole_angle)
    lines = []
    for number, (how, mode, end) in enumerate((("BY HAND", "MODE/MAN", "M"), ("BY THE MACHINE", "MODE/PROG,MAN", ""))):
        lines += [f"$$ ALIGNMENT {how}", mode]
        for name, feature, touches in datums:
            lines += _measured(name + end, feature, touches, plan, moves=not end)
            lines.append(f"DATDEF/FA({name}{end}),DAT({_LETTERS[name]}{end})")
        lines += [
            f"D({3 * number + 1})=DATSET/DAT(C{end}),ZDIR,ZORIG,DAT(A{end}),XORIG,YORIG,DAT(B{end}),XDIR",
            # The upper face was touched, the plan counts from the lower one.
            f"D({3 * number + 2})=TRANS/ZORIG,{_mm(-2.0 * plan.mid_height)}",
        ]
        if abs(rotation) > _TURNED:
            # From crank hole 1 to root 1, which lies on the x axis.
            lines.append(f"D({3 * number + 3})=ROTATE/ZAXIS,{-rotation:.9f}")
    return lines


Touch = tuple[complex, float, complex, float]  # place and height, and normal in the plane and along z [mm]


def _datum_features(record: DesignRecord, plan: InspectionPlan) -> list[tuple[str, str, list[Touch]]]:
    """Name, nominal definition and touches of face, origin and direction."""
    top, height = 2.0 * plan.mid_height, plan.mid_height
    face = [(at, top, 0j, 1.0) for at in face_points(record, plan.probe_radius)]
    found = [("FACE", f"PLANE,CART,{_xyz(face[0][0], top)},0,0,1", face)]
    if plan.bore_radius is not None:
        found.append(("BORE", *_hole(0j, plan.bore_radius, plan)))
    else:
        roots = record.profile.at(2.0 * math.pi * np.arange(record.profile.trochoid.lobes))
        radius = float(np.abs(roots.position[0]))
        touches = [(complex(z), height, complex(z / abs(z)), 0.0) for z in roots.position]
        found.append(("BORE", f"CIRCLE,OUTER,CART,{_xyz(0j, height)},0,0,1,{_mm(2.0 * radius)}", touches))
    if plan.crank_hole is not None:
        return [*found, ("CRANK1", *_hole(*plan.crank_hole, plan))]
    root = record.profile.at(0.0)
    at, normal = complex(root.position), complex(root.normal / np.abs(root.normal))
    touch = [(at, height, normal, 0.0)]
    return [*found, ("CRANK1", f"POINT,CART,{_xyz(at, height)},{_mm(normal.real)},{_mm(normal.imag)},0", touch)]


def _hole(centre: complex, radius: float, plan: InspectionPlan) -> tuple[str, list[Touch]]:
    """Nominal definition and touches of a round hole; normals point out of the material, towards the axis."""
    radial = [cmath.rect(1.0, 2.0 * math.pi * k / plan.bore_points) for k in range(plan.bore_points)]
    touches: list[Touch] = [(centre + radius * r, plan.mid_height, -r, 0.0) for r in radial]
    return f"CIRCLE,INNER,CART,{_xyz(centre, plan.mid_height)},0,0,1,{_mm(2.0 * radius)}", touches


def _measured(name: str, feature: str, touches: list[Touch], plan: InspectionPlan, moves: bool) -> list[str]:
    """A feature with its touches; with ``moves`` the probe goes there and away again."""
    kind = feature.split(",")[0]
    middle = sum((at for at, *_ in touches), 0j) / len(touches)
    inside = moves and "INNER" in feature
    lines = [f"F({name})=FEAT/{feature}", f"MEAS/{kind},F({name}),{len(touches)}"]
    for at, z, normal, up in touches:
        if moves and not inside:
            # From above: over the face, and to the height of a root from outside the teeth.
            clear = at if up else at * (1.0 + _CLEARANCE / abs(at))
            lines += _retract(clear, plan) if up else _descend(clear, plan)
        lines.append(f"PTMEAS/CART,{_xyz(at, z)},{_mm(normal.real)},{_mm(normal.imag)},{up:g}")
        if moves and not inside:
            lines += _retract(clear, plan) if up else [f"GOTO/{_xyz(clear, z)}", *_retract(clear, plan)]
    lines.append("ENDMES")
    return [*_descend(middle, plan), *lines, *_retract(middle, plan)] if inside else lines


def face_points(record: DesignRecord, probe_radius: float) -> list[complex]:
    """Four places of the face, one a quadrant, far from the axis and clear of teeth and openings [mm]."""
    from shapely import Point, Polygon

    def ring(points: ComplexArray) -> FloatArray:
        return np.stack([points.real, points.imag], axis=-1)

    phase = np.linspace(0.0, record.profile.trochoid.phase_period, _OUTLINE, endpoint=False)
    holes = [ring(contour.points(_CHORDS)) for contour in record.outline.contours]
    disc = Polygon(ring(record.profile.at(phase).position), holes)
    root = float(np.min(np.abs(record.profile.at(phase).position)))
    for margin in _MARGINS:
        region = disc.buffer(-(probe_radius + margin))
        found = []
        for quadrant in range(4):
            # From the middle of the quadrant outwards on both sides.
            turns = sorted(np.linspace(0.02, 0.98, 49).tolist(), key=lambda share: abs(share - 0.5))
            places = (
                radius * cmath.exp(0.5j * math.pi * (quadrant + turn))
                for turn in turns
                for radius in np.linspace(root, 0.2 * root, 60).tolist()
            )
            found += [next((z for z in places if region.contains(Point(z.real, z.imag))), None)]
        if None not in found:
            return [z for z in found if z is not None]
    raise ExportError(
        "export.inspection.probe_radius_mm", f"{probe_radius:g}", "finds no face to touch between the openings",
        "take a smaller ball",
    )  # fmt: skip


def _tolerances(plan: InspectionPlan) -> list[str]:
    """Definitions of the tolerances of profile of points and runout of the roots."""
    profile, _, _, runout = (check.tolerance for check in plan.checks)
    return [f"T(1)=TOL/PROFP,{-profile:.6f},{profile:.6f}", f"T(2)=TOL/CRNOUT,{runout:.6f},DAT(A)"]


def _flank_points(points: ToothPoints, lobe: IntArray, plan: InspectionPlan) -> list[str]:
    """Every nominal point with its touch, output against the profile tolerance."""
    lines, previous = [], 0
    for number, (at, position, normal) in enumerate(
        zip(lobe.tolist(), points.position.tolist(), points.normal.tolist(), strict=True), start=1
    ):
        if at != previous:
            lines.append(f"$$ LOBE {at}")
            previous = at
        point = f"{_xyz(position, plan.mid_height)},{_mm(normal.real)},{_mm(normal.imag)},0"
        lines += [
            f"F({number})=FEAT/POINT,CART,{point}",
            f"MEAS/POINT,F({number}),1",
            f"PTMEAS/CART,{point}",
            "ENDMES",
            f"OUTPUT/FA({number}),TA(1)",
        ]
    return lines


def _pitch_and_runout(points: ToothPoints, lobe: IntArray, plan: InspectionPlan) -> list[str]:
    """Pitch as distances and angles between flank points of neighbouring and of first lobes; runout of a circle
    through the points nearest to the roots. All are constructed from measured points."""
    _, single, cumulative, _ = (check.tolerance for check in plan.checks)
    in_lobe = np.mod(points.phase, 2.0 * math.pi)
    lines = ["$$ PITCH"]
    label = 100
    for name, phase in (("L", plan.pitch_phase), ("R", 2.0 * math.pi - plan.pitch_phase)):
        chosen = _nearest_in_each_lobe(in_lobe, lobe, phase)
        at = points.position[chosen]
        for k, number in enumerate((chosen + 1).tolist()):
            lines.append(f"F({name}{k + 1})=FEAT/LINE,UNBND,CART,0,0,{_mm(plan.mid_height)},{_direction(at[k])},0,0,1")
            lines.append(f"CONST/LINE,F({name}{k + 1}),BF,FA(BORE),FA({number})")
        for k, number in enumerate((chosen + 1).tolist()):
            before = k - 1
            chord = float(abs(at[k] - at[before]))
            lines += [
                f"T({label})=TOL/DISTB,NOMINL,{_mm(chord)},{-single:.6f},{single:.6f},PT2PT",
                f"OUTPUT/FA({int(chosen[before]) + 1}),FA({number}),TA({label})",
            ]
            label += 1
            if k:
                angle = abs(math.degrees(float(np.angle(at[k] / at[0]))))
                limit = math.degrees(cumulative / plan.pitch_radius)
                lines += [
                    f"T({label})=TOL/ANGLB,NOMINL,{angle:.9f},{-limit:.9f},{limit:.9f}",
                    f"OUTPUT/FA({name}1),FA({name}{k + 1}),TA({label})",
                ]
                label += 1
    roots = _nearest_in_each_lobe(np.abs(np.angle(np.exp(1j * in_lobe))), lobe, 0.0)
    diameter = 2.0 * float(np.mean(np.abs(points.position[roots])))
    lines += [
        "$$ RUNOUT",
        f"F(ROOTS)=FEAT/CIRCLE,OUTER,CART,{_xyz(0j, plan.mid_height)},0,0,1,{_mm(diameter)}",
        "CONST/CIRCLE,F(ROOTS),BF," + ",$\n".join(f"FA({number})" for number in (roots + 1).tolist()),
    ]
    return [*lines, "OUTPUT/FA(ROOTS),TA(2)"]


def _nearest_in_each_lobe(in_lobe: FloatArray, lobe: IntArray, phase: float) -> IntArray:
    """Index of the point of every lobe that is nearest to a phase within the lobe, shape (lobes,)."""
    away = np.abs(in_lobe - phase)
    found = [int(np.flatnonzero(lobe == k)[np.argmin(away[lobe == k])]) for k in range(1, int(lobe[-1]) + 1)]
    return np.array(found, dtype=np.intp)


def _direction(at: complex) -> str:
    return f"{_mm(at.real / abs(at))},{_mm(at.imag / abs(at))},0"


def _xyz(at: complex, z: float) -> str:
    return f"{_mm(at.real)},{_mm(at.imag)},{_mm(z)}"


def _descend(at: complex, plan: InspectionPlan) -> list[str]:
    """Move above the disc, then to the measuring height."""
    return [*_retract(at, plan), f"GOTO/{_xyz(at, plan.mid_height)}"]


def _retract(at: complex, plan: InspectionPlan) -> list[str]:
    return [f"GOTO/{_xyz(at, 2.0 * plan.mid_height + _CLEARANCE)}"]


def _plain(rows: list[str]) -> list[str]:
    """The plan without table markup, in ASCII capitals."""
    text = (row.strip("|- ").replace(" | ", ", ") for row in rows if row and not row.startswith("|---"))
    return [
        row.replace("± ", "+/-").replace("±", "+/-").replace("µm", "um").replace("°", " deg").upper() for row in text
    ]


def _mm(value: float) -> str:
    return f"{round(value, 9) + 0.0:.9f}"
