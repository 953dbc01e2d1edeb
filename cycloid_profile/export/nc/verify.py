"""Checks of a program that has been run: material, spindle, compensation, limits and end."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cycloid_profile.errors import ExportError
from cycloid_profile.export.nc.interpreter import Motion, Position, Program
from cycloid_profile.spec.model import MachineSpec

C_DRIFT = 1e-3  # °, over a whole job
_SPEED_ROUNDING = 1e-3  # share by which rounded positions may exceed an axis speed
_TINY = 1e-9


@dataclass(frozen=True, slots=True)
class Blank:
    """The blank, a cylinder about the bore axis: ``radius`` over tips and stock, ``height`` of its upper face [mm]."""

    radius: float
    height: float


def check_grinding(program: Program, machine: MachineSpec, blank: Blank, wheel_radius: float, name: str) -> None:
    """Check a contour or polar program.

    Rapids stay above the blank, the tool goes down and up clear of it, spindle and tool are on before contact, radius
    compensation changes in air, feeds, travel and speeds are within the machine, and at the end everything is off.
    Raises ``ExportError``.
    """
    safe = blank.height + machine.heights.safe_z_mm
    unit = 10.0**-machine.numbers.decimals
    before = ""
    for motion in program.motions:
        state = motion.state
        low = min(motion.start.z, motion.end.z)
        # The path of a compensated tool is the tooth itself; only an uncompensated one has the wheel round it.
        reach = 0.0 if state.side else wheel_radius
        nearest = _nearest(motion.start, motion.end) - reach
        contact = not low >= blank.height and not nearest > blank.radius
        if motion.kind == "rapid" and not _is_safe_rapid(motion, safe - unit, contact):
            raise _refusal(name, motion, "is a rapid move through the blank or below the safe height")
        if contact and motion.kind != "rapid" and motion.end.z != motion.start.z:
            raise _refusal(name, motion, "plunges into the blank, or leaves it upwards")
        if contact and not (state.spindle > 0.0 and state.tool and state.offset and state.work_offset):
            raise _refusal(name, motion, "touches the blank without spindle, tool, offset or work offset")
        if state.side != before:
            _check_change_of_side(name, motion, blank, wheel_radius, before)
        before = state.side
        _check_limits(name, motion, machine)
    _check_end(name, program, safe - unit)


def check_wire(program: Program, machine: MachineSpec, name: str) -> None:
    """Check a wire program: it moves fast without wire and cuts with one, flushed by the words of the machine file, in
    X and Y alone, within the machine."""
    flushed = bool(machine.blocks.flush_on)
    for motion in program.motions:
        state = motion.state
        if (motion.kind == "rapid") == state.threaded:
            raise _refusal(name, motion, "is a rapid move with the wire threaded, or a cut without")
        if state.flushing != (state.threaded and flushed):
            raise _refusal(name, motion, "is flushed without a wire, or cuts without flushing")
        milling = state.spindle or state.side or state.tool or (state.coolant and not state.flushing)
        if not math.isnan(motion.end.z) or milling:
            raise _refusal(name, motion, "is a milling word in a wire program")
        _check_limits(name, motion, machine)
    for left, what in ((program.state.threaded, "the wire threaded"), (program.state.flushing, "the flushing on")):
        if left:
            raise ExportError(f"program '{name}'", "its end", f"leaves {what}", "correct the machine file", ": ")


def check_turns(program: Program, turns: int, name: str) -> None:
    """Check that C has turned by whole turns at the digits of the control."""
    steps = [motion for motion in program.motions if motion.kind != "rapid" and motion.end.c != motion.start.c]
    drift = steps[-1].end.c - steps[0].start.c - 360.0 * turns
    if not abs(drift) <= C_DRIFT:
        raise ExportError(f"program '{name}', C", f"{drift:.4f}°", "is off a whole turn", "report this as a defect")


def _is_safe_rapid(motion: Motion, safe: float, contact: bool) -> bool:
    """A rapid at the safe height, or straight up or down to it where the tool is clear of the blank."""
    start, end = motion.start, motion.end
    if math.isnan(start.z):
        return end.z >= safe and math.isnan(end.x)
    axes = ((start.x, end.x), (start.y, end.y), (start.c, end.c))
    sideways = any(a != b and not (math.isnan(a) and math.isnan(b)) for a, b in axes)
    return min(start.z, end.z) >= safe or (not sideways and end.z >= safe and not contact)


def _check_change_of_side(name: str, motion: Motion, blank: Blank, wheel_radius: float, before: str) -> None:
    switched = motion.state.side
    # The compensated end is on the offset path, its wheel beyond the programmed point.
    off, on = (motion.start, motion.end) if switched else (motion.end, motion.start)
    in_air = abs(off.plane) - wheel_radius > blank.radius and abs(on.plane) > blank.radius
    if before and switched:
        raise _refusal(name, motion, "changes the side of the compensation without G40")
    if motion.kind != "line" or not in_air:
        raise _refusal(name, motion, "changes the radius compensation on an arc or in the blank")


def _check_limits(name: str, motion: Motion, machine: MachineSpec) -> None:
    axes, numbers, state = machine.axes, machine.numbers, motion.state
    for axis in "xyz":
        low, high = getattr(axes, f"{axis}_mm")
        at = getattr(motion.end, axis)
        if not math.isnan(at) and not low <= at <= high:
            raise _refusal(name, motion, f"leaves the travel of {axis.upper()}, {low:g} to {high:g} mm, at {at:.4f} mm")
    if motion.kind == "rapid":
        return
    low, high = numbers.inverse_time_per_min if state.inverse else numbers.feed_mm_per_min
    if not low <= state.feed <= high:
        raise _refusal(name, motion, f"has F{state.feed:g} outside the range {low:g} to {high:g} of the control")
    minutes = 1.0 / state.feed if state.inverse else 0.0
    if minutes:
        unit = 10.0**-numbers.decimals, 10.0**-numbers.angle_decimals
        x = (abs(motion.end.x - motion.start.x) - unit[0]) / minutes
        c = (abs(motion.end.c - motion.start.c) - unit[1]) / minutes / 60.0
        many = 1.0 + _SPEED_ROUNDING
        if x > axes.x_speed_mm_per_min * many or c > axes.c_speed_deg_per_s * many:
            raise _refusal(name, motion, f"moves X at {x:.1f} mm/min and C at {c:.2f} °/s, faster than the axes")


def _check_end(name: str, program: Program, safe: float) -> None:
    state, last = program.state, program.motions[-1].end
    if state.side or state.spindle or state.coolant or not last.z >= safe:
        left = f"compensation '{state.side}', spindle {state.spindle:g}, coolant {state.coolant}, Z {last.z:g} mm"
        raise ExportError(
            f"program '{name}', its end", left, "is not off and retracted", "correct the end of the machine file"
        )


def _nearest(start: Position, end: Position) -> float:
    """Least distance of a straight motion from the bore axis [mm]; an arc is nearer by its sagitta at most.

    X of a polar program is a radius whatever C is, with Y unknown.
    """
    a, b = (complex(at.x, 0.0 if math.isnan(at.y) else at.y) for at in (start, end))
    if math.isnan(a.real) or math.isnan(b.real):
        return math.inf
    along = b - a
    if abs(along) < _TINY:
        return abs(b)
    share = min(1.0, max(0.0, -(a * along.conjugate()).real / abs(along) ** 2))
    return abs(a + share * along)


def _refusal(name: str, motion: Motion, finding: str) -> ExportError:
    return ExportError(
        f"program '{name}', line {motion.line}:", f"{motion.kind} to {_shown(motion.end)}", finding,
        "correct the machine file", " ",
    )  # fmt: skip


def _shown(at: Position) -> str:
    return " ".join(f"{axis.upper()}{value:.4f}" for axis, value in at._asdict().items() if not math.isnan(value))
