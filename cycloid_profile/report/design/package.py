"""Files of a design in one folder: chosen formats, pictures, report and manifest."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from cycloid_profile import plot
from cycloid_profile.design import DesignRecord, summary
from cycloid_profile.export import write_formats
from cycloid_profile.export.writing import (
    WrittenFile,
    atomic_folder,
    manifest_entry,
    unchanged_entries,
    write_manifest,
)
from cycloid_profile.plot import pictures as pictures_of
from cycloid_profile.plot import save
from cycloid_profile.report.design import tables
from cycloid_profile.report.page import PLOTS, REPORT, inline_svg, template, write_text
from cycloid_profile.units import UM


def build_package(
    record: DesignRecord, folder: str | Path, progress: Callable[[str], None] = lambda _: None
) -> dict[str, str]:
    """Write the formats of the spec, all pictures, ``report.html`` and ``manifest.json`` into ``folder``.

    All files are written, or none. Files of an earlier manifest that are not in the new one are deleted, unless they
    were changed since: stale outputs must not remain next to a new report. ``progress`` receives the name of each step.
    Returns the formats that could not be written, with the reason: STEP where the CAD kernel is missing.

    Raises
    ------
    ExportError
        If the folder cannot be written to, or a file exceeds its tolerance when read back.
    """
    folder = Path(folder)
    earlier = {entry["path"] for entry in unchanged_entries(folder)}
    with atomic_folder(folder) as scratch:
        written, skipped = write_formats(record, record.spec.export.formats, scratch, progress)
        (scratch / PLOTS).mkdir()
        pictures: list[WrittenFile] = []
        for picture in pictures_of(record):
            progress(f"drawing {picture.name}")
            for file in save(picture.draw(record), scratch / PLOTS, picture.name):
                pictures.append(WrittenFile(f"{PLOTS}/{file.name}", file.suffix[1:]))
        progress("writing the report")
        write_text(scratch / REPORT, design_report(record, written, skipped, scratch / PLOTS))
        everything = [*written, *pictures, WrittenFile(REPORT, "html")]
        entries = [manifest_entry(file, record.spec, scratch) for file in everything]
        write_manifest(record.spec.name, entries, skipped, scratch)
    for path in earlier - {entry["path"] for entry in entries}:
        (folder / path).unlink(missing_ok=True)
    return skipped


def export_package(
    record: DesignRecord, formats: Sequence[str], folder: Path, progress: Callable[[str], None] = lambda _: None
) -> tuple[list[dict[str, Any]], dict[str, str]]:
    """Write ``formats`` into ``folder`` and add them to its manifest.

    Returns the manifest entries of these formats, and the formats that could not be written with the reason.
    Raises ``ExportError`` as ``build_package`` does.
    """
    with atomic_folder(folder) as scratch:
        written, skipped = write_formats(record, formats, scratch, progress)
        entries = [manifest_entry(file, record.spec, scratch) for file in written]
        paths = {entry["path"] for entry in entries}
        others = [entry for entry in unchanged_entries(folder) if entry["path"] not in paths]
        write_manifest(record.spec.name, [*others, *entries], skipped, scratch)
    return entries, skipped


def save_accuracy_plot(record: DesignRecord, folder: Path) -> Path:
    """Draw torque against twist and the transmission error; returns the path of the PNG file."""
    with atomic_folder(folder) as scratch:
        (scratch / PLOTS).mkdir()
        picture, _ = save(plot.accuracy(record), scratch / PLOTS, "accuracy")
    return folder / PLOTS / picture.name


def design_report(record: DesignRecord, written: list[WrittenFile], skipped: dict[str, str], plots: Path) -> str:
    """HTML text of the report; pictures are taken from the SVG files in ``plots``."""
    return template("design.html.j2").render(
        s=summary(record),
        record=record,
        tables=tables,
        files=written,
        micrometre=UM,
        skipped=skipped,
        pictures=[(one.caption, inline_svg(plots / f"{one.name}.svg", one.name)) for one in pictures_of(record)],
    )
