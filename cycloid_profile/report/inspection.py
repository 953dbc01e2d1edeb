"""Report of an inspected disc: table, JSON, rows of every flank, picture and page."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from cycloid_profile import plot
from cycloid_profile.articles import PlainTable
from cycloid_profile.design import DesignRecord, effects_of
from cycloid_profile.diagnosis import screen_files
from cycloid_profile.effects import apply_effects
from cycloid_profile.errors import MeasurementError
from cycloid_profile.export.inspection import FLANKS, CheckResult, Inspection, inspect_scan, qif_document
from cycloid_profile.export.writing import PROTECTED, Protection, atomic_folder
from cycloid_profile.measurement import PROFILE_SCAN, Measurement
from cycloid_profile.report.page import Verdict, json_text, pdf_name, picture, render, write_report, write_text
from cycloid_profile.units import UM

INSPECTION_PAGE = "inspection.html"
_NAME = "inspection"
_CAPTION = (
    "Profile band, pitch and radial position over the lobes; dashed: tolerances. "
    "Flanks are named as seen from the upper face with the tooth's tip up."
)
_COVERAGE = 2.0  # standard deviations of an expanded uncertainty
_RESULT = {True: "passed", False: "failed", None: "not shown"}


def write_inspection(
    record: DesignRecord, scan: Measurement, folder: Path, protection: Protection = PROTECTED, pdf: bool = False
) -> Inspection:
    """Inspect a scan and write page, picture, JSON, QIF and a table of all flanks into ``folder``; ``pdf``: the page as
    PDF, too.

    Raises ``MeasurementError`` for a file that is no profile scan, or as ``screen_files`` and ``inspect_scan``.
    """
    if scan.kind is not PROFILE_SCAN:
        raise MeasurementError(f"{scan.name}: kind", scan.kind.name, "cannot be inspected", "give a profile scan")
    spec = record.spec
    reducer = apply_effects(replace(record.case, profile=record.profile), effects_of(spec))
    (scan,), _ = screen_files(reducer, [scan])
    result = inspect_scan(record, scan)
    with atomic_folder(folder, protection) as scratch:
        plot.save(plot.inspection_chart(result, name=spec.name), scratch, _NAME)
        write_text(scratch / f"{_NAME}.csv", flank_rows(result))
        (scratch / f"{_NAME}.qif").write_bytes(qif_document(record, result))
        write_text(scratch / f"{_NAME}.json", json_text(inspection_to_json(spec.name, result)))
        write_report(scratch, INSPECTION_PAGE, inspection_report(spec.name, result, scratch, pdf), pdf)
    return result


def inspection_report(name: str, result: Inspection, folder: Path, pdf: bool = False) -> str:
    """HTML text of the report, with the picture and links of the files in ``folder``; ``pdf``: one is written next to
    it.
    """
    return render(
        "inspection.html.j2",
        folder,
        name,
        title="inspection",
        verdict=inspection_verdict(result),
        subject=f"Inspection of {result.scan.name}, {result.registered.removal.size:,} points, datum "
        f"{'free' if result.scan.datum_free else 'bore'}.",
        meaning=inspection_meaning(result),
        also=[pdf_name(INSPECTION_PAGE)] if pdf else [],
        notes={
            f"{_NAME}.csv": "one row a flank",
            f"{_NAME}.json": "all values",
            f"{_NAME}.qif": "plan, points and results in QIF 3.0",
            pdf_name(INSPECTION_PAGE): "this report",
        },
        pictures=[picture(folder, _NAME, _CAPTION)],
        result=result,
        table=replace(inspection_table(name, result), title=""),
    )


def inspection_verdict(result: Inspection) -> Verdict:
    """Whether the disc keeps its tolerances, with the checks that fail or cannot be made."""
    failed = [f"{check.name} {check.symbol}" for check in result.checks if check.passed is False]
    hidden = [f"{check.name} {check.symbol}" for check in result.checks if check.passed is None]
    if failed:
        return Verdict(f"The disc is out of tolerance: {' and '.join(failed)} failed.", "failed")
    if hidden:
        return Verdict(f"No check failed, but this scan does not show {' and '.join(hidden)}.", "good")
    return Verdict(f"The disc is within tolerance: all {len(result.checks)} checks passed.", "good")


def inspection_meaning(result: Inspection) -> list[str]:
    """Each value as a share of its tolerance, and next to the noise of the scan."""
    sentences = []
    for check in result.checks:
        if check.value is None:
            sentences.append(f"{check.symbol} needs a scan with the bore as datum.")
            continue
        close = abs(check.value - check.tolerance) < _COVERAGE * check.uncertainty
        doubt = "; so near the limit, the noise of the scan decides: measure again" if close else ""
        noisy = "; noise alone explains it" if check.value <= check.noise_alone + _COVERAGE * check.uncertainty else ""
        share = 100.0 * check.value / check.tolerance
        sentences.append(
            f"{check.name.capitalize()} {check.symbol}: {check.value / UM:.2f} µm, {share:.0f} % of its tolerance "
            f"({check.source}){noisy}{doubt}."
        )
    return sentences


def inspection_table(name: str, result: Inspection) -> PlainTable:
    """One row a check: value, uncertainty, tolerance, result."""
    rows = tuple(
        (
            f"{check.name} {check.symbol}",
            "–" if check.value is None else f"{check.value / UM:.2f}",
            f"{check.uncertainty / UM:.2f}",
            f"{check.noise_alone / UM:.2f}",
            f"{'± ' if check.both_ways else ''}{check.tolerance / UM:.2f}",
            check.source,
            _RESULT[check.passed],
        )
        for check in result.checks
    )
    head = ("check [µm]", "value", "uncertainty", "noise alone", "tolerance", "from", "result")
    note = f"{'passed' if result.passed else 'failed'}; noise of a point {result.noise / UM:.2f} µm"
    return PlainTable(f"{name}: inspection of {result.scan.name}", head, rows, note)


def inspection_to_json(name: str, result: Inspection) -> dict[str, Any]:
    """JSON object of an inspection, lengths in µm."""
    single = result.single_pitch
    flanks = [
        {
            "lobe": lobe + 1,
            "flank": flank,
            "band_um": [_um(result.low[lobe, k]), _um(result.high[lobe, k])],
            "single_pitch_um": _um(single[lobe, k]),
            "position_um": _um(result.position[lobe, k]),
        }
        for lobe in range(single.shape[0])
        for k, flank in enumerate(FLANKS)
    ]
    return {
        "schema": 1,
        "name": name,
        "file": result.scan.name,
        "datum": "free" if result.scan.datum_free else "bore",
        "pass": result.passed,
        "noise_um": _um(result.noise),
        "pitch_radius_mm": round(result.plan.pitch_radius, 6),
        "checks": [_check_to_json(check) for check in result.checks],
        "flanks": flanks,
        "radial_um": [_um(radius) for radius in result.radial.tolist()],
    }


def flank_rows(result: Inspection) -> str:
    """CSV with one row a flank."""
    single = result.single_pitch
    rows = ["lobe,flank,lowest_um,highest_um,single_pitch_um,position_um,radial_um"]
    for lobe in range(single.shape[0]):
        for k, flank in enumerate(FLANKS):
            values = (
                result.low[lobe, k], result.high[lobe, k], single[lobe, k], result.position[lobe, k],
                result.radial[lobe],
            )  # fmt: skip
            rows.append(f"{lobe + 1},{flank}," + ",".join(f"{value / UM + 0.0:.4f}" for value in values))
    return "\n".join(rows) + "\n"


def _check_to_json(check: CheckResult) -> dict[str, Any]:
    return {
        "name": check.name,
        "symbol": check.symbol,
        "value_um": None if check.value is None else _um(check.value),
        "uncertainty_um": _um(check.uncertainty),
        "noise_alone_um": _um(check.noise_alone),
        "tolerance_um": _um(check.tolerance),
        "both_ways": check.both_ways,
        "tolerance_from": check.source,
        "pass": check.passed,
    }


def _um(value: float) -> float:
    return round(float(value) / UM, 4) + 0.0
