"""Area and volume of a plate by Green's theorem and by the CAD kernel."""

from __future__ import annotations

from cycloid_profile.export.curves import ProfileSource, SplinePiece
from cycloid_profile.export.writing import LibraryMissing, require_cad_kernel

_DECIMALS = 4  # below 1e-8 of any disc


def plate_measures(record: ProfileSource, edge: tuple[SplinePiece, ...]) -> dict[str, float]:
    """Area [mm²] and volume [mm³] of the disc, and of the plate inside ``edge`` by OpenCascade.

    ``edge`` holds the splines of the tooth as read from a file.
    """
    try:
        require_cad_kernel()
    except LibraryMissing:
        return measures_of(record)
    from cycloid_profile.export.cad import _solids as kernel

    return measures_of(
        record, kernel.measured(kernel.plate(edge, record.outline.contours, 0.0, record.drive.disc_width))
    )


def measures_of(record: ProfileSource, by_kernel: tuple[float, float] | None = None) -> dict[str, float]:
    """Exact area [mm²] and volume [mm³] of the disc, and those ``by_kernel``."""
    exact = record.outline.area
    found = {"area_mm2": exact, "volume_mm3": exact * record.drive.disc_width}
    if by_kernel is not None:
        found |= dict(zip(("opencascade_area_mm2", "opencascade_volume_mm3"), by_kernel, strict=True))
    return {name: round(value, _DECIMALS) for name, value in found.items()}
