"""The manifest: every file with its hash, what it promises, and how far it was found to be off."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

from cycloid_profile.export.written import WrittenFile
from cycloid_profile.spec.model import Spec
from cycloid_profile.spec.write import format_spec
from cycloid_profile.units import DEGREE, UM

MANIFEST = "manifest.json"


def manifest_entry(written: WrittenFile, spec: Spec, folder: Path) -> dict[str, Any]:
    """One file of ``folder``: what it is, which spec it was made from, and its measured deviation."""
    entry: dict[str, Any] = {
        "path": written.name,
        "format": written.format,
        "bytes": (folder / written.name).stat().st_size,
        "sha256": _sha256(folder / written.name),
        "spec_sha256": hashlib.sha256(format_spec(spec).encode("utf-8")).hexdigest(),
        "tolerance_um": _shown(written.tolerance),
        "deviation_um": None,
    }
    if written.deviation is not None:
        entry |= {
            "deviation_um": _shown(written.deviation.largest),
            "deviation_rms_um": _shown(written.deviation.rms),
            "deviation_worst_at_deg": round(written.deviation.worst_angle / DEGREE, 2),
            "deviation_from_curve_um": _shown(written.deviation.from_curve),
            "points_measured": written.deviation.points,
            "read_back_with": written.reader,
            "entities": written.entities,
        }
    return entry


def write_manifest(name: str, entries: list[dict[str, Any]], skipped: dict[str, str], folder: Path) -> None:
    """Write ``manifest.json`` into ``folder``."""
    manifest = {
        "schema": 1,
        "name": name,
        "files": entries,
        "skipped": [{"format": format_name, "reason": reason} for format_name, reason in skipped.items()],
    }
    text = json.dumps(manifest, indent=1, ensure_ascii=False) + "\n"
    (folder / MANIFEST).write_text(text, encoding="utf-8", newline="\n")


def untouched_entries(folder: Path) -> list[dict[str, Any]]:
    """Entries of an older manifest in ``folder`` whose files are still as they were written; none without one."""
    try:
        entries = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))["files"]
        return [entry for entry in entries if _sha256(folder / entry["path"]) == entry["sha256"]]
    except (OSError, ValueError, KeyError, TypeError):
        return []


def _sha256(path: Path) -> str | None:
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else None


def _shown(length: float | None) -> float | None:
    """A length in µm to three significant digits, for a measured deviation is known no better; None stays None."""
    return None if length is None else float(f"{length / UM:.3g}")
