"""STEP: the disc as a solid, tooth flanks as splines, with its openings."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cycloid_profile.contact.hertz import STEEL
from cycloid_profile.design.record import DesignRecord
from cycloid_profile.export.deviation import deviation_both_ways
from cycloid_profile.export.libraries import require_cad_kernel
from cycloid_profile.export.refine import FIT_SHARE
from cycloid_profile.export.solids import plate
from cycloid_profile.export.spline import disc_splines
from cycloid_profile.export.step_file import Part, Substance, write_part
from cycloid_profile.export.step_read import points_on, read_shape, sound_solids, top_edges
from cycloid_profile.export.text import plain_name
from cycloid_profile.export.written import WrittenFile
from cycloid_profile.spec.materials import MaterialSpec
from cycloid_profile.units import GPA, UM

DISC_COLOUR = (0.70, 0.75, 0.80)


@dataclass(frozen=True, slots=True)
class StepExporter:
    """Writes ``disc.step``."""

    format: str = "step"
    filename: str = "disc.step"

    @property
    def filenames(self) -> tuple[str, ...]:
        """See ``Exporter.filenames``."""
        return (self.filename,)

    def write(self, record: DesignRecord, folder: Path) -> tuple[WrittenFile, ...]:
        """Write and read back.

        Raises ``LibraryMissing``, or ``ExportError`` if the solid read back is not valid and closed.
        """
        require_cad_kernel()
        export = record.spec.export
        tolerance = export.chord_tolerance_um * UM
        splines = disc_splines(record.profile, export.step.degree, FIT_SHARE * tolerance)
        solid = plate(splines, record.outline.contours, 0.0, record.drive.disc_width)
        name = plain_name(record.spec.name)
        path = folder / self.filename
        write_part(Part(name, solid, DISC_COLOUR, substance(record.spec.materials.disc)), path, export.step.schema)
        return (self._read_back(record, path, tolerance),)

    def _read_back(self, record: DesignRecord, path: Path, tolerance: float) -> WrittenFile:
        (disc,) = sound_solids(read_shape(path), path, 1)
        edges, holes, faces = top_edges(disc)
        return WrittenFile(
            self.filename,
            self.format,
            tolerance,
            deviation_both_ways(record.profile, points_on(edges)),
            "OpenCascade, valid closed solid",
            {"solids": 1, "faces": faces, "tooth_edges": len(edges), "holes": holes},
        )


def substance(material: MaterialSpec) -> Substance:
    """Material of a part by its name; where it has none, steel if it is as stiff."""
    stiff = 0.9 < material.youngs_modulus_gpa * GPA / STEEL.youngs_modulus < 1.1
    name = plain_name(material.name) if material.name else "steel" if stiff else "unnamed"
    return Substance(name, f"E = {material.youngs_modulus_gpa:g} GPa, Poisson's ratio {material.poisson_ratio:g}")
