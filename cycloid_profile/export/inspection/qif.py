"""Inspection plan and results in QIF 3.0 (ISO 23952): features, characteristics, measured points, values."""

from __future__ import annotations

import hashlib
import itertools
import math
import uuid
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray, IntArray
from cycloid_profile.design import DesignRecord
from cycloid_profile.export.curves import deviation
from cycloid_profile.export.inspection.datums import OF_TEETH, CircleDatum, KeywayDatum, root_circle
from cycloid_profile.export.inspection.evaluate import FLANKS, Inspection
from cycloid_profile.export.inspection.plan import InspectionPlan, inspection_plan
from cycloid_profile.export.points import POINT_RESOLUTION, measuring_points
from cycloid_profile.export.writing import SingleFileExporter, WrittenFile
from cycloid_profile.spec import format_spec

_NAMESPACE = "{http://qifstandards.org/xsd/qif3}"
_TEMPLATE = "inspection.qif.j2"
_FIRST_ID = 10  # smaller ones stand in the template
_FACE, _KEYWAY = 7, 9  # of the nominal features there
_STATUS = {True: "PASS", False: "FAIL", None: "NOT_ANALYZED"}


@dataclass(frozen=True)
class QifExporter(SingleFileExporter[DesignRecord]):
    """Writes ``inspection.qif``: the plan with the nominal points of every flank."""

    format: str = "qif"
    filename: str = "inspection.qif"

    def write_file(self, source: DesignRecord, path: Path) -> WrittenFile:
        """See ``SingleFileExporter.write_file``."""
        path.write_bytes(qif_document(source))
        points = ElementTree.parse(path).iterfind(f".//{_NAMESPACE}DefiningPoint/{_NAMESPACE}Point")
        back = np.array([(point.text or "").split() for point in points], dtype=np.float64)
        found = deviation(source.profile, back[:, 0] + 1j * back[:, 1])
        count = {"points": len(back), "flanks": 2 * source.profile.trochoid.lobes}
        return self.measured(POINT_RESOLUTION, found, "ElementTree", count)


def qif_document(record: DesignRecord, result: Inspection | None = None) -> bytes:
    """The document of a design: its plan, and with ``result`` the points and values of a scan. Equal input gives equal
    bytes."""
    from jinja2 import Environment, StrictUndefined

    plan, ids = inspection_plan(record), itertools.count(_FIRST_ID)
    flanks = _flanks(record, plan, result, ids)
    circles, datums = _datums(record, plan, ids)
    teeth = len(OF_TEETH)
    digest = hashlib.sha256(format_spec(record.spec).encode() + record.label.encode())
    if result is not None:
        digest.update(result.registered.placed.tobytes())
    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=StrictUndefined)
    environment.filters |= {"mm": lambda value: f"{round(value, 9) + 0.0:.9f}", "pair": lambda one, kind: (kind, one)}
    text = resources.files("cycloid_profile.export.inspection").joinpath(_TEMPLATE).read_text(encoding="utf-8")
    filled = environment.from_string(text).render(
        title=f"{record.spec.name} {record.label}".strip(),
        qp_id=uuid.UUID(bytes=digest.digest()[:16], version=5),
        z=plan.mid_height,
        circles=circles,
        keyway=plan.datums.direction if isinstance(plan.datums.direction, KeywayDatum) else None,
        datums=datums,
        # The frame of the teeth first.
        frames=[datums[:teeth], datums] if len(datums) > teeth else [datums],
        flanks=flanks,
        characteristics=_characteristics(plan, flanks, circles[0]["item"], result, ids),
        measured=result,
        status=_STATUS,
        last_id=next(ids) - 1,
    )
    return f"{filled}\n".encode()


def _datums(
    record: DesignRecord, plan: InspectionPlan, ids: Iterator[int]
) -> tuple[list[dict[str, Any]], list[tuple[str, int, int]]]:
    """Circles with their identifiers, that of the roots first; letter, identifier and nominal feature of the datums."""
    system = plan.datums
    used = [one for one in (root_circle(record), system.axis, system.direction) if isinstance(one, CircleDatum)]
    keys = ("definition", "nominal", "item")
    circles: dict[str, dict[str, Any]] = {
        one.name: {"name": one.name, "circle": one} | {key: next(ids) for key in keys} for one in dict.fromkeys(used)
    }
    nominal = {name: one["nominal"] for name, one in circles.items()} | {system.face: _FACE}
    datums = [(letter, next(ids), nominal.get(name, _KEYWAY)) for letter, name in system.names.items()]
    return list(circles.values()), datums


