"""What is measured on a finished disc, against which datum, with which tolerance and where the tolerance comes from."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.design.record import DesignRecord
from cycloid_profile.export.points import measuring_points
from cycloid_profile.geometry.contour import Arc
from cycloid_profile.units import UM

# Of the play of one flank: so much may a lobe be too thick before half of the play is gone.
SHARE = 0.5


@dataclass(frozen=True, slots=True)
class Check:
    """One line of the plan: ``tolerance`` [mm] about the nominal both ways where ``both_ways``, else a width.

    None where nothing allows to compute it. ``source`` says where it comes from.
    """

    name: str
    quantity: str
    tolerance: float | None
    both_ways: bool
    source: str


@dataclass(frozen=True, slots=True)
class InspectionPlan:
    """Checks of a disc; ``flank_play`` is the normal gap of one flank that they are computed from [mm].

    ``mid_height`` of the points [mm], ``pitch_radius`` at which pitch is read [mm]; ``bore_radius`` [mm], and centre
    and radius of the first ``crank_hole`` [mm], None where the disc has none that is round.
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

    @property
    def datum(self) -> str:
        """What carries the origin."""
        return "axis of the bore" if self.bore_radius is not None else "centre of the circle through the roots"

    @property
    def turn_datum(self) -> str:
        """What carries the direction of the x axis."""
        return "crank hole 1, on the x axis" if self.crank_hole is not None else "best fit of all flank points"


def inspection_plan(record: DesignRecord) -> InspectionPlan:
    """The plan of a design.

    Half the play of a flank is given to each kind of error: a normal displacement of the flank by e takes e of its
    play. A lobe out of its place by the angle β displaces it by a z_c β at most (theory, Eq. 6), which is read as
    an arc at the pitch radius; an eccentricity of the teeth displaces it by as much, and is read as twice that.
    """
    asked = record.spec.export.inspection
    trochoid = record.profile.trochoid
    phase = trochoid.critical_phase
    pitch_radius = float(np.abs(record.profile.at(phase).position))
    play = max(0.0, 0.5 * record.compensated_accuracy.backlash.least * trochoid.longest_lever)
    half = SHARE * play
    per_angle = pitch_radius / trochoid.longest_lever
    bore, crank_hole = (_round(record, name) for name in ("bore", "crank hole 1"))
    wanted = (
        ("profile", "deviation of the flank along its normal", asked.profile_tolerance_um, half, True),
        ("single pitch", "deviation of one lobe from the next, arc at the pitch radius", asked.pitch_tolerance_um,
         half * per_angle, True),
        ("cumulative pitch", "largest minus least place of a lobe, arc at the pitch radius",
         asked.cumulative_pitch_tolerance_um, 2.0 * half * per_angle, False),
        ("runout", "largest minus least radius of the roots about the datum", asked.runout_tolerance_um,
         2.0 * half, False),
    )  # fmt: skip
    _, lobe = measuring_points(record)
    return InspectionPlan(
        checks=tuple(_check(name, what, given, found, both) for name, what, given, found, both in wanted),
        flank_play=play,
        points_per_lobe=int(np.count_nonzero(lobe == 1)),
        lobes=trochoid.lobes,
        mid_height=0.5 * record.drive.disc_width,
        pitch_radius=pitch_radius,
        pitch_phase=phase,
        bore_radius=None if bore is None else bore.radius,
        crank_hole=None if crank_hole is None else (crank_hole.centre, crank_hole.radius),
        bore_points=asked.bore_points,
        probe_radius=asked.probe_radius_mm,
    )


def _round(record: DesignRecord, name: str) -> Arc | None:
    return next((contour.circle for contour in record.outline.contours if contour.name == name), None)


def _check(name: str, quantity: str, given_um: float | None, computed: float, both_ways: bool) -> Check:
    if given_um is not None:
        return Check(name, quantity, given_um * UM, both_ways, "spec")
    # To a tenth of a micrometre downwards; a play that small leaves no tolerance to give.
    down = math.floor(computed / (0.1 * UM) + 1e-9) * 0.1 * UM
    if down <= 0.0:
        return Check(name, quantity, None, both_ways, "to be agreed: the drive has no play to share out")
    return Check(name, quantity, down, both_ways, "half the play of a flank, to be agreed")


def plan_rows(plan: InspectionPlan) -> list[str]:
    """The plan as Markdown, one line an entry."""
    signs = {True: "± ", False: ""}
    tolerance = [
        "to be agreed" if c.tolerance is None else f"{signs[c.both_ways]}{c.tolerance / UM:.1f}" for c in plan.checks
    ]
    bore = "the disc has no round bore" if plan.bore_radius is None else f"{2.0 * plan.bore_radius:.4f} mm"
    return [
        "| check | quantity | tolerance [µm] | tolerance from |",
        "|---|---|---|---|",
        *(f"| {c.name} | {c.quantity} | {t} | {c.source} |" for c, t in zip(plan.checks, tolerance, strict=True)),
        "",
        f"- Datum A: {plan.datum}, diameter {bore}, {plan.bore_points} points at z = {plan.mid_height:g} mm.",
        f"- Datum B, the turn about A: {plan.turn_datum}; lobe 1 is the one whose root lies on the x axis.",
        f"- Flanks: {plan.points_per_lobe} points on each of {plan.lobes} lobes at z = {plan.mid_height:g} mm, with"
        " nominal outward normals.",
        f"- Pitch: at the flank points nearest to phase ±{math.degrees(plan.pitch_phase):.2f}°, radius"
        f" {plan.pitch_radius:.4f} mm, where the lever arm is longest.",
        f"- Probe: ball of radius {plan.probe_radius:g} mm. Its centre stands off by this along the nominal normal;"
        " points and results are those of the surface, compensated by the machine along the normal.",
        f"- Play of a flank at first touch: {plan.flank_play / UM:.2f} µm.",
    ]
