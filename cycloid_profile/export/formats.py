"""All formats, and writing some of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from cycloid_profile.design.record import DesignRecord
from cycloid_profile.errors import ExportError
from cycloid_profile.export.dxf import DxfExporter
from cycloid_profile.export.gcode import GcodeExporter
from cycloid_profile.export.points import CmmExporter, ProfileCsvExporter
from cycloid_profile.export.step import CadKernelMissing, StepExporter
from cycloid_profile.export.written import Exporter, WrittenFile
from cycloid_profile.units import UM

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


def write_formats(
    record: DesignRecord, formats: Sequence[str], folder: Path, progress: Callable[[str], None] = lambda _: None
) -> tuple[list[WrittenFile], dict[str, str]]:
    """Write some formats into ``folder``; returns what was written, and what was skipped with the reason.

    Raises
    ------
    ExportError
        If a file, read back, does not keep its promise, or the lobes of the tooth differ.
    """
    if not record.profile.lobes_alike:
        raise ExportError(
            "tooth profile",
            "with lobes that differ",
            "is not what the exporters write, which is one lobe turned round the disc",
            "export the profile without its measured deviation",
            " ",
        )
    written: list[WrittenFile] = []
    skipped: dict[str, str] = {}
    for name in dict.fromkeys(formats):
        exporter = exporter_for(name)
        progress(f"writing {exporter.filename}")
        try:
            written.append(_kept_promise(exporter.write(record, folder)))
        except CadKernelMissing as missing:
            skipped[name] = str(missing)
    return written, skipped


def _kept_promise(file: WrittenFile) -> WrittenFile:
    if file.deviation is not None and file.tolerance is not None and not file.deviation.largest <= file.tolerance:
        raise ExportError(
            f"deviation of {file.name}",
            f"{file.deviation.largest / UM:.4g} µm",
            f"exceeds the promised {file.tolerance / UM:.4g} µm",
            "raise export.chord_tolerance_um",
        )
    return file
