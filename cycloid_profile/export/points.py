"""Point lists: the profile for grinding and CAD, and the nominal points of a coordinate measuring machine."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.export.deviation import deviation
from cycloid_profile.export.disc_path import Ground, chord_phases
from cycloid_profile.export.written import WrittenFile
from cycloid_profile.geometry.sampling import ChordTolerance, EqualArc, chord_error, sample
from cycloid_profile.units import UM

PROFILE_COLUMNS = ("psi_rad", "x_mm", "y_mm", "nx", "ny", "curvature_per_mm")
CMM_COLUMNS = ("point", "lobe", "psi_rad", "x_mm", "y_mm", "z_mm", "nx", "ny", "nz")
POINT_RESOLUTION = 1e-9  # mm, last decimal written


@dataclass(frozen=True, slots=True)
class ProfileCsvExporter:
    """Writes ``profile.csv``: points dense enough that chords stay within the tolerance."""

    format: str = "csv"
    filename: str = "profile.csv"

    @property
    def filenames(self) -> tuple[str, ...]:
        """See ``Exporter.filenames``."""
        return (self.filename,)

    def write(self, record: Ground, folder: Path) -> tuple[WrittenFile, ...]:
        """Write and read back; the deviation includes the chords between neighbouring points."""
        tolerance = record.spec.export.chord_tolerance_um * UM
        if record.profile.lobes_alike:
            spacing = ChordTolerance(tolerance)
            points = sample(record.profile, spacing)
            closed = np.append(spacing.phases(record.profile), 2.0 * math.pi)
        else:
            along, side = chord_phases(record.profile, tolerance)
            points = record.profile.at(along, side)
            closed = np.append(along, record.profile.trochoid.phase_period)
        n = points.normal
        columns = (points.phase, *points.xy.T, n.real, n.imag, points.curvature)
        rows = zip(*(_decimals(c, d) for c, d in zip(columns, (10, 9, 9, 8, 8, 6), strict=True)), strict=True)
        path = folder / self.filename
        _write_table(path, PROFILE_COLUMNS, [",".join(row) for row in rows])
        back = read_table(path)
        found = deviation(record.profile, back[:, 1] + 1j * back[:, 2])
        found = replace(found, largest=max(found.largest, chord_error(record.profile, closed)))
        return (WrittenFile(self.filename, self.format, tolerance, found, "numpy", {"points": len(back)}),)


@dataclass(frozen=True, slots=True)
class CmmExporter:
    """Writes ``cmm_nominal.csv``: nominal points with outward normals at equal arc, at mid face width."""

    format: str = "cmm"
    filename: str = "cmm_nominal.csv"

    @property
    def filenames(self) -> tuple[str, ...]:
        """See ``Exporter.filenames``."""
        return (self.filename,)

    def write(self, record: Ground, folder: Path) -> tuple[WrittenFile, ...]:
        """Write and read back."""
        points = sample(record.profile, EqualArc(record.spec.export.cmm_points_per_lobe))
        n = points.normal
        lobe = np.floor(points.phase / (2.0 * math.pi) + 1e-9).astype(int) + 1
        columns = zip(*(_decimals(c, 9) for c in (points.phase, *points.xy.T, n.real, n.imag)), strict=True)
        z = f"{0.5 * record.drive.disc_width:.4f}"
        rows = [
            f"{i},{m},{psi},{x},{y},{z},{nx},{ny},0"
            for i, (m, (psi, x, y, nx, ny)) in enumerate(zip(lobe.tolist(), columns, strict=True), start=1)
        ]
        path = folder / self.filename
        _write_table(path, CMM_COLUMNS, rows)
        back = read_table(path)
        found = deviation(record.profile, back[:, 3] + 1j * back[:, 4])
        entities = {"points": len(back), "lobes": int(back[-1, 1])}
        return (WrittenFile(self.filename, self.format, POINT_RESOLUTION, found, "numpy", entities),)


def read_table(path: Path) -> FloatArray:
    """Rows of a point list, shape (points, columns), units as in its header."""
    table: FloatArray = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    return table


def _write_table(path: Path, columns: tuple[str, ...], rows: list[str]) -> None:
    path.write_text("\n".join([",".join(columns), *rows]) + "\n", encoding="ascii", newline="\n")


def _decimals(values: FloatArray, decimals: int) -> list[str]:
    # Adding zero turns −0.0 into 0.0, which would print a sign that depends on rounding.
    rounded = np.round(values, decimals) + 0.0
    return [f"{value:.{decimals}f}" for value in rounded.tolist()]
