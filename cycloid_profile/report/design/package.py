"""Files of a design in one folder: chosen formats, pictures, report and manifest."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from cycloid_profile import plot
from cycloid_profile.design import DesignRecord, disc_parts_sentence, disc_records, summary
from cycloid_profile.export import CadProcess, write_in_two_processes
from cycloid_profile.export.writing import (
    PROTECTED,
    Protection,
    WrittenFile,
    atomic_folder,
    manifest_entry,
    read_manifest,
    unchanged_entries,
    write_manifest,
)
from cycloid_profile.plot import pictures as pictures_of
from cycloid_profile.plot import save
from cycloid_profile.report.design import tables
from cycloid_profile.report.design.text import design_meaning, design_subject, design_verdict
from cycloid_profile.report.page import PLOTS, REPORT, pdf_name, picture, render, write_report
from cycloid_profile.units import UM


def build_package(
    record: DesignRecord,
    folder: str | Path,
    progress: Callable[[str], None] = lambda _: None,
    protection: Protection = PROTECTED,
    process: CadProcess | None = None,
    pdf: bool = False,
) -> tuple[list[dict[str, Any]], dict[str, str]]:
    """Write the formats of the spec, all pictures, ``report.html`` and ``manifest.json`` into ``folder``.

    All files are written, or none. Files of an earlier manifest that are not in the new one are deleted, unless they
    were changed since: stale outputs must not remain next to a new report. ``progress`` receives the name of each step;
    ``protection`` names what is not replaced; ``process`` writes the CAD formats of the spec meanwhile, and is started
    here if not before; ``pdf``: write the report as PDF, too.
    Returns the manifest entries of all files, and the formats that could not be written, with the reason: STEP where
    the CAD kernel is missing.

    Raises
    ------
    ExportError
        If the folder cannot be written to, holds a file of others under a name of the package, or a file exceeds its
        tolerance when read back.
    """
    formats = record.spec.export.formats
    pictures: list[WrittenFile] = []
    with atomic_folder(Path(folder), protection, replaces=True) as scratch, process or CadProcess(formats) as cad:

        def draw() -> None:
            (scratch / PLOTS).mkdir()
            wanted = pictures_of(record)
            for number, picture in enumerate(wanted, 1):
                progress(f"drawing picture {number} of {len(wanted)}")
                for file in save(picture.draw(record), scratch / PLOTS, picture.name):
                    pictures.append(WrittenFile(f"{PLOTS}/{file.name}", file.suffix[1:]))

        written, skipped = write_in_two_processes(disc_records(record), formats, scratch, cad, progress, draw)
        progress("writing the report")
        write_report(scratch, REPORT, design_report(record, written, skipped, scratch, pdf), pdf)
        reports = [WrittenFile(REPORT, "html"), *([WrittenFile(pdf_name(REPORT), "pdf")] if pdf else [])]
        everything = [*written, *pictures, *reports]
        entries = [manifest_entry(file, record.spec, scratch) for file in everything]
        write_manifest(record.spec.name, entries, skipped, scratch, disc_parts_sentence(record))
    return entries, skipped


def export_package(
    record: DesignRecord,
    formats: Sequence[str],
    folder: Path,
    progress: Callable[[str], None] = lambda _: None,
    protection: Protection = PROTECTED,
    process: CadProcess | None = None,
) -> tuple[list[dict[str, Any]], dict[str, str]]:
    """Write ``formats`` into ``folder`` and add them to its manifest; ``process`` as in ``build_package``.

    Returns the manifest entries of these formats, and the formats that could not be written with the reason.
    Raises ``ExportError`` as ``build_package`` does.
    """
    with atomic_folder(folder, protection) as scratch, process or CadProcess(formats) as cad:
        written, skipped = write_in_two_processes(disc_records(record), formats, scratch, cad, progress)
        entries = _add_to_manifest(record, written, skipped, scratch, folder)
    return entries, skipped


def save_accuracy_plot(record: DesignRecord, folder: Path, protection: Protection = PROTECTED) -> Path:
    """Draw torque against twist and the transmission error; returns the path of the PNG file.

    The manifest of a package in ``folder`` follows.
    """
    with atomic_folder(folder, protection) as scratch:
        (scratch / PLOTS).mkdir()
        drawn = save(plot.accuracy(record), scratch / PLOTS, "accuracy")
        if (earlier := read_manifest(folder)) is not None:
            written = [WrittenFile(f"{PLOTS}/{file.name}", file.suffix[1:]) for file in drawn]
            skipped = {one["format"]: one["reason"] for one in earlier["skipped"]}
            _add_to_manifest(record, written, skipped, scratch, folder)
    return folder / PLOTS / drawn[0].name


def _add_to_manifest(
    record: DesignRecord, written: Sequence[WrittenFile], skipped: dict[str, str], scratch: Path, folder: Path
) -> list[dict[str, Any]]:
    """Entries of ``written``, after a manifest of them and of the unchanged files in ``folder`` is in ``scratch``."""
    entries = [manifest_entry(file, record.spec, scratch) for file in written]
    paths = {entry["path"] for entry in entries}
    others = [entry for entry in unchanged_entries(folder) if entry["path"] not in paths]
    write_manifest(record.spec.name, [*others, *entries], skipped, scratch, disc_parts_sentence(record))
    return entries


def design_report(
    record: DesignRecord, written: Sequence[WrittenFile], skipped: dict[str, str], folder: Path, pdf: bool = False
) -> str:
    """HTML text of the report, with the pictures and links of the files in ``folder``; ``pdf``: one is written next to
    it.
    """
    figures = summary(record)
    return render(
        "design.html.j2",
        folder,
        record.spec.name,
        title="cycloid disc",
        verdict=design_verdict(figures),
        subject=design_subject(figures, record.drive.discs),
        meaning=design_meaning(figures),
        also=("manifest.json", *([pdf_name(REPORT)] if pdf else [])),
        notes={"manifest.json": "checksums of all files", pdf_name(REPORT): "this report"},
        pictures=[picture(folder, f"{PLOTS}/{one.name}", one.caption) for one in pictures_of(record)],
        s=figures,
        record=record,
        tables=tables,
        measured={file.name: file for file in written},
        micrometre=UM,
        skipped=skipped,
    )
