"""Polar grinding in C and X: the feed along a wheel path, and one turn as a subprogram called for every infeed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cycloid_profile._display import Described
from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.export.curves import FIT_SHARE, Deviation, ProfileSource, deviation
from cycloid_profile.export.nc.contour import blank_of, comments, lobes_note, stock_of_passes, width_note
from cycloid_profile.export.nc.dialects import Block, Post, post_of, render
from cycloid_profile.export.nc.interpreter import Program, interpret
from cycloid_profile.export.nc.polar_motion import PolarPath, polar_path
from cycloid_profile.export.nc.verify import check_grinding, check_turns
from cycloid_profile.export.nc.wheel import clearance, groove_stock, wheel_radius
from cycloid_profile.export.points import POINT_RESOLUTION, Column, write_table
from cycloid_profile.export.writing import WrittenFile, plain_name
from cycloid_profile.units import DEGREE, UM

_PROGRAM = {"program": "GRINDING_POLAR"}
_CHECKS = (0.0, 0.25, 0.5, 0.75)  # of every step


@dataclass(frozen=True, slots=True)
class AxisLimits:
    """Largest speeds and accelerations: of C [rad/s, rad/s²], of X [mm/s, mm/s²].

    ``inverse_time`` and ``mixed_feed``: largest F of the control, in inverse time [1/min], or along X in mm and C in
    degrees together [mm/min].
    """

    c_speed: float
    c_acceleration: float
    x_speed: float
    x_acceleration: float
    inverse_time: float = math.inf
    mixed_feed: float = math.inf

    def least_time(self, path: PolarPath) -> FloatArray:
        """Shortest time of every step that F can express, shape (n,) [s]."""
        length = np.hypot(np.diff(path.x), np.diff(path.c) / DEGREE)
        return np.maximum(60.0 / self.inverse_time, 60.0 * length / self.mixed_feed)


@dataclass(frozen=True, eq=False, slots=True)
class FeedProfile:
    """``speed`` of the contact along the flank at every step, shape (n + 1,) [mm/s]; ``time`` of every step [s]."""

    speed: FloatArray
    time: FloatArray


def feed_profile(path: PolarPath, speed: float, limits: AxisLimits, repeats: int = 1) -> FeedProfile:
    """The fastest periodic feed of at most ``speed`` [mm/s] along the flank.

    The path consists of ``repeats`` identical parts, such as identical lobes, of which one is solved.
    """
    steps = (path.c.size - 1) // repeats
    squares = _squares(path, steps, speed, limits)
    at = np.sqrt(np.append(np.tile(squares, repeats), squares[0]))
    return FeedProfile(speed=at, time=2.0 * np.diff(path.arc_length) / (at[:-1] + at[1:]))


def _squares(path: PolarPath, steps: int, speed: float, limits: AxisLimits) -> FloatArray:
    """Square of the speed at the first ``steps`` nodes, which repeat."""
    axes = (
        (path.c_rate[:steps], path.c_second[:steps], limits.c_speed, limits.c_acceleration),
        (path.x_rate[:steps], path.x_second[:steps], limits.x_speed, limits.x_acceleration),
    )
    # The mean of the speeds at both ends counts: where neither exceeds the limit, the step does not.
    step = np.diff(path.arc_length[: steps + 1])
    with np.errstate(divide="ignore"):
        shortest = (step / limits.least_time(path)[:steps]) ** 2
    most = np.minimum(speed**2, np.minimum(shortest, np.roll(shortest, 1)))
    for rate, _, fastest, _ in axes:
        with np.errstate(divide="ignore"):
            bound = (fastest / np.abs(rate)) ** 2
        most = np.minimum(most, np.minimum(bound[:, 0], np.roll(bound[:, 1], 1)))
    half = 0.5 / step
    # Coefficients of b at the start and at the end of each step, for the acceleration at either of them.
    rows = []
    for rate, second, _, largest in axes:
        for end in (0, 1):
            start_b, end_b = -rate[:, end] * half, rate[:, end] * half
            (start_b, end_b)[end][:] += second[:, end]
            rows.append((start_b / largest, end_b / largest))
    return _largest(most, rows)


def _largest(most: FloatArray, rows: list[tuple[FloatArray, FloatArray]]) -> FloatArray:
    """The largest b ≤ ``most`` whose accelerations, as shares of their limits, stay within ±1."""
    successor = np.roll(most, -1)
    if all(np.all(np.abs(p * most + q * successor) <= 1.0) for p, q in rows):
        return most
    from scipy.optimize import linprog
    from scipy.sparse import coo_array, vstack

    n = most.size
    i = np.arange(n)
    blocks = [
        coo_array(
            (np.concatenate([p * most, q * successor]), (np.tile(i, 2), np.concatenate([i, (i + 1) % n]))), (n, n)
        )
        for p, q in rows
    ]
    matrix = vstack(blocks)
    # Scaled by the bound, which keeps the unknowns near 1.
    found = linprog(
        -np.ones(n), A_ub=vstack([matrix, -matrix]).tocsr(), b_ub=np.ones(2 * matrix.shape[0]), bounds=(0.0, 1.0)
    )
    if not found.success or not float(np.min(found.x)) > 0.0:
        raise ArithmeticError(f"the feed profile was not found: {found.message}")
    squares: FloatArray = most * found.x
    return squares


def axis_motion(path: PolarPath, feed: FeedProfile) -> tuple[FloatArray, FloatArray]:
    """Mean speeds of C [rad/s] and X [mm/s] during every step, shape (n,) both."""
    return np.diff(path.c) / feed.time, np.diff(path.x) / feed.time


def seconds(feed: FeedProfile) -> float:
    """Duration of one turn [s]."""
    return math.fsum(feed.time.tolist())


@dataclass(frozen=True, slots=True, repr=False)
class PolarGrinding(Described):
    """A wheel path with its feed, and the stock left in grooves at root and tip [mm]."""

    path: PolarPath
    feed: FeedProfile
    groove_stock: float

    def _key_figures(self) -> dict[str, str]:
        return {
            "wheel radius": f"{self.path.radius:.6g} mm",
            "steps": f"{self.feed.time.size}",
            "time per turn": f"{seconds(self.feed):.4g} s",
            "stock left in grooves": f"{self.groove_stock / UM:.4g} µm",
        }

    @property
    def time(self) -> FloatArray:
        """Time at every step from the start of the turn, shape (n + 1,) [s]."""
        return np.concatenate([[0.0], np.cumsum(self.feed.time)])


@dataclass(frozen=True, slots=True)
class PolarExporter:
    """Writes ``grinding_polar.nc`` and, for any other machine, the path as ``grinding_polar_path.csv``."""

    format: str = "gcode-polar"
    filenames: tuple[str, ...] = ("grinding_polar.nc", "grinding_polar_path.csv")

    def write(self, record: ProfileSource, folder: Path) -> tuple[WrittenFile, ...]:
        """Write, read back, and measure the distance of the wheel from the exact tooth, between steps as well.

        Raises ``ExportError`` for a wheel that does not fit the roots.
        """
        file, table = (folder / name for name in self.filenames)
        tolerance = record.spec.export.chord_tolerance
        post = post_of(record.spec.export)
        grinding = polar_grinding(record)
        turns = stock_of_passes(post.machine)
        file.write_text(render(_program(record, grinding, turns, post), post), encoding="ascii", newline="\n")
        program = interpret(file.read_text(encoding="ascii"), post.machine, file.name)
        check_grinding(program, post.machine, blank_of(record, turns), grinding.path.radius, file.name)
        check_turns(program, len(turns), file.name)
        x, c = last_turn(program)
        centre = np.concatenate([_centre(x, c, t) for t in _CHECKS])
        off = clearance(record.profile, centre) - grinding.path.radius
        found = Deviation.of(centre, off)
        back = write_table(table, _path_columns(grinding))
        contact = deviation(record.profile, back[:, 4] + 1j * back[:, 5])
        count = {"steps": x.size - 1, "turns": len(turns)}
        allowed = tolerance + rounding(grinding.path, post)
        return (
            WrittenFile(file.name, self.format, allowed, found, "own interpreter", count),
            WrittenFile(table.name, self.format, POINT_RESOLUTION, contact, "numpy", {"points": len(back)}),
        )


def last_turn(program: Program) -> tuple[FloatArray, FloatArray]:
    """X [mm] and C [°] at the start and after every step of the last turn, shape (n + 1,)."""
    steps = [motion for motion in program.motions if motion.kind == "line" and motion.end.c != motion.start.c]
    x, c = (np.array([getattr(at, axis) for at in (steps[0].start, *(m.end for m in steps))]) for axis in "xc")
    first = int(np.argmin(np.abs(c - (c[-1] - 360.0))))
    return x[first:], c[first:]


def polar_grinding(record: ProfileSource) -> PolarGrinding:
    """Wheel path and feed for the ``[export]`` settings. Raises ``ExportError`` if the wheel does not fit."""
    export = record.spec.export
    profile = record.profile
    path = polar_path(profile, wheel_radius(profile, export.wheel_radius_mm), FIT_SHARE * export.chord_tolerance)
    repeats = profile.trochoid.lobes if profile.identical_lobes else 1
    feed = feed_profile(path, export.feed_mm_per_min / 60.0, axis_limits(post_of(export)), repeats)
    return PolarGrinding(path, feed, groove_stock(profile, path.centre, path.radius))


def axis_limits(post: Post) -> AxisLimits:
    """Limits of the axes of a machine in base units."""
    axes, numbers = post.machine.axes, post.machine.numbers
    inverse = post.dialect.inverse_time
    return AxisLimits(
        c_speed=axes.c_speed_deg_per_s * DEGREE,
        c_acceleration=axes.c_acceleration_deg_per_s2 * DEGREE,
        x_speed=axes.x_speed_mm_per_min / 60.0,
        x_acceleration=axes.x_acceleration_mm_per_s2,
        inverse_time=numbers.inverse_time_per_min[1] if inverse else math.inf,
        mixed_feed=math.inf if inverse else numbers.feed_mm_per_min[1],
    )


def rounding(path: PolarPath, post: Post) -> float:
    """Largest effect of rounding X and C on the distance between wheel and tooth [mm]."""
    largest = float(np.max(path.x))
    return 0.5 * 10.0**-post.decimals + 0.5 * 10.0**-post.angle_decimals * DEGREE * largest


def _program(record: ProfileSource, grinding: PolarGrinding, turns: list[float], post: Post) -> dict[str, list[Block]]:
    setting, machine, path = record.spec.export.grinding, post.machine, grinding.path
    x = np.round(path.x, post.decimals)
    c = np.round(path.c / DEGREE, post.angle_decimals)
    c[-1] = c[0] + 360.0
    x, c, time = _without_short_steps(x, c, grinding.feed.time)
    width = record.drive.disc_width
    safe = width + machine.heights.safe_z_mm
    air, infeed = machine.passes.approach_feed_mm_per_min, machine.passes.infeed_feed_mm_per_min
    stocked = float(x[0]) + machine.passes.stock_um * UM
    # The infeed begins just in front of the stock.
    away, near = stocked + setting.safe_distance_mm, stocked + machine.passes.approach_gap_mm
    main = post.own("polar", "tool", "spindle_on", "coolant_on") + post.own("first_height", z=safe)
    main += [
        Block("polar rapid", {"x": away, "c": float(c[0])}),
        Block("height", {"z": 0.5 * width, "feed": air}),
        *([Block("polar infeed", {"x": near, "feed": air})] if near < away else []),
    ]
    absolute = machine.numbers.c == "absolute"
    before = -1.0
    for number, stock in enumerate(turns):
        if stock != before:
            main.append(Block("polar infeed", {"x": float(x[0]) + stock, "feed": infeed}))
        main += _absolute_turn(x + stock, c + 360.0 * number, time, post) if absolute else [Block("turn")]
        before = stock
    main += [Block("polar infeed", {"x": away, "feed": air}), Block("height rapid", {"z": safe})]
    main += post.own("coolant_off", "spindle_off", "end")
    parts = {"begin": _head(record, grinding, post), "main": main, "end": [Block("end", _PROGRAM)]}
    # Differences of rounded positions: their sum is exactly one turn in C and zero in X.
    steps = _steps("polar step", np.diff(x), np.diff(c), x, c, time)
    return parts if absolute else parts | {"turn": [Block("turn begins"), *steps, Block("turn ends")]}


def _absolute_turn(x: FloatArray, c: FloatArray, time: FloatArray, post: Post) -> list[Block]:
    kind = "polar step absolute" if "polar step absolute" in post.dialect.templates else "polar step"
    return [Block("absolute begins"), *_steps(kind, x[1:], c[1:], x, c, time), Block("absolute ends")]


def _steps(
    kind: str, x_word: FloatArray, c_word: FloatArray, x: FloatArray, c: FloatArray, time: FloatArray
) -> list[Block]:
    """One block a step with the given words, and F from the ``time`` of the step."""
    length = np.hypot(np.diff(x), np.diff(c))
    columns = (v.tolist() for v in (x_word, c_word, 60.0 / time, 60.0 * length / time))
    return [Block(kind, {"x": dx, "c": dc, "inverse": f, "mixed": g}) for dx, dc, f, g in zip(*columns, strict=True)]


def _without_short_steps(x: FloatArray, c: FloatArray, time: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Join steps below the resolution of C to the next, so that C rises in every step."""
    kept = np.unique(c[:-1], return_index=True)[1]
    kept = kept[c[kept] < c[-1]]
    return np.append(x[kept], x[-1]), np.append(c[kept], c[-1]), np.add.reduceat(time, kept)


