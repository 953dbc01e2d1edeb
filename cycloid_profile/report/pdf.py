"""Reports as PDF: the HTML page set on A4 by WeasyPrint, with the fonts of the pictures embedded."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

from cycloid_profile.errors import ExportError

_FONTS = {"normal": "DejaVuSans.ttf", "bold": "DejaVuSans-Bold.ttf"}
_INSTALL = 'install it with pip install "cycloid_profile[pdf]"'
_PANGO = "install the library Pango of your system, on Debian apt install libpango-1.0-0 libpangoft2-1.0-0"


def require_pdf() -> None:
    """Raises ``ExportError`` where WeasyPrint or its system library Pango is missing."""
    _weasyprint()


def write_pdf(html: str, file: Path) -> None:
    """Write the page ``html`` as ``file``; the same page makes the same bytes. Raises as ``require_pdf``."""
    library = _weasyprint()
    fonts = import_module("weasyprint.text.fonts").FontConfiguration()
    style = library.CSS(string=_font_faces(), font_config=fonts)
    # Links of the page name files next to it: they stay relative.
    page = library.HTML(string=html, base_url=None)
    page.write_pdf(file, stylesheets=[style], font_config=fonts)


def _weasyprint() -> Any:
    try:
        return import_module("weasyprint")
    except ImportError:
        raise ExportError("--pdf", "", "needs weasyprint, which is not installed", _INSTALL, "") from None
    except OSError:
        raise ExportError("--pdf", "", "needs Pango, which is not installed", _PANGO, "") from None


def _font_faces() -> str:
    """CSS of the fonts that matplotlib ships: the bytes must not depend on those of the system."""
    folder = Path(import_module("matplotlib").get_data_path()) / "fonts" / "ttf"
    faces = (
        f"@font-face {{ font-family: 'DejaVu Sans'; font-weight: {weight}; src: url('{(folder / name).as_uri()}'); }}"
        for weight, name in _FONTS.items()
    )
    return "\n".join(faces) + "\nhtml, body, text { font-family: 'DejaVu Sans'; }"
