"""What an exporter says of the file it wrote, and the files an export can hold."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from cycloid_profile.design.record import DesignRecord
from cycloid_profile.export.deviation import Deviation


@dataclass(frozen=True, slots=True)
class WrittenFile:
    """A file with its promise and its proof.

    ``name`` relative to the output folder; ``tolerance`` promised [mm]; ``deviation`` measured by reading
    the file back with ``reader``; both None for files that hold no curve. ``entities`` counts its parts.
    """

    name: str
    format: str
    tolerance: float | None = None
    deviation: Deviation | None = None
    reader: str | None = None
    entities: dict[str, int] = field(default_factory=dict)


class Exporter(Protocol):
    """One file format."""

    @property
    def format(self) -> str:
        """Name of the format in the spec file."""
        ...

    @property
    def filenames(self) -> tuple[str, ...]:
        """Names of the files it writes."""
        ...

    def write(self, record: DesignRecord, folder: Path) -> tuple[WrittenFile, ...]:
        """Write the files into ``folder``, read each back and measure it; in the order of ``filenames``."""
        ...
