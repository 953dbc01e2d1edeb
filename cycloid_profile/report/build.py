"""Everything a design yields, in one folder: files, pictures, report, manifest."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from cycloid_profile.design.record import DesignRecord
from cycloid_profile.export.folder import whole_or_nothing
from cycloid_profile.export.formats import write_formats
from cycloid_profile.export.manifest import manifest_entry, untouched_entries, write_manifest
from cycloid_profile.export.written import WrittenFile
from cycloid_profile.plot.gallery import pictures as pictures_of
from cycloid_profile.plot.style import save
from cycloid_profile.report.html import design_report

REPORT = "report.html"
PLOTS = "plots"


def build_package(
    record: DesignRecord, folder: str | Path, progress: Callable[[str], None] = lambda _: None
) -> dict[str, str]:
    """Write the formats of the spec, all pictures, ``report.html`` and ``manifest.json`` into ``folder``.

    Files appear whole or not at all. What an earlier manifest in ``folder`` lists and this one does not is
    removed, if it is still as it was written: an old disc must not lie beside a new report. ``progress`` is
    told of each step. Returns the formats that could not be written, with the reason: STEP where the CAD
    kernel is missing.

    Raises
    ------
    ExportError
        If the folder cannot be written to, or a file does not read back as promised.
    """
    folder = Path(folder)
    earlier = {entry["path"] for entry in untouched_entries(folder)}
    with whole_or_nothing(folder) as scratch:
        written, skipped = write_formats(record, record.spec.export.formats, scratch, progress)
        (scratch / PLOTS).mkdir()
        pictures: list[WrittenFile] = []
        for picture in pictures_of(record):
            progress(f"drawing {picture.name}")
            for file in save(picture.draw(record), scratch / PLOTS, picture.name):
                pictures.append(WrittenFile(f"{PLOTS}/{file.name}", file.suffix[1:]))
        progress("writing the report")
        html = design_report(record, written, skipped, scratch / PLOTS)
        (scratch / REPORT).write_text(html, encoding="utf-8", newline="\n")
        everything = [*written, *pictures, WrittenFile(REPORT, "html")]
        entries = [manifest_entry(file, record.spec, scratch) for file in everything]
        write_manifest(record.spec.name, entries, skipped, scratch)
    for path in earlier - {entry["path"] for entry in entries}:
        (folder / path).unlink(missing_ok=True)
    return skipped
