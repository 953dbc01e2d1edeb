"""The wire-cutting program: every opening from inside, then the teeth from outside, a full cut and skim cuts each.

The path is that of the wire's centre, offset from the outline by wire radius, spark gap and remaining stock.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.errors import ExportError
from cycloid_profile.export.curves import (
    FIT_SHARE,
    Arcs,
    Deviation,
    ProfileSource,
    chain_of,
    disc_arcs,
    distance_to_chain,
    distances,
    nearest_length,
    offset_left,
    stretch,
)
from cycloid_profile.export.nc._chain import chain_blocks, line_block
from cycloid_profile.export.nc.contour import comments, lobes_note, started_at_tip, width_note
from cycloid_profile.export.nc.dialects import Block, Post, post_of, render
from cycloid_profile.export.nc.interpreter import cutting_runs, interpret
from cycloid_profile.export.nc.verify import check_wire
from cycloid_profile.export.writing import SingleFileExporter, WrittenFile, plain_name
from cycloid_profile.geometry import Arc, Contour
from cycloid_profile.spec.model import WireSpec
from cycloid_profile.units import UM

_PROGRAM = {"program": "WIRE_EDM"}
_CHORDS = 1e-3  # mm, of the polygon in which a start hole is placed
_HOLE = 0.01  # mm, accuracy of its place


@dataclass(frozen=True, slots=True)
class Cut:
    """Cuts of one contour between its ``start`` and ``end`` holes: ``chains`` in order, and one of ``remarks`` per
    chain.

    ``finishing`` holds the indices of the finishing cuts; the machine stops with a text of ``stops`` before the chain
    of that index.
    """

    name: str
    start: complex
    end: complex
    chains: tuple[Arcs, ...]
    remarks: tuple[str, ...]
    finishing: tuple[int, ...]
    stops: Mapping[int, str]


@dataclass(frozen=True)
class WireExporter(SingleFileExporter[ProfileSource]):
    """Writes ``wire_edm.nc``: the wire's centre round all openings and the teeth."""

    format: str = "gcode-wire"
    filename: str = "wire_edm.nc"

    def write_file(self, source: ProfileSource, path: Path) -> WrittenFile:
        """Write, read back and measure the error of the wire's distance from the outline in the finishing cuts.

        Raises ``ExportError`` if the wire does not fit a corner.
        """
        export = source.spec.export
        tolerance = export.chord_tolerance
        cuts = [*(_opening(contour, export.wire) for contour in source.outline.contours), _teeth(source, tolerance)]
        post = post_of(export)
        path.write_text(render(_program(source, cuts, tolerance, post), post), encoding="ascii", newline="\n")
        program = interpret(path.read_text(encoding="ascii"), post.machine, path.name)
        check_wire(program, post.machine, path.name)
        blocks = [
            [_leg(cut, k, export.wire.feed_mm_per_min, tolerance, post) for k in range(len(cut.chains))] for cut in cuts
        ]
        found = Deviation.of(*_distance_errors(source, cuts, blocks, cutting_runs(program.motions)))
        count = {"contours": len(cuts), "cuts_each": len(offsets(export.wire)), "blocks": len(program.motions)}
        return self.measured(tolerance + post.rounding, found, "own interpreter", count)


def offsets(wire: WireSpec) -> list[float]:
    """Offset of the wire's centre from the outline in each cut [mm].

    Raises ``ExportError`` if the stock does not decrease from cut to cut.
    """
    stock = [*wire.skim_stock_um, 0.0]
    if any(not a > b for a, b in itertools.pairwise(stock)):
        raise ExportError(
            "export.wire.skim_stock_um",
            list(wire.skim_stock_um),
            "does not decrease from cut to cut to above zero",
            "give the stock after each cut but the last, such as [40, 10]",
        )
    return [0.5 * wire.wire_diameter_mm + (wire.spark_gap_um + remaining) * UM for remaining in stock]


