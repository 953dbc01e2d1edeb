"""Contour programs of lines and arcs along the tooth curve, and the same contour as a table."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cycloid_profile.design import flank_relief
from cycloid_profile.export.curves import FIT_SHARE, Arcs, ProfileSource, deviation, disc_arcs
from cycloid_profile.export.nc._chain import arc_block, chain_blocks, line_block
from cycloid_profile.export.nc.dialects import Block, NcDialect, dialect_of, read_gcode, render
from cycloid_profile.export.nc.wheel import overlap_at_grooves, wheel_radius
from cycloid_profile.export.points import POINT_RESOLUTION, Column, write_table
from cycloid_profile.export.writing import SingleFileExporter, WrittenFile, plain_name
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
        """Write, read back and measure the contour between lead-in and lead-out.

        Raises ``ExportError`` for a wheel that does not fit the roots.
        """
        tolerance = source.spec.export.chord_tolerance_um * UM
        post = dialect_of(source.spec.export)
        path.write_text(render(_program(source, tolerance, post), post), encoding="ascii", newline="\n")
        contour, counts = read_gcode(path)
        # Lead-in and lead-out are a line and an arc each.
        found = deviation(source.profile, contour.part(2, contour.curvature.size - 2).points())
        return self.measured(tolerance + post.rounding, found, "own reader of G1/G2/G3", counts)


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
        tolerance = export.chord_tolerance_um * UM
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
    """Comment on how to clamp a disc whose lobes differ."""
    if source.profile.identical_lobes:
        return []
    return comments("LOBES DIFFER: CLAMP THE DISC WITH ITS LOBE 1 ON THE X AXIS")


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


def _program(source: ProfileSource, tolerance: float, post: NcDialect) -> dict[str, list[Block]]:
    export = source.spec.export
    side = _SIDES.get(export.wheel_compensation)
    radius = wheel_radius(source.profile, export.wheel_radius_mm) if side else 0.0
    chain = contour_chain(source, tolerance)
    start = complex(chain.ends[0])
    outward = start / abs(start)
    heading = 1j * outward if side == "right" else -1j * outward
    # Quarter circles tangential to the tip.
    lead = max(_LEAD_RADIUS, _LEAD_PER_WHEEL * radius)
    approach, leave = start + lead * (outward - heading), start + lead * (outward + heading)
    far_in, far_out = approach + lead * outward, leave + lead * outward
    centre = start + lead * outward
    turn = -1.0 if side == "right" else 1.0
    main = [
        line_block(far_in, "rapid"),
        Block("feed", {"f": export.feed_mm_per_min}),
        # A straight first move, because many controls refuse to start a radius compensation on an arc.
        line_block(approach, f"enter {side}" if side else "enter", diameter=2.0 * radius),
        arc_block(post.rounded(approach), start, centre, turn),
        *chain_blocks(chain, 0.1 * tolerance, post),
        arc_block(post.rounded(start), leave, centre, turn),
        line_block(far_out, "leave compensated" if side else "leave"),
        Block("finish"),
    ]
    return {"begin": _head(source, tolerance, radius, post), "main": main, "end": [Block("end", _PROGRAM)]}


def _head(source: ProfileSource, tolerance: float, radius: float, post: NcDialect) -> list[Block]:
    compensation = source.spec.export.wheel_compensation
    wheel = ["PATH IS THE TOOTH CURVE ITSELF: NO WHEEL RADIUS IS ALLOWED FOR"]
    if radius:
        wheel = [f"PATH IS THE TOOTH CURVE: {compensation} SETS OFF THE WHEEL, RADIUS {radius:.4f} MM"]
        overlap = overlap_at_grooves(source.profile, radius)
        if overlap > 0.0:
            gouge = f"{overlap / UM:.3f} MICROMETRE AT GROOVES"
            wheel.append(f"CONTROLS THAT DO NOT CUT CORNERS BACK MAY CUT IN BY {gouge}")
    direction = "ANTICLOCKWISE" if compensation == "G42" else "CLOCKWISE"
    return [
        Block("begin", _PROGRAM),
        *comments(
            f"PROFILE OF {plain_name(source.spec.name).upper()}",
            *wheel,
            f"X Y IN MM FROM THE BORE AXIS, TOOTH ROOT 1 ON THE X AXIS, {direction}",
        ),
        *lobes_note(source),
        *width_note(source),
        *comments(f"ARCS WITHIN {tolerance / UM:.3f} MICROMETRE, {post.decimals} DECIMALS"),
        Block("contour"),
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
