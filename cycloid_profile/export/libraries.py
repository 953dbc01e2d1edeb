"""Compiled libraries that a machine may lack; what needs none of them is written all the same."""

from __future__ import annotations

from typing import Any

from cycloid_profile.errors import ExportError


class LibraryMissing(ExportError):  # noqa: N818 - a state of the machine, told in one sentence
    """A library cannot be imported; the sentence says what to install."""


def require_cad_kernel() -> None:
    """Raise ``LibraryMissing`` where OpenCascade cannot be imported, which takes a second and system libraries."""
    try:
        import OCP.STEPCAFControl  # noqa: F401 - drags in the whole kernel
    except ImportError as error:
        raise _missing("STEP export", "the OpenCascade kernel", error, "cadquery-ocp-novtk") from None


def lib3mf() -> Any:
    """The library of the 3MF consortium. Raises ``LibraryMissing`` where it cannot be imported."""
    try:
        import lib3mf as library
    except ImportError as error:
        raise _missing("3MF and STL export", "lib3mf", error, "lib3mf") from None
    return library


def _missing(what: str, needed: str, error: ImportError, package: str) -> LibraryMissing:
    shared = "libGL" in str(error) or ".so" in str(error)
    remedy = (
        "install the system libraries libGL, libX11 and libexpat (Debian: apt install libgl1 libx11-6 libexpat1)"
        if shared
        else f"install it with 'pip install {package}'"
    )
    return LibraryMissing(what, f"needs {needed}", f"which cannot be imported ({error})", remedy, " ")
