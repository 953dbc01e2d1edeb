"""Inspection plan and results in QIF 3.0 (ISO 23952): features, characteristics, measured points, values."""

from __future__ import annotations

import hashlib
import itertools
import math
import uuid
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray, IntArray
from cycloid_profile.design import DesignRecord
from cycloid_profile.export.curves import deviation
from cycloid_profile.export.inspection.evaluate import FLANKS, CheckResult, Inspection
from cycloid_profile.export.inspection.plan import Check, InspectionPlan, inspection_plan
from cycloid_profile.export.points import POINT_RESOLUTION, measuring_points
from cycloid_profile.export.writing import SingleFileExporter, WrittenFile
from cycloid_profile.spec import format_spec
from cycloid_profile.units import DEGREE

NAMESPACE = "http://qifstandards.org/xsd/qif3"
FILE = "inspection.qif"
_ARC = "mm of arc"  # unit of pitch: QIF has no characteristic of pitch, and user-defined ones have units of their own
_STATUS = {True: "PASS", False: "FAIL", None: "NOT_ANALYZED"}
_Node = ElementTree.Element


@dataclass(frozen=True)
class QifExporter(SingleFileExporter[DesignRecord]):
    """Writes ``inspection.qif``: the plan with the nominal points of every flank."""

    format: str = "qif"
    filename: str = FILE

    def write_file(self, source: DesignRecord, path: Path) -> WrittenFile:
        """See ``SingleFileExporter.write_file``."""
        path.write_bytes(qif_document(source))
        back = read_defining_points(path)
        found = deviation(source.profile, back[:, 0] + 1j * back[:, 1])
        count = {"points": len(back), "flanks": 2 * source.profile.trochoid.lobes}
        return self.measured(POINT_RESOLUTION, found, "ElementTree", count)


def read_defining_points(path: Path) -> FloatArray:
    """Nominal points x, y, z of all flanks of a document, shape (points, 3) [mm]."""
    points = ElementTree.parse(path).iterfind(f".//{{{NAMESPACE}}}DefiningPoint/{{{NAMESPACE}}}Point")
    return np.array([(point.text or "").split() for point in points], dtype=np.float64)


def qif_document(record: DesignRecord, result: Inspection | None = None) -> bytes:
    """The document of a design: its plan, and with ``result`` the points and values of a scan. Equal input gives equal
    bytes."""
    plan = inspection_plan(record)
    ids = map(str, itertools.count(1))
    standard = _node(
        "Standard",
        _node("Organization", _text("StandardsOrganizationEnum", "ISO")),
        _text("Designator", "1101"),
        id=next(ids),
    )
    features = _features(record, plan, ids)
    datum = _node(
        "DatumDefinition", _text("DatumLabel", "A"), _references("FeatureNominalIds", [features.datum]), id=next(ids)
    )
    frame = _node(
        "DatumReferenceFrame",
        _counted(
            "Datums",
            [
                _node(
                    "Datum",
                    _node(
                        "SimpleDatum",
                        _text("DatumDefinitionId", datum.attrib["id"]),
                        _text("MaterialModifier", "REGARDLESS"),
                        _text("ReferencedComponent", "ACTUAL"),
                    ),
                    _node("Precedence", _text("PrecedenceEnum", "PRIMARY")),
                )
            ],
        ),
        id=next(ids),
    )
    asked = _characteristics(plan, features, frame, ids)
    results = [] if result is None else [_results(result, features, asked, ids)]
    digest = hashlib.sha256(format_spec(record.spec).encode() + record.label.encode())
    if result is not None:
        digest.update(result.registered.placed.tobytes())
    root = _node(
        "QIFDocument",
        _text("QPId", str(uuid.UUID(bytes=digest.digest()[:16], version=5))),
        _node("Version"),
        _node("Header", _text("Description", f"{record.spec.name} {record.label}".strip())),
        _counted("StandardsDefinitions", [standard]),
        _units(),
        _counted("DatumDefinitions", [datum]),
        _counted("DatumReferenceFrames", [frame]),
        _node(
            "Features",
            _counted("FeatureDefinitions", features.definitions),
            _counted("FeatureNominals", features.nominals),
            _counted("FeatureItems", [features.roots, *features.flanks]),
        ),
        _node(
            "Characteristics",
            _text("FormalStandardId", standard.attrib["id"]),
            _counted("CharacteristicDefinitions", [one.definition for one in asked]),
            _counted("CharacteristicNominals", [one.nominal for one in asked]),
            _counted("CharacteristicItems", [item for one in asked for item in one.items]),
        ),
        *results,
        xmlns=NAMESPACE,
        versionQIF="3.0.0",
        idMax=str(int(next(ids)) - 1),
    )
    ElementTree.indent(root)
    written: bytes = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    return written + b"\n"


