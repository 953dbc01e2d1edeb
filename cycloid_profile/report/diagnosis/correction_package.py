"""From scans of a disc to the files of its correction: grinding path, NC program, expected scan, picture, JSON."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from cycloid_profile import plot
from cycloid_profile.correction import Correction, correction
from cycloid_profile.correction import correction_to_json as correction_json
from cycloid_profile.design import as_built_reducer, effects_of
from cycloid_profile.diagnosis import Diagnosis, diagnose
from cycloid_profile.errors import MeasurementError
from cycloid_profile.export import check_deviation
from cycloid_profile.export.curves import SpecifiedProfile
from cycloid_profile.export.nc import GcodeExporter
from cycloid_profile.export.points import ProfileCsvExporter
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
    progress: Callable[[str], None] = lambda _: None,
    protection: Protection = PROTECTED,
    pdf: bool = False,
) -> CorrectedScans:
    """Diagnose scans of one disc and write the grinding path that cancels its errors into ``folder``.

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
        values = {"schema": 1, "name": spec.name, "verdict": diagnosis.verdict, "effects": [], "files": []}
        return CorrectedScans({**values, "reason": reason}, reason, status)

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
    return CorrectedScans(write_correction(found, values, spec, points, folder, progress, protection, pdf))


def write_correction(
    found: Correction,
    values: Mapping[str, Any],
    spec: Spec,
    points: int,
    folder: Path,
    progress: Callable[[str], None] = lambda _: None,
    protection: Protection = PROTECTED,
    pdf: bool = False,
) -> dict[str, Any]:
    """Write all files into ``folder``, or none; returns the content of ``correction.json``.

    ``values``: JSON object of the correction, to which the files are added; ``points`` of the expected scan;
    ``pdf``: write the report as PDF, too.
    """
    path = SpecifiedProfile(spec, found.predicted.case.drive, found.program)
    exporters = (ProfileCsvExporter(filename="profile_corrected.csv"), GcodeExporter(filename="grinding_corrected.nc"))
    with atomic_folder(folder, protection) as scratch:
        files = []
        for exporter in exporters:
            progress(f"writing {exporter.filename}")
            written = [check_deviation(file) for file in exporter.write(path, scratch)]
            files += [manifest_entry(file, spec, scratch) for file in written]
        progress("simulating the expected scan")
        scan = simulate(found.predicted, "profile_scan", Settings(points=points, disc=found.disc))
        note = {"expected": "after the correction, the machine's errors still there"}
        write_text(scratch / "predicted_scan.csv", format_measurement(replace(scan, keys=dict(scan.keys) | note)))
        drawn = [file.name for file in save(plot.correction(found, name=spec.name), scratch, "correction")]
        pages = [CORRECTION_PAGE, *([pdf_name(CORRECTION_PAGE)] if pdf else [])]
        others = [{"path": name} for name in ("predicted_scan.csv", *drawn, "correction.json", *pages)]
        whole = {**values, "files": [*files, *others]}
        write_text(scratch / "correction.json", json_text(whole))
        write_report(scratch, CORRECTION_PAGE, correction_report(whole, scratch, pdf), pdf)
    return whole


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
