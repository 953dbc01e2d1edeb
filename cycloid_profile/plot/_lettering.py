"""Texts of a figure in the chosen language, in a font that has its letters."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from typing import TYPE_CHECKING, Any

from cycloid_profile.language import ENGLISH, chosen_language, translated

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Fonts of Linux, Windows and macOS with Chinese letters, the usual ones first.
FONTS = (
    "Noto Sans CJK SC", "Noto Sans SC", "Source Han Sans SC", "Source Han Sans CN", "Microsoft YaHei", "SimHei",
    "PingFang SC", "Hiragino Sans GB", "Heiti SC", "WenQuanYi Micro Hei", "WenQuanYi Zen Hei", "Noto Sans CJK JP",
    "Arial Unicode MS",
)  # fmt: skip
_log = logging.getLogger("cycloid_profile")


def translate(figure: Figure) -> None:
    """Put titles, labels, legends and named ticks of a figure into the chosen language; English leaves it alone."""
    if chosen_language() == ENGLISH or (font := chinese_font()) is None:
        return
    for axis in _axes_lines(figure):
        # Ticks take their texts at every drawing from their formatter.
        shown = [label.get_text() for label in axis.get_ticklabels()]
        named = [text if "$" in text else translated(text) for text in shown]
        if named != shown:
            axis.set_ticks(axis.get_ticklocs(), named)
    for text in _texts(figure):
        # The first font that has a letter draws it: numbers and signs look as in English.
        text.set_text(translated(text.get_text()))
        if not text.get_text().isascii():
            text.set_fontfamily(["DejaVu Sans", font])


@cache
def chinese_font() -> str | None:
    """Name of the first of ``FONTS`` on this machine; without one a sentence is logged, and pictures stay English."""
    from matplotlib.font_manager import findSystemFonts, fontManager

    found = _first_known()
    if found is None:
        # The list that matplotlib keeps of the fonts may be older than a font.
        listed = {font.fname for font in fontManager.ttflist}
        for path in sorted(set(findSystemFonts()) - listed):
            with suppress(OSError, RuntimeError):
                fontManager.addfont(path)
        found = _first_known()
    if found is None:
        sentence = "pictures stay English: no font of this machine has Chinese letters; install Noto Sans CJK"
        _log.warning(translated(sentence))
    return found


def _first_known() -> str | None:
    from matplotlib.font_manager import fontManager

    known = {font.name for font in fontManager.ttflist}
    return next((name for name in FONTS if name in known), None)


def _axes_lines(figure: Figure) -> Iterator[Any]:
    for axes in figure.get_axes():
        for name in ("xaxis", "yaxis", "zaxis"):
            if hasattr(axes, name):
                yield getattr(axes, name)


def _texts(figure: Figure) -> list[Any]:
    from matplotlib.text import Text

    # Formulas, such as powers of ten, hold no words.
    return [text for text in figure.findobj(Text) if text.get_text().strip("$") == text.get_text() != ""]
