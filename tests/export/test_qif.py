"""QIF documents: a grammar typed from the standard, references and counts, values of plan and evaluation.

With the schema of QIF 3.0 on the machine, its QIFDocument.xsd named by QIF_SCHEMA, the documents are validated, too.
"""

from __future__ import annotations

import os
import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from independent_scans import drawn_points

from cycloid_profile.design import DesignRecord, design_disc
from cycloid_profile.export.inspection import Inspection, inspect_scan, inspection_plan, qif_document
from cycloid_profile.export.inspection.qif import QifExporter
from cycloid_profile.geometry import DiscOutline
from cycloid_profile.measurement import PROFILE_SCAN, Measurement
from cycloid_profile.spec import parse_spec
from tests.export.test_inspection_files import nominal
from tests.spec_texts import RV40E, UNCOMPENSATED

TAG = "{http://qifstandards.org/xsd/qif3}"
FEATURE = r"(CircleFeature|PlaneFeature|PointFeature|PointDefinedCurveFeature)"
KIND = r"(LineProfile|UserDefinedUnit|CircularRunout)Characteristic"
# Children of every element in their order, ISO 23952:2020; elements with children are named here.
GRAMMAR = {
    "QIFDocument": "QPId Version Header StandardsDefinitions FileUnits DatumDefinitions DatumReferenceFrames Features "
    "Characteristics( Results)?",
    "Version": "",
    "Header": "Description",
    "StandardsDefinitions": "Standard",
    "Standard": "Organization Designator",
    "Organization": "StandardsOrganizationEnum",
    "FileUnits": "PrimaryUnits UserDefinedUnits",
    "PrimaryUnits": "AngularUnit LinearUnit",
    "(Angular|Linear)Unit": "SIUnitName UnitName UnitConversion",
    "UnitConversion": "Factor",
    "UserDefinedUnits": "UserDefinedUnit",
    "UserDefinedUnit": "WhatIsMeasured UnitName",
    "DatumDefinitions": "(DatumDefinition ?)+",
    "DatumDefinition": "DatumLabel FeatureNominalIds",
    "DatumReferenceFrames": "(DatumReferenceFrame ?)+",
    "DatumReferenceFrame": "Datums",
    "Datums": "(Datum ?)+",
    "Datum": "SimpleDatum Precedence",
    "SimpleDatum": "DatumDefinitionId MaterialModifier ReferencedComponent",
    "Precedence": "PrecedenceEnum",
    "Features": "FeatureDefinitions FeatureNominals FeatureItems",
    "Feature(Definition|Nominal|Item)s": rf"({FEATURE}(Definition|Nominal|Item) ?)+",
    "CircleFeatureDefinition": "InternalExternal Diameter",
    "(Plane|Point|PointDefinedCurve)FeatureDefinition": "",
    "PointFeatureNominal": "Name FeatureDefinitionId Location",
    "PlaneFeatureNominal": "Name FeatureDefinitionId Location Normal",
    "CircleFeatureNominal": "Name FeatureDefinitionId Location Normal",
    "PointDefinedCurveFeatureNominal": "Name FeatureDefinitionId DefiningPoints",
    "DefiningPoints": "(DefiningPoint ?)+",
    "DefiningPoint": "Point Normal SequenceNumber",
    f"{FEATURE}Item": "FeatureNominalId FeatureName DeterminationMode",
    "DeterminationMode": "Checked",
    "Checked": "",
    "Characteristics": "FormalStandardId CharacteristicDefinitions CharacteristicNominals CharacteristicItems",
    "Characteristic(Definition|Nominal|Item|Measurement)s": rf"({KIND}(Definition|Nominal|Item|Measurement) ?)+",
    "UserDefinedUnitCharacteristicDefinition": "Name",
    "(LineProfile|CircularRunout)CharacteristicDefinition": "Name ToleranceValue DatumReferenceFrameId",
    "LineProfileCharacteristicNominal": "CharacteristicDefinitionId Name Vector",
    "CircularRunoutCharacteristicNominal": "CharacteristicDefinitionId Name",
    "UserDefinedUnitCharacteristicNominal": "CharacteristicDefinitionId Name TargetValue MaxValue MinValue "
    "DefinedAsLimit",
    f"{KIND}Item": "Description Name FeatureItemIds CharacteristicNominalId",
    "Feature(Nominal|Item)Ids": "(Id ?)+",
    "Results": "MeasurementResultsSet",
    "MeasurementResultsSet": "MeasurementResults",
    "MeasurementResults": "MeasuredFeatures MeasuredPointSets MeasuredCharacteristics InspectionStatus",
    "MeasuredFeatures": "(PointDefinedCurveFeatureMeasurement ?)+",
    "PointDefinedCurveFeatureMeasurement": "FeatureItemId PointList",
    "PointList": "WholePointSetId",
    "MeasuredPointSets": "(MeasuredPointSet ?)+",
    "MeasuredPointSet": "Points Compensated",
    "MeasuredCharacteristics": "CharacteristicMeasurements",
    f"{KIND}Measurement": "Status CharacteristicItemId( Value)?( WorstPositiveDeviation WorstNegativeDeviation)?",
    "Status": "CharacteristicStatusEnum",
    "InspectionStatus": "InspectionStatusEnum",
}


