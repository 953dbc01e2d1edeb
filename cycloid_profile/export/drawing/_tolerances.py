"""Tolerances of the drawing: of the spec, else proposed with their source."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from cycloid_profile.design import DesignRecord
from cycloid_profile.export.inspection import inspection_plan
from cycloid_profile.export.inspection.plan import SHARE
from cycloid_profile.units import ARCMIN, UM

# Perpendicularity up to a length of the shorter side [mm], ISO 2768-2 Table 2 [mm].
_LENGTHS = (100.0, 300.0, 1000.0, 3000.0)
_PERPENDICULARITY = {"H": (0.2, 0.3, 0.4, 0.5), "K": (0.4, 0.6, 0.8, 1.0), "L": (0.6, 1.0, 1.5, 2.0)}


@dataclass(frozen=True, slots=True)
class Tolerance:
    """A tolerance [mm], or [arcmin] of an angle; None where nothing gives one. ``mark`` refers to the note."""

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

    profile: Tolerance
    single_pitch: Tolerance
    cumulative_pitch: Tolerance
    runout: Tolerance
    hole_position: Tolerance
    hole_angle_arcmin: Tolerance
    perpendicularity: Tolerance
    notes: tuple[str, ...]


PLAY, GENERAL = "*", "†"


def tolerances(record: DesignRecord) -> Tolerances:
    """Those of ``export.drawing``, else of the inspection plan, else proposed like there from the play of a flank.

    A hole off by e, or an angle off by e over a z_c, uses e of the play. Perpendicularity falls back to ISO 2768-2.
    """
    fields, plan = record.spec.export.drawing, inspection_plan(record)
    half = SHARE * plan.flank_play
    checks = {check.name: check for check in plan.checks}

    def planned(given_um: float | None, name: str, factor: float = 1.0) -> Tolerance:
        check = checks[name]
        if given_um is not None or check.tolerance is None:
            return Tolerance(None if given_um is None else given_um * UM)
        return Tolerance(factor * check.tolerance, "" if check.source == "spec" else PLAY)

    def proposed(given: float | None, size: float, step: float) -> Tolerance:
        if given is not None:
            return Tolerance(given)
        down = math.floor(size / step + 1e-9) * step
        return Tolerance(down, PLAY) if down > 0.0 else Tolerance(None)

    position = None if fields.hole_position_um is None else fields.hole_position_um * UM
    angle = half / record.drive.trochoid.longest_lever / ARCMIN
    found = {
        "profile": planned(fields.profile_tolerance_um, "profile", 2.0),
        "single_pitch": planned(fields.single_pitch_tolerance_um, "single pitch"),
        "cumulative_pitch": planned(fields.cumulative_pitch_tolerance_um, "cumulative pitch"),
        "runout": planned(fields.runout_tolerance_um, "runout"),
        "hole_position": proposed(position, 2.0 * half, 0.1 * UM),
        "hole_angle_arcmin": proposed(fields.hole_angle_tolerance_arcmin, angle, 0.01),
        "perpendicularity": _perpendicularity(record),
    }
    reasons = {
        PLAY: f"{PLAY} not in the spec: half the play of a flank, to be agreed.",
        GENERAL: f"{GENERAL} not in the spec: {fields.general_tolerance}.",
    }
    marks = {tolerance.mark for tolerance in found.values()}
    return Tolerances(**found, notes=tuple(reason for mark, reason in reasons.items() if mark in marks))


def _perpendicularity(record: DesignRecord) -> Tolerance:
    fields = record.spec.export.drawing
    if fields.perpendicularity_um is not None:
        return Tolerance(fields.perpendicularity_um * UM)
    length = min(record.drive.disc_width, 2.0 * record.outline.tip_radius)
    general = re.fullmatch(r"ISO 2768-[fmcv]([HKL])", fields.general_tolerance)
    fitting = [] if general is None else [
        size for longest, size in zip(_LENGTHS, _PERPENDICULARITY[general[1]], strict=True) if length <= longest
    ]  # fmt: skip
    return Tolerance(fitting[0], GENERAL) if fitting else Tolerance(None)
