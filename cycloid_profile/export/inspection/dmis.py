"""A measuring program in DMIS 5.2 (ISO 22093), and the inspection plan as Markdown."""

from __future__ import annotations

import cmath
import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.design import DesignRecord
from cycloid_profile.errors import ExportError
from cycloid_profile.export.curves import deviation
from cycloid_profile.export.inspection.datums import AXIS, DIRECTION, FACE, CircleDatum, KeywayDatum, face_points
from cycloid_profile.export.inspection.plan import InspectionPlan, inspection_plan, plan_rows
from cycloid_profile.export.points import POINT_RESOLUTION, measuring_points
from cycloid_profile.export.writing import WrittenFile, plain_name
from cycloid_profile.geometry import ToothPoints

_EDGE = 1.0  # mm between the ball and a keyway
_APPROACH = 1.0  # mm, before and after a touch; exceeds the depth between neighbouring points
_CLEARANCE = 20.0  # mm above the disc and outside its tips, for moves between features
_TURNED = 1e-9  # °, of datum C away from the x axis
_LETTERS = {"FACE": FACE, "AXIS": AXIS, "TURN": DIRECTION}
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
        *_turn_of_teeth(record, plan, outside),
        *_descend(outside, plan),
        *_flank_points(points, lobe, plan),
        *_retract(outside, plan),
        *_pitch_and_runout(points, lobe, plan),
        "ENDFIL",
    ]


Touch = tuple[complex, float, complex, float]  # place and height, and normal in the plane and along z [mm]


@dataclass(frozen=True, slots=True)
class _Feature:
    """Name, nominal definition and touches of a feature; the probe comes down and goes up at ``entry``, or without
    one over each touch of a face and outside each touch of the teeth."""

    name: str
    definition: str
    touches: list[Touch]
    entry: complex | None = None


def _alignment(record: DesignRecord, plan: InspectionPlan) -> list[str]:
    """Alignment by hand, without a move of the program, then the same features again in automatic mode."""
    features, slot = _datum_features(record, plan), plan.datums.direction
    rotation = math.degrees(plan.datums.direction_angle)
    lines = []
    for number, (how, mode, end) in enumerate((("BY HAND", "MODE/MAN", "M"), ("BY THE MACHINE", "MODE/PROG,MAN", ""))):
        lines += [f"$$ ALIGNMENT {how}", mode]
        for feature in features:
            lines += _measured(feature, plan, end)
        if isinstance(slot, KeywayDatum):
            lines += _midpoint(f"TURN{end}", slot.centre, (f"SIDE1{end}", f"SIDE2{end}"), plan)
        lines += [f"DATDEF/FA({name}{end}),DAT({letter}{end})" for name, letter in _LETTERS.items()]
        a, b, c = (f"DAT({letter}{end})" for letter in (FACE, AXIS, DIRECTION))
        lines += [
            f"D({3 * number + 1})=DATSET/{a},ZDIR,ZORIG,{b},XORIG,YORIG,{c},XDIR",
            # The upper face was touched, the plan counts from the lower one.
            f"D({3 * number + 2})=TRANS/ZORIG,{_mm(-2.0 * plan.mid_height)}",
        ]
        if abs(rotation) > _TURNED:
            # From C to root 1, which lies on the x axis.
            lines.append(f"D({3 * number + 3})=ROTATE/ZAXIS,{-rotation:.9f}")
    return lines


def _datum_features(record: DesignRecord, plan: InspectionPlan) -> list[_Feature]:
    """Features of face, axis and direction."""
    top, height, axis, direction = 2.0 * plan.mid_height, plan.mid_height, plan.datums.axis, plan.datums.direction
    face: list[Touch] = [(at, top, 0j, 1.0) for at in face_points(record, plan.probe_radius)]
    found = [_Feature("FACE", f"PLANE,CART,{_xyz(face[0][0], top)},0,0,1", face)]
    if axis.opening:
        found.append(_hole("AXIS", axis, plan))
    else:
        roots = record.profile.at(2.0 * math.pi * np.arange(record.profile.trochoid.lobes))
        touches: list[Touch] = [(complex(z), height, complex(z / abs(z)), 0.0) for z in roots.position]
        definition = f"CIRCLE,OUTER,CART,{_xyz(0j, height)},0,0,1,{_mm(2.0 * axis.radius)}"
        found.append(_Feature("AXIS", definition, touches))
    if isinstance(direction, CircleDatum):
        return [*found, _hole("TURN", direction, plan)]
    if direction is not None:
        return [*found, *_sides(direction, plan)]
    root = record.profile.at(0.0)
    return [*found, _point("TURN", complex(root.position), complex(root.normal / np.abs(root.normal)), plan)]


def _hole(name: str, hole: CircleDatum, plan: InspectionPlan) -> _Feature:
    """A hole; normals point out of the material, towards the axis."""
    margin = (plan.probe_radius + _EDGE) / hole.radius
    radial = [cmath.rect(1.0, angle) for angle in hole.angles(plan.bore_points, margin)]
    touches: list[Touch] = [(hole.centre + hole.radius * r, plan.mid_height, -r, 0.0) for r in radial]
    definition = f"CIRCLE,INNER,CART,{_xyz(hole.centre, plan.mid_height)},0,0,1,{_mm(2.0 * hole.radius)}"
    return _Feature(name, definition, touches, hole.centre)


