"""How results introduce themselves: a ``repr`` of a few lines, HTML for notebooks, a table for pandas."""

from __future__ import annotations

import html
import io
import math
import re
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any, NamedTuple

from cycloid_profile.errors import CycloidError

MOST_FIGURES = 14  # a notebook cell without a scroll bar
_WIDEST = 96  # characters of a value
# Signs of angles follow their number without a space.
_CLOSE = ("", "°", "′", "″")
_NUMBER = re.compile(r"^[+\-−–±<>≤≥]?\s?[\d.,]*\d|^[–-]?$")


class Described:
    """Base of results that are too large to print whole; subclasses give ``_key_figures``.

    Decorate with ``@dataclass(repr=False)``, otherwise the generated ``repr`` overrides this one.
    """

    __slots__ = ()

    def _key_figures(self) -> Mapping[str, str]:
        """Name of each figure, and its value with unit."""
        raise NotImplementedError

    def _rows(self) -> list[tuple[str, str]]:
        """The first key figures, each value on one line."""
        figures = ((name, " ".join(value.split())) for name, value in self._key_figures().items())
        return [(name, value if len(value) <= _WIDEST else f"{value[: _WIDEST - 1]}…") for name, value in figures][
            :MOST_FIGURES
        ]

    def __repr__(self) -> str:
        rows = self._rows()
        width = max((len(name) for name, _ in rows), default=0)
        return "\n".join([type(self).__name__, *(f"  {name:<{width}}  {value}" for name, value in rows)])

    def _repr_html_(self) -> str:
        """Table of the key figures and, where there is one, the picture of the result."""
        rows = "".join(
            f"<tr><th style='text-align:left'>{html.escape(name)}</th><td>{html.escape(value)}</td></tr>"
            for name, value in self._rows()
        )
        return f"<b>{type(self).__name__}</b><table>{rows}</table>{_picture(self)}"


class FigureRow(NamedTuple):
    """A key figure in a table: its ``key``, its label and unit, a ``note`` and ``report_only`` for the HTML report."""

    key: str
    label: str
    unit: str = ""
    note: str = ""
    report_only: bool = False


def labelled(rows: Sequence[FigureRow], figures: Mapping[str, Any]) -> dict[str, str]:
    """Label of each row, and its figure with unit."""
    return {row.label: figure_text(figures[row.key], row.unit) for row in rows}


def figure_text(value: float | None, unit: str = "", digits: int = 4) -> str:
    """A figure with ``digits`` significant digits and its unit; a dash where it is None or not finite.

    Large figures are whole numbers with commas, not powers of ten.
    """
    if value is None or not math.isfinite(value):
        return "–"
    rounded = float(f"{value:.{digits}g}")
    if 10.0**digits <= abs(rounded) < 1e9:
        return with_unit(f"{rounded:,.0f}", unit)
    # Rounding errors of a perfect fit are printed as the zero they are.
    return with_unit(f"{0.0 if abs(value) < 1e-9 else value:.{digits}g}", unit)


def is_number(cell: str) -> bool:
    """Whether a cell begins with a number, or stands for a missing one."""
    return _NUMBER.match(cell) is not None


def finite(value: float) -> float | None:
    """The value, None where it is NaN or infinite: JSON has no such numbers."""
    return value if math.isfinite(value) else None


def with_unit(number: str, unit: str) -> str:
    """A number with its unit; the signs of angles follow without a space."""
    return f"{number}{unit}" if unit in _CLOSE else f"{number} {unit}"


def frame(columns: Mapping[str, Any]) -> Any:
    """A ``pandas.DataFrame`` of columns of equal length; raises ``CycloidError`` where pandas is not installed."""
    try:
        pandas = import_module("pandas")
    except ImportError:
        raise CycloidError("pandas", "", "is not installed", "install it with pip install pandas", "") from None
    return pandas.DataFrame(dict(columns))


def _picture(result: object) -> str:
    """SVG of a result, empty where no figure belongs to it."""
    # Named by a string: results lie below the room of pictures and must not import it.
    figure = import_module("cycloid_profile.plot").figure_of(result)
    if figure is None:
        return ""
    drawn = io.StringIO()
    figure.savefig(drawn, format="svg", bbox_inches="tight")
    return drawn.getvalue()[drawn.getvalue().index("<svg") :]
