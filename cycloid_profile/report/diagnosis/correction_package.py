"""From scans of a disc to the files of its correction: the corrected disc, the expected scan, a picture, JSON."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import msgspec

from cycloid_profile import plot
from cycloid_profile.correction import Correction, correction
from cycloid_profile.correction import correction_to_json as correction_json
from cycloid_profile.design import as_built_reducer, disc_outline, effects_of, turned_openings
from cycloid_profile.diagnosis import Diagnosis, diagnose
from cycloid_profile.errors import MeasurementError
from cycloid_profile.export import NOT_OF_A_CORRECTION, CadProcess, SpecifiedProfile, write_in_two_processes
from cycloid_profile.export.writing import PROTECTED, Protection, atomic_folder, manifest_entry
from cycloid_profile.measurement import Measurement, format_measurement
from cycloid_profile.plot import save
from cycloid_profile.report.diagnosis.correction_text import CORRECTION_PAGE, correction_report
from cycloid_profile.report.page import json_text, pdf_name, write_report, write_text
from cycloid_profile.rig import LEAST_POINTS_PER_LOBE, Settings, simulate
from cycloid_profile.spec.model import Spec
from cycloid_profile.units import UM

_UNKNOWN = (
    "the difference is not in the library of effects, so no named effect can be cancelled: "
    "--remainder cancels its smooth part, fitted and not explained"
)
_AGREES = "scan and nominal tooth agree within the noise: nothing to correct, nothing written"
_NOTHING = "no smooth deviation of the scan exceeds the noise"
_ONE_GAP = "it holds the gap at lobe 1 alone, and the lobes of this correction differ"
FORMATS = ("csv", "gcode")  # written unless others are asked for
LABEL = "corrected"  # in the names of the files, and in the name of the disc


class CorrectedScans(NamedTuple):
    """JSON object of a correction, the exit ``status``, and the ``reason`` if no file was written, else None."""

    values: dict[str, Any]
    reason: str | None = None
    status: int = 0


def correct_scans(
    spec: Spec,
    scans: Sequence[Measurement],
    folder: Path,
    *,
    disc: int | None = None,
    limit_um: float = 10.0,
    wheel_radius: float | None = None,
    remainder: bool = False,
    formats: Sequence[str] = FORMATS,
    progress: Callable[[str], None] = lambda _: None,
    protection: Protection = PROTECTED,
    pdf: bool = False,
) -> CorrectedScans:
    """Diagnose scans of one disc and write the disc that cancels its errors into ``folder``, in the given ``formats``.

    ``disc`` counted from 0, by default that of the scans; ``limit_um``, largest deviation from the nominal tooth [µm];
    ``wheel_radius`` [mm], that of the generating pin unless given; ``remainder``: cancel a smooth remainder, too;
    ``protection`` names what is not replaced; ``pdf``: write the report as PDF, too.
    Raises ``MeasurementError`` for other measurements, several discs, and sizes that are not above zero.
    """
    _check(scans, limit_um, wheel_radius)
    progress("building the reducer")
    reducer = as_built_reducer(spec)
    diagnosis = diagnose(reducer, scans, None if disc is None else [disc] * len(scans), (), progress)
    which = _one_disc(diagnosis)

    def nothing(reason: str, status: int) -> CorrectedScans:
        values = {"schema": 1, "name": spec.name, "verdict": diagnosis.verdict, "effects": []}
        return CorrectedScans({**values, "files": [], "skipped": {}, "reason": reason}, reason, status)

    if diagnosis.verdict == "unknown_effect" and not remainder:
        return nothing(_UNKNOWN, 1)
    if diagnosis.verdict == "agrees" and reducer.teeth[which] is reducer.case.profile:
        return nothing(_AGREES, 0)
    progress("computing the correction")
    found = correction(
        diagnosis,
        which,
        limit_um * UM,
        wheel_radius=wheel_radius,
        with_remainder=remainder and diagnosis.verdict != "agrees",
        known=effects_of(spec),
    )
    if found.is_unchanged:
        return nothing("; ".join(found.not_ground_away) or _NOTHING, 1)
    # A scan of fewer points is diagnosed, but none is simulated.
    least = LEAST_POINTS_PER_LOBE * reducer.case.drive.trochoid.lobes
    points = max(least, *(scan["x_mm"].size for scan in scans))
    values = correction_json(found, diagnosis, spec.name, limit_um, remainder)
    return CorrectedScans(
        write_correction(
            found,
            values,
            spec,
            points,
            folder,
            progress,
            protection,
            formats=formats,
            wheel_radius=wheel_radius,
            pdf=pdf,
        )
    )


def write_correction(
    found: Correction,
    values: Mapping[str, Any],
    spec: Spec,
    points: int,
    folder: Path,
    progress: Callable[[str], None] = lambda _: None,
    protection: Protection = PROTECTED,
    *,
    formats: Sequence[str] = FORMATS,
    wheel_radius: float | None = None,
    pdf: bool = False,
) -> dict[str, Any]:
    """Write all files into ``folder``, or none; returns the content of ``correction.json``.

    ``values``: JSON object of the correction, to which the files are added; ``points`` of the expected scan;
    ``formats`` and ``wheel_radius`` of the programs [mm], that of the spec unless given. Formats of the finished disc
    or stage are not written: ``skipped`` of the result names the reason. ``pdf``: write the report as PDF, too.
    """
    disc, files_of_csv = corrected_disc(found, spec, wheel_radius)
    skipped = dict(files_of_csv) if "csv" in formats else {}
    skipped |= {name: NOT_OF_A_CORRECTION[name] for name in formats if name in NOT_OF_A_CORRECTION}
    wanted = [name for name in formats if name not in skipped]
    with atomic_folder(folder, protection) as scratch, CadProcess(wanted) as process:
        written, missing = write_in_two_processes([disc], wanted, scratch, process, progress)
        files = [manifest_entry(file, spec, scratch) for file in written]
        progress("simulating the expected scan")
        scan = simulate(found.predicted, "profile_scan", Settings(points=points, disc=found.disc))
        note = {"expected": "after the correction, the machine's errors still there"}
        write_text(scratch / "predicted_scan.csv", format_measurement(replace(scan, keys=dict(scan.keys) | note)))
        drawn = [file.name for file in save(plot.correction(found, name=spec.name), scratch, "correction")]
        pages = [CORRECTION_PAGE, *([pdf_name(CORRECTION_PAGE)] if pdf else [])]
        others = [{"path": name} for name in ("predicted_scan.csv", *drawn, "correction.json", *pages)]
        whole = {**values, "files": [*files, *others], "skipped": {**skipped, **missing}}
        write_text(scratch / "correction.json", json_text(whole))
        write_report(scratch, CORRECTION_PAGE, correction_report(whole, scratch, pdf), pdf)
    return whole


def corrected_disc(
    found: Correction, spec: Spec, wheel_radius: float | None = None
) -> tuple[SpecifiedProfile, dict[str, str]]:
    """The disc of a correction with its openings, for the exporters of a design, and the files that it cannot have with
    the reason.

    ``wheel_radius`` of the programs [mm], that of the spec unless given. Where the lobes differ, no file of the gap at
    lobe 1 is written.
    """
    drive, export, skipped = found.predicted.case.drive, spec.export, {}
    if wheel_radius is not None:
        export = msgspec.structs.replace(export, wheel_radius_mm=wheel_radius)
    if not found.program.identical_lobes:
        if export.form_wheel is not None:
            skipped["form_wheel.csv"] = _ONE_GAP
        if export.points is not None and export.points.range == "gap":
            skipped[export.points.file] = _ONE_GAP
            export = msgspec.structs.replace(export, points=None)
        export = msgspec.structs.replace(export, form_wheel=None)
    labelled = msgspec.structs.replace(spec, name=f"{LABEL} {spec.name}", export=export)
    nominal = disc_outline(spec, drive, found.drawing)
    turn, contours = turned_openings(drive, nominal, found.disc + 1)
    disc = SpecifiedProfile(labelled, drive, found.program, contours, found.disc + 1, turn, LABEL)
    return disc, skipped


def _check(scans: Sequence[Measurement], limit_um: float, wheel_radius: float | None) -> None:
    for scan in scans:
        if scan.kind.is_curve:
            raise MeasurementError(
                f"{scan.name}: kind",
                f"'{scan.kind}'",
                "is no scan of a disc",
                "give profile scans; diagnose takes the other kinds",
            )
    for option, value, unit in (("--limit-um", limit_um, "µm"), ("--wheel-radius-mm", wheel_radius, "mm")):
        if value is not None and not 0.0 < value < math.inf:
            raise MeasurementError(
                option, f"{value:g} {unit}", "is not above zero", f"give a size above zero in {unit}"
            )


def _one_disc(diagnosis: Diagnosis) -> int:
    discs = sorted({gap.recording.disc for gap in diagnosis.gaps})
    if len(discs) > 1:
        raise MeasurementError(
            "discs scanned",
            " and ".join(str(d + 1) for d in discs),
            "are more than one",
            "correct one disc at a time, or choose the disc with --disc",
        )
    return discs[0]
