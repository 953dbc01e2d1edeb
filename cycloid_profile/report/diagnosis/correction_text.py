"""Page of a correction: verdict, what the numbers mean, tables, picture and files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cycloid_profile.report.diagnosis.tables import correction_sentences, correction_tables
from cycloid_profile.report.page import Verdict, pdf_name, picture, render

CORRECTION_PAGE = "correction.html"
_CAPTION = (
    "Deviation of the scans from the nominal tooth, the program that cancels it, and what is expected afterwards."
)


def correction_report(values: Mapping[str, Any], folder: Path, pdf: bool = False) -> str:
    """HTML text of the report from the JSON object of a correction, with the picture and links of the files in
    ``folder``; ``pdf``: one is written next to it.
    """
    scans = ", ".join(one["file"] for one in values["scans"])
    return render(
        "correction.html.j2",
        folder,
        values["name"],
        title="correction",
        verdict=correction_verdict(values),
        subject=f"Correction of disc {values['disc']} from {scans}.",
        meaning=correction_meaning(values),
        also=[pdf_name(CORRECTION_PAGE)] if pdf else [],
        notes={
            "predicted_scan.csv": "the scan to expect after the correction",
            "correction.json": "all values",
            pdf_name(CORRECTION_PAGE): "this report",
            **{
                one["path"]: f"within {one['deviation_um']:.3g} µm of the corrected tooth, read back with "
                f"{one['read_back_with']}"
                for one in values["files"]
                if one.get("deviation_um") is not None
            },
        },
        pictures=[picture(folder, "correction", _CAPTION)],
        tables=list(correction_tables(values)),
    )


def correction_verdict(values: Mapping[str, Any]) -> Verdict:
    """What the corrected program removes, and whether errors remain that it cannot."""
    names = [one["name"].replace("_", " ") for key in ("effects", "known_effects") for one in values[key]]
    names += [one["name"] for one in values.get("empirical", ())]
    names += ["a smooth remainder"] if values["remainder"] is not None else []
    left = len(values["not_ground_away"])
    rest = f", but not {left} other error{'' if left == 1 else 's'}" if left else ""
    removed = " and ".join(dict.fromkeys(names)) or "the deviation of the tooth"
    return Verdict(f"The corrected program of disc {values['disc']} removes {removed}{rest}.", "good")


def correction_meaning(values: Mapping[str, Any]) -> list[str]:
    """Scan to expect, change of the path against its limit, clamping, notes, and formats that were not written."""
    sentences = [
        f"{one['file']}: {one['rms_before_um']:.3g} µm rms from the nominal tooth now, with noise of "
        f"{one['noise_um']:.3g} µm; a scan of the corrected disc is expected at {values['rms_expected_um']:.3g} µm."
        for one in values["scans"]
    ]
    share = 100.0 * values["largest_um"] / values["limit_um"]
    sentences.append(
        f"The path changes by at most {values['largest_um']:.3g} µm, {share:.0f} % of the limit of "
        f"{values['limit_um']:g} µm."
    )
    _, *further = correction_sentences(values)
    notes = [each.removeprefix("note: ") for each in further]
    notes += [f"{name} is not written: {reason}" for name, reason in values["skipped"].items()]
    return [*sentences, *(f"{one[0].upper()}{one[1:]}." for one in notes)]
