"""Tolerances of the drawing: those of the inspection, and perpendicularity, with the marks that notes explain."""

from __future__ import annotations

import re
from dataclasses import dataclass, fields

from cycloid_profile.design import DesignRecord
from cycloid_profile.export.inspection import STATED, Tolerance, inspection_tolerances
from cycloid_profile.units import UM

# Perpendicularity up to a length of the shorter side [mm], ISO 2768-2 Table 2 [mm].
_LENGTHS = (100.0, 300.0, 1000.0, 3000.0)
_PERPENDICULARITY = {"H": (0.2, 0.3, 0.4, 0.5), "K": (0.4, 0.6, 0.8, 1.0), "L": (0.6, 1.0, 1.5, 2.0)}
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
    notes: tuple[str, ...]


def tolerances(record: DesignRecord) -> Tolerances:
    """Those of ``inspection_tolerances``; perpendicularity falls back to ISO 2768-2."""
    limits = inspection_tolerances(record, on_drawing=True)
    present = [limit for limit in (getattr(limits, one.name) for one in fields(limits)) if limit is not None]
    grades = dict.fromkeys(limit.source for limit in present if limit.source != STATED)
    marks = dict(zip(grades, _MARKS, strict=False)) | {STATED: ""}

    def shown(limit: Tolerance | None, factor: float = 1.0) -> ShownTolerance:
        return ShownTolerance(None) if limit is None else ShownTolerance(factor * limit.size, marks[limit.source])

    perpendicularity = _perpendicularity(record)
    notes = [f"{marks[grade]} not in the spec: {grade}, ISO 286-1; to be agreed." for grade in grades]
    if perpendicularity.mark:
        notes.append(f"{GENERAL} not in the spec: {record.spec.export.drawing.general_tolerance}.")
    return Tolerances(
        profile=shown(limits.profile, 2.0),
        single_pitch=shown(limits.single_pitch),
        cumulative_pitch=shown(limits.cumulative_pitch),
        runout=shown(limits.runout),
        hole_position=shown(limits.hole_position),
        hole_angle_arcmin=shown(limits.hole_angle_arcmin),
        perpendicularity=perpendicularity,
        notes=tuple(notes),
    )


def _perpendicularity(record: DesignRecord) -> ShownTolerance:
    drawing = record.spec.export.drawing
    if drawing.perpendicularity_um is not None:
        return ShownTolerance(drawing.perpendicularity_um * UM)
    length = min(record.drive.disc_width, 2.0 * record.outline.tip_radius)
    general = re.fullmatch(r"ISO 2768-[fmcv]([HKL])", drawing.general_tolerance)
    fitting = [] if general is None else [
        size for longest, size in zip(_LENGTHS, _PERPENDICULARITY[general[1]], strict=True) if length <= longest
    ]  # fmt: skip
    return ShownTolerance(fitting[0], GENERAL) if fitting else ShownTolerance(None)
