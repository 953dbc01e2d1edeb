"""Everything a correction yields, in one folder: path, program, the scan to expect, picture, result."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from cycloid_profile.discrepancy.correction import Correction
from cycloid_profile.effects.built import Built
from cycloid_profile.export.disc_path import DiscPath
from cycloid_profile.export.folder import whole_or_nothing
from cycloid_profile.export.formats import kept_promise
from cycloid_profile.export.gcode import GcodeExporter
from cycloid_profile.export.manifest import manifest_entry
from cycloid_profile.export.points import ProfileCsvExporter
from cycloid_profile.measurement.files import Measurement, format_measurement
from cycloid_profile.plot.correction import correction_plot
from cycloid_profile.plot.style import save_png
from cycloid_profile.rig.simulate import Settings, simulate
from cycloid_profile.spec.model import Spec


def write_correction(
    found: Correction,
    told: Mapping[str, Any],
    spec: Spec,
    points: int,
    folder: Path,
    tell: Callable[[str], None] = lambda _: None,
) -> dict[str, Any]:
    """Write all files into ``folder``, together or not at all; returns what ``correction.json`` holds.

    ``told`` of the correction, to which the files are added; ``points`` of the scan to expect.
    """
    path = DiscPath(spec, found.predicted.case.drive, found.program)
    exporters = (ProfileCsvExporter(filename="profile_corrected.csv"), GcodeExporter(filename="grinding_corrected.nc"))
    with whole_or_nothing(folder) as scratch:
        files = []
        for exporter in exporters:
            tell(f"writing {exporter.filename}")
            written = [kept_promise(file) for file in exporter.write(path, scratch)]
            files += [manifest_entry(file, spec, scratch) for file in written]
        tell("the scan to expect")
        expected = _expected_scan(found.predicted, found.disc, points)
        (scratch / "predicted_scan.csv").write_text(format_measurement(expected), encoding="utf-8", newline="\n")
        save_png(correction_plot(found, spec.name), scratch / "correction.png")
        others = [{"path": name} for name in ("predicted_scan.csv", "correction.png", "correction.json")]
        whole = {**told, "files": [*files, *others]}
        text = json.dumps(whole, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
        (scratch / "correction.json").write_text(text, encoding="utf-8", newline="\n")
    return whole


def _expected_scan(predicted: Built, disc: int, points: int) -> Measurement:
    scan = simulate(predicted, "profile_scan", Settings(points=points, disc=disc))
    return replace(scan, keys=dict(scan.keys) | {"expected": "after the correction, the machine's errors still there"})
