"""STEP of the whole stage: discs, pins, ring, cranks and carrier in their places, each shape held once."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile.design.record import DesignRecord
from cycloid_profile.export.deviation import deviation_both_ways
from cycloid_profile.export.libraries import require_cad_kernel
from cycloid_profile.export.refine import FIT_SHARE
from cycloid_profile.export.solids import joined_solid, plate
from cycloid_profile.export.spline import SplinePiece, disc_splines
from cycloid_profile.export.stage_parts import Place, StagePart, disc_places, mounted, stage_parts
from cycloid_profile.export.step import DISC_COLOUR, substance
from cycloid_profile.export.step_file import Part, Substance, write_assembly
from cycloid_profile.export.step_read import points_on, read_shape, sound_solids, top_edges
from cycloid_profile.export.text import plain_name
from cycloid_profile.export.written import WrittenFile
from cycloid_profile.units import UM

_COLOURS = {
    "pin": (0.85, 0.65, 0.20),
    "pin ring": (0.45, 0.50, 0.55),
    "crank shaft": (0.55, 0.35, 0.30),
    "crank bearing": (0.90, 0.90, 0.85),
    "output pin": (0.35, 0.55, 0.40),
    "carrier plate": (0.40, 0.55, 0.70),
}
_SHADE = 0.1
_SIZED_TO_FIT = Substance("unnamed", "sized to show and to fit, not designed")


@dataclass(frozen=True, slots=True)
class StepAssemblyExporter:
    """Writes ``assembly.step``."""

    format: str = "step-assembly"
    filename: str = "assembly.step"

    @property
    def filenames(self) -> tuple[str, ...]:
        """See ``Exporter.filenames``."""
        return (self.filename,)

    def write(self, record: DesignRecord, folder: Path) -> tuple[WrittenFile, ...]:
        """Write and read back; the deviation is that of the disc that is worst, measured where it stands.

        Raises ``LibraryMissing``, or ``ExportError`` if a solid read back is not valid and closed.
        """
        require_cad_kernel()
        export = record.spec.export
        tolerance = export.chord_tolerance_um * UM
        splines = disc_splines(record.profile, export.step.degree, FIT_SHARE * tolerance)
        discs = [_disc(record, splines, place, j) for j, place in enumerate(disc_places(record.drive))]
        parts = (*discs, *(_part(record, part) for part in stage_parts(record.drive, record.outline)))
        path = folder / self.filename
        write_assembly(plain_name(record.spec.name), parts, path, export.step.schema)
        return (self._read_back(record, parts, path, tolerance),)

    def _read_back(self, record: DesignRecord, parts: tuple[Part, ...], path: Path, tolerance: float) -> WrittenFile:
        count = sum(len(part.places) for part in parts)
        solids = sound_solids(read_shape(path), path, count)
        # Solids come back in the order of the parts, which begins with the discs.
        found = []
        for place, solid in zip(disc_places(record.drive), solids, strict=False):
            points = points_on(top_edges(solid)[0])
            in_disc = (points - place.shift) * np.exp(-1j * place.turn)
            found.append(deviation_both_ways(record.profile, in_disc))
        worst = max(found, key=lambda one: max(one.largest, one.from_curve or 0.0))
        entities = {"solids": count, "shapes": len(parts), "discs": len(found), "pins": record.drive.trochoid.pins}
        return WrittenFile(
            self.filename, self.format, tolerance, worst, "OpenCascade, valid closed solids in place", entities
        )


def _disc(record: DesignRecord, splines: tuple[SplinePiece, ...], place: Place, number: int) -> Part:
    outline = mounted(record.outline, place)
    solid = plate(splines, outline.contours, 0.0, record.drive.disc_width)
    # A shade for each: two parts of one colour would share its entity, in an order that changes.
    red, green, blue = (channel * (1.0 - _SHADE * number) for channel in DISC_COLOUR)
    return Part(place.name, solid, (red, green, blue), substance(record.spec.materials.disc), (place,))


def _part(record: DesignRecord, part: StagePart) -> Part:
    solid: Any = joined_solid([plate(slab.edge, slab.openings, slab.low, slab.high) for slab in part.slabs])
    made_of = substance(record.spec.materials.pin) if part.kind == "pin" else _SIZED_TO_FIT
    return Part(part.kind, solid, _COLOURS[part.kind], made_of, part.places)
