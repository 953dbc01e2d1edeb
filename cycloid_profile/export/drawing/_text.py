"""Texts as outlines of letters, so that every program shows every script: fonts, widths, paths."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

FONT = "DejaVuSans.ttf"  # comes with matplotlib, under a free licence, so that prints are identical on every machine
_NARROW = 0.85
_FLAT = 0.02  # of the height of capitals, error of the outlines
_SLIT = 2e-4  # of the height of capitals
_HANGING = 0.3  # below the base line, in heights of capitals


def text_width(text: str, height: float) -> float:
    """Width of one line of text, ``height`` that of its capitals [mm of paper]."""
    return height * sum(_letter(letter)[1] for letter in shown(text))


def text_box(text: str, height: float) -> tuple[complex, complex]:
    """Lower left corner, relative to the start of the base line, and size of one line of text [mm of paper]."""
    return -1j * _HANGING * height, complex(text_width(text, height), (1.0 + 1.5 * _HANGING) * height)


def outlines(text: str, height: float) -> list[list[complex]]:
    """Polygons without holes that fill the letters of one line that starts at 0."""
    found, start = [], 0.0
    for letter in shown(text):
        polygons, width = _letter(letter)
        found += [[height * (start + point) for point in polygon] for polygon in polygons]
        start += width
    return found


@cache
def shown(text: str) -> str:
    """The text with code points in place of letters that no font has."""
    composed = unicodedata.normalize("NFC", text)
    return "".join(letter if _font_of(letter) else f" {_code(letter)}" for letter in composed).strip()


def font_notes(texts: Iterable[str]) -> tuple[str, ...]:
    """A sentence on the letters of some texts that are shown as code points."""
    letters = set(unicodedata.normalize("NFC", "".join(texts)))
    missing = sorted(letter for letter in letters if _font_of(letter) is None)
    if not missing:
        return ()
    codes = ", ".join(f"{letter} as {_code(letter)}" for letter in missing)
    return (f"the drawing shows {codes}: no font of this machine has them; install one, such as Noto Sans CJK",)


def _code(letter: str) -> str:
    return f"U+{ord(letter):04X}"


@cache
def _letter(letter: str) -> tuple[list[list[complex]], float]:
    """Polygons without holes of a letter, and its width, in heights of capitals."""
    from ezdxf.fonts import fonts

    font = fonts.make_font(_font_of(letter) or FONT, 1.0, _NARROW)
    strokes = [list(stroke.flattening(_FLAT, 2)) for stroke in font.text_path(letter).to_path().sub_paths()]
    # Between two others: blanks at an end have no width.
    width = font.text_width(f"H{letter}H") - font.text_width("HH")
    return _filled([points for points in strokes if len(points) > 2]), width


def _filled(strokes: Sequence[Sequence[Any]]) -> list[list[complex]]:
    """Polygons that fill the closed strokes of a letter, each hole opened by a slit.

    Strokes of a letter may overlap, and programs disagree on holes side by side, as in Ø.
    """
    import shapely

    rings = [shapely.LinearRing([(p.x, p.y) for p in points]) for points in strokes]
    if not rings:
        return []
    # Inner strokes run against the outer ones.
    outer = max(rings, key=lambda ring: float(shapely.Polygon(ring).area)).is_ccw
    solid, hollow = (
        shapely.union_all([shapely.Polygon(ring).buffer(0.0) for ring in rings if (ring.is_ccw == outer) == same])
        for same in (True, False)
    )
    found: list[list[complex]] = []
    for polygon in shapely.get_parts(solid.difference(hollow)):
        slits = [
            shapely.shortest_line(polygon.exterior, hole).buffer(_SLIT, cap_style="square")
            for hole in polygon.interiors
        ]
        open_ones = shapely.get_parts(polygon.difference(shapely.union_all(slits)))
        found += [[complex(*point) for point in one.exterior.coords] for one in open_ones]
    return found


@cache
def _font_of(letter: str) -> str | None:
    """File name of the first font with a letter, the own one before those of the system in the order of names."""
    from ezdxf.fonts import fonts
    from matplotlib.font_manager import findSystemFonts

    if ord(letter) in _letters(_own_fonts() / FONT):
        return FONT
    others = sorted((Path(path) for path in findSystemFonts()), key=lambda path: (path.name, str(path)))
    found = next((path for path in others if path.name != FONT and ord(letter) in _letters(path)), None)
    if found is None:
        return None
    fonts.font_manager.scan_folder(found.parent)
    # Again: the system may have other versions of the own fonts.
    fonts.font_manager.scan_folder(_own_fonts())
    return found.name


@cache
def _letters(path: Path) -> frozenset[int]:
    """Code points of the letters of a font file; none of one that cannot be read."""
    from matplotlib.ft2font import FT2Font

    try:
        return frozenset(FT2Font(str(path)).get_charmap())
    except (OSError, RuntimeError):
        return frozenset()


@cache
def _own_fonts() -> Path:
    """Folder of matplotlib's fonts, from now on known to ezdxf instead of other versions on the machine."""
    import matplotlib
    from ezdxf.fonts import fonts

    folder = Path(matplotlib.get_data_path()) / "fonts" / "ttf"
    fonts.font_manager.scan_folder(folder)
    return folder
