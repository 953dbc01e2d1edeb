"""Inspection plan of a finished disc: checks with datum, tolerance and source of the tolerance."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile._display import Described
from cycloid_profile.design import DesignRecord
from cycloid_profile.export.inspection.tolerances import inspection_tolerances
from cycloid_profile.export.points import measuring_points
from cycloid_profile.units import DEGREE, UM


@dataclass(frozen=True, slots=True)
class Check:
    """One line of the plan: ``tolerance`` ± about the nominal if ``both_ways``, else a width [mm]; its ``source``."""

    name: str
    symbol: str
    quantity: str
    tolerance: float
    both_ways: bool
    source: str


@dataclass(frozen=True, slots=True, repr=False)
class InspectionPlan(Described):
    """Checks of a disc; ``flank_play`` is the normal gap of one flank at first touch [mm].

    ``mid_height`` of the points [mm]; ``pitch_radius`` [mm] and ``pitch_phase`` [rad] at which pitch is evaluated;
    ``bore_radius`` [mm], and centre and radius of the first ``crank_hole`` [mm], None without a round one.
    """

    checks: tuple[Check, ...]
    flank_play: float
    points_per_lobe: int
    lobes: int
    mid_height: float
    pitch_radius: float
    pitch_phase: float
    bore_radius: float | None
    crank_hole: tuple[complex, float] | None
    bore_points: int
    probe_radius: float

    def _key_figures(self) -> dict[str, str]:
        checks = {c.name: f"{c.tolerance / UM:.1f} µm" for c in self.checks}
        return checks | {"points": f"{self.points_per_lobe} on each of {self.lobes} lobes", "datum": self.datum}

    @property
    def datum(self) -> str:
        """Datum of the origin."""
        return "axis of the bore" if self.bore_radius is not None else "centre of the circle through the roots"

    @property
    def turn_datum(self) -> str:
        """Datum of the direction of the x axis."""
        if self.crank_hole is None:
            return "best fit of all flank points"
        turn = self.hole_angle / DEGREE
        return f"crank hole 1, {turn:.4f}° from the x axis" if turn else "crank hole 1, on the x axis"

    @property
    def hole_angle(self) -> float:
        """Angle of crank hole 1 from the x axis, which goes through root 1 [rad]."""
        return 0.0 if self.crank_hole is None else round(cmath.phase(self.crank_hole[0]), 12)


def inspection_plan(record: DesignRecord) -> InspectionPlan:
    """The plan of a design, its tolerances those of ``inspection_tolerances``."""
    settings = record.spec.export.inspection
    trochoid = record.profile.trochoid
    phase = trochoid.critical_phase
    pitch_radius = float(np.abs(record.profile.at(phase).position))
    play = max(0.0, 0.5 * record.compensated_accuracy.backlash.least * trochoid.longest_lever)
    arcs = {contour.name: contour.full_circle_arc for contour in record.outline.contours}
    bore, crank_hole = arcs.get("bore"), arcs.get("crank hole 1")
    limits = inspection_tolerances(record)
    rows = (
        ("profile", "F_α", "deviation of the flank along its normal", limits.profile, True),
        ("single pitch", "f_p", "deviation of one lobe from the next, arc at the pitch radius", limits.single_pitch,
         True),
        ("cumulative pitch", "F_p", "largest minus least position of a lobe, arc at the pitch radius",
         limits.cumulative_pitch, False),
        ("runout", "F_r", "largest minus least radius of the roots about the datum", limits.runout, False),
    )  # fmt: skip
    _, lobe = measuring_points(record)
    return InspectionPlan(
        checks=tuple(Check(name, sign, what, of.size, both, of.source) for name, sign, what, of, both in rows),
        flank_play=play,
        points_per_lobe=int(np.count_nonzero(lobe == 1)),
        lobes=trochoid.lobes,
        mid_height=0.5 * record.drive.disc_width,
        pitch_radius=pitch_radius,
        pitch_phase=phase,
        bore_radius=None if bore is None else bore.radius,
        crank_hole=None if crank_hole is None else (crank_hole.centre, crank_hole.radius),
        bore_points=settings.bore_points,
        probe_radius=settings.probe_radius_mm,
    )


def plan_rows(plan: InspectionPlan) -> list[str]:
    """The plan as Markdown, one line an entry."""
    tight = plan.checks[0].tolerance > plan.flank_play
    beyond = ", less than the profile tolerance: a disc at its limits may touch on both flanks" if tight else ""
    bore = "the disc has no round bore" if plan.bore_radius is None else f"{2.0 * plan.bore_radius:.4f} mm"
    return [
        "| check | quantity | tolerance [µm] | tolerance from |",
        "|---|---|---|---|",
        *(
            f"| {c.name} | {c.quantity} | {'± ' if c.both_ways else ''}{c.tolerance / UM:.4g} | {c.source} |"
            for c in plan.checks
        ),
        "",
        f"- Datum A: {plan.datum}, diameter {bore}, {plan.bore_points} points at z = {plan.mid_height:g} mm.",
        f"- Datum B, the turn about A: {plan.turn_datum}; lobe 1 is the one whose root lies on the x axis.",
        f"- Flanks: {plan.points_per_lobe} points on each of {plan.lobes} lobes at z = {plan.mid_height:g} mm, with"
        " nominal outward normals.",
        f"- Pitch: at the flank points nearest to phase ±{math.degrees(plan.pitch_phase):.2f}°, radius"
        f" {plan.pitch_radius:.4f} mm, where the lever arm is longest.",
        f"- Probe: ball of radius {plan.probe_radius:g} mm. Its centre stands off by this along the nominal normal;"
        " points and results are those of the surface, compensated by the machine along the normal.",
        f"- Play of a flank at first touch: {plan.flank_play / UM:.2f} µm{beyond}.",
    ]
