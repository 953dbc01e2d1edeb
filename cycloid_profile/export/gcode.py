"""A contour program of lines and arcs along the tooth curve, with or without compensation of the wheel's radius."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cycloid_profile.export.biarc import Arcs, disc_arcs
from cycloid_profile.export.cnc_chain import arc_block, chain_blocks, line_block, reversed_chain, started_at
from cycloid_profile.export.cnc_read import read_gcode
from cycloid_profile.export.deviation import deviation
from cycloid_profile.export.disc_path import Ground
from cycloid_profile.export.post import Block, Post, post_of, render
from cycloid_profile.export.refine import FIT_SHARE
from cycloid_profile.export.text import plain_name
from cycloid_profile.export.wheel import overlap_at_grooves, wheel_radius
from cycloid_profile.export.written import WrittenFile
from cycloid_profile.units import UM

_LEAD_RADIUS = 3.0  # mm
# A control refuses to follow a lead-in tighter than the wheel it sets off.
_LEAD_PER_WHEEL = 1.5
_PROGRAM = {"program": "GRINDING"}
_SIDES = {"G41": "left", "G42": "right"}


@dataclass(frozen=True, slots=True)
class GcodeExporter:
    """Writes ``grinding.nc``: absolute XY in mm, clockwise round the disc, anticlockwise with G42."""

    format: str = "gcode"
    filename: str = "grinding.nc"

    @property
    def filenames(self) -> tuple[str, ...]:
        """See ``Exporter.filenames``."""
        return (self.filename,)

    def write(self, record: Ground, folder: Path) -> tuple[WrittenFile, ...]:
        """Write, read back and measure the contour between lead-in and lead-out.

        Raises ``ExportError`` for a wheel that does not go into the roots.
        """
        tolerance = record.spec.export.chord_tolerance_um * UM
        path = folder / self.filename
        post = post_of(record.spec.export)
        path.write_text(render(_program(record, tolerance, post), post), encoding="ascii", newline="\n")
        contour, counts = read_gcode(path)
        # Lead-in and lead-out are a line and an arc each.
        inner = Arcs(contour.ends[2:-2], contour.bend[2:-2])
        found = deviation(record.profile, inner.points())
        promise = tolerance + post.rounding
        return (WrittenFile(self.filename, self.format, promise, found, "own reader of G1/G2/G3", counts),)


def from_tip(arcs: Arcs, record: Ground) -> Arcs:
    """The same closed chain started at a tooth tip, where a lead-in does no harm."""
    radius = np.abs(arcs.ends[:-1])
    # Where lobes differ their arcs cannot be counted off: the highest tip of all is taken.
    reach = len(radius) // record.drive.trochoid.lobes + 1 if record.profile.lobes_alike else len(radius)
    return started_at(arcs, int(np.argmax(radius[:reach])))


def comments(*texts: str) -> list[Block]:
    """Blocks that say something and do nothing."""
    return [Block("comment", {"text": text}) for text in texts]


def lobes_note(record: Ground) -> list[Block]:
    """How a disc whose lobes differ is clamped."""
    return [] if record.profile.lobes_alike else comments("LOBES DIFFER: CLAMP THE DISC WITH ITS LOBE 1 ON THE X AXIS")


def contour_chain(record: Ground, tolerance: float) -> Arcs:
    """Arcs round the disc from a tip, clockwise, or anticlockwise where the wheel is set off to the right by G42."""
    chain = from_tip(disc_arcs(record.profile, FIT_SHARE * tolerance), record)
    return reversed_chain(chain) if record.spec.export.wheel_compensation == "G42" else chain


def _program(record: Ground, tolerance: float, post: Post) -> dict[str, list[Block]]:
    export = record.spec.export
    side = _SIDES.get(export.wheel_compensation)
    radius = wheel_radius(record.profile, export.wheel_radius_mm) if side else 0.0
    chain = contour_chain(record, tolerance)
    start = complex(chain.ends[0])
    outward = start / abs(start)
    heading = 1j * outward if side == "right" else -1j * outward
    # Quarter circles that meet the tip tangentially.
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
        arc_block(post.stands(approach), start, centre, turn),
        *chain_blocks(chain, 0.1 * tolerance, post),
        arc_block(post.stands(start), leave, centre, turn),
        line_block(far_out, "leave compensated" if side else "leave"),
        Block("finish"),
    ]
    return {"begin": _head(record, tolerance, radius, post), "main": main, "end": [Block("end", _PROGRAM)]}


def _head(record: Ground, tolerance: float, radius: float, post: Post) -> list[Block]:
    compensation = record.spec.export.wheel_compensation
    wheel = "PATH IS THE TOOTH CURVE ITSELF: NO WHEEL RADIUS IS ALLOWED FOR"
    if radius:
        wheel = f"PATH IS THE TOOTH CURVE: {compensation} SETS OFF THE WHEEL, RADIUS {radius:.4f} MM"
    overlap = overlap_at_grooves(record.profile, radius) if radius else 0.0
    corners = f"CONTROLS THAT DO NOT CUT CORNERS BACK MAY CUT IN BY {overlap / UM:.3f} MICROMETRE BESIDE GROOVES"
    way = "ANTICLOCKWISE" if compensation == "G42" else "CLOCKWISE"
    return [
        Block("begin", _PROGRAM),
        *comments(
            f"PROFILE OF {plain_name(record.spec.name).upper()}",
            wheel,
            *([corners] if overlap > 0.0 else []),
            f"X Y IN MM FROM THE BORE AXIS, TOOTH ROOT 1 ON THE X AXIS, {way}",
        ),
        *lobes_note(record),
        *comments(f"ARCS WITHIN {tolerance / UM:.3f} MICROMETRE, {post.decimals} DECIMALS"),
        Block("contour"),
    ]
