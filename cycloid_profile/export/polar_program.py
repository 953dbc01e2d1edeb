"""The grinding program in C and X: one turn as a subprogram of small steps, called for every infeed and spark-out."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.export.cnc_read import read_turn
from cycloid_profile.export.deviation import Deviation, deviation
from cycloid_profile.export.disc_path import Ground
from cycloid_profile.export.gcode import comments, lobes_note
from cycloid_profile.export.points import POINT_RESOLUTION, read_table, write_table
from cycloid_profile.export.polar import PolarPath, polar_path
from cycloid_profile.export.polar_feed import AxisLimits, FeedProfile, axis_motion, feed_profile, seconds
from cycloid_profile.export.post import Block, Post, post_of, render
from cycloid_profile.export.refine import FIT_SHARE
from cycloid_profile.export.text import plain_name
from cycloid_profile.export.wheel import clearance, groove_left, wheel_radius
from cycloid_profile.export.written import WrittenFile
from cycloid_profile.spec.machining import GrindingSpec
from cycloid_profile.units import DEGREE, UM

PATH_COLUMNS = (
    "step", "c_deg", "x_mm", "psi_rad", "contact_x_mm", "contact_y_mm", "nx", "ny", "curvature_per_mm",
    "wheel_x_mm", "wheel_y_mm", "way_mm", "time_s", "surface_speed_mm_per_min",
)  # fmt: skip
_PROGRAM = {"program": "GRINDING_POLAR"}
_BETWEEN = (0.0, 0.25, 0.5, 0.75)


@dataclass(frozen=True, slots=True)
class PolarGrinding:
    """A wheel path with its feed and the moments of its steps."""

    path: PolarPath
    feed: FeedProfile
    groove_left: float

    @property
    def time(self) -> FloatArray:
        """Time at every step from the start of the turn, shape (n + 1,) [s]."""
        return np.concatenate([[0.0], np.cumsum(self.feed.time)])


@dataclass(frozen=True, slots=True)
class PolarExporter:
    """Writes ``grinding_polar.nc`` and, for any other machine, the path as ``grinding_polar_path.csv``."""

    format: str = "gcode-polar"
    filenames: tuple[str, ...] = ("grinding_polar.nc", "grinding_polar_path.csv")

    def write(self, record: Ground, folder: Path) -> tuple[WrittenFile, ...]:
        """Write, read back, and measure how far the wheel is from touching the exact tooth, steps included.

        Raises ``ExportError`` for a wheel that does not go into the roots.
        """
        program, table = (folder / name for name in self.filenames)
        tolerance = record.spec.export.chord_tolerance_um * UM
        grinding = polar_grinding(record)
        post = post_of(record.spec.export)
        program.write_text(render(_program(record, grinding, post), post), encoding="ascii", newline="\n")
        write_table(table, PATH_COLUMNS, _rows(grinding))
        turn = read_turn(program)
        centre = np.concatenate([_centre(turn.x, turn.c, t) for t in _BETWEEN])
        off = clearance(record.profile, centre) - grinding.path.radius
        found = Deviation(
            largest=float(np.max(np.abs(off))),
            rms=float(np.sqrt(np.mean(off**2))),
            worst_angle=float(np.angle(centre[int(np.argmax(np.abs(off)))])),
            points=off.size,
        )
        back = read_table(table)
        contact = deviation(record.profile, back[:, 4] + 1j * back[:, 5])
        count = {"steps": turn.x.size - 1, "turns": len(infeeds(record.spec.export.grinding))}
        promise = tolerance + rounding(grinding.path, post)
        return (
            WrittenFile(program.name, self.format, promise, found, "own reader of C and X", count),
            WrittenFile(table.name, self.format, POINT_RESOLUTION, contact, "numpy", {"points": len(back)}),
        )


def polar_grinding(record: Ground) -> PolarGrinding:
    """Path and feed as the spec asks for them."""
    export = record.spec.export
    profile = record.profile
    path = polar_path(
        profile, wheel_radius(profile, export.wheel_radius_mm), FIT_SHARE * export.chord_tolerance_um * UM
    )
    repeats = profile.trochoid.lobes if profile.lobes_alike else 1
    feed = feed_profile(path, export.feed_mm_per_min / 60.0, axis_limits(export.grinding), repeats)
    return PolarGrinding(path, feed, groove_left(profile, path.centre, path.radius))


def axis_limits(grinding: GrindingSpec) -> AxisLimits:
    """Limits of the axes in base units."""
    return AxisLimits(
        c_speed=grinding.c_speed_limit_deg_per_s * DEGREE,
        c_acceleration=grinding.c_acceleration_limit_deg_per_s2 * DEGREE,
        x_speed=grinding.x_speed_limit_mm_per_min / 60.0,
        x_acceleration=grinding.x_acceleration_limit_mm_per_s2,
    )


def infeeds(grinding: GrindingSpec) -> list[float]:
    """Stock left along X in every turn, spark-out included, last 0 [mm]."""
    cuts = max(1, math.ceil(grinding.stock_um / grinding.infeed_um - 1e-9))
    left = [max(0.0, grinding.stock_um - (k + 1) * grinding.infeed_um) * UM for k in range(cuts)]
    return left + grinding.spark_out_turns * [0.0]


def rounding(path: PolarPath, post: Post) -> float:
    """What rounding X and C can add to the distance between wheel and tooth [mm]."""
    largest = float(np.max(path.x))
    return 0.5 * 10.0**-post.decimals + 0.5 * 10.0**-post.angle_decimals * DEGREE * largest


def _program(record: Ground, grinding: PolarGrinding, post: Post) -> dict[str, list[Block]]:
    setting, path = record.spec.export.grinding, grinding.path
    x = np.round(path.x, post.decimals)
    c = np.round(path.c / DEGREE, post.angle_decimals)
    c[-1] = c[0] + 360.0
    x, c, time = _joined(x, c, grinding.feed.time)
    safe = {"x": float(x[0]) + setting.safe_distance_mm, "c": float(c[0])}
    main = [Block("polar"), Block("polar rapid", safe)]
    before = -1.0
    for stock in infeeds(setting):
        if stock != before:
            main.append(Block("polar infeed", {"x": float(x[0]) + stock, "f": setting.infeed_feed_mm_per_min}))
        main.append(Block("turn"))
        before = stock
    main += [Block("polar retract", safe), Block("finish")]
    # Differences of rounded places: they add up to exactly one turn, and to nothing in X.
    steps = zip(np.diff(x).tolist(), np.diff(c).tolist(), time.tolist(), strict=True)
    turn = [
        Block("polar step", {"x": dx, "c": dc, "inverse": 60.0 / t, "mixed": 60.0 * math.hypot(dx, dc) / t})
        for dx, dc, t in steps
    ]
    return {
        "begin": _head(record, grinding),
        "turn": [Block("turn begins"), *turn, Block("turn ends")],
        "main": main,
        "end": [Block("end", _PROGRAM)],
    }


def _joined(x: FloatArray, c: FloatArray, time: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Steps too short for the decimals joined to the next, so that C rises in every one."""
    kept = np.unique(c[:-1], return_index=True)[1]
    kept = kept[c[kept] < c[-1]]
    return np.append(x[kept], x[-1]), np.append(c[kept], c[-1]), np.add.reduceat(time, kept)


