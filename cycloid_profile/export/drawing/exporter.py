"""A workshop drawing of the disc on A3: DXF at true size, and SVG and PDF at the size of the paper."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from pathlib import Path

from cycloid_profile.design import DesignRecord
from cycloid_profile.errors import ExportError
from cycloid_profile.export.curves import deviation_both_ways, fitted_splines, joined
from cycloid_profile.export.drawing._annotation import draw_frame, draw_notes, draw_table, draw_title
from cycloid_profile.export.drawing._detail import detail_scale, draw_detail, draw_removal
from cycloid_profile.export.drawing._sheet import Sheet, new_sheet, polar, print_drawing
from cycloid_profile.export.drawing._symbols import Roughness
from cycloid_profile.export.drawing._text import font_notes
from cycloid_profile.export.drawing._tolerances import tolerances
from cycloid_profile.export.drawing._tooth_data import notes, title_cells, tooth_data
from cycloid_profile.export.drawing._views import ViewLayout, draw_front, draw_section, label_front, label_section
from cycloid_profile.export.dxf import read_dxf_profile, repeatable_bytes, save
from cycloid_profile.export.writing import WrittenFile
from cycloid_profile.spec import format_spec

SCALES = tuple(factor * 10.0**power for power in range(-3, 4) for factor in (1.0, 2.0, 5.0))  # ISO 5455
_DEGREE = 3
_LARGEST_RADIUS, _WIDEST_SECTION = 68.0, 36.0  # mm of paper
_LEADERS, _BETWEEN = 66.0, 20.0
_AXIS = 200.0


@dataclass(frozen=True, slots=True)
class DrawingExporter:
    """Writes ``drawing.dxf``, ``drawing.svg`` and ``drawing.pdf``."""

    format: str = "drawing"
    stem: str = "drawing"

    @property
    def filenames(self) -> tuple[str, ...]:
        """See ``Exporter.filenames``."""
        return tuple(f"{self.stem}.{kind}" for kind in ("dxf", "svg", "pdf"))

    def write(self, record: DesignRecord, folder: Path) -> tuple[WrittenFile, ...]:
        """Draw the sheet, write the files, and read the tooth back from the DXF.

        Raises ``ExportError`` if no standard scale fits the sheet, or the DXF fails its audit.
        """
        tolerance = record.spec.export.chord_tolerance
        paths = [folder / name for name in self.filenames]
        with repeatable_bytes():
            sheet, centre = draw_sheet(record)
            save(sheet.doc, paths[0])
            print_drawing(sheet.doc, sheet.unit, paths[1:])
        spans, entities = read_dxf_profile(paths[0])
        # From the sheet, where root 1 is at the top, to the disc frame.
        found = deviation_both_ways(record.profile, (spans - centre) / 1j)
        return (
            WrittenFile(
                self.filenames[0],
                self.format,
                tolerance,
                found,
                "ezdxf, audited",
                entities,
                notes=font_notes(sheet.texts),
            ),
            *(WrittenFile(name, self.format) for name in self.filenames[1:]),
        )


def draw_sheet(record: DesignRecord) -> tuple[Sheet, complex]:
    """The sheet, and the disc's centre in its model space [mm].

    Raises ``ExportError`` if no standard scale fits the sheet.
    """
    limits = tolerances(record)
    scale = _scale(record)
    sheet = new_sheet(1.0 / scale)
    radius = record.outline.tip_radius * scale
    centre = complex(_LEADERS + radius, _AXIS)
    layout = ViewLayout(centre, radius, centre.real + radius + _BETWEEN)
    curve = joined(fitted_splines(record, _DEGREE))
    digest = hashlib.sha256(format_spec(record.spec).encode("utf-8")).hexdigest()
    enlarged = detail_scale(record, SCALES)
    # Fixed places first; labels then find theirs.
    draw_frame(sheet)
    fields = record.spec.export.drawing
    surfaces = Roughness(fields.tooth_roughness_ra_um), Roughness(fields.roughness_ra_um)
    draw_title(sheet, title_cells(record, scale_text(scale)), *surfaces)
    draw_table(sheet, tooth_data(record, limits), 410 + 287j, 120.0)
    draw_notes(sheet, notes(record, limits, digest), 292 + 106j, 114.0)
    draw_removal(sheet, record, 238 + 72j)
    draw_front(sheet, record, curve, layout)
    _mark_detail(sheet, record, layout)
    draw_section(sheet, record, layout)
    draw_detail(sheet, record, limits, 110 + 60j, enlarged, scale_text(enlarged))
    label_section(sheet, record, limits, layout)
    label_front(sheet, record, limits, layout)
    return sheet, complex(*sheet.at(centre))


def scale_text(scale: float) -> str:
    """A scale in the form of ISO 5455, such as 5:1 or 1:2."""
    return f"{scale:g}:1" if scale >= 1.0 else f"1:{1.0 / scale:g}"


def _scale(record: DesignRecord) -> float:
    radius, width = record.outline.tip_radius, record.drive.disc_width
    fitting = [s for s in SCALES if s * radius <= _LARGEST_RADIUS and s * width <= _WIDEST_SECTION]
    if not fitting:
        raise ExportError(
            "drawing", f"of a disc of {2.0 * radius:g} × {width:g} mm", "fits A3 at no standard scale",
            "leave the format drawing out", " ",
        )  # fmt: skip
    return max(fitting)


def _mark_detail(sheet: Sheet, record: DesignRecord, layout: ViewLayout) -> None:
    """A thin circle with the letter Z round a tooth in the upper right of the front view."""
    lobes, outline = record.profile.trochoid.lobes, record.outline
    # Tips lie half a pitch from root 1, which is at the top.
    lobe = round(40.0 / (360.0 / lobes))
    angle = 90.0 - (lobe + 0.5) * 360.0 / lobes
    size = min(max(3.0, 1.1 * layout.radius * math.sin(math.pi / lobes)), 0.3 * layout.radius)
    middle = layout.centre + polar(0.5 * (outline.root_radius + outline.tip_radius) / sheet.unit, angle)
    sheet.circle(middle, size)
    sheet.text(middle + polar(size + 2.0, angle) - 1.0j, "Z", 3.5)
