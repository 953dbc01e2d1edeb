"""The contour as a table for any machine: lines and arcs with their centres, outward normals, curvature and feed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cycloid_profile.export.biarc import Arcs
from cycloid_profile.export.cnc_chain import lengths, tangents
from cycloid_profile.export.deviation import deviation
from cycloid_profile.export.disc_path import Ground
from cycloid_profile.export.gcode import contour_chain
from cycloid_profile.export.points import POINT_RESOLUTION, read_table, write_table
from cycloid_profile.export.written import WrittenFile
from cycloid_profile.units import UM

PATH_COLUMNS = (
    "segment", "x0_mm", "y0_mm", "x1_mm", "y1_mm", "turn", "centre_x_mm", "centre_y_mm", "radius_mm",
    "nx0", "ny0", "nx1", "ny1", "curvature_per_mm", "length_mm", "feed_mm_per_min",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class GcodePathExporter:
    """Writes ``grinding_path.csv``: the contour of ``grinding.nc`` without leads, to the last decimal of a nanometre.

    ``turn`` is 1 for an anticlockwise arc, −1 for a clockwise one, 0 for a line, whose centre and radius are 0.
    """

    format: str = "gcode-path"
    filenames: tuple[str, ...] = ("grinding_path.csv",)

    def write(self, record: Ground, folder: Path) -> tuple[WrittenFile, ...]:
        """Write, read back and measure."""
        export = record.spec.export
        tolerance = export.chord_tolerance_um * UM
        path = folder / self.filenames[0]
        # The disc is on the right of a clockwise path, on the left of the other.
        side = -1j if export.wheel_compensation == "G42" else 1j
        write_table(path, PATH_COLUMNS, _rows(contour_chain(record, tolerance), export.feed_mm_per_min, side))
        back = read_table(path)
        ends = back[:, 1:5:2] + 1j * back[:, 2:5:2]
        bend = np.where(back[:, 5] == 0.0, 0.0, back[:, 5] / np.where(back[:, 8] == 0.0, 1.0, back[:, 8]))
        found = deviation(record.profile, Arcs(np.append(ends[:, 0], ends[-1, 1]), bend).points())
        promise = tolerance + POINT_RESOLUTION
        return (WrittenFile(path.name, self.format, promise, found, "numpy", {"segments": len(back)}),)


def _rows(chain: Arcs, feed: float, side: complex) -> list[str]:
    bent = chain.bend != 0.0
    centre = np.where(bent, np.nan_to_num(chain.centres), 0.0)
    radius = np.where(bent, 1.0 / np.where(bent, np.abs(chain.bend), 1.0), 0.0)
    normals = [side * tangent for tangent in tangents(chain)]
    columns = (
        chain.ends[:-1].real, chain.ends[:-1].imag, chain.ends[1:].real, chain.ends[1:].imag, np.sign(chain.bend),
        centre.real, centre.imag, radius, normals[0].real, normals[0].imag, normals[1].real, normals[1].imag,
        # Negative where the tooth is convex, whichever way round the path runs.
        chain.bend * side.imag, lengths(chain), np.full(chain.bend.shape, feed),
    )  # fmt: skip
    places = (9, 9, 9, 9, 0, 9, 9, 9, 9, 9, 9, 9, 9, 9, 6)
    shown = [
        [f"{value:.{p}f}" for value in (np.round(v, p) + 0.0).tolist()] for v, p in zip(columns, places, strict=True)
    ]
    return [f"{k},{','.join(row)}" for k, row in enumerate(zip(*shown, strict=True), start=1)]
