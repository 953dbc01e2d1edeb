"""Everything a design yields, in one folder: files, pictures, report, manifest."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from cycloid_profile.design.record import DesignRecord
from cycloid_profile.export.package import exporter_for, whole_or_nothing, write_manifest
from cycloid_profile.export.step import CadKernelMissing
from cycloid_profile.export.written import WrittenFile
from cycloid_profile.plot.gallery import PICTURES
from cycloid_profile.plot.style import save
from cycloid_profile.report.html import design_report

REPORT = "report.html"
PLOTS = "plots"


def build_package(
    record: DesignRecord, folder: str | Path, progress: Callable[[str], None] = lambda _: None
) -> dict[str, str]:
    """Write the formats of the spec, all pictures, ``report.html`` and ``manifest.json`` into ``folder``.

    Files appear whole or not at all. ``progress`` is told of each step. Returns the formats that could not
    be written, with the reason: STEP where the CAD kernel is missing.

    Raises
    ------
    ExportError
        If the folder cannot be written to, or a file does not read back.
    """
    folder = Path(folder)
    with whole_or_nothing(folder) as scratch:
        written, skipped = write_formats(record, record.spec.export.formats, scratch, progress)
        (scratch / PLOTS).mkdir()
        pictures: list[WrittenFile] = []
        for picture in PICTURES:
            progress(f"drawing {picture.name}")
            for file in save(picture.draw(record), scratch / PLOTS, picture.name):
                pictures.append(WrittenFile(f"{PLOTS}/{file.name}", file.suffix[1:]))
        progress("writing the report")
        html = design_report(record, written, skipped, scratch / PLOTS)
        (scratch / REPORT).write_text(html, encoding="utf-8", newline="\n")
        write_manifest(record, [*written, *pictures, WrittenFile(REPORT, "html")], skipped, scratch)
    return skipped


def write_formats(
    record: DesignRecord, formats: tuple[str, ...], folder: Path, progress: Callable[[str], None] = lambda _: None
) -> tuple[list[WrittenFile], dict[str, str]]:
    """Write some formats into ``folder``; returns what was written, and what was skipped with the reason."""
    written: list[WrittenFile] = []
    skipped: dict[str, str] = {}
    for name in dict.fromkeys(formats):
        exporter = exporter_for(name)
        progress(f"writing {exporter.filename}")
        try:
            written.append(exporter.write(record, folder))
        except CadKernelMissing as missing:
            skipped[name] = str(missing)
    return written, skipped
