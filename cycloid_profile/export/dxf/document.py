"""DXF documents: units, layers, polylines, reference lines, and reproducible bytes."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.export.curves import ProfileSource
from cycloid_profile.export.writing import dxf_text, read_back_error
from cycloid_profile.geometry import Contour, Line

VERSION = "R2010"
_MILLIMETRES = 4
_TEXT_PER_RADIUS = 1.0 / 30.0  # legible where the whole disc fills a screen

# Strokes and gaps in mm: long dash, gap, short dash, gap. LibreCAD draws the names it knows, others continuous.
LINETYPES = {"CENTER": (12.0, -2.0, 1.0, -2.0), "DASHED": (4.0, -1.5), "DIVIDE": (12.0, -1.5, 2.0, -1.5, 2.0, -1.5)}
# Of coordinates [mm], and of bulges, which multiply them.
_DECIMALS, _BULGE_DECIMALS = 9, 13


@dataclass(frozen=True, slots=True)
class Layer:
    """A layer: colour index, line type and line width in 1/100 mm."""

    name: str
    colour: int
    linetype: str = "CONTINUOUS"
    lineweight: int = 25


LAYERS = (
    Layer("PROFILE", 7, lineweight=50),
    Layer("PITCH", 3, "CENTER"),
    Layer("HOLES", 5, lineweight=50),
    Layer("CENTRE", 1, "CENTER"),
    Layer("PINS", 8, "DIVIDE"),
    Layer("TEXT", 2),
)


def new_document(layers: tuple[Layer, ...] = LAYERS, line_scale: float = 1.0) -> Any:
    """An empty document in millimetres with its layers; ``line_scale`` stretches the line types."""
    import ezdxf

    doc = ezdxf.new(VERSION, units=_MILLIMETRES)
    doc.header["$MEASUREMENT"] = 1
    doc.header["$LTSCALE"] = line_scale
    for name, strokes in LINETYPES.items():
        doc.linetypes.add(name, [sum(abs(stroke) for stroke in strokes), *strokes])
    for layer in layers:
        doc.layers.add(layer.name, color=layer.colour, linetype=layer.linetype, lineweight=layer.lineweight)
    return doc


def save(doc: Any, path: Path) -> None:
    """Write the document."""
    # ezdxf adds the classes from a set, in an order that changes between runs.
    for dxf_type in sorted(doc.entitydb.dxf_types_in_use()):
        doc.classes.add_class(dxf_type)
    doc.saveas(path)


@contextmanager
def repeatable_bytes() -> Iterator[None]:
    """Omit dates and random numbers, so that equal input gives equal bytes."""
    from ezdxf import options

    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before


@contextmanager
def new_dxf(path: Path) -> Iterator[Any]:
    """Model space of a new document that is saved to ``path`` at the end, with repeatable bytes."""
    with repeatable_bytes():
        doc = new_document()
        yield doc.modelspace()
        save(doc, path)


def audited(path: Path) -> Any:
    """The document read back; raises ``ExportError`` where ezdxf's audit finds an error."""
    import ezdxf

    doc = ezdxf.readfile(path)
    faults = doc.audit().errors
    if faults:
        finding = f"read back with {len(faults)} errors, the first '{faults[0].message}'"
        raise read_back_error("DXF file", path, finding)
    return doc


def layer_counts(doc: Any) -> dict[str, int]:
    """Number of entities on each layer of the model space that holds any."""
    found = [entity.dxf.layer for entity in doc.modelspace()]
    return {layer.name: found.count(layer.name) for layer in LAYERS if layer.name in found}


def draw_contour(space: Any, contour: Contour, layer: str = "HOLES", shift: complex = 0j) -> None:
    """Lines, arcs and circles of an opening, translated by ``shift`` [mm]."""
    on_layer = {"dxfattribs": {"layer": layer}}
    for segment in contour.segments:
        if isinstance(segment, Line):
            space.add_line(xy(segment.start + shift), xy(segment.end + shift), **on_layer)
        elif segment.full_circle:
            space.add_circle(xy(segment.centre + shift), segment.radius, **on_layer)
        else:
            low, high = sorted((math.degrees(segment.from_angle), math.degrees(segment.to_angle)))
            space.add_arc(xy(segment.centre + shift), segment.radius, low, high, **on_layer)


