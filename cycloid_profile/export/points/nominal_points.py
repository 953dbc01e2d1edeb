"""Nominal points of a coordinate measuring machine: as CSV, and in VDA-FS 2.0 (DIN 66301)."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.design import flank_relief
from cycloid_profile.export.curves import ProfileSource, deviation
from cycloid_profile.export.points.tables import (
    EQUAL_SPACINGS,
    POINT_RESOLUTION,
    fixed_decimals,
    from_mid_height,
    relieved_points,
    write_table,
)
from cycloid_profile.export.writing import SingleFileExporter, WrittenFile, plain_name
from cycloid_profile.geometry import ToothPoints, sample

_RELIEVED = (0.5, 0.1, 0.9)  # of the face width: where flanks with relief are measured, mid-height first
_WIDTH = 72  # columns of data; the last eight of eighty number the lines
_SEQUENCE = re.compile(r"\w+ *= *MDI */ *(\d+) *,([-+0-9., Ee]*)")


def measuring_points(source: ProfileSource) -> tuple[ToothPoints, IntArray]:
    """Nominal measuring points spaced as ``[export]`` asks, and the lobe number of each from 1, shape (points,)."""
    export = source.spec.export
    points = sample(source.profile, EQUAL_SPACINGS[export.cmm_spacing](export.cmm_points_per_lobe))
    return points, np.floor(points.phase / (2.0 * math.pi) + 1e-9).astype(np.intp) + 1


@dataclass(frozen=True)
class CmmExporter(SingleFileExporter[ProfileSource]):
    """Writes ``cmm_nominal.csv``: nominal points with outward normals at equal arc, at mid face width; flanks with
    relief along the axis at further heights, their numbers running on.
    """

    format: str = "cmm"
    filename: str = "cmm_nominal.csv"

    def write_file(self, source: ProfileSource, path: Path) -> WrittenFile:
        """See ``SingleFileExporter.write_file``."""
        points, lobe = measuring_points(source)
        b, relieved = source.drive.disc_width, bool(flank_relief(source.spec))
        heights = [share * b for share in (_RELIEVED if relieved else (0.5,))]
        xyz, normal = (each.reshape(-1, 3) for each in relieved_points(source, points, heights))
        x, y, z = xyz.T
        nx, ny, nz = normal.T
        count = len(heights)
        back = write_table(
            path,
            (
                ("point", np.arange(1.0, x.size + 1.0), 0), ("lobe", np.tile(lobe.astype(np.float64), count), 0),
                ("psi_rad", np.tile(points.phase, count), 9), ("x_mm", x, 9), ("y_mm", y, 9), ("z_mm", z, 4),
                ("nx", nx, 9), ("ny", ny, 9), ("nz", nz, 9 if relieved else 0),
            ),
        )  # fmt: skip
        # Heights are written to 0.1 µm, which no relief feels.
        found = from_mid_height(source, np.stack([back[:, 3], back[:, 4], z], axis=1), back[:, 6:])
        entities = {"points": len(back), "lobes": int(back[-1, 1])} | ({"heights": count} if relieved else {})
        return self.measured(POINT_RESOLUTION, found, "numpy", entities)


@dataclass(frozen=True)
class VdaExporter(SingleFileExporter[ProfileSource]):
    """Writes ``cmm_nominal.vda``: nominal points with normals, one point-vector sequence (MDI) per lobe."""

    format: str = "vdafs"
    filename: str = "cmm_nominal.vda"

    def write_file(self, source: ProfileSource, path: Path) -> WrittenFile:
        """See ``SingleFileExporter.write_file``."""
        data = [*_header(plain_name(source.spec.name)), *_sequences(source), "TEETHEND = END"]
        lines = [f"{line:<{_WIDTH}}{number:08d}" for number, line in enumerate(data, start=1)]
        path.write_text("\n".join(lines) + "\n", encoding="ascii", newline="\n")
        back = read_sequences(path)
        found = deviation(source.profile, back[:, 0] + 1j * back[:, 1])
        count = {"points": len(back), "lobes": source.profile.trochoid.lobes}
        return self.measured(POINT_RESOLUTION, found, "own reader", count)


def read_sequences(path: Path) -> FloatArray:
    """Points x, y, z and normals of all sequences of a VDA-FS file, shape (points, 6) [mm]."""
    text = "".join(line[:_WIDTH] for line in path.read_text(encoding="ascii").splitlines())
    rows = [np.array(values.split(","), dtype=np.float64).reshape(int(n), 6) for n, values in _SEQUENCE.findall(text)]
    return np.concatenate(rows)


def _header(name: str) -> list[str]:
    text = [
        "VDA-FS 2.0",
        *wrap(f"NOMINAL POINTS OF THE TEETH OF {name.upper()}", _WIDTH),
        "COORDINATES IN MM, ORIGIN ON THE BORE AXIS, TOOTH ROOT 1 ON THE X AXIS",
        "ONE MDI A LOBE: POINTS AND OUTWARD UNIT NORMALS",
    ]
    return [f"TEETH = HEADER / {len(text)}", *text]


def _sequences(source: ProfileSource) -> list[str]:
    points, lobe = measuring_points(source)
    n = points.normal
    z = np.full(n.shape, 0.5 * source.drive.disc_width)
    rows = np.stack([*points.xy.T, z, n.real, n.imag, np.zeros_like(z)], axis=-1)
    lines: list[str] = []
    for number in range(1, source.profile.trochoid.lobes + 1):
        values = rows[lobe == number]
        lines += _wrapped(f"LOBE{number:04d} = MDI / ", [f"{len(values)}", *fixed_decimals(values.ravel(), 9)])
    return lines


def _wrapped(line: str, words: list[str]) -> list[str]:
    """A statement of ``words`` separated by commas, broken after commas into lines of at most 72 columns."""
    lines = []
    for position, word in enumerate(words):
        piece = word if position == len(words) - 1 else word + ","
        if len(line) + len(piece) > _WIDTH:
            lines.append(line)
            line = ""
        line += piece
    return [*lines, line]
