"""Table of the export formats, and functions that write selected formats in one process or two."""

from __future__ import annotations

import contextlib
import os
import pickle
import queue
import subprocess
import sys
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from cycloid_profile.design import DesignRecord, disc_records
from cycloid_profile.effects import load_plugins, plugin_sources
from cycloid_profile.errors import CycloidError, ExportError, PluginError, did_you_mean
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
from cycloid_profile.export.dxf import ArcDxfExporter, DxfExporter, OffsetDxfExporter
from cycloid_profile.export.inspection import DmisExporter
from cycloid_profile.export.nc import GcodeExporter, GcodePathExporter, PolarExporter, WireExporter
from cycloid_profile.export.points import CmmExporter, ProfileCsvExporter, VdaExporter
from cycloid_profile.export.svg import SvgExporter
from cycloid_profile.export.writing import Exporter, LibraryMissing, WrittenFile, plain_name, signals_deferred
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
    VdaExporter(),
)
EXPORTERS: Mapping[str, Exporter[Any]] = {exporter.format: exporter for exporter in _ALL}
Outcome = tuple[list[WrittenFile], dict[str, str]]
_COMMAND = (
    "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN); "
    "from cycloid_profile.export.formats import write_for_another_process as write; write()"
)
# Formats that load the CAD kernel, the DXF for its area.
WITH_KERNEL = frozenset({"dxf", "step", "step-assembly", "parts-step", "parts-3mf", "parts-stl"})
# Formats whose readers, controls and measuring machines, take plain ASCII only.
IN_ASCII = frozenset({"gcode", "gcode-polar", "gcode-wire", "dmis", "vdafs"})
# Formats with all parts of a stage, not of one disc.
OF_THE_STAGE = frozenset({"step-assembly", "parts-step", "parts-3mf", "parts-stl", "bom"})
# Formats of the finished disc or stage: a corrected tooth is ground, but never the aim.
NOT_OF_A_CORRECTION: Mapping[str, str] = {
    **dict.fromkeys(
        ("drawing", "cmm", "dmis", "vdafs"),
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
) -> Outcome:
    """As ``write_formats``, of the given ``discs``: each has a file of every format of a disc, named by its ``label``.

    Formats of the stage are those of the first of them, a ``DesignRecord``.
    """
    written: list[WrittenFile] = []
    skipped: dict[str, str] = {}
    for name in dict.fromkeys(formats):
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


class CadProcess:
    """A process for the formats of ``WITH_KERNEL`` among ``formats``; none where there are none.

    build123d takes 3 s to import. The process imports it while the design is computed, and writes while tables,
    programs and pictures are made here. Ctrl-C does not reach it: it ends with this object, or with its parent.
    """

    def __init__(self, formats: Sequence[str]) -> None:
        self.formats = tuple(name for name in dict.fromkeys(formats) if name in WITH_KERNEL)
        self._has_job = False
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
        command = [sys.executable, "-c", _COMMAND]
        # A group of its own: the terminal sends its signals to the group of this process.
        options: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "process_group": 0}
        # An interrupt between the start of the process and its handle would leave it without an owner.
        with signals_deferred():
            self._process = subprocess.Popen(command, env=environment, **options) if self.formats else None

    def __enter__(self) -> CadProcess:
        return self

    def __exit__(self, *_: object) -> None:
        if self._process is not None:
            with signals_deferred():
                self._process.kill()
                self._process.communicate()

    def start(self, discs: Sequence[ProfileSource], folder: Path) -> None:
        """Begin to write the formats into ``folder``."""
        if self._process is None or self._process.stdin is None:
            return
        # Effects and laws of a script or notebook cannot be imported by another process.
        with contextlib.suppress(PluginError, pickle.PicklingError, AttributeError, TypeError, BrokenPipeError):
            # Plugins first: the discs may hold their effects.
            job = (plugin_sources(), pickle.dumps(tuple(discs)), self.formats, folder)
            pickle.dump(job, self._process.stdin)
            self._process.stdin.flush()
            self._has_job = True

    def result(self) -> Outcome | None:
        """The written files and skipped formats, as of ``write_formats``, when they are done; raises its errors.

        None where the other process could not take the discs, or was ended by others.
        """
        if self._process is None:
            return [], {}
        if not self._has_job or self._process.stdout is None:
            return None
        # Its input stays open: the process ends where it is closed.
        try:
            outcome: Outcome | BaseException = pickle.load(self._process.stdout)
        except (EOFError, pickle.UnpicklingError):
            return None
        if isinstance(outcome, BaseException):
            raise outcome
        return outcome


def write_in_two_processes(
    discs: Sequence[ProfileSource],
    formats: Sequence[str],
    folder: Path,
    process: CadProcess,
    progress: Callable[[str], None] = lambda _: None,
    meanwhile: Callable[[], None] = lambda: None,
) -> Outcome:
    """As ``write_discs``: ``process`` writes its formats, this one the others and then does what is to be done
    ``meanwhile``."""
    process.start(discs, folder)
    here = [name for name in formats if name not in process.formats]
    written, skipped = write_discs(discs, here, folder, progress)
    meanwhile()
    if process.formats:
        progress(f"writing {', '.join(process.formats)}")
    more, missing = process.result() or write_discs(discs, process.formats, folder)
    order = {name: i for i, name in enumerate(dict.fromkeys(formats))}
    return sorted([*written, *more], key=lambda file: order[file.format]), {**skipped, **missing}


def write_for_another_process() -> None:
    """Write the formats of the job on standard input; the outcome goes to standard output."""
    # Only the result goes to the pipe, whatever the kernel prints.
    pipe = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    jobs: queue.SimpleQueue[Any] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(jobs,), daemon=True).start()
    # The exporters say what is missing.
    with contextlib.suppress(ImportError):
        import build123d  # noqa: F401 - while the design is computed
    try:
        plugins, packed, formats, folder = jobs.get()
        load_plugins(plugins, must_register=False)
        discs = pickle.loads(packed)
    except (AttributeError, ImportError, PluginError, pickle.UnpicklingError):
        return
    try:
        outcome: Outcome | BaseException = write_discs(discs, formats, folder)
    except (CycloidError, OSError, MemoryError) as error:
        outcome = error
    with pipe:
        pickle.dump(outcome, pipe)


def _listen(jobs: queue.SimpleQueue[Any]) -> None:
    """Pass the job on, and end the process when the one that wants the files has gone."""
    with contextlib.suppress(EOFError, OSError, pickle.UnpicklingError), os.fdopen(os.dup(0), "rb") as source:
        jobs.put(pickle.load(source))
        # The other side writes no more; this returns when it closes, even by a kill.
        os.read(0, 1)
    os._exit(1)


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