def _opening(contour: Contour, wire: WireSpec) -> Cut:
    """Cuts inside an opening: the first to a tab that holds the slug, then the tab, then the skims to and fro, each
    past its start by the overlap."""
    middle = _middle(contour)
    # The outline runs counterclockwise with the opening on its left.
    first, *skims = [offset_left(chain_of(contour), offset) for offset in offsets(wire)]
    begin, whole = nearest_length(first, middle), float(np.sum(first.lengths))
    tab = min(wire.slug_tab_mm, 0.5 * whole)
    chains = [stretch(first, begin, whole - tab)] if tab else []
    chains.append(stretch(first, begin + whole - tab, tab + wire.overlap_mm) if tab else _round(first, begin, wire))
    stops = {1: f"HOLD THE SLUG, {tab:g} MM LEFT TO CUT"} if tab else {}
    if skims:
        stops[len(chains)] = "REMOVE THE SLUG"
    for k, skim in enumerate(skims):
        path = skim.reversed() if k % 2 == 0 else skim
        # Every cut starts where the one before has ended.
        chains.append(_round(path, nearest_length(path, complex(chains[-1].ends[-1])), wire))
    first_cut, *others = _remarks(wire)
    remarks = (first_cut, *([f"{first_cut}, TAB"] if tab else []), *others)
    finishing = (len(chains) - 1,) if skims or not tab else (0, 1)
    return Cut(contour.name, middle, middle, tuple(chains), remarks, finishing, stops)


def _round(path: Arcs, begin: float, wire: WireSpec) -> Arcs:
    """Once round a closed path from the arc length ``begin``, and past the start by the overlap."""
    return stretch(path, begin, float(np.sum(path.lengths)) + wire.overlap_mm)


def _middle(contour: Contour) -> complex:
    """Centre of the largest circle inside a contour, for its start hole [mm]; of an arc's circle where that is one."""
    if contour.full_circle_arc is not None:
        return contour.full_circle_arc.centre
    from shapely import Polygon
    from shapely.ops import polylabel

    points = contour.points(_CHORDS)
    label = polylabel(Polygon(np.stack([points.real, points.imag], axis=-1)), _HOLE)
    found = complex(label.x, label.y)
    outline = chain_of(contour)
    centres = [segment.centre for segment in contour.segments if isinstance(segment, Arc) and segment.sweep > 0.0]
    room = distance_to_chain(outline, np.array([found, *centres]))
    # A centre may lie outside, in the disc: only those near the one found count.
    near = [
        k for k, centre in enumerate(centres, start=1) if abs(centre - found) < room[0] and room[k] > room[0] - _HOLE
    ]
    return complex(centres[near[0] - 1]) if near else found


def _teeth(record: ProfileSource, tolerance: float) -> Cut:
    """Cuts of all lobes but the last, in alternating directions. The disc is then clamped, and the last lobe, which
    held it, is cut."""
    wire = record.spec.export.wire
    # Clockwise from a tip, with the outside on the left.
    chain = started_at_tip(disc_arcs(record.profile, FIT_SHARE * tolerance), record)
    overlap = wire.overlap_mm
    # With an even number of cuts the held part ends at its start, which is the end of the lobe.
    joined_at_end = len(offsets(wire)) % 2 == 0
    held: list[Arcs] = []
    lobe: list[Arcs] = []
    for offset in offsets(wire):
        path = offset_left(chain, offset)
        last_tip = path.ends[0] * np.exp(2j * math.pi / record.drive.trochoid.lobes)
        joint = int(np.argmin(np.abs(np.angle(path.ends / last_tip))))
        whole, cut = float(np.sum(path.lengths)), float(np.sum(path.lengths[:joint]))
        held.append(stretch(path, 0.0, cut))
        # Where the first cut of the lobe starts, the held part has ended: there it needs no overlap.
        before, after = (overlap if lobe or joined_at_end == at_end else 0.0 for at_end in (True, False))
        lobe.append(stretch(path, cut - before, whole - cut + before + after))
    count = len(held)
    # Alternating directions: each cut starts at the end of the previous one.
    chains = [chain if k % 2 == 0 else chain.reversed() for k, chain in enumerate(held)]
    chains += [chain if (k % 2 == 0) == (count % 2 == 1) else chain.reversed() for k, chain in enumerate(lobe)]
    away = 1.0 + wire.start_distance_mm / abs(chain.ends[0])
    start, end = (complex(away * z) for z in (chain.ends[0], chains[-1].ends[-1]))
    remarks = _remarks(wire)
    return Cut(
        "teeth", start, end, tuple(chains), (*remarks, *(f"LAST LOBE, {r}" for r in remarks)),
        (count - 1, 2 * count - 1), {count: "CLAMP THE DISC, THE LAST LOBE SETS IT FREE"},
    )  # fmt: skip


