"""Parts common to all reports: file names, templates, inline pictures, text and JSON files."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cycloid_profile._display import figure_text

if TYPE_CHECKING:
    from jinja2 import Template

REPORT = "report.html"
PLOTS = "plots"


def template(name: str) -> Template:
    """A template of ``report/templates``; an undefined name in it is an error."""
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("cycloid_profile", "report/templates"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters["figures"] = lambda value, digits=4: figure_text(value, digits=digits)
    return environment.get_template(name)


def inline_svg(svg: Path, prefix: str) -> str:
    """The SVG element of a file, its ids made unique by ``prefix`` so that several fit on one page."""
    text = svg.read_text(encoding="utf-8")
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'\bid="', f'id="{prefix}-', text)
    return re.sub(r'(url\(#|href="#)', rf"\g<1>{prefix}-", text)


def write_text(path: Path, text: str) -> None:
    """Write a text file, UTF-8 with line feeds on every system."""
    path.write_text(text, encoding="utf-8", newline="\n")


def json_text(value: Mapping[str, Any]) -> str:
    """One JSON object; NaN and infinity raise ``ValueError``."""
    return json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
