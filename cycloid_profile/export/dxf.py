"""DXF R2010: the tooth as one cubic spline from control vertices, holes and axes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile.arrays import ComplexArray
from cycloid_profile.design.record import DesignRecord
from cycloid_profile.errors import ExportError
from cycloid_profile.export.deviation import deviation
from cycloid_profile.export.refine import FIT_SHARE
from cycloid_profile.export.spline import disc_splines, inside_spans, joined
from cycloid_profile.export.written import WrittenFile
from cycloid_profile.geometry.contour import Contour, Line
from cycloid_profile.units import UM

_DEGREE = 3  # LibreCAD draws no higher degree
_CHECKS_PER_SPAN = 5
_MILLIMETRES = 4
LAYERS = {"PROFILE": 7, "HOLES": 5, "CENTRE": 1}


@dataclass(frozen=True, slots=True)
class DxfExporter:
    """Writes ``profile.dxf``."""

    format: str = "dxf"
    filename: str = "profile.dxf"

    @property
    def filenames(self) -> tuple[str, ...]:
        """See ``Exporter.filenames``."""
        return (self.filename,)

    def write(self, record: DesignRecord, folder: Path) -> tuple[WrittenFile, ...]:
        """Write, audit and read back. Raises ``ExportError`` if the file does not pass its own audit."""
        import ezdxf

        tolerance = record.spec.export.chord_tolerance_um * UM
        curve = joined(disc_splines(record.profile, _DEGREE, FIT_SHARE * tolerance))
        path = folder / self.filename
        with _repeatable_bytes():
            doc = ezdxf.new("R2010", units=_MILLIMETRES)
            space = doc.modelspace()
            for name, colour in LAYERS.items():
                doc.layers.add(name, color=colour)
            spline = space.add_spline(degree=_DEGREE, dxfattribs={"layer": "PROFILE"})
            # The closed flag stays off although the curve closes: several readers drop flagged splines.
            spline.control_points = [(p.real, p.imag, 0.0) for p in curve.control_points.tolist()]
            spline.knots = curve.knots.tolist()
            for contour in record.outline.contours:
                _draw(space, contour)
            reach = 1.05 * record.outline.tip_radius
            for end in (complex(reach, 0.0), complex(0.0, reach)):
                space.add_line((-end.real, -end.imag), (end.real, end.imag), dxfattribs={"layer": "CENTRE"})
            # ezdxf adds these from a set, in an order that changes from run to run.
            for dxf_type in sorted(doc.entitydb.dxf_types_in_use()):
                doc.classes.add_class(dxf_type)
            doc.saveas(path)
        points, entities = read_dxf_profile(path)
        found = deviation(record.profile, points)
        return (WrittenFile(self.filename, self.format, tolerance, found, "ezdxf, audited", entities),)


def _draw(space: Any, contour: Contour) -> None:
    """Lines, arcs and circles of an opening."""
    on_layer = {"dxfattribs": {"layer": "HOLES"}}
    for segment in contour.segments:
        if isinstance(segment, Line):
            space.add_line(_xy(segment.start), _xy(segment.end), **on_layer)
        elif segment.whole:
            space.add_circle(_xy(segment.centre), segment.radius, **on_layer)
        else:
            low, high = sorted((math.degrees(segment.from_angle), math.degrees(segment.to_angle)))
            space.add_arc(_xy(segment.centre), segment.radius, low, high, **on_layer)


def _xy(point: complex) -> tuple[float, float]:
    return point.real, point.imag


def read_dxf_profile(path: Path) -> tuple[ComplexArray, dict[str, int]]:
    """Dense points of the spline on layer PROFILE [mm], and entity counts by layer.

    Raises
    ------
    ExportError
        If the audit finds an error, or there is not exactly one closed curve on the layer.
    """
    import ezdxf

    doc = ezdxf.readfile(path)
    faults = doc.audit().errors
    splines: list[Any] = list(doc.modelspace().query('SPLINE[layer=="PROFILE"]'))
    if faults or len(splines) != 1:
        raise ExportError(
            "DXF file",
            f"'{path.name}'",
            f"read back with {len(faults)} errors and {len(splines)} profile curves",
            "report this as a defect",
            " ",
        )
    tool = splines[0].construction_tool()
    parameters = inside_spans(np.array(tool.knots()), _CHECKS_PER_SPAN)
    xyz = np.array([tuple(point) for point in tool.points(parameters.tolist())])
    points: ComplexArray = xyz[:, 0] + 1j * xyz[:, 1]
    first, last = splines[0].control_points[0], splines[0].control_points[-1]
    if math.dist(first, last) > 1e-9:
        raise ExportError("DXF curve", f"'{path.name}'", "does not close", "report this as a defect", " ")
    layers = [entity.dxf.layer for entity in doc.modelspace()]
    entities = {name: layers.count(name) for name in LAYERS}
    return points, {**entities, "control_points": len(splines[0].control_points)}


@contextmanager
def _repeatable_bytes() -> Iterator[None]:
    """No dates and random numbers in the file, so that equal input gives equal bytes."""
    from ezdxf import options

    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before