def _sides(keyway: KeywayDatum, plan: InspectionPlan) -> list[_Feature]:
    """A point of each side of a keyway. Raises ``ExportError`` where the ball does not fit between them."""
    if keyway.half_width <= plan.probe_radius:
        raise ExportError(
            "export.inspection.probe_radius_mm", f"{plan.probe_radius:g}", "does not fit into the keyway, datum C",
            "take a smaller ball",
        )  # fmt: skip
    across = 1j * keyway.centre / abs(keyway.centre)
    return [
        _point(name, keyway.centre + side * keyway.half_width * across, -side * across, plan, keyway.centre)
        for name, side in (("SIDE1", 1.0), ("SIDE2", -1.0))
    ]


def _point(name: str, at: complex, normal: complex, plan: InspectionPlan, entry: complex | None = None) -> _Feature:
    place = f"{_xyz(at, plan.mid_height)},{_mm(normal.real)},{_mm(normal.imag)},0"
    return _Feature(name, f"POINT,CART,{place}", [(at, plan.mid_height, normal, 0.0)], entry)


def _midpoint(name: str, at: complex, ends: tuple[str, str], plan: InspectionPlan) -> list[str]:
    """A point midway between two measured ones."""
    along = _direction(at)
    return [
        f"F({name})=FEAT/POINT,CART,{_xyz(at, plan.mid_height)},{along}",
        f"CONST/POINT,F({name}),MIDPT,FA({ends[0]}),FA({ends[1]})",
    ]


def _measured(feature: _Feature, plan: InspectionPlan, end: str = "") -> list[str]:
    """A feature with its touches; without ``end`` the probe goes there and away again."""
    name, moves, entry = feature.name + end, not end, feature.entry
    kind = feature.definition.split(",")[0]
    lines = [f"F({name})=FEAT/{feature.definition}", f"MEAS/{kind},F({name}),{len(feature.touches)}"]
    for at, z, normal, up in feature.touches:
        # From above: over the face, and to the height of a root from outside the teeth.
        clear = at if up else at * (1.0 + _CLEARANCE / abs(at))
        if moves and entry is None:
            lines += _retract(clear, plan) if up else _descend(clear, plan)
        lines.append(f"PTMEAS/CART,{_xyz(at, z)},{_mm(normal.real)},{_mm(normal.imag)},{up:g}")
        if moves and entry is None:
            lines += _retract(clear, plan) if up else [f"GOTO/{_xyz(clear, z)}", *_retract(clear, plan)]
    lines.append("ENDMES")
    if not moves or entry is None:
        return lines
    leave = [f"GOTO/{_xyz(entry, plan.mid_height)}", *_retract(entry, plan)]
    return [*_descend(entry, plan), *lines, *leave]


def _turn_of_teeth(record: DesignRecord, plan: InspectionPlan, outside: complex) -> list[str]:
    """The axis of root 1, midway between its flanks at the pitch radius; its angle from C, and the x axis along it.

    The turn of the teeth about B is free: a profile within its zone at this turn is within it.
    """
    lines = ["$$ TURN OF THE TEETH"]
    flanks = record.profile.at(np.array([plan.pitch_phase, -plan.pitch_phase]))
    for name, at, normal in zip(("ROOT1L", "ROOT1R"), flanks.position, flanks.normal, strict=True):
        lines += _measured(_point(name, complex(at), complex(normal), plan, outside), plan)
    middle = complex(np.mean(flanks.position))
    lines += _midpoint("MID1", middle, ("ROOT1L", "ROOT1R"), plan)
    lines += _line("ROOT1", middle, "MID1", plan)
    angle, datums = plan.hole_angle_arcmin, plan.datums
    if datums.direction is not None and angle is not None:
        turn, limit = abs(math.degrees(datums.direction_angle)), angle.size / 60.0
        lines += [
            *_line("HOLE", datums.direction.centre, "TURN", plan),
            f"T(3)=TOL/ANGLB,NOMINL,{turn:.9f},{-limit:.9f},{limit:.9f}",
            "OUTPUT/FA(HOLE),FA(ROOT1),TA(3)",
        ]
    return [*lines, "D(7)=ROTATE/ZAXIS,FA(ROOT1),XDIR"]


def _line(name: str, through: complex, point: str, plan: InspectionPlan) -> list[str]:
    """A line from the axis B through a point or centre."""
    return [
        f"F({name})=FEAT/LINE,UNBND,CART,0,0,{_mm(plan.mid_height)},{_direction(through)},0,0,1",
        f"CONST/LINE,F({name}),BF,FA(AXIS),FA({point})",
    ]


def _tolerances(plan: InspectionPlan) -> list[str]:
    """Definitions of the tolerances of profile of points and runout of the roots."""
    profile, _, _, runout = (check.tolerance for check in plan.checks)
    return [f"T(1)=TOL/PROFP,{-profile:.6f},{profile:.6f}", f"T(2)=TOL/CRNOUT,{runout:.6f},DAT({AXIS})"]


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
            lines += _line(f"{name}{k + 1}", at[k], f"{number}", plan)
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
        row.replace("± ", "+/-")
        .replace("±", "+/-")
        .replace("µm", "um")
        .replace("°", " deg")
        .replace("′", " arcmin")
        .upper()
        for row in text
    ]


def _mm(value: float) -> str:
    return f"{round(value, 9) + 0.0:.9f}"
