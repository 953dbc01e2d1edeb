"""Table of the export formats, and a function that writes selected formats."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from cycloid_profile.design import DesignRecord
from cycloid_profile.errors import ExportError, did_you_mean
from cycloid_profile.export.cad import MeshExporter, StepAssemblyExporter, StepExporter
from cycloid_profile.export.drawing import DrawingExporter
from cycloid_profile.export.dxf import ArcDxfExporter, DxfExporter
from cycloid_profile.export.inspection import DmisExporter
from cycloid_profile.export.nc import GcodeExporter, GcodePathExporter, PolarExporter, WireExporter
from cycloid_profile.export.points import CmmExporter, ProfileCsvExporter, VdaExporter
from cycloid_profile.export.writing import Exporter, LibraryMissing, WrittenFile
from cycloid_profile.units import UM

_ALL: tuple[Exporter, ...] = (
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
EXPORTERS: Mapping[str, Exporter] = {exporter.format: exporter for exporter in _ALL}


def exporter_for(name: str) -> Exporter:
    """The exporter of a format. Raises ``ExportError`` for an unknown one."""
    if name not in EXPORTERS:
        remedy = did_you_mean(name, EXPORTERS, f"choose from {', '.join(EXPORTERS)}")
        raise ExportError("format", f"'{name}'", "is not known", remedy, " ")
    return EXPORTERS[name]


def write_formats(
    record: DesignRecord, formats: Sequence[str], folder: Path, progress: Callable[[str], None] = lambda _: None
) -> tuple[list[WrittenFile], dict[str, str]]:
    """Write ``formats`` into ``folder``; returns the written files, and the skipped formats with the reason.

    Raises ``ExportError`` if a file, read back, exceeds its tolerance.
    """
    written: list[WrittenFile] = []
    skipped: dict[str, str] = {}
    for name in dict.fromkeys(formats):
        exporter = exporter_for(name)
        progress(f"writing {', '.join(exporter.filenames)}")
        try:
            written += [check_deviation(file) for file in exporter.write(record, folder)]
        except LibraryMissing as missing:
            skipped[name] = str(missing)
    return written, skipped


def check_deviation(file: WrittenFile) -> WrittenFile:
    """The given file, unchanged. Raises ``ExportError`` if its deviation, in either direction, exceeds its
    tolerance."""
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
