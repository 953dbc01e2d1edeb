"""Exporters, the files they write, and the libraries they need."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

from cycloid_profile.errors import ExportError
from cycloid_profile.export.curves import Deviation
from cycloid_profile.export.writing.signals import signals_deferred

Source = TypeVar("Source", contravariant=True)


@dataclass(frozen=True, slots=True)
class WrittenFile:
    """A file with its promised tolerance and its measured deviation.

    ``name`` relative to the output folder; ``tolerance`` promised [mm]; ``deviation`` measured by reading the file
    back with ``reader``; both None for files without a curve. ``entities`` counts the items in the file by kind;
    ``measures`` holds areas and volumes [mm², mm³] by their names in the manifest, ``notes`` sentences for the user.
    """

    name: str
    format: str
    tolerance: float | None = None
    deviation: Deviation | None = None
    reader: str | None = None
    entities: dict[str, int] = field(default_factory=dict)
    measures: dict[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


class Exporter(Protocol[Source]):
    """One file format."""

    @property
    def format(self) -> str:
        """Name of the format in the spec file."""
        ...

    @property
    def filenames(self) -> tuple[str, ...]:
        """Names of the files it writes."""
        ...

    def write(self, source: Source, folder: Path, /) -> tuple[WrittenFile, ...]:
        """Write the files into ``folder``, read each back and measure it; in the order of ``filenames``."""
        ...


@dataclass(frozen=True)
class SingleFileExporter(ABC, Generic[Source]):
    """Exporter of one file; subclasses set ``format`` and ``filename`` and define ``write_file``."""

    format: str
    filename: str

    @property
    def filenames(self) -> tuple[str, ...]:
        """See ``Exporter.filenames``."""
        return (self.filename,)

    @abstractmethod
    def write_file(self, source: Source, path: Path) -> WrittenFile:
        """Write the file at ``path``, read it back and measure it."""

    def write(self, source: Source, folder: Path) -> tuple[WrittenFile, ...]:
        """See ``Exporter.write``."""
        return (self.write_file(source, folder / self.filename),)

    def measured(self, tolerance: float, deviation: Deviation, reader: str, entities: dict[str, int]) -> WrittenFile:
        """The file with its tolerance [mm] and measured deviation; see ``WrittenFile``."""
        return WrittenFile(self.filename, self.format, tolerance, deviation, reader, entities)


def read_back_error(kind: str, path: Path, finding: str) -> ExportError:
    """The error of a ``kind`` of file that fails its own check when read back; ``finding`` is a clause."""
    return ExportError(kind, f"'{path.name}'", finding, "report this as a defect", " ")


class LibraryMissing(ExportError):  # noqa: N818 - a state of the machine, not a fault of the input
    """A library cannot be imported; the message names the package to install."""


def require_cad_kernel() -> None:
    """Raise ``LibraryMissing`` where build123d cannot be imported; the import takes 3 s and needs system libraries."""
    with _needed("STEP export", "build123d with its kernel", "build123d"):
        import build123d  # noqa: F401 - loads the whole kernel


def lib3mf() -> Any:
    """The library of the 3MF consortium. Raises ``LibraryMissing`` where it cannot be imported."""
    with _needed("3MF and STL export", "lib3mf", "lib3mf"):
        import lib3mf as library
    return library


@contextmanager
def _needed(what: str, needed: str, package: str) -> Iterator[None]:
    """Around an import: raises ``LibraryMissing`` where it fails."""
    try:
        # A library written in C turns an interrupt of its import into an ImportError: it would seem to be missing.
        with signals_deferred():
            yield
    except ImportError as error:
        remedy = f"install it with 'pip install {package}'"
        if "libGL" in str(error) or ".so" in str(error):
            wanted = "libGL, libX11 and libexpat (Debian: apt install libgl1 libx11-6 libexpat1)"
            remedy = f"install the system libraries {wanted}"
        limit = f"which cannot be imported ({error})"
        raise LibraryMissing(what, f"needs {needed}", limit, remedy, " ") from None
