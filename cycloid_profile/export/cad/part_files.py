"""A file for each part of the stage except the discs, as STEP or as mesh with print offsets, and the parts list."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from cycloid_profile.design import DesignRecord, disc_parts
from cycloid_profile.export.cad.mesh import Mesh, print_offsets, write_closed_mesh
from cycloid_profile.export.cad.parts import StagePart
from cycloid_profile.export.cad.step import cad_material, cad_part, part_material, parts_of
from cycloid_profile.export.writing import WrittenFile, require_cad_kernel
from cycloid_profile.units import UM

_FOLDER = "parts"
_HEAD = ("item", "part", "quantity", "outer_diameter_mm", "length_mm", "material", "made_from")


@dataclass(frozen=True)
class PartStepExporter:
    """Writes ``parts/KIND.step`` for every kind of part except the discs: pins, ring, shafts, bearings, rollers,
    plates."""

    format: str = "parts-step"
    filenames: tuple[str, ...] = (f"{_FOLDER}/*.step",)

    def write(self, record: DesignRecord, folder: Path) -> tuple[WrittenFile, ...]:
        """Write every part and read it back.

        Raises ``LibraryMissing``, or ``ExportError`` if a solid read back is not valid and closed.
        """
        require_cad_kernel()
        from cycloid_profile.export.cad import _solids as kernel

        def write_one(part: StagePart, path: Path) -> dict[str, int]:
            kernel.write_part(cad_part(record, part), path, record.spec.export.step.schema)
            (solid,) = kernel.sound_solids(kernel.read_shape(path), path, 1)
            return {"solids": 1, "faces": kernel.face_count(solid)}

        return write_each_part(parts_of(record), folder, self.format, "step", write_one)


@dataclass(frozen=True)
class PartMeshExporter:
    """Writes ``parts/KIND.3mf`` or ``.stl``: the same parts with the print offsets of holes and seats."""

    format: str
    suffix: str

    @property
    def filenames(self) -> tuple[str, ...]:
        """See ``Exporter.filenames``."""
        return (f"{_FOLDER}/*.{self.suffix}",)

    def write(self, record: DesignRecord, folder: Path) -> tuple[WrittenFile, ...]:
        """Write every part and read it back.

        Raises ``LibraryMissing``, or ``ExportError`` if a mesh read back is open.
        """
        require_cad_kernel()
        from cycloid_profile.export.cad import _solids as kernel

        chord = record.spec.export.print.chord_um * UM

        def write_one(part: StagePart, path: Path) -> dict[str, int]:
            mesh = Mesh(*kernel.tessellated(cad_part(record, part).solid, chord))
            back = write_closed_mesh(mesh, f"{record.spec.name} {part.kind}", path, self.suffix)
            return {"triangles": len(back.triangles), "open_edges": 0}

        parts = parts_of(record, 0.0, print_offsets(record.spec))
        return write_each_part(parts, folder, self.format, self.suffix, write_one)


def write_each_part(
    parts: Iterable[StagePart],
    folder: Path,
    kind: str,
    suffix: str,
    write_one: Callable[[StagePart, Path], dict[str, int]],
) -> tuple[WrittenFile, ...]:
    """A file of every part; ``write_one`` returns the items in it by kind."""
    (folder / _FOLDER).mkdir(exist_ok=True)
    written = []
    for part in parts:
        name = f"{_FOLDER}/{_stem(part)}.{suffix}"
        entities = write_one(part, folder / name) | {"quantity": len(part.placements)}
        written.append(WrittenFile(name, kind, entities=entities))
    return tuple(written)


@dataclass(frozen=True)
class BomExporter:
    """Writes ``bom.csv``: every part with quantity, size, material and the name of its file."""

    format: str = "bom"
    filenames: tuple[str, ...] = ("bom.csv",)

    def write(self, record: DesignRecord, folder: Path) -> tuple[WrittenFile, ...]:
        """Write the list."""
        drive, width = record.drive, record.drive.disc_width
        material = cad_material(record.spec.materials.disc).name
        rows: list[tuple[str, int, float, float, str, str]] = []
        tip = 2.0 * record.outline.tip_radius
        for disc in disc_parts(drive, record.outline):
            name = "disc" if disc.number == 1 else f"disc_{disc.number}"
            rows.append((f"disc {disc.number}", len(disc.discs), tip, width, material, name))
        for part in parts_of(record):
            low, high = min(slab.low for slab in part.slabs), max(slab.high for slab in part.slabs)
            reach = max(float(abs(slab.edge.points(1e-3)).max()) for slab in part.slabs)
            made_of, file = part_material(record, part).name, f"{_FOLDER}/{_stem(part)}"
            rows.append((part.kind, len(part.placements), 2.0 * reach, high - low, made_of, file))
        with (folder / "bom.csv").open("w", encoding="utf-8", newline="") as file_of_rows:
            table = csv.writer(file_of_rows, lineterminator="\n")
            table.writerow(_HEAD)
            for i, (kind, count, diameter, length, made_of, file) in enumerate(rows, start=1):
                table.writerow((i, kind, count, f"{diameter:.4f}", f"{length:.4f}", made_of, file))
        return (WrittenFile("bom.csv", self.format, entities={"items": len(rows)}),)


def _stem(part: StagePart) -> str:
    return part.kind.replace(" ", "_")
