"""STEP files of the disc alone, and of the whole stage with all parts in place."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cycloid_profile.contact.laws import STEEL
from cycloid_profile.design import DesignRecord
from cycloid_profile.export.cad.parts import (
    CadMaterial,
    Part,
    Placement,
    StagePart,
    disc_placements,
    mounted,
    stage_parts,
)
from cycloid_profile.export.curves import FIT_SHARE, SplinePiece, deviation_both_ways, disc_splines
from cycloid_profile.export.writing import SingleFileExporter, WrittenFile, plain_name, require_cad_kernel
from cycloid_profile.spec.model import MaterialSpec
from cycloid_profile.units import GPA, UM

_DISC_COLOUR = (0.70, 0.75, 0.80)
_COLOURS = {
    "pin": (0.85, 0.65, 0.20),
    "pin ring": (0.45, 0.50, 0.55),
    "crank shaft": (0.55, 0.35, 0.30),
    "crank bearing": (0.90, 0.90, 0.85),
    "output pin": (0.35, 0.55, 0.40),
    "carrier plate": (0.40, 0.55, 0.70),
}
_SHADE = 0.1
_SIZED_TO_FIT = CadMaterial("unnamed", "sized to show and to fit, not designed")


@dataclass(frozen=True)
class StepExporter(SingleFileExporter[DesignRecord]):
    """Writes ``disc.step``: the disc as a solid with its openings, tooth flanks as splines."""

    format: str = "step"
    filename: str = "disc.step"

    def write_file(self, source: DesignRecord, path: Path) -> WrittenFile:
        """Write and read back.

        Raises ``LibraryMissing``, or ``ExportError`` if the solid read back is not valid and closed.
        """
        require_cad_kernel()
        from cycloid_profile.export.cad import _opencascade as kernel

        tolerance, splines = _tooth(source)
        solid = kernel.plate(splines, source.outline.contours, 0.0, source.drive.disc_width)
        part = Part(plain_name(source.spec.name), solid, _DISC_COLOUR, cad_material(source.spec.materials.disc))
        kernel.write_part(part, path, source.spec.export.step.schema)
        (disc,) = kernel.sound_solids(kernel.read_shape(path), path, 1)
        edges, holes, faces = kernel.top_edges(disc)
        found = deviation_both_ways(source.profile, kernel.points_on(edges))
        counts = {"solids": 1, "faces": faces, "tooth_edges": len(edges), "holes": holes}
        return self.measured(tolerance, found, "OpenCascade, valid closed solid", counts)


@dataclass(frozen=True)
class StepAssemblyExporter(SingleFileExporter[DesignRecord]):
    """Writes ``assembly.step``: discs, pins, ring, cranks and carrier in place, each shape stored once."""

    format: str = "step-assembly"
    filename: str = "assembly.step"

    def write_file(self, source: DesignRecord, path: Path) -> WrittenFile:
        """Write and read back; the deviation is the largest of all discs, measured in place.

        Raises ``LibraryMissing``, or ``ExportError`` if a solid read back is not valid and closed.
        """
        require_cad_kernel()
        from cycloid_profile.export.cad import _opencascade as kernel

        tolerance, splines = _tooth(source)
        placements = disc_placements(source.drive)
        discs = [_disc(source, splines, placement, j) for j, placement in enumerate(placements)]
        parts = (*discs, *(_part(source, part) for part in stage_parts(source.drive, source.outline)))
        kernel.write_assembly(plain_name(source.spec.name), parts, path, source.spec.export.step.schema)
        count = sum(len(part.placements) for part in parts)
        # Solids are read in the order of the parts, which begins with the discs.
        found = []
        solids = kernel.sound_solids(kernel.read_shape(path), path, count)
        for placement, solid in zip(placements, solids, strict=False):
            points = kernel.points_on(kernel.top_edges(solid)[0])
            in_disc = (points - placement.shift) * np.exp(-1j * placement.rotation)
            found.append(deviation_both_ways(source.profile, in_disc))
        worst = max(found, key=lambda one: max(one.largest, one.from_curve or 0.0))
        counts = {"solids": count, "shapes": len(parts), "discs": len(found), "pins": source.drive.trochoid.pins}
        return self.measured(tolerance, worst, "OpenCascade, valid closed solids in place", counts)


def _tooth(record: DesignRecord) -> tuple[float, tuple[SplinePiece, ...]]:
    """Tolerance [mm] and splines of the tooth."""
    tolerance = record.spec.export.chord_tolerance_um * UM
    return tolerance, disc_splines(record.profile, record.spec.export.step.degree, FIT_SHARE * tolerance)


def _disc(record: DesignRecord, splines: tuple[SplinePiece, ...], placement: Placement, number: int) -> Part:
    from cycloid_profile.export.cad import _opencascade as kernel

    solid = kernel.plate(splines, mounted(record.outline, placement).contours, 0.0, record.drive.disc_width)
    # Parts of equal colour would share its entity, in an order that changes between runs.
    red, green, blue = (channel * (1.0 - _SHADE * number) for channel in _DISC_COLOUR)
    return Part(placement.name, solid, (red, green, blue), cad_material(record.spec.materials.disc), (placement,))


def _part(record: DesignRecord, part: StagePart) -> Part:
    from cycloid_profile.export.cad import _opencascade as kernel

    solid = kernel.joined_solid([kernel.plate(slab.edge, slab.openings, slab.low, slab.high) for slab in part.slabs])
    material = cad_material(record.spec.materials.pin) if part.kind == "pin" else _SIZED_TO_FIT
    return Part(part.kind, solid, _COLOURS[part.kind], material, part.placements)


def cad_material(material: MaterialSpec) -> CadMaterial:
    """Material of a part, named as in the spec; without a name, "steel" if its modulus is near that of steel, else
    "unnamed"."""
    like_steel = 0.9 < material.youngs_modulus_gpa * GPA / STEEL.youngs_modulus < 1.1
    name = plain_name(material.name) if material.name else "steel" if like_steel else "unnamed"
    return CadMaterial(name, f"E = {material.youngs_modulus_gpa:g} GPa, Poisson's ratio {material.poisson_ratio:g}")
