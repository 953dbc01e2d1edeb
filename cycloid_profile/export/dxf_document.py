"""What all DXF files have in common: units, layers, reference lines, and bytes that repeat."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cycloid_profile.design.record import DesignRecord
from cycloid_profile.errors import ExportError
from cycloid_profile.export.text import plain_name
from cycloid_profile.geometry.contour import Contour, Line

VERSION = "R2010"
_MILLIMETRES = 4
_TEXT_PER_RADIUS = 1.0 / 30.0

# Strokes and gaps in mm: long dash, gap, short dash, gap.
LINETYPES = {"CENTRE": (12.0, -2.0, 1.0, -2.0), "DASHED": (4.0, -1.5), "PHANTOM": (12.0, -1.5, 2.0, -1.5, 2.0, -1.5)}


@dataclass(frozen=True, slots=True)
class Layer:
    """A layer: colour index, line type and line width in 1/100 mm."""

    name: str
    colour: int
    linetype: str = "CONTINUOUS"
    lineweight: int = 25


LAYERS = (
    Layer("PROFILE", 7, lineweight=50),
    Layer("PITCH", 3, "CENTRE"),
    Layer("HOLES", 5, lineweight=50),
    Layer("CENTRE", 1, "CENTRE"),
    Layer("PINS", 8, "PHANTOM"),
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
    # ezdxf adds these from a set, in an order that changes from run to run.
    for dxf_type in sorted(doc.entitydb.dxf_types_in_use()):
        doc.classes.add_class(dxf_type)
    doc.saveas(path)


@contextmanager
def repeatable_bytes() -> Iterator[None]:
    """No dates and random numbers in the file, so that equal input gives equal bytes."""
    from ezdxf import options

    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before


def audited(path: Path) -> Any:
    """The document read back; raises ``ExportError`` where ezdxf's audit finds an error."""
    import ezdxf

    doc = ezdxf.readfile(path)
    faults = doc.audit().errors
    if faults:
        raise ExportError(
            "DXF file",
            f"'{path.name}'",
            f"read back with {len(faults)} errors, the first '{faults[0].message}'",
            "report this as a defect",
            " ",
        )
    return doc


def layer_counts(doc: Any) -> dict[str, int]:
    """Number of entities on each layer of the model space that holds any."""
    found = [entity.dxf.layer for entity in doc.modelspace()]
    return {layer.name: found.count(layer.name) for layer in LAYERS if layer.name in found}


def draw_contour(space: Any, contour: Contour, layer: str = "HOLES", shift: complex = 0j) -> None:
    """Lines, arcs and circles of an opening, moved by ``shift`` [mm]."""
    on_layer = {"dxfattribs": {"layer": layer}}
    for segment in contour.segments:
        if isinstance(segment, Line):
            space.add_line(xy(segment.start + shift), xy(segment.end + shift), **on_layer)
        elif segment.whole:
            space.add_circle(xy(segment.centre + shift), segment.radius, **on_layer)
        else:
            low, high = sorted((math.degrees(segment.from_angle), math.degrees(segment.to_angle)))
            space.add_arc(xy(segment.centre + shift), segment.radius, low, high, **on_layer)


def draw_reference(space: Any, record: DesignRecord, promise: str) -> None:
    """What is no edge of the disc: axes, pitch circle, the pins with the crank at φ = 0, and a note below the disc."""
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
    height = tip * _TEXT_PER_RADIUS
    lowest = -trochoid.pin_circle_radius - record.drive.pin_radius
    lines = (
        plain_name(record.spec.name),
        f"LOBES {trochoid.lobes}  PINS {trochoid.pins}  PIN CIRCLE R {trochoid.pin_circle_radius:g}  "
        f"PIN R {record.drive.pin_radius:g}  ECCENTRICITY {a:g}  MM",
        f"PITCH CIRCLE R {trochoid.longest_lever:g}  {promise}",
    )
    for i, line in enumerate(lines):
        at = (-tip, lowest - (2.0 + 1.8 * i) * height)
        space.add_text(line, height=height, dxfattribs={"layer": "TEXT", "insert": at})


def xy(point: complex) -> tuple[float, float]:
    """Coordinates of x + iy."""
    return point.real, point.imag