def draw_reference(space: Any, record: ProfileSource, note: str) -> None:
    """Openings, axes, pitch circle, pins with the crank at φ = 0, and the notes below the disc."""
    trochoid, outline = record.drive.trochoid, record.outline
    a, tip = trochoid.eccentricity, outline.tip_radius
    for contour in outline.contours:
        draw_contour(space, contour)
    reach = 1.05 * tip
    for end in (complex(reach, 0.0), complex(0.0, reach)):
        space.add_line(xy(-end), xy(end), dxfattribs={"layer": "CENTRE"})
    for radius in sorted({round(abs(hole.centre), 9) for hole in outline.holes} - {0.0}):
        space.add_circle((0.0, 0.0), radius, dxfattribs={"layer": "CENTRE"})
    space.add_circle((0.0, 0.0), trochoid.longest_lever, dxfattribs={"layer": "PITCH"})
    for k in range(trochoid.pins):
        # With φ = 0 the disc's centre lies at +a from that of the pin circle.
        centre = cmath.rect(trochoid.pin_circle_radius, 2.0 * math.pi * k / trochoid.pins) - a
        at = (round(centre.real, 9), round(centre.imag, 9))
        space.add_circle(at, record.drive.pin_radius, dxfattribs={"layer": "PINS"})
    draw_notes(space, record, note)


def draw_notes(space: Any, record: ProfileSource, note: str) -> None:
    """Name and numbers of the drive below the disc, and ``note``."""
    trochoid, tip = record.drive.trochoid, record.outline.tip_radius
    height = tip * _TEXT_PER_RADIUS
    lowest = -trochoid.pin_circle_radius - record.drive.pin_radius
    lines = (
        dxf_text(record.spec.name),
        f"LOBES {trochoid.lobes}  PINS {trochoid.pins}  PIN CIRCLE R {trochoid.pin_circle_radius:g}  "
        f"PIN R {record.drive.pin_radius:g}  ECCENTRICITY {trochoid.eccentricity:g}  MM",
        f"PITCH CIRCLE R {trochoid.longest_lever:g}  {note}",
    )
    for i, line in enumerate(lines):
        at = (-tip, lowest - (2.0 + 1.8 * i) * height)
        space.add_text(line, height=height, dxfattribs={"layer": "TEXT", "insert": at})


def xy(point: complex) -> tuple[float, float]:
    """Coordinates of x + iy."""
    return point.real, point.imag


def add_polyline(
    space: Any, points: ComplexArray, bulge: FloatArray | None = None, layer: str = "PROFILE", closed: bool = True
) -> Any:
    """One LWPOLYLINE through ``points``, complex, shape (n,) [mm]; the entity.

    ``bulge``, shape (n,), is tan(θ/4) of the arc after each point, θ its angle, positive to the left; None for
    straight segments.
    """
    # Defined here, so that ezdxf is imported only when a file is written.
    from ezdxf.entities.lwpolyline import LWPolylinePoints

    class Vertices(LWPolylinePoints):  # type: ignore[misc]
        """Vertices formatted in one pass: tag by tag ezdxf takes four times as long."""

        def dxftags(self) -> list[_FormattedTags]:
            x, y, _, _, bulges = self.values.T.tolist()
            if any(bulges):
                lines = [f" 10\n{a!r}\n 20\n{b!r}\n 42\n{c!r}\n" for a, b, c in zip(x, y, bulges, strict=True)]
            else:
                lines = [f" 10\n{a!r}\n 20\n{b!r}\n" for a, b in zip(x, y, strict=True)]
            return [_FormattedTags("".join(lines))]

    vertices = Vertices()
    rows = np.zeros((len(points), Vertices.VERTEX_SIZE))
    # Adding zero turns −0.0 into 0.0.
    rows[:, 0], rows[:, 1] = np.round(points.real, _DECIMALS) + 0.0, np.round(points.imag, _DECIMALS) + 0.0
    if bulge is not None:
        rows[:, 4] = np.round(bulge, _BULGE_DECIMALS) + 0.0
    # All at once: appending vertex by vertex copies the array each time.
    vertices.set(rows)
    polyline = space.add_lwpolyline([], close=closed, dxfattribs={"layer": layer})
    polyline.lwpoints = vertices
    return polyline


def write_polyline(path: Path, points: ComplexArray, bulge: FloatArray | None = None) -> None:
    """A DXF with one closed LWPOLYLINE on layer PROFILE; see ``add_polyline``."""
    with new_dxf(path) as space:
        add_polyline(space, points, bulge)


class _FormattedTags:
    """DXF tags formatted as text."""

    def __init__(self, text: str) -> None:
        self.text = text

    def dxfstr(self) -> str:
        """The text."""
        return self.text
