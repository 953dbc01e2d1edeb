"""Texts in the chosen language, with words for the signs that the encoding of the output lacks: ′ as arcmin."""

from __future__ import annotations

import codecs
import sys
import unicodedata
from io import TextIOWrapper
from typing import TextIO

from cycloid_profile.errors import CycloidError
from cycloid_profile.language import error_sentences, translated

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


def has_letters(text: str, stream: TextIO | None = None) -> bool:
    """Whether ``stream``, default standard output, encodes the letters of a script without small and large ones."""
    encoding = getattr(sys.stdout if stream is None else stream, "encoding", None) or "utf-8"
    letters = "".join(sign for sign in text if unicodedata.category(sign) == "Lo")
    return "?" not in letters.encode(encoding, "replace").decode(encoding)


def ascii_unless_unicode(text: str) -> str:
    """Text for a file that is read as UTF-8: plain ASCII where standard output is not UTF-8."""
    return text if encodes_unicode() else text.encode("ascii", FALLBACK).decode("ascii")


def encodes_unicode() -> bool:
    """Whether standard output takes every sign."""
    return codecs.lookup(getattr(sys.stdout, "encoding", None) or "utf-8").name.startswith("utf")


def said(sentence: str, stream: TextIO | None = None) -> str:
    """The sentence in the chosen language, or as it is where ``stream``, default standard output, lacks its letters."""
    return _encoded(sentence, translated(sentence), stream)


def said_error(error: CycloidError) -> list[str]:
    """Sentences of an error for standard error, as ``said``."""
    pairs = zip(error.sentences, error_sentences(error), strict=True)
    return [_encoded(sentence, shown, sys.stderr) for sentence, shown in pairs]


def _encoded(sentence: str, shown: str, stream: TextIO | None) -> str:
    return shown if shown == sentence or has_letters(shown, stream) else sentence


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
