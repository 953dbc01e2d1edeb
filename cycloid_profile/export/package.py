"""Write a set of files whole or not at all, with a manifest that states each one's measured error."""

from __future__ import annotations

import hashlib
import json
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from cycloid_profile.design.record import DesignRecord
from cycloid_profile.errors import ExportError
from cycloid_profile.export.dxf import DxfExporter
from cycloid_profile.export.gcode import GcodeExporter
from cycloid_profile.export.points import CmmExporter, ProfileCsvExporter
from cycloid_profile.export.step import StepExporter
from cycloid_profile.export.written import Exporter, WrittenFile
from cycloid_profile.units import DEGREE, UM

MANIFEST = "manifest.json"
EXPORTERS: tuple[Exporter, ...] = (
    ProfileCsvExporter(),
    DxfExporter(),
    StepExporter(),
    GcodeExporter(),
    CmmExporter(),
)


def exporter_for(name: str) -> Exporter:
    """The exporter of a format. Raises ``ExportError`` for an unknown one."""
    for exporter in EXPORTERS:
        if exporter.format == name:
            return exporter
    known = ", ".join(exporter.format for exporter in EXPORTERS)
    raise ExportError("format", f"'{name}'", "is not known", f"choose from {known}", " ")


@contextmanager
def whole_or_nothing(folder: Path) -> Iterator[Path]:
    """A scratch folder whose files move into ``folder`` at the end, or vanish if anything fails.

    Raises
    ------
    ExportError
        If ``folder`` cannot be made or written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        scratch = Path(tempfile.mkdtemp(prefix=f".{folder.name}.partial-", dir=folder))
    except OSError as error:
        raise ExportError(
            "output folder", f"'{folder}'", f"cannot be written ({error.strerror})", "choose another with --out", " "
        ) from None
    try:
        yield scratch
        for file in sorted(path for path in scratch.rglob("*") if path.is_file()):
            target = folder / file.relative_to(scratch)
            target.parent.mkdir(parents=True, exist_ok=True)
            file.replace(target)
    except OSError as error:
        raise ExportError(
            "output file",
            f"'{error.filename}'",
            f"cannot be written ({error.strerror})",
            "free it or choose --out",
            " ",
        ) from None
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def manifest_entry(written: WrittenFile, folder: Path) -> dict[str, Any]:
    """One line of the manifest: what the file is, its hash, and how far it is from the exact curve."""
    data = (folder / written.name).read_bytes()
    entry: dict[str, Any] = {
        "path": written.name,
        "format": written.format,
        "bytes": len(data),
        "sha256": hashlib.sha256(data).hexdigest(),
        "tolerance_um": None if written.tolerance is None else _short(written.tolerance / UM),
        "deviation_um": None,
    }
    if written.deviation is not None:
        entry |= {
            "deviation_um": _short(written.deviation.largest / UM),
            "deviation_rms_um": _short(written.deviation.rms / UM),
            "deviation_worst_at_deg": round(written.deviation.worst_angle / DEGREE, 2),
            "points_measured": written.deviation.points,
            "read_back_with": written.reader,
            "entities": written.entities,
        }
    return entry


def write_manifest(record: DesignRecord, written: list[WrittenFile], skipped: dict[str, str], folder: Path) -> None:
    """Write ``manifest.json`` into ``folder``, which must hold the files already."""
    manifest = {
        "schema": 1,
        "name": record.spec.name,
        "files": [manifest_entry(file, folder) for file in written],
        "skipped": [{"format": name, "reason": reason} for name, reason in skipped.items()],
    }
    text = json.dumps(manifest, indent=1, ensure_ascii=False) + "\n"
    (folder / MANIFEST).write_text(text, encoding="utf-8", newline="\n")


def _short(value: float) -> float:
    """Three significant digits: a measured deviation is known no better."""
    return float(f"{value:.3g}")
