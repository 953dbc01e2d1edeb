"""Point lists: the profile for grinding and CAD, and the nominal points of a coordinate measuring machine."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.errors import ExportError
from cycloid_profile.export.deviation import deviation
from cycloid_profile.export.disc_path import Ground, chord_phases
from cycloid_profile.export.written import WrittenFile
from cycloid_profile.geometry.profile import ToothPoints, ToothProfile
from cycloid_profile.geometry.sampling import (
    ChordTolerance,
    EqualArc,
    EqualNormalAngle,
    Sampling,
    chord_error,
    sample,
)
from cycloid_profile.spec.export import ExportSpec
from cycloid_profile.units import UM

PROFILE_COLUMNS = ("psi_rad", "x_mm", "y_mm", "nx", "ny", "curvature_per_mm")
CMM_COLUMNS = ("point", "lobe", "psi_rad", "x_mm", "y_mm", "z_mm", "nx", "ny", "nz")
POINT_RESOLUTION = 1e-9  # mm, last decimal written
_MOST_POINTS, _GROWTH = 20_000, 1.05  # on a lobe
_EQUAL: dict[str, Callable[[int], Sampling]] = {"equal-arc": EqualArc, "equal-normal-angle": EqualNormalAngle}


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
        """Write and read back; the deviation includes the chords between points, unless their number was given."""
        points, closed = _spread(record.spec.export, record.profile)
        n = points.normal
        columns = (points.phase, *points.xy.T, n.real, n.imag, points.curvature)
        rows = zip(*(_decimals(c, d) for c, d in zip(columns, (10, 9, 9, 8, 8, 6), strict=True)), strict=True)
        path = folder / self.filename
        write_table(path, PROFILE_COLUMNS, [",".join(row) for row in rows])
        back = read_table(path)
        found = deviation(record.profile, back[:, 1] + 1j * back[:, 2])
        promise = POINT_RESOLUTION
        if closed is not None:
            promise = record.spec.export.chord_tolerance_um * UM
            found = replace(found, largest=max(found.largest, chord_error(record.profile, closed)))
        return (WrittenFile(self.filename, self.format, promise, found, "numpy", {"points": len(back)}),)


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
        points, lobe = measuring_points(record)
        n = points.normal
        columns = zip(*(_decimals(c, 9) for c in (points.phase, *points.xy.T, n.real, n.imag)), strict=True)
        z = f"{0.5 * record.drive.disc_width:.4f}"
        rows = [
            f"{i},{m},{psi},{x},{y},{z},{nx},{ny},0"
            for i, (m, (psi, x, y, nx, ny)) in enumerate(zip(lobe.tolist(), columns, strict=True), start=1)
        ]
        path = folder / self.filename
        write_table(path, CMM_COLUMNS, rows)
        back = read_table(path)
        found = deviation(record.profile, back[:, 3] + 1j * back[:, 4])
        entities = {"points": len(back), "lobes": int(back[-1, 1])}
        return (WrittenFile(self.filename, self.format, POINT_RESOLUTION, found, "numpy", entities),)


def measuring_points(record: Ground) -> tuple[ToothPoints, IntArray]:
    """Nominal measuring points as ``[export]`` spreads them, and the lobe of each counted from 1."""
    export = record.spec.export
    points = sample(record.profile, _EQUAL[export.cmm_spacing](export.cmm_points_per_lobe))
    return points, np.floor(points.phase / (2.0 * math.pi) + 1e-9).astype(np.intp) + 1


def _spread(export: ExportSpec, profile: ToothProfile) -> tuple[ToothPoints, FloatArray | None]:
    """Points of the profile, and phases between which their chords keep the tolerance; None where that is not asked."""
    tolerance = export.chord_tolerance_um * UM
    if export.point_spacing != "chord-error":
        return _spread_equally(export, profile, tolerance)
    if profile.lobes_alike:
        spacing = ChordTolerance(tolerance)
        return sample(profile, spacing), np.append(spacing.phases(profile), 2.0 * math.pi)
    along, side = chord_phases(profile, tolerance)
    return profile.at(along, side), np.append(along, profile.trochoid.phase_period)


def _spread_equally(
    export: ExportSpec, profile: ToothProfile, tolerance: float
) -> tuple[ToothPoints, FloatArray | None]:
    equally = _EQUAL[export.point_spacing]
    if export.points_per_lobe is not None:
        return sample(profile, equally(export.points_per_lobe)), None
    count = ChordTolerance(tolerance).phases(profile).size
    while count <= _MOST_POINTS:
        phases = equally(count).phases(profile)
        turns = np.arange(1.0 if profile.lobes_alike else profile.trochoid.lobes)[:, np.newaxis]
        along = (phases + 2.0 * math.pi * turns).ravel()
        closed = np.append(along, 2.0 * math.pi * turns.size)
        if chord_error(profile, closed) <= tolerance:
            return sample(profile, equally(count)), closed
        count = math.ceil(_GROWTH * count)
    raise ExportError(
        "export.chord_tolerance_um",
        f"{export.chord_tolerance_um:g}",
        f"needs more than {_MOST_POINTS} points a lobe at {export.point_spacing} spacing",
        "raise it, or take chord-error spacing",
    )


def read_table(path: Path) -> FloatArray:
    """Rows of a point list, shape (points, columns), units as in its header."""
    table: FloatArray = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    return table


def write_table(path: Path, columns: tuple[str, ...], rows: list[str]) -> None:
    """Write a point list: one header row, one row a point."""
    path.write_text("\n".join([",".join(columns), *rows]) + "\n", encoding="ascii", newline="\n")


def _decimals(values: FloatArray, decimals: int) -> list[str]:
    # Adding zero turns −0.0 into 0.0, which would print a sign that depends on rounding.
    rounded = np.round(values, decimals) + 0.0
    return [f"{value:.{decimals}f}" for value in rounded.tolist()]