class _Features(NamedTuple):
    """Definitions and nominals of datum, roots and flanks; identifier of the ``datum``; items of roots and flanks."""

    definitions: list[_Node]
    nominals: list[_Node]
    datum: str
    roots: _Node
    flanks: list[_Node]


class _Characteristic(NamedTuple):
    """A check of the plan as definition, nominal and items."""

    definition: _Node
    nominal: _Node
    items: list[_Node]


def _features(record: DesignRecord, plan: InspectionPlan, ids: Iterator[str]) -> _Features:
    """Roots as a circle, datum as the bore, or the roots without one, and flanks as curves through their points."""
    points, _ = measuring_points(record)
    lobes = plan.lobes
    root = float(np.abs(record.profile.at(0.0).position))
    sizes = [("EXTERNAL", root)] if plan.bore_radius is None else [("EXTERNAL", root), ("INTERNAL", plan.bore_radius)]
    definitions = [
        _node("CircleFeatureDefinition", _text("InternalExternal", side), _text("Diameter", _mm(2.0 * r)), id=next(ids))
        for side, r in sizes
    ]
    circles = [
        _node(
            "CircleFeatureNominal",
            _text("Name", name),
            _text("FeatureDefinitionId", one.attrib["id"]),
            _text("Location", _row((0.0, 0.0, plan.mid_height))),
            _text("Normal", "0 0 1"),
            id=next(ids),
        )
        for name, one in zip(("roots", "bore"), definitions, strict=False)
    ]
    curve = _node("PointDefinedCurveFeatureDefinition", id=next(ids))
    # A flank belongs to the root that it ends at, as in the evaluation.
    at_root = np.round(points.phase / (2.0 * math.pi))
    foot = points.phase - 2.0 * math.pi * at_root
    on_flank = _on_flanks(at_root % lobes, foot, lobes)
    flanks = [
        _flank_nominal(name, curve, points.position[chosen], points.normal[chosen], plan.mid_height, ids)
        for name, chosen in zip(_flank_names(lobes), on_flank, strict=True)
    ]
    items = [
        _item("Circle", circles[0], "roots", ids),
        *(
            _item("PointDefinedCurve", nominal, name, ids)
            for name, nominal in zip(_flank_names(lobes), flanks, strict=True)
        ),
    ]
    return _Features([*definitions, curve], [*circles, *flanks], circles[-1].attrib["id"], items[0], items[1:])


def _flank_names(lobes: int) -> list[str]:
    return [f"lobe {lobe + 1} {flank}" for lobe in range(lobes) for flank in FLANKS]


def _on_flanks(lobe: FloatArray, foot: FloatArray, lobes: int) -> list[IntArray]:
    """Indices of the points of every flank, in the order of ``_flank_names``."""
    return [
        np.flatnonzero((lobe == k) & side).astype(np.intp) for k in range(lobes) for side in (foot >= 0.0, foot < 0.0)
    ]


def _flank_nominal(
    name: str, definition: _Node, at: ComplexArray, normal: ComplexArray, z: float, ids: Iterator[str]
) -> _Node:
    points = [
        _node(
            "DefiningPoint",
            _text("Point", _row((p.real, p.imag, z))),
            _text("Normal", _row((n.real, n.imag, 0.0))),
            _text("SequenceNumber", str(k)),
            id=next(ids),
        )
        for k, (p, n) in enumerate(zip(at.tolist(), normal.tolist(), strict=True), start=1)
    ]
    return _node(
        "PointDefinedCurveFeatureNominal",
        _text("Name", name),
        _text("FeatureDefinitionId", definition.attrib["id"]),
        _counted("DefiningPoints", points),
        id=next(ids),
    )


