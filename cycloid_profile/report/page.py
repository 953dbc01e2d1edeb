"""What every report page is made with: its template, and pictures put into it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from cycloid_profile.design.summary import shown

if TYPE_CHECKING:
    from jinja2 import Template


def template(name: str) -> Template:
    """A template of this folder; a name it does not know is an error."""
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("cycloid_profile", "report"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters["figures"] = shown
    return environment.get_template(name)


def inline_svg(svg: Path, prefix: str) -> str:
    """The SVG element alone, its ids made unique so that several fit on one page."""
    text = svg.read_text(encoding="utf-8")
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'\bid="', f'id="{prefix}-', text)
    return re.sub(r'(url\(#|href="#)', rf"\g<1>{prefix}-", text)
