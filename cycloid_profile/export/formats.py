"""All formats, and writing some of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from cycloid_profile.design.record import DesignRecord
from cycloid_profile.errors import ExportError
from cycloid_profile.export.assembly import StepAssemblyExporter
from cycloid_profile.export.dmis import DmisExporter
from cycloid_profile.export.drawing import DrawingExporter
from cycloid_profile.export.dxf import DxfExporter
from cycloid_profile.export.dxf_arcs import ArcDxfExporter
from cycloid_profile.export.gcode import GcodeExporter
from cycloid_profile.export.gcode_path import GcodePathExporter
from cycloid_profile.export.libraries import LibraryMissing
from cycloid_profile.export.points import CmmExporter, ProfileCsvExporter
from cycloid_profile.export.polar_program import PolarExporter
from cycloid_profile.export.printing import MeshExporter
from cycloid_profile.export.step import StepExporter
from cycloid_profile.export.vdafs import VdaExporter
from cycloid_profile.export.wire import WireExporter
from cycloid_profile.export.written import Exporter, WrittenFile
from cycloid_profile.units import UM

EXPORTERS: tuple[Exporter, ...] = (
    ProfileCsvExporter(),
    DxfExporter(),
    ArcDxfExporter(),
    DrawingExporter(),
    StepExporter(),
    StepAssemblyExporter(),
    MeshExporter("3mf", "disc.3mf"),
    MeshExporter("stl", "disc.stl"),
    GcodeExporter(),
    GcodePathExporter(),
    PolarExporter(),
    WireExporter(),
    CmmExporter(),
    DmisExporter(),
    VdaExporter(),
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
        If a file, read back, does not keep its promise.
    """
    written: list[WrittenFile] = []
    skipped: dict[str, str] = {}
    for name in dict.fromkeys(formats):
        exporter = exporter_for(name)
        progress(f"writing {', '.join(exporter.filenames)}")
        try:
            written += [kept_promise(file) for file in exporter.write(record, folder)]
        except LibraryMissing as missing:
            skipped[name] = str(missing)
    return written, skipped


def kept_promise(file: WrittenFile) -> WrittenFile:
    """The file itself; raises ``ExportError`` where it lies further from the curve than it promises, or the curve
    from it.
    """
    if file.deviation is None or file.tolerance is None:
        return file
    worst = max(file.deviation.largest, file.deviation.from_curve or 0.0)
    if not worst <= file.tolerance:
        raise ExportError(
            f"deviation of {file.name}",
            f"{worst / UM:.4g} µm",
            f"exceeds the promised {file.tolerance / UM:.4g} µm",
            "raise export.chord_tolerance_um",
        )
    return file