@pytest.fixture(scope="module")
def record() -> DesignRecord:
    return design_disc(parse_spec(RV40E + UNCOMPENSATED))


@pytest.fixture(scope="module", params=["bore", "free"])
def result(record: DesignRecord, request: pytest.FixtureRequest) -> Inspection:
    points = drawn_points(1, 0.3e-3, pitch=1e-3, runout=2e-3)
    columns = {"x_mm": points.real, "y_mm": points.imag}
    return inspect_scan(record, Measurement(PROFILE_SCAN, columns, {"datum": request.param}, "scan.csv"))


def named(root: ElementTree.Element, tag: str) -> list[ElementTree.Element]:
    return list(root.iter(TAG + tag))


def assert_is_qif(document: bytes) -> None:
    """Elements in their order, counts as stated, identifiers unique, and every reference to one of them."""
    root = ElementTree.fromstring(document)
    ids = [element.attrib["id"] for element in root.iter() if "id" in element.attrib]
    assert len(ids) == len(set(ids))
    assert int(root.attrib["idMax"]) == max(map(int, ids))
    for element in root.iter():
        tag, children = element.tag.removeprefix(TAG), " ".join(child.tag.removeprefix(TAG) for child in element)
        (order,) = [order for pattern, order in GRAMMAR.items() if re.fullmatch(pattern, tag)] or [""]
        assert re.fullmatch(order, children), f"{tag}: {children}"
        assert int(element.attrib.get("n", len(element))) == len(element)
        if tag.endswith("Id") and tag != "QPId":
            assert element.text in ids, tag


