"""Tolerances of the drawing: those of the inspection, and of the faces, with the marks that notes explain."""

from __future__ import annotations

import re
from dataclasses import dataclass, fields

from cycloid_profile.design import DesignRecord
from cycloid_profile.export.inspection import STATED, Tolerance, inspection_tolerances
from cycloid_profile.units import UM

# Perpendicularity up to a length of the shorter side [mm], ISO 2768-2 Table 2 [mm].
_LENGTHS = (100.0, 300.0, 1000.0, 3000.0)
_PERPENDICULARITY = {"H": (0.2, 0.3, 0.4, 0.5), "K": (0.4, 0.6, 0.8, 1.0), "L": (0.6, 1.0, 1.5, 2.0)}
# Flatness up to a diameter [mm], ISO 2768-2 Table 1 [mm].
_DIAMETERS = (10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0)
_FLATNESS = {
    "H": (0.02, 0.05, 0.1, 0.2, 0.3, 0.4), "K": (0.05, 0.1, 0.2, 0.4, 0.6, 0.8), "L": (0.1, 0.2, 0.4, 0.8, 1.2, 1.6),
}  # fmt: skip
# Lengths up to a size [mm], ISO 2768-1 Table 1, ± [mm].
_SIZES = (6.0, 30.0, 120.0, 400.0, 1000.0, 2000.0)
_SIZE = {
    "f": (0.05, 0.1, 0.15, 0.2, 0.3, 0.5), "m": (0.1, 0.2, 0.3, 0.5, 0.8, 1.2), "c": (0.3, 0.5, 0.8, 1.2, 2.0, 3.0),
    "v": (0.5, 1.0, 1.5, 2.5, 4.0, 6.0),
}  # fmt: skip
_MARKS = ("*", "**")  # of grades, in the order of their sources
GENERAL = "†"


@dataclass(frozen=True, slots=True)
class ShownTolerance:
    """A tolerance as the drawing shows it [mm], or [arcmin] of an angle; None where nothing gives one."""

    size: float | None
    mark: str = ""

    def __str__(self) -> str:
        return self.in_unit("")

    def in_unit(self, unit: str) -> str:
        """Size, ``unit`` and mark; a line to fill in without a size."""
        return f"________{unit}" if self.size is None else f"{self.size:.4g}{unit}{self.mark}"


@dataclass(frozen=True, slots=True)
class Tolerances:
    """Tolerances of a disc: zones and ranges whole, pitch and hole angle ±. ``notes`` explain their marks."""

    profile: ShownTolerance
    single_pitch: ShownTolerance
    cumulative_pitch: ShownTolerance
    runout: ShownTolerance
    hole_position: ShownTolerance
    hole_angle_arcmin: ShownTolerance
    perpendicularity: ShownTolerance
    parallelism: ShownTolerance
    notes: tuple[str, ...]


def tolerances(record: DesignRecord) -> Tolerances:
    """Those of ``inspection_tolerances``; perpendicularity and parallelism fall back to ISO 2768-2."""
    limits = inspection_tolerances(record, on_drawing=True)
    present = [limit for limit in (getattr(limits, one.name) for one in fields(limits)) if limit is not None]
    grades = dict.fromkeys(limit.source for limit in present if limit.source != STATED)
    marks = dict(zip(grades, _MARKS, strict=False)) | {STATED: ""}

    def shown(limit: Tolerance | None, factor: float = 1.0) -> ShownTolerance:
        return ShownTolerance(None) if limit is None else ShownTolerance(factor * limit.size, marks[limit.source])

    perpendicularity, parallelism = _perpendicularity(record), _parallelism(record)
    notes = [f"{marks[grade]} not in the spec: {grade}, ISO 286-1; to be agreed." for grade in grades]
    if perpendicularity.mark or parallelism.mark:
        notes.append(f"{GENERAL} not in the spec: {record.spec.export.drawing.general_tolerance}.")
    return Tolerances(
        profile=shown(limits.profile, 2.0),
        single_pitch=shown(limits.single_pitch),
        cumulative_pitch=shown(limits.cumulative_pitch),
        runout=shown(limits.runout),
        hole_position=shown(limits.hole_position),
        hole_angle_arcmin=shown(limits.hole_angle_arcmin),
        perpendicularity=perpendicularity,
        parallelism=parallelism,
        notes=tuple(notes),
    )


def _perpendicularity(record: DesignRecord) -> ShownTolerance:
    drawing = record.spec.export.drawing
    if drawing.perpendicularity_um is not None:
        return ShownTolerance(drawing.perpendicularity_um * UM)
    length = min(record.drive.disc_width, 2.0 * record.outline.tip_radius)
    general = _general_class(drawing.general_tolerance)
    return _general(_up_to(length, _LENGTHS, _PERPENDICULARITY[general[1]]) if general else None)


def _parallelism(record: DesignRecord) -> ShownTolerance:
    """ISO 2768-2, 5.2.2: the tolerance of the width or the flatness, whichever is larger."""
    drawing = record.spec.export.drawing
    if drawing.parallelism_um is not None:
        return ShownTolerance(drawing.parallelism_um * UM)
    general = _general_class(drawing.general_tolerance)
    if general is None:
        return ShownTolerance(None)
    width = drawing.width_tolerance_um
    half = _up_to(record.drive.disc_width, _SIZES, _SIZE[general[0]]) if width is None else width * UM
    flat = _up_to(2.0 * record.outline.tip_radius, _DIAMETERS, _FLATNESS[general[1]])
    return _general(None if half is None or flat is None else max(2.0 * half, flat))


def _general_class(name: str) -> tuple[str, str] | None:
    """Classes of ISO 2768-1 and -2 in a name such as ISO 2768-mK."""
    found = re.fullmatch(r"ISO 2768-([fmcv])([HKL])", name)
    return found and (found[1], found[2])


def _up_to(size: float, limits: tuple[float, ...], values: tuple[float, ...]) -> float | None:
    """The value of the first range that holds a size."""
    return next((value for limit, value in zip(limits, values, strict=True) if size <= limit), None)


def _general(size: float | None) -> ShownTolerance:
    return ShownTolerance(size, "" if size is None else GENERAL)
