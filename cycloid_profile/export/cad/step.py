"""STEP files of the disc alone, and of the whole stage with all parts in place."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile.design import DesignRecord, output_sizes
from cycloid_profile.export.cad.areas import measures_of
from cycloid_profile.export.cad.parts import (
    AS_DESIGNED,
    CadMaterial,
    CadPart,
    OutputPins,
    Placement,
    PrintOffsets,
    StagePart,
    disc_placements,
    mounted,
    stage_parts,
)
from cycloid_profile.export.curves import ProfileSource, SplinePiece, deviation_both_ways, fitted_splines
from cycloid_profile.export.writing import SingleFileExporter, WrittenFile, require_cad_kernel
from cycloid_profile.geometry import DiscOutline
from cycloid_profile.spec.model import MaterialSpec
from cycloid_profile.spec.model.materials import is_like_steel
from cycloid_profile.units import DEGREE

_DISC_COLOUR = (0.70, 0.75, 0.80)
_COLOURS = {
    "pin": (0.85, 0.65, 0.20),
    "pin ring": (0.45, 0.50, 0.55),
    "crank shaft": (0.55, 0.35, 0.30),
    "crank bearing": (0.90, 0.90, 0.85),
    "output pin": (0.35, 0.55, 0.40),
    "output roller": (0.75, 0.70, 0.55),
    "carrier plate": (0.40, 0.55, 0.70),
}
_SHADE = 0.1
_SIZED_TO_FIT = CadMaterial("unnamed", "sized to show and to fit, not designed")


@dataclass(frozen=True)
class StepExporter(SingleFileExporter[ProfileSource]):
    """Writes ``disc.step``: the disc as a solid with its openings, tooth flanks as splines."""

    format: str = "step"
    filename: str = "disc.step"

    def write_file(self, source: ProfileSource, path: Path) -> WrittenFile:
        """Write and read back.

        Raises ``LibraryMissing``, or ``ExportError`` if the solid read back is not valid and closed.
        """
        require_cad_kernel()
        from cycloid_profile.export.cad import _solids as kernel

        tolerance, part = source.spec.export.chord_tolerance, _disc_part(source)
        kernel.write_part(part, path, source.spec.export.step.schema)
        (disc,) = kernel.sound_solids(kernel.read_shape(path), path, 1)
        edges, holes, faces = kernel.top_edges(disc)
        found = deviation_both_ways(source.profile, kernel.points_on(edges))
        counts = {"solids": 1, "faces": faces, "tooth_edges": len(edges), "holes": holes}
        file = self.measured(tolerance, found, "OpenCascade, valid closed solid", counts)
        return replace(file, measures=measures_of(source, kernel.measured(disc)))


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
        from cycloid_profile.export.cad import _solids as kernel

        tolerance = source.spec.export.chord_tolerance
        angle = source.spec.export.step.crank_angle_deg * DEGREE
        placements, parts = disc_placements(source.drive, angle), _stage(source, angle)
        kernel.write_assembly(source.spec.name, parts, path, source.spec.export.step.schema)
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


def to_build123d(record: ProfileSource) -> Any:
    """The disc as a ``Part`` of build123d, with its label and colour, to model on with.

    Raises ``LibraryMissing`` where build123d cannot be imported.
    """
    require_cad_kernel()
    from cycloid_profile.export.cad import _solids as kernel

    return kernel.model(_disc_part(record))


def stage_to_build123d(record: DesignRecord, crank_angle: float = 0.0) -> Any:
    """The whole stage at ``crank_angle`` [rad] as a ``Compound`` of build123d, a child for every part in its place.

    Raises ``LibraryMissing`` where build123d cannot be imported.
    """
    require_cad_kernel()
    from cycloid_profile.export.cad import _solids as kernel

    return kernel.assembly(record.spec.name, _stage(record, crank_angle))


def _disc_part(record: ProfileSource) -> CadPart:
    from cycloid_profile.export.cad import _solids as kernel

    solid = kernel.plate(_tooth(record), record.outline.contours, 0.0, record.drive.disc_width)
    return CadPart(record.spec.name, solid, _DISC_COLOUR, cad_material(record.spec.materials.disc))


def _stage(record: DesignRecord, crank_angle: float) -> tuple[CadPart, ...]:
    """All parts at ``crank_angle`` [rad], the discs first."""
    splines = _tooth(record)
    placements = disc_placements(record.drive, crank_angle)
    outlines = [mounted(record.outline, placement) for placement in disc_placements(record.drive)]
    discs = [
        _disc(record, splines, outline, placement, j)
        for j, (outline, placement) in enumerate(zip(outlines, placements, strict=True))
    ]
    return (*discs, *(cad_part(record, part) for part in parts_of(record, crank_angle)))


def _tooth(record: ProfileSource) -> tuple[SplinePiece, ...]:
    return fitted_splines(record, record.spec.export.step.degree)


def parts_of(
    record: DesignRecord, crank_angle: float = 0.0, offsets: PrintOffsets = AS_DESIGNED
) -> tuple[StagePart, ...]:
    """The parts of a design except its discs, at ``crank_angle`` [rad]; see ``stage_parts``."""
    sizes, holes = output_sizes(record.spec), record.spec.disc.output_holes
    output = None if sizes is None or holes is None else OutputPins(sizes[1], holes.pin_radius_mm)
    return stage_parts(record.drive, record.outline, crank_angle, offsets, output)


def _disc(
    record: DesignRecord, splines: tuple[SplinePiece, ...], outline: DiscOutline, placement: Placement, number: int
) -> CadPart:
    from cycloid_profile.export.cad import _solids as kernel

    solid = kernel.plate(splines, outline.contours, 0.0, record.drive.disc_width)
    # Parts of equal colour would share its entity, in an order that changes between runs.
    red, green, blue = (channel * (1.0 - _SHADE * number) for channel in _DISC_COLOUR)
    return CadPart(placement.name, solid, (red, green, blue), cad_material(record.spec.materials.disc), (placement,))


def cad_part(record: DesignRecord, part: StagePart) -> CadPart:
    """The solid of a part with its colour and material; the CAD kernel must be there."""
    from cycloid_profile.export.cad import _solids as kernel

    solid = kernel.joined_solid([kernel.plate(slab.edge, slab.openings, slab.low, slab.high) for slab in part.slabs])
    return CadPart(part.kind, solid, _COLOURS[part.kind], part_material(record, part), part.placements)


def part_material(record: DesignRecord, part: StagePart) -> CadMaterial:
    """Material of a part: that of the pins in the spec for pins, else unnamed."""
    return cad_material(record.spec.materials.pin) if part.kind == "pin" else _SIZED_TO_FIT


def cad_material(material: MaterialSpec) -> CadMaterial:
    """Material of a part, named as in the spec; without a name, "steel" if its modulus is near that of steel, else
    "unnamed"."""
    name = material.name or ("steel" if is_like_steel(material.youngs_modulus_gpa) else "unnamed")
    return CadMaterial(name, f"E = {material.youngs_modulus_gpa:g} GPa, Poisson's ratio {material.poisson_ratio:g}")
