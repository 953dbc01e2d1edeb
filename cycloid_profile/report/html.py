"""The design as one self-contained HTML page: verdict, numbers, pictures, files."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from cycloid_profile.design.record import DesignRecord
from cycloid_profile.design.summary import shown, summary
from cycloid_profile.export.written import WrittenFile
from cycloid_profile.plot.gallery import PICTURES
from cycloid_profile.units import UM

TEMPLATE = "design.html.j2"


def design_report(record: DesignRecord, written: list[WrittenFile], skipped: dict[str, str], plots: Path) -> str:
    """HTML text of the report; pictures are taken from the SVG files in ``plots``."""
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("cycloid_profile", "report"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters["figures"] = shown
    pictures = [(picture.caption, inline_svg(plots / f"{picture.name}.svg", picture.name)) for picture in PICTURES]
    return environment.get_template(TEMPLATE).render(
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


def inline_svg(svg: Path, prefix: str) -> str:
    """The SVG element alone, its ids made unique so that several fit on one page."""
    text = svg.read_text(encoding="utf-8")
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'\bid="', f'id="{prefix}-', text)
    return re.sub(r'(url\(#|href="#)', rf"\g<1>{prefix}-", text)