def _head(record: ProfileSource, grinding: PolarGrinding, post: Post) -> list[Block]:
    export, path, feed = record.spec.export, grinding.path, grinding.feed
    setting, passes = export.grinding, post.machine.passes
    rises = "ITS DISPLAY MAY ROLL OVER, THE STEPS ARE INCREMENTAL"
    if post.machine.numbers.c == "absolute":
        rises = "ALL POSITIONS ARE ABSOLUTE"
    c_speed, x_speed = (float(np.max(np.abs(v))) for v in axis_motion(path, feed))
    reached = float(np.min(feed.speed)) * 60.0
    return [
        Block("begin", _PROGRAM),
        *comments(
            f"POLAR GRINDING OF {plain_name(record.spec.name).upper()}",
            f"MACHINE {plain_name(post.machine.name).upper()}",
            f"WHEEL RADIUS {path.radius:.5f} MM, X IS ITS CENTRE FROM THE BORE AXIS: A RADIUS, NO DIAMETER",
            "C TURNS THE DISC, POSITIVE ANTICLOCKWISE. AT C = 0 TOOTH ROOT 1 FACES THE WHEEL",
            f"STARTS AT A TIP. C RISES BY 360 IN EVERY TURN: {rises}",
            f"Z0 IS THE LOWER FACE OF THE DISC, Z{record.drive.disc_width:g} THE UPPER ONE, Z THE MIDDLE OF THE WHEEL",
        ),
        *lobes_note(record),
        *width_note(record),
        *comments(
            f"WITHIN {export.chord_tolerance_um:.3f} MICROMETRE OF TANGENCY, {len(feed.time)} STEPS A TURN",
            f"CONTACT RUNS AT {reached:.1f} TO {float(np.max(feed.speed)) * 60.0:.1f} MM/MIN ALONG THE FLANK,"
            f" {seconds(feed):.1f} S A TURN",
            f"SHORTEST STEP {float(np.min(feed.time)) * 1e3:.2f} MS, C UP TO {c_speed / DEGREE:.2f} DEG/S,"
            f" X UP TO {x_speed * 60.0:.1f} MM/MIN",
            f"STOCK {passes.stock_um:g} MICROMETRE ALONG X, {passes.infeed_um:g} A TURN,"
            f" {passes.spark_out_turns} TURNS OF SPARK-OUT",
            f"DRESSING TAKES {setting.dressing_allowance_um:g} MICROMETRE OFF THE RADIUS:"
            " GENERATE A NEW PROGRAM FOR THE SMALLER WHEEL",
            f"STOCK LEFT IN GROOVES AT ROOT AND TIP: {grinding.groove_stock / UM:.4f} MICROMETRE",
        ),
    ]


def _path_columns(grinding: PolarGrinding) -> tuple[Column, ...]:
    path, time = grinding.path, grinding.time
    wheel, contact, n = path.centre, path.contact, path.normal
    return (
        ("step", np.arange(float(time.size)), 0), ("c_deg", path.c / DEGREE, 9), ("x_mm", path.x, 9),
        ("psi_rad", path.phase, 10), ("contact_x_mm", contact.real, 9), ("contact_y_mm", contact.imag, 9),
        ("nx", n.real, 8), ("ny", n.imag, 8), ("curvature_per_mm", path.curvature, 6),
        ("wheel_x_mm", wheel.real, 9), ("wheel_y_mm", wheel.imag, 9), ("way_mm", path.arc_length, 6),
        ("time_s", time, 6), ("surface_speed_mm_per_min", grinding.feed.speed * 60.0, 4),
    )  # fmt: skip


def _centre(x: FloatArray, c_deg: FloatArray, t: float) -> ComplexArray:
    """Centre of the wheel in the disc frame at the fraction ``t`` of every step [mm]."""
    at_x, at_c = (v[:-1] + t * np.diff(v) for v in (x, c_deg))
    centre: ComplexArray = at_x * np.exp(-1j * at_c * DEGREE)
    return centre
