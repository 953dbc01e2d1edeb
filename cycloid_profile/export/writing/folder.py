"""Output folders: files that appear all together or not at all, and their manifest."""

from __future__ import annotations

import hashlib
import json
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from cycloid_profile.errors import ExportError
from cycloid_profile.export.writing.exporter import WrittenFile
from cycloid_profile.spec import format_spec
from cycloid_profile.spec.model import Spec
from cycloid_profile.units import DEGREE, UM

MANIFEST = "manifest.json"


@contextmanager
def atomic_folder(folder: Path) -> Iterator[Path]:
    """A scratch folder whose files move into ``folder`` at the end, or vanish if anything fails.

    All targets are checked before the first file moves, so that one occupied name prevents every move.

    Raises ``ExportError`` if ``folder`` cannot be created or written to, or a folder has the name of a target.
    """
    # Missing folders, innermost first: a failed attempt removes them again.
    created = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        scratch = Path(tempfile.mkdtemp(prefix=".partial-", dir=folder))
    except OSError as error:
        raise _refusal("output folder", str(folder), error.strerror) from None
    try:
        yield scratch
        moves = [(file, folder / file.relative_to(scratch)) for file in sorted(scratch.rglob("*")) if file.is_file()]
        for _, target in moves:
            if target.is_dir():
                raise _refusal("output file", str(target), "a folder has that name")
            target.parent.mkdir(parents=True, exist_ok=True)
        for file, target in moves:
            file.replace(target)
        created = []
    except OSError as error:
        named = error.filename2 or error.filename or folder
        raise _refusal("output file", str(named), error.strerror or str(error)) from None
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
        for path in created:
            if path.is_dir() and not any(path.iterdir()):
                path.rmdir()


def _refusal(what: str, path: str, reason: str | None) -> ExportError:
    return ExportError(what, f"'{path}'", f"cannot be written ({reason})", "choose another with --out", " ")


def manifest_entry(written: WrittenFile, spec: Spec, folder: Path) -> dict[str, Any]:
    """Entry of one file of ``folder``: format, hashes of file and spec, tolerance and measured deviation."""
    entry: dict[str, Any] = {
        "path": written.name,
        "format": written.format,
        "bytes": (folder / written.name).stat().st_size,
        "sha256": _sha256(folder / written.name),
        "spec_sha256": hashlib.sha256(format_spec(spec).encode("utf-8")).hexdigest(),
        "tolerance_um": _micrometres(written.tolerance),
        "deviation_um": None,
    }
    if written.deviation is not None:
        entry |= {
            "deviation_um": _micrometres(written.deviation.largest),
            "deviation_rms_um": _micrometres(written.deviation.rms),
            "deviation_worst_at_deg": round(written.deviation.worst_angle / DEGREE, 2),
            "deviation_from_curve_um": _micrometres(written.deviation.from_curve),
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


def unchanged_entries(folder: Path) -> list[dict[str, Any]]:
    """Entries of an older manifest in ``folder`` whose files are unchanged; empty without a manifest."""
    try:
        entries = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))["files"]
        return [entry for entry in entries if _sha256(folder / entry["path"]) == entry["sha256"]]
    except (OSError, ValueError, KeyError, TypeError):
        return []


def _sha256(path: Path) -> str | None:
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else None


def _micrometres(length: float | None) -> float | None:
    """A length in µm to three significant digits, the accuracy of a measured deviation; None stays None."""
    return None if length is None else float(f"{length / UM:.3g}")
