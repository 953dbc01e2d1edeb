"""Table of the export formats, and functions that write selected formats in one process or two."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from cycloid_profile.design import DesignRecord, disc_records
from cycloid_profile.errors import ExportError, did_you_mean
from cycloid_profile.export.cad import (
    BomExporter,
    MeshExporter,
    PartMeshExporter,
    PartStepExporter,
    StepAssemblyExporter,
    StepExporter,
)
from cycloid_profile.export.curves import ProfileSource
from cycloid_profile.export.drawing import DrawingExporter
from cycloid_profile.export.dxf import ArcDxfExporter, DxfExporter, OffsetDxfExporter, PartDxfExporter
from cycloid_profile.export.inspection import DmisExporter, QifExporter
from cycloid_profile.export.nc import GcodeExporter, GcodePathExporter, PolarExporter, WireExporter
from cycloid_profile.export.points import CmmExporter, ProfileCsvExporter, VdaExporter
from cycloid_profile.export.processes import WITH_KERNEL as WITH_KERNEL
from cycloid_profile.export.processes import CadProcess
from cycloid_profile.export.svg import SvgExporter
from cycloid_profile.export.writing import Exporter, LibraryMissing, WrittenFile, plain_name
from cycloid_profile.spec.model import Spec
from cycloid_profile.units import UM

_ALL: tuple[Exporter[Any], ...] = (
    ProfileCsvExporter(),
    DxfExporter(),
    ArcDxfExporter(),
    OffsetDxfExporter(),
    SvgExporter(),
    DrawingExporter(),
    StepExporter(),
    StepAssemblyExporter(),
    PartStepExporter(),
    PartDxfExporter(),
    PartMeshExporter("parts-3mf", "3mf"),
    PartMeshExporter("parts-stl", "stl"),
    BomExporter(),
    MeshExporter("3mf", "disc.3mf"),
    MeshExporter("stl", "disc.stl"),
    GcodeExporter(),
    GcodePathExporter(),
    PolarExporter(),
    WireExporter(),
    CmmExporter(),
    DmisExporter(),
    QifExporter(),
    VdaExporter(),
)
EXPORTERS: Mapping[str, Exporter[Any]] = {exporter.format: exporter for exporter in _ALL}
Outcome = tuple[list[WrittenFile], dict[str, str]]
# Formats whose readers, controls and measuring machines, take plain ASCII only.
IN_ASCII = frozenset({"gcode", "gcode-polar", "gcode-wire", "dmis", "vdafs"})
# Formats with all parts of a stage, not of one disc.
OF_THE_STAGE = frozenset({"step-assembly", "parts-step", "parts-dxf", "parts-3mf", "parts-stl", "bom"})
# Formats of the finished disc or stage: a corrected tooth is ground, but never the aim.
NOT_OF_A_CORRECTION: Mapping[str, str] = {
    **dict.fromkeys(
        ("drawing", "cmm", "dmis", "qif", "vdafs"),
        "it describes the finished disc, whose tooth is nominal; use that of build",
    ),
    **dict.fromkeys(
        sorted(OF_THE_STAGE), "it holds parts of the finished stage, whose teeth are nominal; use that of build"
    ),
}


def exporter_for(name: str) -> Exporter[Any]:
    """The exporter of a format. Raises ``ExportError`` for an unknown one."""
    if name not in EXPORTERS:
        remedy = did_you_mean(name, EXPORTERS, f"choose from {', '.join(EXPORTERS)}")
        raise ExportError("format", f"'{name}'", "is not known", remedy, " ")
    return EXPORTERS[name]


def ascii_name_notes(spec: Spec, formats: Iterable[str]) -> list[str]:
    """A sentence on the name of a spec where some of the ``formats`` cannot hold it as it is."""
    concerned, written = [name for name in formats if name in IN_ASCII], plain_name(spec.name)
    if not concerned or written == spec.name:
        return []
    return [f"the name '{spec.name}' is '{written}' in {', '.join(concerned)}: such files hold plain ASCII only"]


def write_formats(
    record: DesignRecord, formats: Sequence[str], folder: Path, progress: Callable[[str], None] = lambda _: None
) -> tuple[list[WrittenFile], dict[str, str]]:
    """Write ``formats`` into ``folder``; returns the written files, and the skipped formats with the reason.

    A disc that differs from disc 1 has its own file of every format of a disc, with its number in the name.

    Raises ``ExportError`` if a file, read back, exceeds its tolerance.
    """
    return write_discs(disc_records(record), formats, folder, progress)


def write_discs(
    discs: Sequence[ProfileSource],
    formats: Sequence[str],
    folder: Path,
    progress: Callable[[str], None] = lambda _: None,
    is_wanted: Callable[[str], bool] = lambda _: True,
) -> Outcome:
    """As ``write_formats``, of the given ``discs``: each has a file of every format of a disc, named by its ``label``.

    Formats of the stage are those of the first of them, a ``DesignRecord``. ``is_wanted`` is asked before each format.
    """
    written: list[WrittenFile] = []
    skipped: dict[str, str] = {}
    for name in filter(is_wanted, dict.fromkeys(formats)):
        progress(f"writing {', '.join(_labelled_names(name, [one.label for one in discs]))}")
        try:
            for one in discs[:1] if name in OF_THE_STAGE else discs:
                written += [check_deviation(file) for file in _write(exporter_for(name), one, folder)]
        except LibraryMissing as missing:
            skipped[name] = str(missing)
    return written, skipped


def file_names(name: str, discs: Sequence[int] = (1,)) -> tuple[str, ...]:
    """Names of the files of a format where the different discs of a stage have the numbers ``discs``."""
    return _labelled_names(name, ["" if disc == 1 else f"disc_{disc}" for disc in discs])


def _labelled_names(name: str, labels: Sequence[str]) -> tuple[str, ...]:
    own = exporter_for(name).filenames
    return tuple(_labelled(file, one) for one in (labels[:1] if name in OF_THE_STAGE else labels) for file in own)


def _write(exporter: Exporter[Any], source: ProfileSource, folder: Path) -> tuple[WrittenFile, ...]:
    if not source.label:
        return exporter.write(source, folder)
    # Of this format alone: another process may write others at the same time.
    own = folder / f"{source.label}_{exporter.format}"
    own.mkdir(exist_ok=True)
    files = exporter.write(source, own)
    labelled = tuple(replace(file, name=_labelled(file.name, source.label)) for file in files)
    for file, target in zip(files, labelled, strict=True):
        (own / file.name).replace(folder / target.name)
    own.rmdir()
    return labelled


def _labelled(name: str, label: str) -> str:
    """``disc_2.step`` of ``disc.step``, ``profile_disc_2.dxf`` of ``profile.dxf``, ``disc_corrected.step``."""
    path = Path(name)
    if not label:
        return name
    stem = label if path.stem == "disc" and label.startswith("disc_") else f"{path.stem}_{label}"
    return f"{stem}{path.suffix}"


@dataclass(frozen=True, slots=True)
class _Claims:
    """Formats that a process has begun, as empty files in a ``folder``: each is taken once."""

    folder: Path

    def take(self, name: str) -> bool:
        """Whether the format is this process's to write."""
        try:
            (self.folder / name).touch(exist_ok=False)
        except FileExistsError:
            return False
        return True


def write_in_two_processes(
    discs: Sequence[ProfileSource],
    formats: Sequence[str],
    folder: Path,
    process: CadProcess,
    progress: Callable[[str], None] = lambda _: None,
    meanwhile: Callable[[], None] = lambda: None,
) -> Outcome:
    """As ``write_discs``. This process does what is to be done ``meanwhile``, then writes the formats that ``process``
    has not begun; ``process`` begins with those of the kernel, and takes the others from the last on."""
    wanted = tuple(dict.fromkeys(formats))
    others = [name for name in wanted if name not in process.formats]
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as place:
        claims = _Claims(Path(place))
        order = (*process.formats, *reversed(others))
        process.start(partial(write_discs, tuple(discs), order, folder, is_wanted=claims.take))
        meanwhile()
        written, skipped = write_discs(discs, others, folder, progress, claims.take)
        here = {*(file.format for file in written), *skipped}
        if left := [name for name in wanted if name not in here]:
            progress(f"writing {', '.join(left)}")
        more, missing = process.result() or write_discs(discs, left, folder)
    rank = {name: i for i, name in enumerate(wanted)}
    return sorted([*written, *more], key=lambda file: rank[file.format]), {**skipped, **missing}


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
