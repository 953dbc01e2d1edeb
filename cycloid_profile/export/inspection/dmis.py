"""A measuring program in DMIS 5.2 (ISO 22093), and the inspection plan as Markdown."""

from __future__ import annotations

import cmath
import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.design import DesignRecord
from cycloid_profile.export.curves import deviation
from cycloid_profile.export.inspection.plan import InspectionPlan, inspection_plan, plan_rows
from cycloid_profile.export.points import POINT_RESOLUTION, measuring_points
from cycloid_profile.export.writing import WrittenFile, plain_name

_APPROACH = 1.0  # mm, before and after a touch; exceeds the depth between neighbouring points
_CLEARANCE = 20.0  # mm above the disc and outside its tips, for moves between features
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
    height = _mm(plan.mid_height)
    lines = [
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
        "MODE/PROG,MAN",
        *_datums(plan),
    ]
    profile = plan.checks[0].tolerance
    if profile is not None:
        lines.append(f"T(1)=TOL/PROFP,{-profile:.6f},{profile:.6f}")
    radius = np.abs(points.position)
    outside = complex(points.position[0]) / radius[0] * (float(np.max(radius)) + _CLEARANCE)
    lines += _descend(outside, plan)
    previous = 0
    n = points.normal
    for number, (at, x, y, i, j) in enumerate(
        zip(lobe.tolist(), *(v.tolist() for v in (*points.xy.T, n.real, n.imag)), strict=True), start=1
    ):
        if at != previous:
            lines.append(f"$$ LOBE {at}")
            previous = at
        point = f"{_mm(x)},{_mm(y)},{height},{_mm(i)},{_mm(j)},0"
        lines += [
            f"F({number})=FEAT/POINT,CART,{point}",
            f"MEAS/POINT,F({number}),1",
            f"PTMEAS/CART,{point}",
            "ENDMES",
            f"OUTPUT/FA({number})" + ("" if profile is None else ",TA(1)"),
        ]
    return [*lines, *_retract(outside, plan), "ENDFIL"]


def _datums(plan: InspectionPlan) -> list[str]:
    """The bore as origin and crank hole 1 as direction, if the disc has them."""
    if plan.bore_radius is None:
        return ["$$ NO ROUND BORE: SET THE ORIGIN TO THE CENTRE OF THE ROOTS BY HAND"]
    lines = [*_hole("BORE", 0j, plan.bore_radius, plan), "DATDEF/FA(BORE),DAT(A)"]
    if plan.crank_hole is None:
        return [*lines, "D(1)=DATSET/DAT(A),XORIG,YORIG"]
    centre, radius = plan.crank_hole
    return [
        *lines,
        *_hole("CRANK1", centre, radius, plan),
        "DATDEF/FA(CRANK1),DAT(B)",
        "D(1)=DATSET/DAT(A),XORIG,YORIG,DAT(B),XDIR",
    ]


def _hole(name: str, centre: complex, radius: float, plan: InspectionPlan) -> list[str]:
    height = _mm(plan.mid_height)
    touches = []
    for k in range(plan.bore_points):
        radial = cmath.rect(1.0, 2.0 * math.pi * k / plan.bore_points)
        at = centre + radius * radial
        # The normal points out of the material, towards the axis.
        touches.append(f"PTMEAS/CART,{_mm(at.real)},{_mm(at.imag)},{height},{_mm(-radial.real)},{_mm(-radial.imag)},0")
    return [
        *_descend(centre, plan),
        f"F({name})=FEAT/CIRCLE,INNER,CART,{_mm(centre.real)},{_mm(centre.imag)},{height},0,0,1,{_mm(2.0 * radius)}",
        f"MEAS/CIRCLE,F({name}),{plan.bore_points}",
        *touches,
        "ENDMES",
        *_retract(centre, plan),
    ]


def _descend(at: complex, plan: InspectionPlan) -> list[str]:
    """Move above the disc, then to the measuring height."""
    return [*_retract(at, plan), f"GOTO/{_mm(at.real)},{_mm(at.imag)},{_mm(plan.mid_height)}"]


def _retract(at: complex, plan: InspectionPlan) -> list[str]:
    return [f"GOTO/{_mm(at.real)},{_mm(at.imag)},{_mm(2.0 * plan.mid_height + _CLEARANCE)}"]


def _plain(rows: list[str]) -> list[str]:
    """The plan without table markup, in ASCII capitals."""
    text = (row.strip("|- ").replace(" | ", ", ") for row in rows if row and not row.startswith("|---"))
    return [
        row.replace("± ", "+/-").replace("±", "+/-").replace("µm", "um").replace("°", " deg").upper() for row in text
    ]


def _mm(value: float) -> str:
    return f"{round(value, 9) + 0.0:.9f}"
