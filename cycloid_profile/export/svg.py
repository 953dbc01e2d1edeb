"""Plain SVG of the disc at true size, for laser cutters."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from html import escape
from pathlib import Path

import numpy as np

from cycloid_profile.arrays import ComplexArray
from cycloid_profile.export.curves import ProfileSource, deviation_both_ways, fitted_splines
from cycloid_profile.export.writing import SingleFileExporter, WrittenFile, read_back_error
from cycloid_profile.geometry import Arc, Contour

_DECIMALS = 7  # of coordinates [mm]
_MARGIN = 1.0  # mm
_STROKE = 0.05  # mm; laser programs take thin strokes for cuts
_POINTS_PER_CURVE = 7  # measured when the file is read back


@dataclass(frozen=True)
class SvgExporter(SingleFileExporter[ProfileSource]):
    """Writes ``profile.svg``: the tooth as cubic Bézier curves and the openings, one unit a millimetre."""

    format: str = "svg"
    filename: str = "profile.svg"

    def write_file(self, source: ProfileSource, path: Path) -> WrittenFile:
        """Write and read back. Raises ``ExportError`` if the path read back is open."""
        curves = np.concatenate([spline.beziers() for spline in fitted_splines(source, 3)])
        paths = [_tooth(curves), *(_opening(contour) for contour in source.outline.contours)]
        half = source.outline.tip_radius + _MARGIN
        size = f'width="{2 * half:.4f}mm" height="{2 * half:.4f}mm"'
        box = f'viewBox="{-half:.4f} {-half:.4f} {2 * half:.4f} {2 * half:.4f}"'
        lines = [
            f'<svg xmlns="http://www.w3.org/2000/svg" version="1.1" {size} {box}>',
            f"<title>{escape(source.spec.name, quote=False)}</title>",
            f'<g fill="none" stroke="#000000" stroke-width="{_STROKE}">',
            *(f'<path d="{data}"/>' for data in paths),
            "</g>",
            "</svg>",
        ]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")
        back = read_svg_tooth(path)
        found = deviation_both_ways(source.profile, _points(back))
        entities = {"curves": len(back), "openings": len(paths) - 1}
        return self.measured(source.spec.export.chord_tolerance, found, "own reader of Bézier curves", entities)


def read_svg_tooth(path: Path) -> ComplexArray:
    """Control points of the Bézier curves of the first path, shape (curves, 4) [mm].

    Raises ``ExportError`` if there are none or they do not close.
    """
    data = re.search(r'<path d="M([^"]*)Z"/>', path.read_text(encoding="utf-8"))
    x, y = np.array(re.findall(r"-?\d+\.\d+", data[1] if data else ""), dtype=np.float64).reshape(-1, 2).T
    points = x - 1j * y
    if points.size < 4 or points[0] != points[-1]:
        raise read_back_error("SVG file", path, "read back without a closed tooth")
    rest = points[1:].reshape(-1, 3)
    return np.column_stack([np.append(points[0], rest[:-1, 2]), rest])


def _points(curves: ComplexArray) -> ComplexArray:
    t = np.linspace(0.0, 1.0, _POINTS_PER_CURVE)
    basis = np.stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
    points: ComplexArray = curves @ basis
    return points


def _tooth(curves: ComplexArray) -> str:
    return f"M{_xy(curves[0, 0])}\n" + "\n".join("C" + " ".join(map(_xy, row[1:])) for row in curves) + "\nZ"


def _opening(contour: Contour) -> str:
    data = [f"M{_xy(contour.segments[0].start)}"]
    for segment in contour.segments:
        if not isinstance(segment, Arc):
            data.append(f"L{_xy(segment.end)}")
            continue
        # Two halves, because an arc between equal ends is not drawn.
        for angle in (0.5 * (segment.from_angle + segment.to_angle), segment.to_angle):
            end = segment.centre + segment.radius * complex(math.cos(angle), math.sin(angle))
            # Anticlockwise with y upwards is sweep flag 0 with y downwards.
            data.append(f"A{segment.radius:.{_DECIMALS}f} {segment.radius:.{_DECIMALS}f} 0 0 "
                        f"{0 if segment.sweep > 0.0 else 1} {_xy(end)}")  # fmt: skip
    return "\n".join(data) + "\nZ"


def _xy(point: complex) -> str:
    """Coordinates with y downwards; adding zero turns −0.0 into 0.0."""
    x, y = round(point.real, _DECIMALS) + 0.0, round(-point.imag, _DECIMALS) + 0.0
    return f"{x:.{_DECIMALS}f} {y:.{_DECIMALS}f}"
