"""Front view and section of the disc with dimensions; root 1 is at the top of the sheet."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.design import DesignRecord
from cycloid_profile.export.curves import SplinePiece
from cycloid_profile.export.drawing._annotation import datum, section_mark, tolerance_frames
from cycloid_profile.export.drawing._sheet import Sheet, polar
from cycloid_profile.export.dxf import add_spline
from cycloid_profile.geometry import Arc, Contour
from cycloid_profile.spec.model import DrawingSpec
from cycloid_profile.units import UM

_UPRIGHT = 0.5 * math.pi
_CHORDS = 1e-3  # mm, of openings where they are cut
_LEADER_STEP = 17.0
_DIMENSION_STEP = 8.0


@dataclass(frozen=True, slots=True)
class ViewLayout:
    """Layout of the views: centre and radius of the front view, left face of the section [mm of paper]."""

    centre: complex
    radius: float
    section_left: float


def draw_front(sheet: Sheet, record: DesignRecord, fields: DrawingSpec, curve: SplinePiece, layout: ViewLayout) -> None:
    """The disc seen along its axis: tooth, openings, pitch circle, centre lines, leaders to the openings."""
    centre, outline = layout.centre, record.outline
    moved = curve.control_points * 1j + complex(*sheet.at(centre))
    add_spline(sheet.space, replace(curve, control_points=moved))
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
    _leaders(sheet, record, fields, layout)
    section_mark(sheet, centre + 1j * (layout.radius + 5.0), 1j)
    section_mark(sheet, centre - 1j * (layout.radius + 5.0), -1j)


def _upright(contours: tuple[Contour, ...]) -> tuple[Contour, ...]:
    return tuple(contour.rotated(_UPRIGHT, contour.name) for contour in contours)


def _groups(contours: tuple[Contour, ...]) -> list[tuple[float, list[Arc]]]:
    """Equal round holes on one circle, with the radius of the circle [mm]."""
    off_centre = [arc for arc in (c.full_circle_arc for c in contours) if arc is not None and abs(arc.centre) > _CHORDS]

    def kind(arc: Arc) -> tuple[float, float]:
        return round(abs(arc.centre), 6), round(arc.radius, 6)

    grouped = itertools.groupby(sorted(off_centre, key=kind), kind)
    return [(circle_radius, list(found)) for (circle_radius, _), found in grouped]


def _leaders(sheet: Sheet, record: DesignRecord, fields: DrawingSpec, layout: ViewLayout) -> None:
    """Leaders on the left, stacked in the vertical order of their targets."""
    unit, centre, disc = sheet.unit, layout.centre, record.spec.disc
    notes: list[tuple[complex, list[str]]] = []
    for circle_radius, circles in _groups(_upright(record.outline.contours)):
        hole = min(circles, key=lambda arc: (round(arc.centre.real, 6), -arc.centre.imag))
        fit = "" if fields.hole_fit is None else f" {fields.hole_fit}"
        lines = [f"{len(circles)} × φ{2.0 * hole.radius:.6g}{fit}", f"on φ{2.0 * circle_radius:.6g}"]
        if fields.hole_position_um is not None:
            lines.append(f"position φ{fields.hole_position_um * UM:g} A")
        notes.append((centre + (hole.centre + hole.radius * polar(1.0, 160.0)) / unit, lines))
    if disc.windows is not None:
        w = disc.windows
        windows = [contour for contour in _upright(record.outline.contours) if contour.name.startswith("window")]
        edges = [complex(p) for window in windows for p in window.points(_CHORDS)]
        lines = [f"{w.count} × window {w.span_deg:g}°", f"R{w.inner_radius_mm:g} to R{w.outer_radius_mm:g}"]
        if w.corner_radius_mm is not None:
            lines.append(f"corners R{w.corner_radius_mm:g}")
        notes.append((centre + min(edges, key=lambda p: p.real) / unit, lines))
    if disc.keyway is not None:
        key = disc.keyway
        at = polar(key.depth_mm + _bore_radius(record), key.first_at_deg + 90.0)
        fit = "" if fields.keyway_fit is None else f" {fields.keyway_fit}"
        many = "" if key.count == 1 else f"{key.count} × "
        lines = [f"{many}keyway {key.width_mm:g}{fit}", f"height {2.0 * _bore_radius(record) + key.depth_mm:.6g}"]
        notes.append((centre + at / unit, lines))
    pitch = record.drive.trochoid.longest_lever
    notes.append((centre + polar(pitch / unit, 205.0), [f"φ{2.0 * pitch:.6g}", "pitch circle"]))
    notes.sort(key=lambda note: -note[0].imag)
    top = centre.imag + 0.5 * _LEADER_STEP * (len(notes) - 1)
    for i, (tip, lines) in enumerate(notes):
        knee = complex(centre.real - layout.radius - 7.0, top - _LEADER_STEP * i)
        sheet.leader(tip, knee, lines, to_left=True)


def _bore_radius(record: DesignRecord) -> float:
    """Radius of the bore's circle [mm], 0 without a bore."""
    bore = [contour for contour in record.outline.contours if contour.name == "bore"]
    arcs = [s for contour in bore for s in contour.segments if isinstance(s, Arc) and s.centre == 0j]
    return arcs[0].radius if arcs else 0.0


