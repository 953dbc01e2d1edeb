"""Names of a spec in files: as they are where the format takes them, escaped, or transliterated to ASCII."""

from __future__ import annotations

import re

_LONGEST_NAME = 100  # characters: a block of a control holds 128
_UNSAFE = re.compile(r"[^A-Za-z0-9 ._-]")  # in comments of NC programs and strings of measuring programs
_BASIC_PLANE, _OTHER_PLANES = re.compile("[\x7f-\uffff]+"), re.compile("[\U00010000-\U0010ffff]+")


def plain_name(name: str) -> str:
    """``name`` for controls and measuring machines: transliterated to ASCII, other signs as ``_``, at most 100
    characters."""
    if not name.isascii():
        from anyascii import anyascii

        name = anyascii(name)
    return _UNSAFE.sub("_", " ".join(name.split()))[:_LONGEST_NAME].strip() or "DISC"


def dxf_text(text: str) -> str:
    """Text of a DXF entity: UTF-8, with carets and double per cent signs escaped."""
    return text.replace("^", "^ ").replace("%%", "%%%%%%")


def step_text(text: str) -> str:
    """Text of a STEP file by ISO 10303-21: four hexadecimal digits a character, eight outside the basic plane.

    Apostrophes are doubled by the kernel.
    """
    text = _BASIC_PLANE.sub(lambda found: f"\\X2\\{_hexadecimal(found, 'utf-16-be')}\\X0\\", text.replace("\\", "\\\\"))
    return _OTHER_PLANES.sub(lambda found: f"\\X4\\{_hexadecimal(found, 'utf-32-be')}\\X0\\", text)


def _hexadecimal(found: re.Match[str], encoding: str) -> str:
    return found[0].encode(encoding).hex().upper()
