"""Plan of each part of the stage except the discs as DXF, to cut plates and rings from."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cycloid_profile.design import DesignRecord
from cycloid_profile.export.cad import parts_of
from cycloid_profile.export.cad.part_files import write_each_part
from cycloid_profile.export.cad.parts import StagePart
from cycloid_profile.export.dxf.document import audited, draw_contour, layer_counts, new_dxf
from cycloid_profile.export.writing import WrittenFile


@dataclass(frozen=True)
class PartDxfExporter:
    """Writes ``parts/KIND.dxf`` for every kind of part except the discs: edges on layer PROFILE, openings on HOLES."""

    format: str = "parts-dxf"
    filenames: tuple[str, ...] = ("parts/*.dxf",)

    def write(self, record: DesignRecord, folder: Path) -> tuple[WrittenFile, ...]:
        """Write every part at true size, seen along its axis, and read it back.

        Raises ``ExportError`` if ezdxf's audit of a file finds an error.
        """

        def write_one(part: StagePart, path: Path) -> dict[str, int]:
            with new_dxf(path) as space:
                for edge in dict.fromkeys(slab.edge for slab in part.slabs):
                    draw_contour(space, edge, "PROFILE")
                for opening in dict.fromkeys(opening for slab in part.slabs for opening in slab.openings):
                    draw_contour(space, opening)
            return layer_counts(audited(path))

        return write_each_part(parts_of(record), folder, self.format, "dxf", write_one)
