"""Signs that the encoding of the output lacks are printed as words: ′ as arcmin, µ as u, ≤ as <=."""

from __future__ import annotations

import codecs
import sys
import unicodedata
from io import TextIOWrapper
from typing import TextIO

FALLBACK = "cycloid-profile-words"  # name of the error handler
# Unit signs that follow a number without a space; as words they need one.
_UNITS = {"′": "arcmin", "″": "arcsec", "°": "deg"}
_WORDS = {
    "µ": "u", "μ": "u", "²": "^2", "³": "^3", "·": ".", "×": "x", "÷": "/", "±": "+/-", "−": "-", "–": "-", "—": "-",
    "…": "...", "≤": "<=", "≥": ">=", "≠": "!=", "≈": "~", "→": "->", "←": "<-", "√": "sqrt", "∞": "inf",
    "∅": "dia. ", "⌀": "dia. ", "Ø": "dia. ", "“": '"', "”": '"', "‘": "'", "’": "'", "•": "*",
    "ψ": "psi", "κ": "kappa", "δ": "delta", "Δ": "Delta", "φ": "phi", "θ": "theta", "σ": "sigma", "τ": "tau",
    "ν": "nu", "α": "alpha", "β": "beta", "λ": "lambda", "ω": "omega", "π": "pi", "χ": "chi", "ρ": "rho",
    "│": "|", "─": "-", "╭": "+", "╮": "+", "╰": "+", "╯": "+",
}  # fmt: skip


def fit_streams() -> None:
    """Let standard output and standard error print every sign in the encoding that they have."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors=FALLBACK)


def printable(text: str, stream: TextIO | None = None) -> str:
    """The text with words for the signs that ``stream``, default standard output, cannot encode."""
    encoding = getattr(sys.stdout if stream is None else stream, "encoding", None) or "utf-8"
    return text.encode(encoding, FALLBACK).decode(encoding)


def ascii_unless_unicode(text: str) -> str:
    """Text for a file that is read as UTF-8: plain ASCII where standard output is not UTF-8."""
    return text if encodes_unicode() else text.encode("ascii", FALLBACK).decode("ascii")


def encodes_unicode() -> bool:
    """Whether standard output takes every sign."""
    return codecs.lookup(getattr(sys.stdout, "encoding", None) or "utf-8").name.startswith("utf")


def _words(error: UnicodeError) -> tuple[str, int]:
    """Error handler of the codecs: words for the signs that an encoding lacks."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    found = []
    for place in range(error.start, error.end):
        sign, before = error.object[place], error.object[place - 1 : place]
        if sign in _UNITS:
            found.append(f" {_UNITS[sign]}" if before.isdigit() else _UNITS[sign])
        else:
            plain = unicodedata.normalize("NFKD", sign).encode("ascii", "ignore").decode("ascii")
            found.append(_WORDS.get(sign) or plain or "?")
    return "".join(found), error.end


codecs.register_error(FALLBACK, _words)
