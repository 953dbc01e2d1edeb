"""Contour programs of lines and arcs along the tooth curve, and the same contour as a table."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cycloid_profile.design import flank_relief
from cycloid_profile.errors import ExportError
from cycloid_profile.export.curves import (
    FIT_SHARE,
    Arcs,
    Deviation,
    ProfileSource,
    deviation,
    disc_arcs,
    distances,
    offset_left,
)
from cycloid_profile.export.nc._chain import arc_block, chain_blocks, line_block
from cycloid_profile.export.nc.dialects import Block, Post, post_of, render
from cycloid_profile.export.nc.interpreter import cutting_runs, interpret
from cycloid_profile.export.nc.verify import Blank, check_grinding
from cycloid_profile.export.nc.wheel import least_concave_radius, overlap_at_grooves, wheel_radius
from cycloid_profile.export.points import POINT_RESOLUTION, Column, write_table
from cycloid_profile.export.writing import SingleFileExporter, WrittenFile, plain_name
from cycloid_profile.spec.model import MachineSpec
from cycloid_profile.units import UM

_LEAD_RADIUS = 3.0  # mm
# Controls refuse a lead-in arc tighter than the wheel they compensate.
_LEAD_PER_WHEEL = 1.5
_PROGRAM = {"program": "GRINDING"}
_SIDES = {"G41": "left", "G42": "right"}


@dataclass(frozen=True)
class GcodeExporter(SingleFileExporter[ProfileSource]):
    """Writes ``grinding.nc``: absolute XY in mm, clockwise round the disc, anticlockwise with G42."""

    format: str = "gcode"
    filename: str = "grinding.nc"

    def write_file(self, source: ProfileSource, path: Path) -> WrittenFile:
        """Write, run with the own interpreter, check, and measure the contour of every pass between its leads.

        Raises ``ExportError`` for a wheel that does not fit the roots, or a program that breaks a rule of the machine.
        """
        tolerance = source.spec.export.chord_tolerance
        post = post_of(source.spec.export)
        passes = contour_passes(source, post.machine)
        path.write_text(render(_program(source, passes, tolerance, post), post), encoding="ascii", newline="\n")
        program = interpret(path.read_text(encoding="ascii"), post.machine, path.name)
        check_grinding(program, post.machine, blank_of(source, passes), _compensated_radius(source), path.name)
        # Lead-in and lead-out are a line and an arc each.
        chains = [run.part(2, run.curvature.size - 2).points() for run in cutting_runs(program.motions)]
        found = deviation(source.profile, chains[-1])
        rough = [
            Deviation.of(chain, distances(source.profile, chain) - left)
            for chain, left in zip(chains, passes, strict=True)
        ]
        found = replace(found, largest=max(each.largest for each in rough))
        kinds = [motion.kind for motion in program.motions]
        codes = {"G1": "line", "G2": "clockwise", "G3": "anticlockwise"}
        counts = {code: kinds.count(kind) for code, kind in codes.items()} | {"passes": len(passes)}
        return self.measured(tolerance + post.rounding, found, "own interpreter", counts)


@dataclass(frozen=True)
class GcodePathExporter(SingleFileExporter[ProfileSource]):
    """Writes ``grinding_path.csv``: the contour of ``grinding.nc`` without leads, with a resolution of 1e-9 mm.

    Lines and arcs with centres, outward normals, curvature and feed. ``turn`` is 1 for an anticlockwise arc, −1 for a
    clockwise one, 0 for a line, whose centre and radius are 0.
    """

    format: str = "gcode-path"
    filename: str = "grinding_path.csv"

    def write_file(self, source: ProfileSource, path: Path) -> WrittenFile:
        """See ``SingleFileExporter.write_file``."""
        export = source.spec.export
        tolerance = export.chord_tolerance
        # The disc is on the right of a clockwise path, on the left of an anticlockwise one.
        outward = -1j if export.wheel_compensation == "G42" else 1j
        columns = _path_columns(contour_chain(source, tolerance), export.feed_mm_per_min, outward)
        back = write_table(path, columns)
        ends = back[:, 1:5:2] + 1j * back[:, 2:5:2]
        curvature = np.where(back[:, 5] == 0.0, 0.0, back[:, 5] / np.where(back[:, 8] == 0.0, 1.0, back[:, 8]))
        found = deviation(source.profile, Arcs(np.append(ends[:, 0], ends[-1, 1]), curvature).points())
        return self.measured(tolerance + POINT_RESOLUTION, found, "numpy", {"segments": len(back)})


def started_at_tip(arcs: Arcs, source: ProfileSource) -> Arcs:
    """The same closed chain started at a tooth tip, the highest of all if lobes differ."""
    radius = np.abs(arcs.ends[:-1])
    searched = len(radius) // source.drive.trochoid.lobes + 1 if source.profile.identical_lobes else len(radius)
    return arcs.started_at(int(np.argmax(radius[:searched])))


def comments(*texts: str) -> list[Block]:
    """One comment block per text."""
    return [Block("comment", {"text": text}) for text in texts]


def lobes_note(source: ProfileSource) -> list[Block]:
    """Comments on how to clamp a disc whose lobes differ, or whose openings are turned against its teeth."""
    texts = []
    if source.openings_turn:
        turn = math.degrees(source.openings_turn)
        texts.append(f"DISC {source.disc}: ROOT 1 ON THE X AXIS, OPENINGS {turn:.4f} DEG ANTICLOCKWISE OF DISC 1")
    if not source.profile.identical_lobes:
        texts.append("LOBES DIFFER: CLAMP THE DISC WITH ITS LOBE 1 ON THE X AXIS")
    return comments(*texts)


def width_note(source: ProfileSource) -> list[Block]:
    """Comments on the relief of the flanks along the axis, which the program does not cut."""
    relief, b = flank_relief(source.spec), source.drive.disc_width
    if not relief:
        return []
    texts = ["CONTOUR AT MID-HEIGHT. RELIEF ALONG THE AXIS IS NOT IN THIS PROGRAM: DRESS OR SWING THE WHEEL TO IT"]
    if relief.crowning:
        radius = b**2 / (8.0 * relief.crowning)
        texts.append(f"CROWNING {relief.crowning / UM:g} MICROMETRE AT BOTH EDGES OF {b:g} MM, RADIUS {radius:.0f} MM")
    if relief.edge_relief:
        depth, length = relief.edge_relief / UM, relief.edge_length
        texts.append(f"EDGE RELIEF {depth:g} MICROMETRE MORE OVER THE LAST {length:g} MM AT BOTH EDGES, A PARABOLA")
    if relief.taper:
        angle = math.degrees(math.atan(abs(relief.taper) / b)) * 3600.0
        edge = "UPPER" if relief.taper > 0.0 else "LOWER"
        texts.append(
            f"TAPER {abs(relief.taper) / UM:g} MICROMETRE OVER THE WIDTH, {angle:.1f} ARC SECONDS,"
            f" MORE REMOVED AT THE {edge} EDGE"
        )
    return comments(*texts)


def contour_chain(source: ProfileSource, tolerance: float) -> Arcs:
    """Arcs round the disc from a tip, clockwise, or anticlockwise with G42, within ``tolerance`` [mm]."""
    chain = started_at_tip(disc_arcs(source.profile, FIT_SHARE * tolerance), source)
    return chain.reversed() if source.spec.export.wheel_compensation == "G42" else chain


def stock_of_passes(machine: MachineSpec) -> list[float]:
    """Remaining stock in every pass, spark-out included, last 0 [mm]."""
    given = machine.passes
    cuts = max(1, math.ceil(given.stock_um / given.infeed_um - 1e-9))
    stock = [max(0.0, given.stock_um - (k + 1) * given.infeed_um) * UM for k in range(cuts)]
    return stock + given.spark_out_turns * [0.0]


def contour_passes(source: ProfileSource, machine: MachineSpec) -> list[float]:
    """Stock that each pass of the contour program leaves [mm]; one pass where no wheel is compensated.

    Raises ``ExportError`` if wheel and stock do not fit the roots.
    """
    radius = _compensated_radius(source)
    if not radius:
        return [0.0]
    passes = stock_of_passes(machine)
    limit = least_concave_radius(source.profile)
    if radius + passes[0] >= limit:
        raise ExportError(
            "export.wheel_radius_mm",
            f"{radius:g}",
            f"does not fit the roots, {limit:.4f} mm, under the {passes[0] / UM:g} µm that the first pass leaves",
            "take a smaller wheel, or lower export.grinding.stock_um",
        )
    return passes


def _compensated_radius(source: ProfileSource) -> float:
    export = source.spec.export
    return wheel_radius(source.profile, export.wheel_radius_mm) if export.wheel_compensation != "none" else 0.0


def blank_of(source: ProfileSource, passes: list[float]) -> Blank:
    """The blank with the stock that the first pass leaves."""
    tips = source.profile.at(math.pi * (2.0 * np.arange(source.profile.trochoid.lobes) + 1.0)).position
    return Blank(float(np.max(np.abs(tips))) + passes[0], source.drive.disc_width)


def _program(source: ProfileSource, passes: list[float], tolerance: float, post: Post) -> dict[str, list[Block]]:
    machine = post.machine
    safe = source.drive.disc_width + machine.heights.safe_z_mm
    chain = started_at_tip(disc_arcs(source.profile, FIT_SHARE * tolerance), source)
    main = post.own("tool", "spindle_on", "coolant_on") + post.own("first_height", z=safe)
    for number, left in enumerate(passes, start=1):
        main += comments(f"PASS {number} OF {len(passes)}, LEAVES {left / UM:g} MICROMETRE")
        # The outside is on the left of a clockwise chain.
        one = offset_left(chain, left) if left else chain
        main += _pass(source, one, 0.1 * tolerance, safe, post)
    main += post.own("coolant_off", "spindle_off", "end")
    return {"begin": _head(source, passes, tolerance, post), "main": main, "end": [Block("end", _PROGRAM)]}


def _pass(source: ProfileSource, chain: Arcs, sagitta: float, safe: float, post: Post) -> list[Block]:
    """One pass: down outside the disc, in, round the disc, out and up."""
    export, machine = source.spec.export, post.machine
    side = _SIDES.get(export.wheel_compensation)
    radius = _compensated_radius(source)
    chain = chain.reversed() if side == "right" else chain
    start = complex(chain.ends[0])
    outward = start / abs(start)
    heading = 1j * outward if side == "right" else -1j * outward
    # Quarter circles tangential to the tip.
    lead = max(_LEAD_RADIUS, _LEAD_PER_WHEEL * radius)
    approach, leave = start + lead * (outward - heading), start + lead * (outward + heading)
    far_in, far_out = approach + lead * outward, leave + lead * outward
    centre = start + lead * outward
    turn = -1.0 if side == "right" else 1.0
    air, cut = machine.passes.approach_feed_mm_per_min, export.feed_mm_per_min
    entry = arc_block(post.rounded(approach), start, centre, turn)
    return [
        line_block(far_in, "rapid"),
        Block("height", {"z": -machine.heights.overrun_mm, "feed": air}),
        # A straight first move, because many controls refuse to start a radius compensation on an arc.
        line_block(approach, f"enter {side}" if side else "enter", diameter=2.0 * radius, feed=air),
        Block(entry.kind, {**entry.words, "feed": cut}),
        *chain_blocks(chain, sagitta, post),
        arc_block(post.rounded(start), leave, centre, turn),
        line_block(far_out, "leave compensated" if side else "leave", feed=air),
        Block("height rapid", {"z": safe}),
    ]


def _head(source: ProfileSource, passes: list[float], tolerance: float, post: Post) -> list[Block]:
    compensation, width = source.spec.export.wheel_compensation, source.drive.disc_width
    radius = _compensated_radius(source)
    wheel = ["PATH IS THE TOOTH CURVE ITSELF IN ONE PASS: NO WHEEL RADIUS AND NO STOCK IS ALLOWED FOR"]
    if radius:
        wheel = [f"PATH IS THE TOOTH CURVE: {compensation} SETS OFF THE WHEEL, RADIUS {radius:.4f} MM"]
        wheel.append(f"{len(passes)} PASSES, THE FIRST LEAVES {passes[0] / UM:g} MICROMETRE")
        overlap = overlap_at_grooves(source.profile, radius)
        if overlap > 0.0:
            gouge = f"{overlap / UM:.3f} MICROMETRE AT GROOVES"
            wheel.append(f"CONTROLS THAT DO NOT CUT CORNERS BACK MAY CUT IN BY {gouge}")
    direction = "ANTICLOCKWISE" if compensation == "G42" else "CLOCKWISE"
    return [
        Block("begin", _PROGRAM),
        *comments(
            f"PROFILE OF {plain_name(source.spec.name).upper()}",
            f"MACHINE {plain_name(post.machine.name).upper()}",
            *wheel,
            f"X Y IN MM FROM THE BORE AXIS, TOOTH ROOT 1 ON THE X AXIS, {direction}",
            f"Z0 IS THE LOWER FACE OF THE DISC, Z{width:g} THE UPPER ONE",
        ),
        *lobes_note(source),
        *width_note(source),
        *comments(f"ARCS WITHIN {tolerance / UM:.3f} MICROMETRE, {post.decimals} DECIMALS"),
        *post.own("contour"),
    ]


def _path_columns(chain: Arcs, feed: float, outward: complex) -> tuple[Column, ...]:
    curved = chain.curvature != 0.0
    centre = np.where(curved, np.nan_to_num(chain.centres), 0.0)
    radius = np.where(curved, 1.0 / np.where(curved, np.abs(chain.curvature), 1.0), 0.0)
    n0, n1 = (outward * tangent for tangent in chain.tangents)
    start, end = chain.ends[:-1], chain.ends[1:]
    return (
        ("segment", np.arange(1.0, radius.size + 1.0), 0),
        ("x0_mm", start.real, 9), ("y0_mm", start.imag, 9), ("x1_mm", end.real, 9), ("y1_mm", end.imag, 9),
        ("turn", np.sign(chain.curvature), 0),
        ("centre_x_mm", centre.real, 9), ("centre_y_mm", centre.imag, 9), ("radius_mm", radius, 9),
        ("nx0", n0.real, 9), ("ny0", n0.imag, 9), ("nx1", n1.real, 9), ("ny1", n1.imag, 9),
        # Negative where the tooth is convex, in either direction of the path.
        ("curvature_per_mm", chain.curvature * outward.imag, 9),
        ("length_mm", chain.lengths, 9), ("feed_mm_per_min", np.full(radius.shape, feed), 6),
    )  # fmt: skip
