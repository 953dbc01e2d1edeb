"""The tooth profile for grinding and CAD: ``profile.csv`` and the further files that a spec asks for with it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cycloid_profile.design import flank_relief
from cycloid_profile.errors import ExportError
from cycloid_profile.export.curves import ProfileSource, chord_points, deviation
from cycloid_profile.export.points.layouts import write_points
from cycloid_profile.export.points.tables import (
    EQUAL_SPACINGS,
    POINT_RESOLUTION,
    from_mid_height,
    relieved_points,
    write_table,
)
from cycloid_profile.export.points.wheel_section import write_form_wheel
from cycloid_profile.export.writing import SingleFileExporter, WrittenFile
from cycloid_profile.geometry import ChordTolerance, ToothPoints, ToothProfile, chord_error, sample
from cycloid_profile.spec.model import ExportSpec

_CLOUD, _HEIGHTS = "profile_width.csv", 11
_MOST_POINTS, _GROWTH = 20_000, 1.05  # per lobe


@dataclass(frozen=True)
class ProfileCsvExporter(SingleFileExporter[ProfileSource]):
    """Writes ``profile.csv``: points dense enough that chords stay within the tolerance."""

    format: str = "csv"
    filename: str = "profile.csv"

    def write(self, source: ProfileSource, folder: Path) -> tuple[WrittenFile, ...]:
        """See ``Exporter.write``; flanks with relief along the axis add ``profile_width.csv``, ``[export.points]`` and
        ``[export.form_wheel]`` their files."""
        written, export = list(super().write(source, folder)), source.spec.export
        if flank_relief(source.spec):
            written.append(_write_cloud(source, folder / _CLOUD))
        if export.points is not None:
            written.append(write_points(source, export.points, folder))
        if export.form_wheel is not None:
            written += write_form_wheel(source, export.form_wheel, folder)
        return tuple(written)

    def write_file(self, source: ProfileSource, path: Path) -> WrittenFile:
        """Write and read back; the deviation includes the chords between points, unless their number was given."""
        export = source.spec.export
        points = _profile_points(export, source.profile)
        x, y = points.xy.T
        n = points.normal
        back = write_table(
            path,
            (
                ("psi_rad", points.phase, 10), ("x_mm", x, 9), ("y_mm", y, 9), ("nx", n.real, 8), ("ny", n.imag, 8),
                ("curvature_per_mm", points.curvature, 6),
            ),
        )  # fmt: skip
        found, tolerance = deviation(source.profile, back[:, 1] + 1j * back[:, 2]), POINT_RESOLUTION
        if export.point_spacing == "chord-error" or export.points_per_lobe is None:
            tolerance = export.chord_tolerance
            found = replace(found, largest=max(found.largest, _chord_error(source.profile, points)))
        return self.measured(tolerance, found, "numpy", {"points": len(back)})


def _write_cloud(source: ProfileSource, path: Path) -> WrittenFile:
    """The flanks as points at several heights, spaced like measuring points round the disc."""
    export, b = source.spec.export, source.drive.disc_width
    points = sample(source.profile, EQUAL_SPACINGS[export.cmm_spacing](export.cmm_points_per_lobe))
    begins = flank_relief(source.spec).edge_length
    heights = sorted({*np.linspace(0.0, b, _HEIGHTS).tolist(), *((begins, b - begins) if begins else ())})
    xyz, normal = (each.reshape(-1, 3) for each in relieved_points(source, points, heights))
    psi = np.tile(points.phase, len(heights))
    names = ("z_mm", "x_mm", "y_mm", "nx", "ny", "nz")
    values = (xyz[:, 2], xyz[:, 0], xyz[:, 1], *normal.T)
    columns = [(name, each, 9) for name, each in zip(names, values, strict=True)]
    back = write_table(path, [("psi_rad", psi, 10), *columns])
    found = from_mid_height(source, back[:, [2, 3, 1]], back[:, 4:])
    count = {"points": len(back), "heights": len(heights)}
    return WrittenFile(path.name, "csv", POINT_RESOLUTION, found, "numpy", count)


def _profile_points(export: ExportSpec, profile: ToothProfile) -> ToothPoints:
    """Points at the spacing of the spec: their given number, or the fewest whose chords keep the tolerance."""
    tolerance = export.chord_tolerance
    if export.point_spacing == "chord-error":
        return chord_points(profile, tolerance)
    spacing = EQUAL_SPACINGS[export.point_spacing]
    if export.points_per_lobe is not None:
        return sample(profile, spacing(export.points_per_lobe))
    count = ChordTolerance(tolerance).phases(profile).size
    while count <= _MOST_POINTS:
        points = sample(profile, spacing(count))
        if _chord_error(profile, points) <= tolerance:
            return points
        count = math.ceil(_GROWTH * count)
    raise ExportError(
        "export.chord_tolerance_um",
        f"{export.chord_tolerance_um:g}",
        f"needs more than {_MOST_POINTS} points per lobe at {export.point_spacing} spacing",
        "raise it, or take chord-error spacing",
    )


def _chord_error(profile: ToothProfile, points: ToothPoints) -> float:
    """Largest chord error of points round the disc, on the first lobe if all are identical [mm]."""
    lobes = profile.trochoid.lobes
    size, end = points.phase.size, profile.trochoid.phase_period
    if profile.identical_lobes:
        size, end = size // lobes, 2.0 * math.pi
    return chord_error(profile, np.append(points.phase[:size], end))
