"""A contour program of lines and arcs (G1, G2, G3) along the tooth curve, and a small reader to check it."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cycloid_profile.export.biarc import Arcs, disc_arcs
from cycloid_profile.export.deviation import deviation
from cycloid_profile.export.disc_path import Ground
from cycloid_profile.export.refine import FIT_SHARE
from cycloid_profile.export.text import plain_name
from cycloid_profile.export.written import WrittenFile
from cycloid_profile.units import UM

DECIMALS = 5
# Ends and centres are rounded, each by up to half a unit in x and in y.
ROUNDING = math.sqrt(2.0) * 10.0**-DECIMALS
_LEAD_RADIUS = 3.0  # mm
_STRAIGHT = 1e-4  # 1/mm; flatter arcs are written as lines while they stay within a tenth of the tolerance
_WORD = re.compile(r"([A-Z])(-?\d+\.?\d*)")


@dataclass(frozen=True, slots=True)
class GcodeExporter:
    """Writes ``grinding.nc``: absolute XY in mm, arc centres incremental, clockwise round the disc."""

    format: str = "gcode"
    filename: str = "grinding.nc"

    def write(self, record: Ground, folder: Path) -> WrittenFile:
        """Write, read back and measure the contour between lead-in and lead-out."""
        tolerance = record.spec.export.chord_tolerance_um * UM
        arcs = _from_tip(disc_arcs(record.profile, FIT_SHARE * tolerance), record)
        path = folder / self.filename
        path.write_text("\n".join(_program(record, arcs, tolerance)) + "\n", encoding="ascii", newline="\n")
        contour, counts = read_gcode(path)
        # Lead-in and lead-out are a line and an arc each.
        inner = Arcs(contour.ends[2:-2], contour.bend[2:-2])
        return WrittenFile(
            self.filename,
            self.format,
            tolerance + ROUNDING,
            deviation(record.profile, inner.points()),
            "own reader of G1/G2/G3",
            counts,
        )


def read_gcode(path: Path) -> tuple[Arcs, dict[str, int]]:
    """Cutting moves of a program as a chain of arcs, and how many of each kind."""
    ends: list[complex] = []
    bend: list[float] = []
    counts = {"G1": 0, "G2": 0, "G3": 0}
    here = 0j
    for line in path.read_text(encoding="ascii").splitlines():
        words = dict(_WORD.findall(re.sub(r"\(.*?\)", "", line)))
        move = f"G{int(float(words['G']))}" if "G" in words else ""
        if "X" not in words and "Y" not in words:
            continue
        there = complex(float(words.get("X", here.real)), float(words.get("Y", here.imag)))
        if move in counts:
            ends = ends or [here]
            ends.append(there)
            radius = abs(complex(float(words.get("I", 0)), float(words.get("J", 0))))
            turn = {"G1": 0.0, "G2": -1.0, "G3": 1.0}[move]
            bend.append(turn / radius if radius else 0.0)
            counts[move] += 1
        here = there
    return Arcs(np.array(ends), np.array(bend)), counts


def _from_tip(arcs: Arcs, record: Ground) -> Arcs:
    """The same closed chain started at a tooth tip, where a lead-in does no harm."""
    radius = np.abs(arcs.ends[:-1])
    # Where lobes differ their arcs cannot be counted off: the highest tip of all is taken.
    reach = len(radius) // record.drive.trochoid.lobes + 1 if record.profile.lobes_alike else len(radius)
    start = int(np.argmax(radius[:reach]))
    ends = np.roll(arcs.ends[:-1], -start)
    return replace(arcs, ends=np.append(ends, ends[0]), bend=np.roll(arcs.bend, -start))


def _program(record: Ground, arcs: Arcs, tolerance: float) -> list[str]:
    start = complex(arcs.ends[0])
    outward = start / abs(start)
    # Quarter circles that meet the tip tangentially: the path runs clockwise, −i·outward.
    approach = start + _LEAD_RADIUS * (outward + 1j * outward)
    leave = start + _LEAD_RADIUS * (outward - 1j * outward)
    far_in, far_out = approach + _LEAD_RADIUS * outward, leave + _LEAD_RADIUS * outward
    lead_centre = start + _LEAD_RADIUS * outward
    feed = record.spec.export.feed_mm_per_min
    differing = [] if record.profile.lobes_alike else ["(LOBES DIFFER: CLAMP THE DISC WITH ITS LOBE 1 ON THE X AXIS)"]
    lines = [
        "%",
        f"(PROFILE OF {plain_name(record.spec.name).upper()})",
        "(PATH IS THE TOOTH CURVE ITSELF: NO WHEEL RADIUS IS ALLOWED FOR)",
        "(X Y IN MM FROM THE BORE AXIS, TOOTH ROOT 1 ON THE X AXIS, CLOCKWISE)",
        *differing,
        f"(ARCS WITHIN {tolerance / UM:.3f} MICROMETRE, {DECIMALS} DECIMALS)",
        "G17 G21 G40 G90 G91.1 G94",
        f"G0 {_xy(far_in)}",
        f"F{f'{feed:.3f}'.rstrip('0').rstrip('.')}",
        # A straight first move, because many controls refuse to start a radius compensation on an arc.
        f"G1 {_xy(approach)}",
    ]
    here = _rounded(approach)
    # The lead-in turns left onto the tip, seen from outside the disc.
    lines.append(_arc("G3", here, start, lead_centre))
    here = _rounded(start)
    for end, bend, centre in zip(arcs.ends[1:].tolist(), arcs.bend.tolist(), arcs.centres.tolist(), strict=True):
        sagitta = abs(bend) * abs(end - here) ** 2 / 8.0
        if abs(bend) < _STRAIGHT and sagitta < 0.1 * tolerance:
            lines.append(f"G1 {_xy(end)}")
        else:
            lines.append(_arc("G2" if bend < 0.0 else "G3", here, end, centre))
        here = _rounded(end)
    lines.append(_arc("G3", here, leave, lead_centre))
    lines.append(f"G1 {_xy(far_out)}")
    return [*lines, "M30", "%"]


def _arc(code: str, here: complex, end: complex, centre: complex) -> str:
    # The centre is given from the rounded start, which is where the machine stands.
    offset = centre - here
    return f"{code} {_xy(end)} I{_n(offset.real)} J{_n(offset.imag)}"


def _xy(z: complex) -> str:
    return f"X{_n(z.real)} Y{_n(z.imag)}"


def _n(value: float) -> str:
    return f"{round(value, DECIMALS) + 0.0:.{DECIMALS}f}"


def _rounded(z: complex) -> complex:
    return complex(round(z.real, DECIMALS), round(z.imag, DECIMALS))
