"""Area and volume of a plate by Green's theorem and by the CAD kernel."""

from __future__ import annotations

from cycloid_profile.export.curves import ProfileSource, SplinePiece
from cycloid_profile.export.writing import LibraryMissing, require_cad_kernel

_DECIMALS = 4  # below 1e-8 of any disc


def plate_measures(record: ProfileSource, edge: tuple[SplinePiece, ...]) -> dict[str, float]:
    """Area [mm²] and volume [mm³] of the disc, and of the plate inside ``edge`` by OpenCascade.

    ``edge`` holds the splines of the tooth as read from a file. The kernel integrates its own top face; the volume is
    that of the prism on this face, because its integral over the side faces is three to ten times less accurate.
    """
    try:
        require_cad_kernel()
    except LibraryMissing:
        return measures_of(record)
    from cycloid_profile.export.cad import _solids as kernel

    return measures_of(record, kernel.top_area(kernel.plate(edge, record.outline.contours, 0.0, 1.0)))


def measures_of(record: ProfileSource, kernel_area: float | None = None) -> dict[str, float]:
    """Exact area [mm²] and volume [mm³] of the disc, and those from the area of its face by the kernel [mm²]."""
    width, exact = record.drive.disc_width, record.outline.area
    found = {"area_mm2": exact, "volume_mm3": exact * width}
    if kernel_area is not None:
        found |= {"opencascade_area_mm2": kernel_area, "opencascade_volume_mm3": kernel_area * width}
    return {name: round(value, _DECIMALS) for name, value in found.items()}
