"""Names for files whose formats know only plain letters."""

from __future__ import annotations

import re
import unicodedata

_LONGEST = 60


def plain_name(name: str) -> str:
    """``name`` in ASCII letters, digits and a few signs, accents dropped, at most 60 characters."""
    ascii_only = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode("ascii")
    return re.sub(r"[^A-Za-z0-9 ._-]", "", ascii_only).strip()[:_LONGEST] or "DISC"
