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
# Formats whose writers turn one lobe round the disc.
_ONE_LOBE = ("dxf", "step")


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
        If a file, read back, does not keep its promise, or lobes differ and the format has one for all.
    """
    one_lobe = [name for name in formats if name in _ONE_LOBE]
    if one_lobe and not record.profile.lobes_alike:
        raise ExportError(
            "tooth profile",
            "with lobes that differ",
            f"is not what the format {one_lobe[0]} is written of, which is one lobe turned round the disc",
            "export csv, gcode or cmm, or the profile without what makes its lobes differ",
            " ",
        )
    written: list[WrittenFile] = []
    skipped: dict[str, str] = {}
    for name in dict.fromkeys(formats):
        exporter = exporter_for(name)
        progress(f"writing {', '.join(exporter.filenames)}")
        try:
            written += [kept_promise(file) for file in exporter.write(record, folder)]
        except CadKernelMissing as missing:
            skipped[name] = str(missing)
    return written, skipped


def kept_promise(file: WrittenFile) -> WrittenFile:
    """The file itself; raises ``ExportError`` where it lies further from the curve than it promises."""
    if file.deviation is not None and file.tolerance is not None and not file.deviation.largest <= file.tolerance:
        raise ExportError(
            f"deviation of {file.name}",
            f"{file.deviation.largest / UM:.4g} µm",
            f"exceeds the promised {file.tolerance / UM:.4g} µm",
            "raise export.chord_tolerance_um",
        )
    return file