def _remarks(wire: WireSpec) -> tuple[str, ...]:
    stock = [*wire.skim_stock_um, 0.0]
    return tuple(
        f"CUT {k + 1} OF {len(stock)}: WIRE {offset:.4f} MM FROM THE OUTLINE, LEAVES {remaining:g} MICROMETRE"
        for k, (offset, remaining) in enumerate(zip(offsets(wire), stock, strict=True))
    )


def _program(record: ProfileSource, cuts: list[Cut], tolerance: float, post: Post) -> dict[str, list[Block]]:
    wire = record.spec.export.wire
    head = [
        Block("begin", _PROGRAM),
        *comments(
            f"WIRE CUTTING OF {plain_name(record.spec.name).upper()}",
            "PATH IS THE CENTRE OF THE WIRE: NO COMPENSATION IN THE CONTROL",
            f"WIRE {wire.wire_diameter_mm:g} MM, SPARK GAP {wire.spark_gap_um:g} MICROMETRE",
            "X Y IN MM FROM THE BORE AXIS, TOOTH ROOT 1 ON THE X AXIS",
        ),
        *lobes_note(record),
        *width_note(record),
        *comments(
            f"EVERY CUT OVERLAPS ITS START BY {wire.overlap_mm:g} MM",
            f"SLUGS HANG ON {wire.slug_tab_mm:g} MM UNTIL A STOP",
            f"ARCS WITHIN {tolerance / UM:.3f} MICROMETRE, {post.decimals} DECIMALS",
        ),
        *post.own("wire"),
    ]
    main: list[Block] = []
    for cut in cuts:
        main += [
            *comments(f"{plain_name(cut.name).upper()}: START HOLE AT X{cut.start.real:.3f} Y{cut.start.imag:.3f}"),
            line_block(cut.start, "rapid"),
            *post.own("thread", "flush_on"),
        ]
        for k in range(len(cut.chains)):
            if k in cut.stops:
                main.append(Block("stop", {"text": cut.stops[k]}))
            lead, along = _leg(cut, k, wire.feed_mm_per_min, tolerance, post)
            main += [*comments(cut.remarks[k]), *lead, *along]
        main += [line_block(cut.end), *post.own("flush_off", "cut_wire")]
    return {"begin": head, "main": [*main, *post.own("end")], "end": [Block("end", _PROGRAM)]}


def _leg(cut: Cut, k: int, feed: float, tolerance: float, post: Post) -> tuple[list[Block], list[Block]]:
    """The straight block to the start of a chain, if it is not there yet, and the blocks along the chain."""
    chain = cut.chains[k]
    start = complex(chain.ends[0])
    if k == 0:
        return [line_block(start, "enter", feed=feed)], chain_blocks(chain, 0.1 * tolerance, post)
    here = complex(cut.chains[k - 1].ends[-1])
    lead = [line_block(start)] if post.rounded(here) != post.rounded(start) else []
    return lead, chain_blocks(chain, 0.1 * tolerance, post)


def _distance_errors(
    record: ProfileSource, cuts: list[Cut], legs: list[list[tuple[list[Block], list[Block]]]], runs: list[Arcs]
) -> tuple[ComplexArray, FloatArray]:
    """Points of the finishing cuts, and the error of the wire's distance from the outline there [mm]."""
    wanted = offsets(record.spec.export.wire)[-1]
    outlines = [chain_of(contour) for contour in record.outline.contours]
    at, off = [], []
    for k, (cut, run) in enumerate(zip(cuts, runs, strict=True)):
        ends = np.cumsum([len(lead) + len(along) for lead, along in legs[k]])
        for which in cut.finishing:
            points = run.part(int(ends[which]) - len(legs[k][which][1]), int(ends[which])).points()
            at_teeth = k == len(outlines)
            found = distances(record.profile, points) if at_teeth else distance_to_chain(outlines[k], points)
            off.append(found - wanted)
            at.append(points)
    return np.concatenate(at), np.concatenate(off)