def test_the_plan_holds_the_nominal_points_and_its_tolerances(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    (written,) = QifExporter().write(rv40e_record, tmp_path)
    assert written.deviation is not None
    assert written.deviation.largest <= 1e-9
    document = (tmp_path / "inspection.qif").read_bytes()
    assert_is_qif(document)
    root = ElementTree.fromstring(document)
    rows = [
        (point.findtext(f"{TAG}Point", "") + " " + point.findtext(f"{TAG}Normal", "")).split()
        for point in named(root, "DefiningPoint")
    ]
    found, expected = np.array(rows, float), nominal(rv40e_record, tmp_path)
    # By flanks, not in the order of the points along the disc.
    assert len(found) == len(expected)
    order, by_place = (np.lexsort(np.round(table[:, :2], 6).T) for table in (found, expected))
    assert np.max(np.abs(found[order] - expected[by_place])) <= 1e-9
    plan = inspection_plan(rv40e_record)
    zones = [float(one.text or "") for one in named(root, "ToleranceValue")]
    assert zones == pytest.approx([2.0 * plan.checks[0].tolerance, plan.checks[3].tolerance], abs=1e-9)
    limits = [[float(one.text or "") for one in named(root, tag)] for tag in ("MinValue", "MaxValue")]
    single, cumulative = plan.checks[1].tolerance, plan.checks[2].tolerance
    assert np.array(limits) == pytest.approx(np.array([[-single, 0.0], [single, cumulative]]), abs=1e-9)
    assert len(named(root, "LineProfileCharacteristicItem")) == 78
    assert len(named(root, "UserDefinedUnitCharacteristicItem")) == 78 + 2


def test_results_hold_points_and_values_of_the_evaluation(record: DesignRecord, result: Inspection) -> None:
    document = qif_document(record, result)
    assert_is_qif(document)
    assert document == qif_document(record, result)
    root = ElementTree.fromstring(document)
    points = np.concatenate([np.array((one.text or "").split(), float).reshape(-1, 3) for one in named(root, "Points")])
    placed = result.registered.placed
    assert len(points) == placed.size == sum(int(one.attrib["count"]) for one in named(root, "MeasuredPointSet"))
    assert np.sort(points[:, 0]) == pytest.approx(np.sort(placed.real), abs=1e-9)

    def values(kind: str) -> list[float]:
        measured = named(root, f"{kind}CharacteristicMeasurement")
        return [float(one.text or "") for each in measured for one in each.iter(f"{TAG}Value")]

    profile, single, cumulative, runout = (check.value for check in result.checks)
    assert profile is not None
    assert max(values("LineProfile")) == pytest.approx(2.0 * profile, abs=1e-9)
    pitch = values("UserDefinedUnit")
    assert max(map(abs, pitch[:78])) == pytest.approx(single, abs=1e-9)
    assert max(pitch[78:]) == pytest.approx(cumulative, abs=1e-9)
    states = [one.text for one in named(root, "CharacteristicStatusEnum")]
    assert values("CircularRunout") == ([] if runout is None else [pytest.approx(runout, abs=1e-9)])
    assert states[-1] == ("NOT_ANALYZED" if runout is None else "PASS" if result.checks[3].passed else "FAIL")
    assert ("FAIL" in states) is not result.passed
    assert named(root, "InspectionStatusEnum")[0].text == ("PASS" if result.passed else "FAIL")


def test_a_disc_without_a_bore_has_its_roots_as_datum(rv40e_record: DesignRecord) -> None:
    document = qif_document(replace(rv40e_record, outline=DiscOutline(rv40e_record.profile, ())))
    assert_is_qif(document)
    root = ElementTree.fromstring(document)
    (circle,), (face,) = named(root, "CircleFeatureNominal"), named(root, "PlaneFeatureNominal")
    assert [ids[0].text for ids in named(root, "FeatureNominalIds")] == [face.attrib["id"], circle.attrib["id"]]


def test_the_datums_are_those_of_the_plan(rv40e_record: DesignRecord) -> None:
    """Face, bore and crank hole 1 as A, B and C; the teeth are related to A and B."""
    root = ElementTree.fromstring(qif_document(rv40e_record))
    places = {
        nominal.attrib["id"]: (nominal.findtext(f"{TAG}Name"), nominal.findtext(f"{TAG}Location"))
        for kind in ("Circle", "Plane")
        for nominal in named(root, f"{kind}FeatureNominal")
    }
    datums = {
        one.attrib["id"]: (one.findtext(f"{TAG}DatumLabel"), *places[one.findtext(f".//{TAG}Id", "")])
        for one in named(root, "DatumDefinition")
    }
    expected = [
        ("A", "upper face", "0 0 11.500000000"),
        ("B", "bore", "0.000000000 0.000000000 5.750000000"),
        ("C", "crank hole 1", "36.000000000 0.000000000 5.750000000"),
    ]
    assert list(datums.values()) == expected
    frames = {
        frame.attrib["id"]: "".join(datums[one.text or ""][0] or "" for one in frame.iter(f"{TAG}DatumDefinitionId"))
        for frame in named(root, "DatumReferenceFrame")
    }
    assert list(frames.values()) == ["AB", "ABC"]
    assert [frames[one.text or ""] for one in named(root, "DatumReferenceFrameId")] == ["AB", "AB"]


def test_the_schema_of_the_standard_accepts_plan_and_results(record: DesignRecord, result: Inspection) -> None:
    schema = os.environ.get("QIF_SCHEMA")
    if not schema:
        pytest.skip("QIF_SCHEMA does not name the QIFDocument.xsd of QIF 3.0")
    etree = pytest.importorskip("lxml.etree")
    checker = etree.XMLSchema(etree.parse(schema))
    for document in (qif_document(record), qif_document(record, result)):
        checker.assertValid(etree.fromstring(document))
