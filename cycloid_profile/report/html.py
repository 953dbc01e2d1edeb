"""The design as one self-contained HTML page: verdict, numbers, pictures, files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from cycloid_profile.design.record import DesignRecord
from cycloid_profile.design.summary import summary
from cycloid_profile.export.written import WrittenFile
from cycloid_profile.plot.gallery import pictures as pictures_of
from cycloid_profile.report.page import inline_svg, template
from cycloid_profile.units import UM

TEMPLATE = "design.html.j2"


def design_report(record: DesignRecord, written: list[WrittenFile], skipped: dict[str, str], plots: Path) -> str:
    """HTML text of the report; pictures are taken from the SVG files in ``plots``."""
    pictures = [
        (picture.caption, inline_svg(plots / f"{picture.name}.svg", picture.name)) for picture in pictures_of(record)
    ]
    return template(TEMPLATE).render(
        s=summary(record), record=record, files=[_row(file) for file in written], skipped=skipped, pictures=pictures
    )


def _row(file: WrittenFile) -> dict[str, Any]:
    deviation = None if file.deviation is None else file.deviation.largest / UM
    return {
        "name": file.name,
        "tolerance": None if file.tolerance is None else file.tolerance / UM,
        "deviation": deviation,
        "reader": file.reader,
    }
