"""Parts common to all reports: verdict, meaning, tables, pictures, files, terms; HTML, PDF, text and JSON."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from cycloid_profile._display import FigureRow, figure_text, is_number
from cycloid_profile.articles import PlainTable
from cycloid_profile.language import ENGLISH, chosen_language, translated
from cycloid_profile.report.terms import explained
from cycloid_profile.units import ARCMIN, UM

if TYPE_CHECKING:
    from jinja2 import Environment

REPORT = "report.html"
PLOTS = "plots"
_LONG, _SHORT = 24, 12  # characters of cells that fold, and that never do
# Text between tags, and what is none: pictures, style, links to files, tags.
_TEXT = re.compile(r"<(?P<kept>svg|style|a)\b.*?</(?P=kept)>|<[^>]*>|(?P<text>[^<]*[^<\s][^<]*)", re.DOTALL)
ARM = 100.0  # mm, an arm on the output at whose end an angle is shown as a length


class Verdict(NamedTuple):
    """The verdict of a report in one sentence, and its colour."""

    sentence: str
    kind: Literal["good", "found", "failed"]


class Picture(NamedTuple):
    """A picture of a report: file without ending, caption, and the SVG element."""

    stem: str
    caption: str
    svg: str


def picture(folder: Path, stem: str, caption: str) -> Picture:
    """The picture ``stem`` of a report in ``folder``, such as plots/accuracy, from its SVG file."""
    return Picture(stem, caption, inline_svg(folder / f"{stem}.svg", Path(stem).name))


def render(
    template: str,
    folder: Path,
    name: str,
    title: str,
    *,
    also: Sequence[str] = (),
    notes: Mapping[str, str] = {},
    pictures: Sequence[Picture] = (),
    **values: Any,
) -> str:
    """HTML text of a report from a template of ``report/templates``.

    It links every file in ``folder`` and those of ``also``, with their ``notes``. ``name`` of the drive, ``title`` of
    the report; ``values`` are those of the template, ``verdict``, ``subject`` and ``meaning`` always.
    Raises ``jinja2.UndefinedError`` for a missing value.
    """
    written = sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
    drawn = {f"{one.stem}.{ending}" for one in pictures for ending in ("png", "svg")} & set(written)
    files = [(file, notes.get(file, "")) for file in (*written, *also) if file not in drawn]
    text = _environment().get_template(template)
    page = translated_page(text.render(name=name, pictures=pictures, drawn=drawn, files=files, **values))
    body, terms = explained(page)
    return (
        _environment()
        .get_template("page.html.j2")
        .render(
            name=name,
            title=translated(title),
            body=body,
            terms=terms,
            language=chosen_language(),
            heading=translated("Terms"),
        )
    )


def translated_page(page: str) -> str:
    """HTML text in the chosen language; pictures and tags stay as they are."""
    if chosen_language() == ENGLISH:
        return page
    return _TEXT.sub(
        lambda text: html.escape(translated(html.unescape(text[0])), quote=False) if text["text"] else text[0], page
    )


def write_report(folder: Path, file: str, html: str, pdf: bool = False) -> None:
    """Write a report as HTML and, if ``pdf``, as PDF of the same name; raises as ``require_pdf``."""
    write_text(folder / file, html)
    if pdf:
        from cycloid_profile.report.pdf import write_pdf

        write_pdf(html, folder / pdf_name(file))


def pdf_name(file: str) -> str:
    """Name of the PDF of a report."""
    return str(Path(file).with_suffix(".pdf"))


def at_an_arm(angle_arcmin: float) -> str:
    """An angle in degrees, and the length that it is at the end of an arm of 100 mm."""
    length = abs(angle_arcmin) * ARCMIN * ARM
    shown = figure_text(length, "mm", 3) if length >= 0.1 else figure_text(length / UM, "µm", 3)
    return f"{figure_text(angle_arcmin / 60.0, '°', 3)}, {shown} at the end of a {ARM:g} mm arm on the output"


def figure_table(
    title: str, rows: Sequence[FigureRow], columns: Sequence[Mapping[str, Any]], heads: Sequence[str] = (),
    digits: int = 4, note: str = "",
) -> PlainTable:  # fmt: skip
    """Table of key figures with their units; columns of identical cells become one."""
    merged = merged_columns(rows, columns, heads or ("",) * len(columns), digits)
    notes = [row.note for row in rows]
    found = [found for _, found in merged]
    cells = [[row.label for row in rows], *found, [row.unit for row in rows], *([notes] if any(notes) else [])]
    named = ("", *(head for head, _ in merged), "unit", *([""] if any(notes) else []))
    return PlainTable(
        title, named if any(heads) else ("",) * len(cells), tuple(zip(*map(tuple, cells), strict=True)), note
    )


def merged_columns(
    rows: Sequence[FigureRow], columns: Sequence[Mapping[str, Any]], heads: Sequence[str], digits: int = 4
) -> list[tuple[str, tuple[str, ...]]]:
    """Head and cells of each column; columns of identical cells become one, "a and b"."""
    merged: dict[tuple[str, ...], list[str]] = {}
    for column, head in zip(columns, heads, strict=True):
        merged.setdefault(tuple(figure_text(column[row.key], digits=digits) for row in rows), []).append(head)
    return [(" and ".join(same), cells) for cells, same in merged.items()]


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


def _environment() -> Environment:
    """Templates of ``report/templates``; an undefined name in one is an error."""
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("cycloid_profile", "report/templates"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters["figures"] = lambda value, digits=4: figure_text(value, digits=digits)
    environment.filters["column_classes"] = _column_classes
    environment.filters["sentence"] = lambda text: text[:1].upper() + text[1:]
    return environment


def _column_classes(table: PlainTable) -> list[str]:
    """CSS class of each column: ``n`` of numbers, flush right and never the first; ``t`` of long texts, which fold;
    ``s`` of short ones, such as units, which do not; else none.
    """
    classes = []
    for at, cells in enumerate(zip(*table.rows, strict=True) if table.rows else [()] * len(table.head)):
        longest = max(map(len, cells), default=0)
        numbers = at > 0 and any(cells) and all(map(is_number, cells))
        classes.append("n" if numbers else "t" if longest > _LONG else "s" if longest <= _SHORT else "")
    return classes
