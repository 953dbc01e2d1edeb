"""Nominal points with normals in VDA-FS 2.0 (DIN 66301): one point-vector sequence (MDI) for every lobe."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.export.deviation import deviation
from cycloid_profile.export.disc_path import Ground
from cycloid_profile.export.points import POINT_RESOLUTION, measuring_points
from cycloid_profile.export.text import plain_name
from cycloid_profile.export.written import WrittenFile

_WIDTH = 72  # columns of data; the last eight of eighty number the lines
_SEQUENCE = re.compile(r"\w+ *= *MDI */ *(\d+) *,([-+0-9., Ee]*)")


@dataclass(frozen=True, slots=True)
class VdaExporter:
    """Writes ``cmm_nominal.vda``."""

    format: str = "vdafs"
    filenames: tuple[str, ...] = ("cmm_nominal.vda",)

    def write(self, record: Ground, folder: Path) -> tuple[WrittenFile, ...]:
        """Write and read back."""
        path = folder / self.filenames[0]
        data = [*_header(plain_name(record.spec.name)), *_sequences(record), "TEETHEND = END"]
        lines = [f"{line:<{_WIDTH}}{number:08d}" for number, line in enumerate(data, start=1)]
        path.write_text("\n".join(lines) + "\n", encoding="ascii", newline="\n")
        back = read_sequences(path)
        found = deviation(record.profile, back[:, 0] + 1j * back[:, 1])
        count = {"points": len(back), "lobes": record.profile.trochoid.lobes}
        return (WrittenFile(path.name, self.format, POINT_RESOLUTION, found, "own reader", count),)


def read_sequences(path: Path) -> FloatArray:
    """Points x, y, z and normals of all sequences, shape (points, 6) [mm]."""
    text = "".join(line[:_WIDTH] for line in path.read_text(encoding="ascii").splitlines())
    rows = [np.array(values.split(","), dtype=np.float64).reshape(int(n), 6) for n, values in _SEQUENCE.findall(text)]
    return np.concatenate(rows)


def _header(name: str) -> list[str]:
    text = [
        "VDA-FS 2.0",
        f"NOMINAL POINTS OF THE TEETH OF {name.upper()}",
        "COORDINATES IN MM, ORIGIN ON THE BORE AXIS, TOOTH ROOT 1 ON THE X AXIS",
        "ONE MDI A LOBE: POINTS AND OUTWARD UNIT NORMALS",
    ]
    return [f"TEETH = HEADER / {len(text)}", *text]


def _sequences(record: Ground) -> list[str]:
    points, lobe = measuring_points(record)
    n = points.normal
    z = np.full(n.shape, 0.5 * record.drive.disc_width)
    rows = np.round(np.stack([*points.xy.T, z, n.real, n.imag, np.zeros_like(z)], axis=-1), 9) + 0.0
    lines: list[str] = []
    for at in range(1, record.profile.trochoid.lobes + 1):
        values = rows[lobe == at]
        words = [f"{len(values)}", *(f"{value:.9f}" for value in values.ravel().tolist())]
        lines += _filled(f"LOBE{at:04d} = MDI / ", words)
    return lines


def _filled(line: str, words: list[str]) -> list[str]:
    """A statement over as many lines as it takes, broken after commas."""
    lines = []
    for position, word in enumerate(words):
        piece = word if position == len(words) - 1 else word + ","
        if len(line) + len(piece) > _WIDTH:
            lines.append(line)
            line = ""
        line += piece
    return [*lines, line]
