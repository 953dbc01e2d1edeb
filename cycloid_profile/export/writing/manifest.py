"""The manifest of a package, and the record of all files this program has made for the user."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path, PurePath, PurePosixPath
from typing import Any

from cycloid_profile.export.writing.exporter import WrittenFile
from cycloid_profile.filesystem import new_file
from cycloid_profile.spec import format_spec
from cycloid_profile.spec.model import Spec
from cycloid_profile.units import DEGREE, UM

MANIFEST = "manifest.json"
_ENTRY = {"path": str, "format": str, "bytes": int, "sha256": str, "spec_sha256": str}
_HASH_LENGTH = 64  # hexadecimal digits of SHA-256
_LONGEST_RECORD = 4_000_000  # bytes, some 60 000 files; the older half is then forgotten
_LARGEST_MANIFEST = 50_000_000  # bytes


def manifest_entry(written: WrittenFile, spec: Spec, folder: Path) -> dict[str, Any]:
    """Entry of one file of ``folder``: format, hashes of file and spec, tolerance and measured deviation."""
    entry: dict[str, Any] = {
        "path": written.name,
        "format": written.format,
        "bytes": (folder / written.name).stat().st_size,
        "sha256": file_hash(folder / written.name),
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
    if written.measures:
        entry["measures"] = written.measures
    if written.notes:
        entry["notes"] = list(written.notes)
    return entry


def notes_of(entries: Iterable[Mapping[str, Any]]) -> list[str]:
    """Sentences for the user in the entries of files, each once."""
    return list(dict.fromkeys(note for entry in entries for note in entry.get("notes", ())))


def write_manifest(
    name: str, entries: list[dict[str, Any]], skipped: dict[str, str], folder: Path, discs: str = ""
) -> None:
    """Write ``manifest.json`` into ``folder``; ``discs`` says which discs differ."""
    manifest = {
        "schema": 1,
        "name": name,
        **({"discs": discs} if discs else {}),
        "files": entries,
        "skipped": [{"format": format_name, "reason": reason} for format_name, reason in skipped.items()],
    }
    text = json.dumps(manifest, indent=1, ensure_ascii=False) + "\n"
    (folder / MANIFEST).write_text(text, encoding="utf-8", newline="\n")


def read_manifest(folder: Path) -> dict[str, Any] | None:
    """The manifest in ``folder``, None where there is none or another program wrote it.

    Ours has the keys of ``write_manifest``, and names files inside the folder only.
    """
    path = folder / MANIFEST
    try:
        if not path.is_file() or path.stat().st_size > _LARGEST_MANIFEST:
            return None
        read = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    if not isinstance(read, dict) or not set(read) >= {"schema", "name", "files", "skipped"} or read["schema"] != 1:
        return None
    ours = isinstance(read["files"], list) and all(_is_entry(entry, folder) for entry in read["files"])
    return read if ours else None


def unchanged_entries(folder: Path) -> list[dict[str, Any]]:
    """Entries of an older manifest in ``folder`` whose files are unchanged; empty without a manifest of ours."""
    read = read_manifest(folder)
    entries: list[dict[str, Any]] = [] if read is None else read["files"]
    return [entry for entry in entries if file_hash(folder / entry["path"]) == entry["sha256"]]


def is_inside(name: str, folder: Path) -> bool:
    """Whether the relative path ``name`` stays in ``folder``, symbolic links included."""
    try:
        outside = PurePath(name).is_absolute() or ".." in PurePosixPath(name).parts or not PurePosixPath(name).parts
        return not outside and (folder / name).resolve().is_relative_to(folder.resolve())
    except (OSError, ValueError, RuntimeError):
        return False


def file_hash(path: Path) -> str | None:
    """SHA-256 of a plain file, None for anything else."""
    if path.is_symlink() or not path.is_file():
        return None
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def was_made_here(digest: str | None) -> bool:
    """Whether this program wrote a file with this SHA-256 for this user."""
    return digest is not None and digest in _recorded()


def remember(digests: Iterable[str]) -> None:
    """Add to the record of files made; without a place for it, a later overwrite only needs ``--force``."""
    fresh = sorted(set(digests) - _recorded())
    if not fresh:
        return
    with suppress(OSError):
        path = _record_file()
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.is_file() and path.stat().st_size > _LONGEST_RECORD:
            lines = path.read_text(encoding="ascii", errors="replace").splitlines()
            with new_file(path) as shorter:
                shorter.write_text("\n".join(lines[len(lines) // 2 :]) + "\n", encoding="ascii", newline="\n")
        with path.open("a", encoding="ascii", newline="\n") as file:
            file.write("".join(f"{digest}\n" for digest in fresh))


def _recorded() -> set[str]:
    try:
        return set(_record_file().read_text(encoding="ascii", errors="replace").split())
    except OSError:
        return set()


def _record_file() -> Path:
    from platformdirs import user_state_path

    return user_state_path("cycloid-profile", appauthor=False) / "files-made.txt"


def _is_entry(entry: object, folder: Path) -> bool:
    if not isinstance(entry, dict) or any(not isinstance(entry.get(key), kind) for key, kind in _ENTRY.items()):
        return False
    return len(entry["sha256"]) == _HASH_LENGTH and is_inside(entry["path"], folder)


def _micrometres(length: float | None) -> float | None:
    """A length in µm to three significant digits, the accuracy of a measured deviation; None stays None."""
    return None if length is None else float(f"{length / UM:.3g}")