def _item(kind: str, nominal: _Node, name: str, ids: Iterator[str]) -> _Node:
    return _node(
        f"{kind}FeatureItem",
        _text("FeatureNominalId", nominal.attrib["id"]),
        _text("FeatureName", name),
        _node("DeterminationMode", _node("Checked")),
        id=next(ids),
    )


def _characteristics(
    plan: InspectionPlan, features: _Features, frame: _Node, ids: Iterator[str]
) -> list[_Characteristic]:
    """Profile and single pitch of every flank, cumulative pitch of left and of right flanks, runout of the roots."""
    profile, single, cumulative, runout = plan.checks
    each = [(one.findtext("FeatureName", ""), [one]) for one in features.flanks]
    of_side = [(f"{side} flanks", features.flanks[k::2]) for k, side in enumerate(FLANKS)]
    about_datum = _text("DatumReferenceFrameId", frame.attrib["id"])
    # A zone is symmetric about the nominal curve: twice the deviation that is allowed on either side.
    zone, width = (_text("ToleranceValue", _mm(size)) for size in (2.0 * profile.tolerance, runout.tolerance))

    def made(
        kind: str, check: Check, of: list[tuple[str, list[_Node]]], within: list[_Node], more: list[_Node]
    ) -> _Characteristic:
        definition = _node(f"{kind}CharacteristicDefinition", _text("Name", check.symbol), *within, id=next(ids))
        nominal = _node(
            f"{kind}CharacteristicNominal",
            _text("CharacteristicDefinitionId", definition.attrib["id"]),
            _text("Name", check.symbol),
            *more,
            id=next(ids),
        )
        items = [
            _node(
                f"{kind}CharacteristicItem",
                _text("Description", check.quantity),
                _text("Name", f"{check.symbol} {name}"),
                _references("FeatureItemIds", [one.attrib["id"] for one in concerned]),
                _text("CharacteristicNominalId", nominal.attrib["id"]),
                id=next(ids),
            )
            for name, concerned in of
        ]
        return _Characteristic(definition, nominal, items)

    def pitch(low: float, high: float) -> list[_Node]:
        limits = [_text(name, _mm(value), unitName=_ARC) for name, value in (("MaxValue", high), ("MinValue", low))]
        return [_text("TargetValue", "0", unitName=_ARC), *limits, _text("DefinedAsLimit", "false")]

    return [
        made("LineProfile", profile, each, [zone, about_datum], [_text("Vector", "0 0 1")]),
        made("UserDefinedUnit", single, each, [], pitch(-single.tolerance, single.tolerance)),
        made("UserDefinedUnit", cumulative, of_side, [], pitch(0.0, cumulative.tolerance)),
        made("CircularRunout", runout, [("roots", [features.roots])], [width, about_datum], []),
    ]


def _results(result: Inspection, features: _Features, asked: list[_Characteristic], ids: Iterator[str]) -> _Node:
    """Measured points of every flank in the frame of the disc, and the value of every item."""
    at, z = result.registered, result.plan.mid_height
    on_flank = _on_flanks(at.lobe, at.foot, result.plan.lobes)
    xyz = np.stack([at.placed.real, at.placed.imag, np.full(at.placed.shape, z)], axis=1)
    sets = [
        _node(
            "MeasuredPointSet",
            _text("Points", _row(xyz[chosen].ravel().tolist())),
            _text("Compensated", "true"),
            count=str(chosen.size),
            id=next(ids),
        )
        for chosen in on_flank
    ]
    measured = [
        _node(
            "PointDefinedCurveFeatureMeasurement",
            _text("FeatureItemId", item.attrib["id"]),
            _counted("PointList", [_text("WholePointSetId", points.attrib["id"])]),
            id=next(ids),
        )
        for item, points in zip(features.flanks, sets, strict=True)
    ]
    values = [
        _value(item, check, value, next(ids))
        for one, check, found in zip(asked, result.checks, _found(result), strict=True)
        for item, value in zip(one.items, found, strict=True)
    ]
    return _node(
        "Results",
        _counted(
            "MeasurementResultsSet",
            [
                _node(
                    "MeasurementResults",
                    _counted("MeasuredFeatures", measured),
                    _counted("MeasuredPointSets", sets),
                    _node("MeasuredCharacteristics", _counted("CharacteristicMeasurements", values)),
                    _node("InspectionStatus", _text("InspectionStatusEnum", "PASS" if result.passed else "FAIL")),
                    id=next(ids),
                )
            ],
        ),
    )


