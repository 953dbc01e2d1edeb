"""Tolerances of teeth and holes: of the spec, else of the grade that the quality of manufacture holds.

The one rule of drawing, inspection plan, DMIS program and evaluation; docs/inspection.md has its reason.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from cycloid_profile.design import DesignRecord
from cycloid_profile.spec.model import FLANK_GRADES, HOLE_GRADES, ByQuality, quality_of, standard_zone
from cycloid_profile.units import ARCMIN, UM

STATED = "spec"
_OFF_CENTRE = 1e-3  # mm


@dataclass(frozen=True, slots=True)
class Tolerance:
    """A tolerance [mm], or [arcmin] of an angle, and its ``source``: ``STATED``, or grade and quality."""

    size: float
    source: str = STATED


@dataclass(frozen=True, slots=True)
class InspectionTolerances:
    """Tolerances of a disc: ``profile`` and ``single_pitch`` ± [mm], ``cumulative_pitch`` and ``runout`` a range [mm],
    ``hole_position`` a diameter [mm], ``hole_angle_arcmin`` ±, both None where the disc has no round holes.
    """

    profile: Tolerance
    single_pitch: Tolerance
    cumulative_pitch: Tolerance
    runout: Tolerance
    hole_position: Tolerance | None
    hole_angle_arcmin: Tolerance | None


def inspection_tolerances(record: DesignRecord, on_drawing: bool = False) -> InspectionTolerances:
    """Those of ``export.inspection``, else of ``export.drawing``, else the zone of a grade, ± half of it.

    Teeth have their grade at the pin circle, holes theirs at the circle of their axes. Where both tables state one,
    ``on_drawing`` prefers that of the drawing: limits of inspection are tighter by the uncertainty of measurement.
    """

    def stated(*given_um: float | None) -> Tolerance | None:
        order = reversed(given_um) if on_drawing else given_um
        return next((Tolerance(um * UM) for um in order if um is not None), None)

    plan, drawing = record.spec.export.inspection, record.spec.export.drawing
    pin_circle = 2.0 * record.profile.trochoid.pin_circle_radius
    tooth, circle = _zone(record, FLANK_GRADES, pin_circle), _hole_circle(record)
    half = Tolerance(0.5 * tooth.size, tooth.source)
    hole = _zone(record, HOLE_GRADES, circle) if circle else None
    # Half the zone at the circle, seen from its centre; to the hundredth of a minute that a drawing shows.
    angle = None if hole is None else Tolerance(math.floor(100.0 * hole.size / circle / ARCMIN) / 100.0, hole.source)
    both_ways = None if drawing.profile_tolerance_um is None else 0.5 * drawing.profile_tolerance_um
    arcmin = drawing.hole_angle_tolerance_arcmin
    return InspectionTolerances(
        profile=stated(plan.profile_tolerance_um, both_ways) or half,
        single_pitch=stated(plan.pitch_tolerance_um, drawing.single_pitch_tolerance_um) or half,
        cumulative_pitch=stated(plan.cumulative_pitch_tolerance_um, drawing.cumulative_pitch_tolerance_um) or tooth,
        runout=stated(plan.runout_tolerance_um, drawing.runout_tolerance_um) or tooth,
        hole_position=hole and (stated(drawing.hole_position_um) or hole),
        hole_angle_arcmin=angle if angle is None or arcmin is None else Tolerance(arcmin),
    )


def _zone(record: DesignRecord, grades: ByQuality, size: float) -> Tolerance:
    quality = quality_of(record.spec.quality, record.case.disc_material.youngs_modulus)
    grade = int(grades.of(quality))
    return Tolerance(standard_zone(grade, size), f"IT{grade}, {quality}")


def _hole_circle(record: DesignRecord) -> float:
    """Diameter of the largest circle of holes [mm], 0 without holes."""
    arcs = (contour.full_circle_arc for contour in record.outline.contours)
    return 2.0 * max((abs(arc.centre) for arc in arcs if arc is not None and abs(arc.centre) > _OFF_CENTRE), default=0)