def _head(record: Ground, grinding: PolarGrinding) -> list[Block]:
    export, path, feed = record.spec.export, grinding.path, grinding.feed
    setting = export.grinding
    c_speed, x_speed = (float(np.max(np.abs(v))) for v in axis_motion(path, feed))
    reached = float(np.min(feed.speed)) * 60.0
    return [
        Block("begin", _PROGRAM),
        *comments(
            f"POLAR GRINDING OF {plain_name(record.spec.name).upper()}",
            f"WHEEL RADIUS {path.radius:.5f} MM, X IS ITS CENTRE FROM THE BORE AXIS: A RADIUS, NO DIAMETER",
            "C TURNS THE DISC, POSITIVE ANTICLOCKWISE. AT C = 0 TOOTH ROOT 1 FACES THE WHEEL",
            "STARTS AT A TIP. C RISES BY 360 IN EVERY TURN: ITS DISPLAY MAY ROLL OVER, THE STEPS ARE INCREMENTAL",
        ),
        *lobes_note(record),
        *comments(
            f"WITHIN {export.chord_tolerance_um:.3f} MICROMETRE OF TANGENCY, {len(feed.time)} STEPS A TURN",
            f"CONTACT RUNS AT {reached:.1f} TO {float(np.max(feed.speed)) * 60.0:.1f} MM/MIN ALONG THE FLANK,"
            f" {seconds(feed):.1f} S A TURN",
            f"SHORTEST STEP {float(np.min(feed.time)) * 1e3:.2f} MS, C UP TO {c_speed / DEGREE:.2f} DEG/S,"
            f" X UP TO {x_speed * 60.0:.1f} MM/MIN",
            f"STOCK {setting.stock_um:g} MICROMETRE ALONG X, {setting.infeed_um:g} A TURN,"
            f" {setting.spark_out_turns} TURNS OF SPARK-OUT",
            f"DRESSING TAKES {setting.dressing_allowance_um:g} MICROMETRE OFF THE RADIUS:"
            " WRITE THE PROGRAM ANEW FOR THE SMALLER WHEEL",
            f"LEFT STANDING IN GROOVES AT ROOT AND TIP: {grinding.groove_left / UM:.4f} MICROMETRE",
        ),
    ]


def _rows(grinding: PolarGrinding) -> list[str]:
    path = grinding.path
    w, p, n = path.centre, path.contact, path.normal
    columns = (
        (path.c / DEGREE, 9), (path.x, 9), (path.phase, 10), (p.real, 9), (p.imag, 9), (n.real, 8), (n.imag, 8),
        (path.curvature, 6), (w.real, 9), (w.imag, 9), (path.way, 6), (grinding.time, 6),
        (grinding.feed.speed * 60.0, 4),
    )  # fmt: skip
    shown = [[f"{value:.{places}f}" for value in (np.round(v, places) + 0.0).tolist()] for v, places in columns]
    return [f"{i},{','.join(row)}" for i, row in enumerate(zip(*shown, strict=True))]


def _centre(x: FloatArray, c_deg: FloatArray, t: float) -> ComplexArray:
    """Centre of the wheel in the disc frame a share ``t`` of every step on [mm]."""
    at_x, at_c = (v[:-1] + t * np.diff(v) for v in (x, c_deg))
    centre: ComplexArray = at_x * np.exp(-1j * at_c * DEGREE)
    return centre