def draw_section(sheet: Sheet, record: DesignRecord, fields: DrawingSpec, layout: ViewLayout) -> None:
    """Section along the vertical axis; teeth are not hatched and are shown up to their tips (ISO 2203)."""
    unit, outline = sheet.unit, record.outline
    left, axis = layout.section_left, layout.centre.imag
    width = record.drive.disc_width / unit
    root, tip = outline.root_radius / unit, outline.tip_radius / unit
    sheet.box(complex(left, axis - tip), complex(width, 2.0 * tip), "PROFILE")
    edges = sorted([-root, *(y / unit for y in _crossings(outline.contours)), root])
    for low, high in itertools.pairwise(edges):
        if (edges.index(low) % 2) == 0:
            _hatched(sheet, complex(left, axis + low), complex(width, high - low))
    for y in edges:
        sheet.line(complex(left, axis + y), complex(left + width, axis + y), "PROFILE")
    pitch = record.drive.trochoid.longest_lever / unit
    for y, layer in ((0.0, "CENTRE"), (pitch, "PITCH"), (-pitch, "PITCH")):
        sheet.line(complex(left - 3.0, axis + y), complex(left + width + 3.0, axis + y), layer)
    sheet.text(complex(left + 0.5 * width, axis + tip + 17.0), "A–A", 3.5, "CENTER")
    _section_dimensions(sheet, record, fields, complex(left, axis), width)
    tolerance_frames(sheet, complex(left, axis - tip), fields)


def _section_dimensions(sheet: Sheet, record: DesignRecord, fields: DrawingSpec, corner: complex, width: float) -> None:
    unit, outline = sheet.unit, record.outline
    right = corner + width
    bore = _bore_radius(record)
    fit = "" if fields.bore_fit is None else f" {fields.bore_fit}"
    sizes = [(bore, f"φ<>{fit}"), (outline.root_radius, "φ<> root"), (outline.tip_radius, "φ<> tip")]
    for i, (radius, text) in enumerate((radius, text) for radius, text in sizes if radius > 0.0):
        at = right + _DIMENSION_STEP * (i + 1) + 1.0
        half = 1j * radius / unit
        sheet.dimension(right - half, right + half, at, 90.0, text)
        if radius == bore:
            datum(sheet, at - half, "A")
    tolerance = fields.width_tolerance_um
    text = "<>" if tolerance is None else f"<> ±{tolerance * UM:g}"
    top = corner + 1j * outline.tip_radius / unit
    sheet.dimension(top, top + width, top + 9.0j, 0.0, text)


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