class _Found(NamedTuple):
    """Value of an item [mm], None where the scan does not show it, and whether it is within its tolerance."""

    value: float | None
    passed: bool | None
    extremes: tuple[float, float] | None = None  # deviation, high and low


def _found(result: Inspection) -> list[list[_Found]]:
    """Values of the items of every check, in their order."""
    profile, single, cumulative, runout = (check.tolerance for check in result.checks)
    extremes = list(zip(result.high.ravel().tolist(), result.low.ravel().tolist(), strict=True))
    largest = [max(abs(high), abs(low)) for high, low in extremes]
    steps = result.single_pitch.ravel().tolist()
    ranges = np.ptp(result.position, axis=0).tolist()
    radial = result.checks[3].value
    return [
        [_Found(2.0 * size, size <= profile, ends) for size, ends in zip(largest, extremes, strict=True)],
        [_Found(step, abs(step) <= single) for step in steps],
        [_Found(width, width <= cumulative) for width in ranges],
        [_Found(radial, None if radial is None else radial <= runout)],
    ]


def _value(item: _Node, check: CheckResult, found: _Found, number: str) -> _Node:
    """The measurement of an item: its value with the standard uncertainty, and the deviations of a profile."""
    kind = item.tag.removesuffix("CharacteristicItem")
    unit = {"unitName": _ARC} if kind == "UserDefinedUnit" else {}
    # The width of a zone counts a deviation twice.
    uncertainty = check.uncertainty * (2.0 if found.extremes else 1.0)
    shown = [] if found.value is None else [
        _text("Value", _mm(found.value), combinedUncertainty=_mm(uncertainty), **unit)
    ]  # fmt: skip
    extremes = [] if found.extremes is None else [
        _text("WorstPositiveDeviation", _mm(found.extremes[0])), _text("WorstNegativeDeviation", _mm(found.extremes[1]))
    ]  # fmt: skip
    return _node(
        f"{kind}CharacteristicMeasurement",
        _node("Status", _text("CharacteristicStatusEnum", _STATUS[found.passed])),
        _text("CharacteristicItemId", item.attrib["id"]),
        *shown,
        *extremes,
        id=number,
    )


def _units() -> _Node:
    def unit(name: str, si: str, own: str, factor: float) -> _Node:
        conversion = _node("UnitConversion", _text("Factor", f"{factor:.15g}"))
        return _node(name, _text("SIUnitName", si), _text("UnitName", own), conversion)

    return _node(
        "FileUnits",
        _node(
            "PrimaryUnits",
            unit("AngularUnit", "radian", "degree", DEGREE),
            unit("LinearUnit", "meter", "mm", 0.001),
        ),
        _counted(
            "UserDefinedUnits",
            [
                _node(
                    "UserDefinedUnit",
                    _text("WhatIsMeasured", "pitch deviation, as an arc at the pitch radius"),
                    _text("UnitName", _ARC),
                )
            ],
        ),
    )


def _node(tag: str, *children: _Node, **attributes: str) -> _Node:
    node = ElementTree.Element(tag, attributes)
    node.extend(children)
    return node


def _text(tag: str, text: str, **attributes: str) -> _Node:
    node = _node(tag, **attributes)
    node.text = text
    return node


def _counted(tag: str, children: Sequence[_Node]) -> _Node:
    return _node(tag, *children, n=str(len(children)))


def _references(tag: str, ids: Sequence[str]) -> _Node:
    return _counted(tag, [_text("Id", one) for one in ids])


def _row(values: Iterable[float]) -> str:
    return " ".join(map(_mm, values))


def _mm(value: float) -> str:
    return f"{round(value, 9) + 0.0:.9f}"
