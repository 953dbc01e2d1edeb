"""Front view and section of the disc with dimensions; root 1 is at the top of the sheet."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.design import DesignRecord
from cycloid_profile.export.curves import SplinePiece
from cycloid_profile.export.drawing._sheet import Sheet, polar
from cycloid_profile.export.drawing._symbols import Datum, Frame, Row, Words, dimension, label
from cycloid_profile.export.drawing._tolerances import Tolerances
from cycloid_profile.export.dxf import add_spline
from cycloid_profile.export.inspection import (
    AXIS,
    DIRECTION,
    FACE,
    CircleDatum,
    DatumSystem,
    KeywayDatum,
    datum_system,
)
from cycloid_profile.geometry import Arc, Contour
from cycloid_profile.units import UM

_UPRIGHT = 0.5 * math.pi
_CHORDS = 1e-3  # mm, of openings where they are cut
_ANGLE = 3.5  # mm outside the tips, where the angle of the holes is dimensioned
_EXTENSION = 9.0  # mm, of the line of the upper face that holds datum A
_EVEN = 1e-9  # rad


@dataclass(frozen=True, slots=True)
class ViewLayout:
    """Layout of the views: centre and radius of the front view, left face of the section [mm of paper]."""

    centre: complex
    radius: float
    section_left: float


def draw_front(sheet: Sheet, record: DesignRecord, curve: SplinePiece, layout: ViewLayout) -> None:
    """The disc seen along its axis: tooth, openings, pitch circle, centre lines, cutting line, axis of hole 1."""
    centre, outline = layout.centre, record.outline
    moved = curve.control_points * 1j + complex(*sheet.at(centre))
    add_spline(sheet.space, replace(curve, control_points=moved))
    sheet.taken.round_view(centre, layout.radius + 1.0)
    for contour in _upright(outline.contours):
        sheet.contour(contour, centre)
    sheet.circle(centre, record.drive.trochoid.longest_lever / sheet.unit, "PITCH")
    reach = layout.radius + 4.0
    sheet.line(centre - reach, centre + reach, "CENTRE")
    sheet.line(centre - 1j * reach, centre + 1j * reach, "CENTRE")
    groups = _groups(_upright(outline.contours))
    for circle_radius in sorted({radius for radius, _ in groups}):
        sheet.circle(centre, circle_radius / sheet.unit, "CENTRE")
    for _, circles in groups:
        for hole in circles:
            out = hole.centre / abs(hole.centre) * (hole.radius + 2.0 * sheet.unit)
            sheet.line(centre + (hole.centre - out) / sheet.unit, centre + (hole.centre + out) / sheet.unit, "CENTRE")
    for side in (1j, -1j):
        _section_mark(sheet, centre + (layout.radius + 5.0) * side, side)


def _section_mark(sheet: Sheet, at: complex, outward: complex) -> None:
    """End of the cutting line D–D with the arrow of the viewing direction, to the right."""
    end = at + 7.0 * outward
    sheet.line(at, end, "TABLE")
    sheet.line(end - 9.0, end, "DIMENSIONS")
    sheet.arrow(end, -1.0)
    sheet.text(end - 12.0 - 1.7j, "D", 3.5, "CENTER")


def _upright(contours: tuple[Contour, ...]) -> tuple[Contour, ...]:
    return tuple(contour.rotated(_UPRIGHT, contour.name) for contour in contours)


def _groups(contours: tuple[Contour, ...]) -> list[tuple[float, list[Arc]]]:
    """Equal round holes on one circle, with the radius of the circle [mm]."""
    off_centre = [arc for arc in (c.full_circle_arc for c in contours) if arc is not None and abs(arc.centre) > _CHORDS]

    def kind(arc: Arc) -> tuple[float, float]:
        return round(abs(arc.centre), 6), round(arc.radius, 6)

    grouped = itertools.groupby(sorted(off_centre, key=kind), kind)
    return [(circle_radius, list(found)) for (circle_radius, _), found in grouped]


def label_front(sheet: Sheet, record: DesignRecord, limits: Tolerances, layout: ViewLayout) -> None:
    """Labels of the front view: datums B and C, holes and their angle, windows, keyway, pitch circle."""
    unit, centre = sheet.unit, layout.centre
    contours = _upright(record.outline.contours)
    datums = datum_system(record)
    _hole_angle(sheet, datums, limits, layout)
    found = [
        *_axis_label(record, datums, limits),
        *_hole_labels(record, contours, datums, limits),
        *_opening_labels(record, contours, datums),
    ]
    pitch = record.drive.trochoid.longest_lever
    found.append((polar(pitch, 205.0), [Frame((f"Ø{2.0 * pitch:.6g}",), "pitch circle")]))
    # From the top: neighbours then have their labels in the same order.
    for tip, rows in sorted(found, key=lambda one: (-round(one[0].imag, 6), round(one[0].real, 6))):
        label(sheet, centre + tip / unit, rows)


_Label = tuple[complex, list[Row]]


def _axis_label(record: DesignRecord, datums: DatumSystem, limits: Tolerances) -> list[_Label]:
    """Datum B with its size and its perpendicularity: the bore, or the circle through the roots."""
    fields, axis = record.spec.export.drawing, datums.axis
    fit = "" if fields.bore_fit is None else f" {fields.bore_fit}"
    size = f"Ø{2.0 * axis.radius:.6g}{fit}" if axis.opening else f"Ø{2.0 * axis.radius:.3f} root"
    tip = polar(axis.radius, 35.0) if axis.opening else 1j * axis.radius
    frame = Frame(("perpendicularity", f"Ø{limits.perpendicularity}", FACE))
    return [(tip, [Words(size), frame, Datum(AXIS)])]


def _hole_labels(
    record: DesignRecord, contours: tuple[Contour, ...], datums: DatumSystem, limits: Tolerances
) -> list[_Label]:
    """Sizes of equal holes, their exact circle and division, and the tolerance of their position."""
    fields = record.spec.export.drawing
    fit = "" if fields.hole_fit is None else f" {fields.hole_fit}"
    found: list[_Label] = []
    c = datums.direction
    if isinstance(c, CircleDatum):
        found.append((1j * c.centre + c.radius * polar(1.0, 20.0), [Words(c.name), Datum(DIRECTION)]))
    for circle_radius, circles in _groups(contours):
        hole = min(circles, key=lambda arc: (round(arc.centre.real, 6), -arc.centre.imag))
        rows: list[Row] = [
            Words(f"{len(circles)} × Ø{2.0 * hole.radius:.6g}{fit}"),
            Frame((f"Ø{2.0 * circle_radius:.6g}",)),
        ]
        if _evenly_spaced(circles):
            rows.append(Frame((f"{len(circles)} × {360.0 / len(circles):.6g}°",)))
        letters = datums.of_holes(arc.centre / 1j for arc in circles)
        rows.append(Frame(("position", f"Ø{limits.hole_position}", *letters)))
        found.append((hole.centre + hole.radius * polar(1.0, 160.0), rows))
    return found


def _evenly_spaced(circles: list[Arc]) -> bool:
    angles = np.sort(np.angle([arc.centre for arc in circles]))
    steps = np.diff(angles, append=angles[0] + 2.0 * math.pi)
    return len(circles) > 1 and bool(np.ptp(steps) < _EVEN)


def _opening_labels(record: DesignRecord, contours: tuple[Contour, ...], datums: DatumSystem) -> list[_Label]:
    """Windows and keyway."""
    disc, fields = record.spec.disc, record.spec.export.drawing
    found: list[_Label] = []
    if disc.windows is not None:
        w = disc.windows
        windows = [contour for contour in contours if contour.name.startswith("window")]
        edges = [complex(p) for window in windows for p in window.points(_CHORDS)]
        lines = [f"{w.count} × window {w.span_deg:g}°", f"R{w.inner_radius_mm:g} to R{w.outer_radius_mm:g}"]
        if w.corner_radius_mm is not None:
            lines.append(f"corners R{w.corner_radius_mm:g}")
        found.append((min(edges, key=lambda p: p.real), [Words(line) for line in lines]))
    if disc.keyway is not None:
        key = disc.keyway
        bore = datums.axis.radius
        at = polar(key.depth_mm + bore, key.first_at_deg + math.degrees(record.openings_turn) + 90.0)
        fit = "" if fields.keyway_fit is None else f" {fields.keyway_fit}"
        many = "" if key.count == 1 else f"{key.count} × "
        rows: list[Row] = [
            Words(f"{many}keyway {key.width_mm:g}{fit}"),
            Words(f"height {2.0 * bore + key.depth_mm:.6g}"),
        ]
        found.append((at, [*rows, Datum(DIRECTION)] if isinstance(datums.direction, KeywayDatum) else rows))
    return found


def _hole_angle(sheet: Sheet, datums: DatumSystem, limits: Tolerances, layout: ViewLayout) -> None:
    """Angle from the axis through root 1, which is upright, to the axis through datum C."""
    if datums.direction is None:
        return
    turn = round(math.degrees(datums.direction_angle), 6)
    radius = layout.radius + _ANGLE
    for angle in {0.0, turn}:
        sheet.line(layout.centre + polar(layout.radius - 4.0, 90.0 + angle),
                   layout.centre + polar(radius + 1.0, 90.0 + angle), "CENTRE")  # fmt: skip
    if turn:
        sheet.arc(layout.centre, radius, 90.0 + min(0.0, turn), 90.0 + max(0.0, turn), "DIMENSIONS")
        for angle, away in ((0.0, -turn), (turn, turn)):
            out = polar(1.0, 90.0 + angle)
            sheet.arrow(layout.centre + radius * out, math.copysign(1.0, away) * 1j * out)
    text = f"{abs(turn):.6g}° ±{limits.hole_angle_arcmin.in_unit('′')}"
    rows = [Words(text), Words(f"{DIRECTION} to axis of root 1")]
    label(sheet, layout.centre + polar(radius, 90.0 + 0.5 * turn), rows)


def draw_section(sheet: Sheet, record: DesignRecord, layout: ViewLayout) -> None:
    """Section along the vertical axis; teeth are not hatched and are shown up to their tips (ISO 2203)."""
    unit, outline = sheet.unit, record.outline
    left, axis = layout.section_left, layout.centre.imag
    width = record.drive.disc_width / unit
    root, tip = outline.root_radius / unit, outline.tip_radius / unit
    sheet.box(complex(left, axis - tip), complex(width, 2.0 * tip), "PROFILE")
    sheet.taken.view(complex(left, axis - tip), complex(width, 2.0 * tip))
    edges = sorted([-root, *(y / unit for y in _crossings(outline.contours)), root])
    for low, high in itertools.pairwise(edges):
        if (edges.index(low) % 2) == 0:
            _hatched(sheet, complex(left, axis + low), complex(width, high - low))
    for y in edges:
        sheet.line(complex(left, axis + y), complex(left + width, axis + y), "PROFILE")
    pitch = record.drive.trochoid.longest_lever / unit
    for y, layer in ((0.0, "CENTRE"), (pitch, "PITCH"), (-pitch, "PITCH")):
        sheet.line(complex(left - 3.0, axis + y), complex(left + width + 3.0, axis + y), layer)
    sheet.text(complex(left + 0.5 * width, axis + tip + 17.0), "D–D", 3.5, "CENTER")
    _section_dimensions(sheet, record, complex(left, axis), width)
    # The upper face is on the right: the section is seen from the left, in first angle.
    corner = complex(left + width, axis - tip)
    sheet.line(corner - 0.8j, corner - 1j * _EXTENSION, "DIMENSIONS")
    Datum(FACE).draw_on(sheet, corner - 1j * (_EXTENSION - 2.5), 1.0)


def _section_dimensions(sheet: Sheet, record: DesignRecord, corner: complex, width: float) -> None:
    """Root, tip and width."""
    outline, tolerance = record.outline, record.spec.export.drawing.width_tolerance_um
    right = corner + width
    for radius, name in ((outline.root_radius, "root"), (outline.tip_radius, "tip")):
        half = 1j * radius / sheet.unit
        dimension(sheet, right - half, right + half, 1.0, f"Ø{2.0 * radius:.3f} {name}")
    text = f"{record.drive.disc_width:.6g}" + ("" if tolerance is None else f" ±{tolerance * UM:g}")
    top = corner + 1j * outline.tip_radius / sheet.unit
    dimension(sheet, top, top + width, 1j, text)


def label_section(sheet: Sheet, record: DesignRecord, limits: Tolerances, layout: ViewLayout) -> None:
    """Parallelism of the lower face."""
    height = 0.5 * (layout.radius + record.outline.root_radius / sheet.unit)
    at = complex(layout.section_left, layout.centre.imag - height)
    label(sheet, at, [Frame(("parallelism", f"{limits.parallelism}", FACE))])


def _crossings(contours: tuple[Contour, ...]) -> list[float]:
    """Ordinates at which the edges of the openings cross the vertical axis [mm]."""
    found: list[float] = []
    for contour in contours:
        points = contour.rotated(_UPRIGHT, contour.name).points(_CHORDS)
        successor = np.roll(points, -1)
        across = (points.real < 0.0) != (successor.real < 0.0)
        a, b = points[across], successor[across]
        found += (a.imag - a.real * (b.imag - a.imag) / (b.real - a.real)).tolist()
    return found


def _hatched(sheet: Sheet, corner: complex, size: complex) -> None:
    hatch = sheet.space.add_hatch(dxfattribs={"layer": "HATCH"})
    hatch.set_pattern_fill("ANSI31", scale=0.8 * sheet.unit)
    w, h = size.real, 1j * size.imag
    hatch.paths.add_polyline_path([sheet.at(p) for p in (corner, corner + w, corner + w + h, corner + h)])