def _flanks(
    record: DesignRecord, plan: InspectionPlan, result: Inspection | None, ids: Iterator[int]
) -> list[dict[str, Any]]:
    """Name, nominal and measured points and identifiers of every flank, left and right of lobe 1, 2, …"""
    points, _ = measuring_points(record)
    # A flank belongs to the root that it ends at, as in the evaluation.
    at_root = np.round(points.phase / (2.0 * math.pi))
    nominal = _on_flanks(at_root % plan.lobes, points.phase - 2.0 * math.pi * at_root, plan.lobes)
    measured: list[Any] = [()] * len(nominal)
    if result is not None:
        at = result.registered
        measured = [_xy(at.placed[chosen]) for chosen in _on_flanks(at.lobe, at.foot, plan.lobes)]
    names = (f"lobe {lobe + 1} {side}" for lobe in range(plan.lobes) for side in FLANKS)
    return [
        {"name": name, "measured": own}
        | {key: next(ids) for key in ("nominal", "item", "measurement", "point_set")}
        | {
            "points": [
                (next(ids), *xy, *n) for xy, n in zip(_xy(points.position[k]), _xy(points.normal[k]), strict=True)
            ]
        }
        for name, k, own in zip(names, nominal, measured, strict=True)
    ]


def _on_flanks(lobe: FloatArray, foot: FloatArray, lobes: int) -> list[IntArray]:
    """Indices of the points of every flank, left and right of each lobe in turn."""
    sides = (foot >= 0.0, foot < 0.0)
    return [np.flatnonzero((lobe == k) & side).astype(np.intp) for k in range(lobes) for side in sides]


def _xy(points: ComplexArray) -> list[tuple[float, float]]:
    return list(zip(points.real.tolist(), points.imag.tolist(), strict=True))


class _Found(NamedTuple):
    """Value of an item and its standard uncertainty [mm], whether it is within its tolerance, and the largest and
    least deviation of a profile [mm]; no value where there is no scan, or the scan does not show it."""

    value: float | None = None
    uncertainty: float = 0.0
    passed: bool | None = None
    extremes: tuple[float, float] | None = None


def _characteristics(
    plan: InspectionPlan, flanks: list[dict[str, Any]], roots: int, result: Inspection | None, ids: Iterator[int]
) -> list[dict[str, Any]]:
    """Profile and single pitch of every flank, cumulative pitch of left and of right flanks, runout of the roots.

    A zone of a profile is symmetric about the nominal curve: twice the deviation that is allowed on either side. The
    last identifier is that of an item, which is there without results, too.
    """
    profile, single, cumulative, runout = plan.checks
    items = [flank["item"] for flank in flanks]
    each = [(flank["name"], [flank["item"]]) for flank in flanks]
    sides = [(f"{side} flanks", items[k::2]) for k, side in enumerate(FLANKS)]
    rows = (
        ("LineProfile", profile, 2.0 * profile.tolerance, each),
        ("UserDefinedUnit", single, None, each),
        ("UserDefinedUnit", cumulative, None, sides),
        ("CircularRunout", runout, runout.tolerance, [("roots", [roots])]),
    )
    found = [[_Found()] * len(concerned) for *_, concerned in rows] if result is None else _found(result)
    return [
        {"kind": kind, "check": check, "zone": zone, "count": len(concerned)}
        | {"definition": next(ids), "nominal": next(ids)}
        | {
            "members": [
                {"name": name, "features": features, "found": one, "measurement": next(ids), "id": next(ids)}
                for (name, features), one in zip(concerned, values, strict=True)
            ]
        }
        for (kind, check, zone, concerned), values in zip(rows, found, strict=True)
    ]


def _found(result: Inspection) -> list[list[_Found]]:
    """Values of the items of every check, in their order."""
    profile, single, cumulative, runout = result.checks
    extremes = list(zip(result.high.ravel().tolist(), result.low.ravel().tolist(), strict=True))
    largest = [max(abs(high), abs(low)) for high, low in extremes]
    steps, ranges = result.single_pitch.ravel().tolist(), np.ptp(result.position, axis=0).tolist()
    return [
        [
            _Found(2.0 * size, 2.0 * profile.uncertainty, size <= profile.tolerance, ends)
            for size, ends in zip(largest, extremes, strict=True)
        ],
        [_Found(step, single.uncertainty, abs(step) <= single.tolerance) for step in steps],
        [_Found(width, cumulative.uncertainty, width <= cumulative.tolerance) for width in ranges],
        [_Found(runout.value, runout.uncertainty, runout.passed)],
    ]
