"""Inspection plan of a finished disc: datums, and checks with tolerance and source of the tolerance."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile._display import Described
from cycloid_profile.design import DesignRecord
from cycloid_profile.export.inspection.datums import (
    AXIS,
    DIRECTION,
    FACE,
    FACE_POINTS,
    OF_TEETH,
    CircleDatum,
    DatumSystem,
    datum_system,
)
from cycloid_profile.export.inspection.tolerances import Tolerance, inspection_tolerances
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
    ``hole_angle_arcmin``: ± of the angle from datum C to root 1, None without round holes.
    """

    checks: tuple[Check, ...]
    flank_play: float
    points_per_lobe: int
    lobes: int
    mid_height: float
    pitch_radius: float
    pitch_phase: float
    datums: DatumSystem
    hole_angle_arcmin: Tolerance | None
    bore_points: int
    probe_radius: float

    def _key_figures(self) -> dict[str, str]:
        checks = {c.name: f"{c.tolerance / UM:.1f} µm" for c in self.checks}
        datums = ", ".join(f"{letter} {name}" for letter, name in self.datums.names.items())
        return checks | {"points": f"{self.points_per_lobe} on each of {self.lobes} lobes", "datums": datums}


def inspection_plan(record: DesignRecord) -> InspectionPlan:
    """The plan of a design, its tolerances those of ``inspection_tolerances``."""
    settings = record.spec.export.inspection
    trochoid = record.profile.trochoid
    phase = trochoid.critical_phase
    pitch_radius = float(np.abs(record.profile.at(phase).position))
    play = max(0.0, 0.5 * record.compensated_accuracy.backlash.least * trochoid.longest_lever)
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
        datums=datum_system(record),
        hole_angle_arcmin=limits.hole_angle_arcmin,
        bore_points=settings.bore_points,
        probe_radius=settings.probe_radius_mm,
    )


def plan_rows(plan: InspectionPlan) -> list[str]:
    """The plan as Markdown, one line an entry."""
    tight = plan.checks[0].tolerance > plan.flank_play
    beyond = ", less than the profile tolerance: a disc at its limits may touch on both flanks" if tight else ""
    teeth = ", ".join(OF_TEETH)
    angle = plan.hole_angle_arcmin if plan.datums.direction is not None else None
    return [
        "| check | quantity | datums | tolerance [µm] | tolerance from |",
        "|---|---|---|---|---|",
        *(
            f"| {c.name} | {c.quantity} | {teeth} | {'± ' if c.both_ways else ''}{c.tolerance / UM:.4g} | {c.source} |"
            for c in plan.checks
        ),
        *(
            [f"| hole to tooth | angle from {DIRECTION} to root 1 | {teeth} | ± {angle.size:.4g}′ | {angle.source} |"]
            if angle is not None
            else []
        ),
        "",
        *_datum_rows(plan),
        f"- Flanks: {plan.points_per_lobe} points on each of {plan.lobes} lobes at z = {plan.mid_height:g} mm, with"
        " nominal outward normals.",
        f"- Pitch: at the flank points nearest to phase ±{math.degrees(plan.pitch_phase):.2f}°, radius"
        f" {plan.pitch_radius:.4f} mm, where the lever arm is longest.",
        f"- Probe: ball of radius {plan.probe_radius:g} mm. Its centre stands off by this along the nominal normal;"
        " points and results are those of the surface, compensated by the machine along the normal.",
        f"- Play of a flank at first touch: {plan.flank_play / UM:.2f} µm{beyond}.",
    ]


def _datum_rows(plan: InspectionPlan) -> list[str]:
    """Datums with their points, and the frame in which coordinates are given."""
    datums, points = plan.datums, plan.bore_points
    level = f"at z = {plan.mid_height:g} mm"
    touched = points if datums.axis.opening else plan.lobes
    rows = [
        f"- Datum {FACE}: {datums.face}, {FACE_POINTS} points.",
        f"- Datum {AXIS}: axis of the {datums.axis.name}, diameter {2.0 * datums.axis.radius:.4f} mm, {touched} points"
        f" {level}.",
    ]
    if datums.direction is None:
        rows.append(f"- No datum {DIRECTION}: the disc has no hole or keyway. Root 1 gives the direction.")
    else:
        touched = points if isinstance(datums.direction, CircleDatum) else 2
        turn = datums.direction_angle / DEGREE
        place = f"{turn:.4f}° from the x axis" if turn else "on the x axis"
        rows.append(f"- Datum {DIRECTION}: {datums.direction.name}, {place}, {touched} points {level}.")
    rows.append(
        "- Frame: origin on the lower face, x axis through root 1. Teeth are evaluated with their turn about"
        f" {AXIS} free; lobe 1 is the one whose root lies on the x axis."
    )
    return rows
