"""The wire-cutting program: every opening from inside, then the teeth from outside, a full cut and skim cuts each.

The path is that of the wire's centre, offset from the outline by wire radius, spark gap and remaining stock.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.design import DesignRecord
from cycloid_profile.errors import ExportError
from cycloid_profile.export.curves import FIT_SHARE, Arcs, Deviation, disc_arcs, distances
from cycloid_profile.export.nc._chain import (
    chain_blocks,
    chain_of,
    distance_to_chain,
    line_block,
    offset_left,
    started_near,
)
from cycloid_profile.export.nc.contour import comments, lobes_note, started_at_tip, width_note
from cycloid_profile.export.nc.dialects import Block, NcDialect, cutting_runs, dialect_of, read_moves, render
from cycloid_profile.export.writing import SingleFileExporter, WrittenFile, plain_name
from cycloid_profile.geometry import Contour
from cycloid_profile.spec.model import WireSpec
from cycloid_profile.units import UM

_PROGRAM = {"program": "WIRE_EDM"}
_CHORDS = 1e-3  # mm, of the polygon in which a start hole is placed


@dataclass(frozen=True, slots=True)
class Cut:
    """Cuts of one contour between its ``start`` and ``end`` holes: ``chains`` in order, and one of ``remarks`` per
    chain.

    ``finishing`` holds the indices of the finishing cuts; the machine stops before chain ``stop_before``.
    """

    name: str
    start: complex
    end: complex
    chains: tuple[Arcs, ...]
    remarks: tuple[str, ...]
    finishing: tuple[int, ...]
    stop_before: int | None = None
    stop: str = ""


@dataclass(frozen=True)
class WireExporter(SingleFileExporter[DesignRecord]):
    """Writes ``wire_edm.nc``: the wire's centre round all openings and the teeth."""

    format: str = "gcode-wire"
    filename: str = "wire_edm.nc"

    def write_file(self, source: DesignRecord, path: Path) -> WrittenFile:
        """Write, read back and measure the error of the wire's distance from the outline in the finishing cuts.

        Raises ``ExportError`` if the wire does not fit a corner.
        """
        export = source.spec.export
        tolerance = export.chord_tolerance_um * UM
        cuts = [*(_opening(contour, export.wire) for contour in source.outline.contours), _teeth(source, tolerance)]
        post = dialect_of(export)
        path.write_text(render(_program(source, cuts, tolerance, post), post), encoding="ascii", newline="\n")
        moves = read_moves(path)
        found = Deviation.of(*_distance_errors(source, cuts, cutting_runs(moves)))
        count = {"contours": len(cuts), "cuts_each": len(offsets(export.wire)), "blocks": len(moves)}
        return self.measured(tolerance + post.rounding, found, "own reader of G1/G2/G3", count)


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
    start = _middle(contour)
    # The outline runs counterclockwise with the opening on its left.
    chain = chain_of(contour) if contour.full_circle_arc is not None else started_near(chain_of(contour), start)
    chains = tuple(offset_left(chain, offset) for offset in offsets(wire))
    last = len(chains) - 1
    return Cut(contour.name, start, start, chains, _remarks(wire), (last,), 1 if last else None, "REMOVE THE SLUG")


def _middle(contour: Contour) -> complex:
    """Centre of the largest circle inside a contour, for its start hole [mm]."""
    if contour.full_circle_arc is not None:
        return contour.full_circle_arc.centre
    from shapely import Polygon
    from shapely.ops import polylabel

    points = contour.points(_CHORDS)
    label = polylabel(Polygon(np.stack([points.real, points.imag], axis=-1)), 0.01)
    return complex(label.x, label.y)


def _teeth(record: DesignRecord, tolerance: float) -> Cut:
    """Cuts of all lobes but the last, in alternating directions. The disc is then clamped, and the last lobe, which
    held it, is cut."""
    wire = record.spec.export.wire
    # Clockwise from a tip, with the outside on the left.
    chain = started_at_tip(disc_arcs(record.profile, FIT_SHARE * tolerance), record)
    held, lobe = [], []
    for offset in offsets(wire):
        path = offset_left(chain, offset)
        before = path.ends[0] * np.exp(2j * math.pi / record.drive.trochoid.lobes)
        joint = int(np.argmin(np.abs(np.angle(path.ends / before))))
        held.append(path.part(0, joint))
        lobe.append(path.part(joint, path.curvature.size))
    count = len(held)
    # Alternating directions: each cut starts at the end of the previous one.
    chains = [chain if k % 2 == 0 else chain.reversed() for k, chain in enumerate(held)]
    chains += [chain if (k % 2 == 0) == (count % 2 == 1) else chain.reversed() for k, chain in enumerate(lobe)]
    away = 1.0 + wire.start_distance_mm / abs(chain.ends[0])
    start, end = (complex(away * z) for z in (chain.ends[0], chains[-1].ends[-1]))
    remarks = _remarks(wire)
    return Cut(
        "teeth", start, end, tuple(chains), (*remarks, *(f"LAST LOBE, {r}" for r in remarks)),
        (count - 1, 2 * count - 1), count, "CLAMP THE DISC, THE LAST LOBE SETS IT FREE",
    )  # fmt: skip


def _remarks(wire: WireSpec) -> tuple[str, ...]:
    stock = [*wire.skim_stock_um, 0.0]
    return tuple(
        f"CUT {k + 1} OF {len(stock)}: WIRE {offset:.4f} MM FROM THE OUTLINE, LEAVES {remaining:g} MICROMETRE"
        for k, (offset, remaining) in enumerate(zip(offsets(wire), stock, strict=True))
    )


def _program(record: DesignRecord, cuts: list[Cut], tolerance: float, post: NcDialect) -> dict[str, list[Block]]:
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
        *comments(f"ARCS WITHIN {tolerance / UM:.3f} MICROMETRE, {post.decimals} DECIMALS"),
        Block("contour"),
        Block("feed", {"f": wire.feed_mm_per_min}),
    ]
    main: list[Block] = []
    for cut in cuts:
        main += [
            *comments(f"{plain_name(cut.name).upper()}: START HOLE AT X{cut.start.real:.3f} Y{cut.start.imag:.3f}"),
            line_block(cut.start, "rapid"),
            Block("thread"),
        ]
        for k, chain in enumerate(cut.chains):
            if k == cut.stop_before:
                main.append(Block("stop", {"text": cut.stop}))
            main += comments(cut.remarks[k])
            main.append(line_block(complex(chain.ends[0]), "enter" if k == 0 else "line"))
            main += chain_blocks(chain, 0.1 * tolerance, post)
        main += [line_block(cut.end), Block("cut wire")]
    return {"begin": head, "main": [*main, Block("finish")], "end": [Block("end", _PROGRAM)]}


def _distance_errors(record: DesignRecord, cuts: list[Cut], runs: list[Arcs]) -> tuple[ComplexArray, FloatArray]:
    """Points of the finishing cuts, and the error of the wire's distance from the outline there [mm]."""
    wanted = offsets(record.spec.export.wire)[-1]
    outlines = [chain_of(contour) for contour in record.outline.contours]
    at, off = [], []
    for k, (cut, run) in enumerate(zip(cuts, runs, strict=True)):
        # One straight move precedes every chain.
        ends = np.cumsum([chain.curvature.size + 1 for chain in cut.chains])
        for which in cut.finishing:
            points = run.part(int(ends[which]) - cut.chains[which].curvature.size, int(ends[which])).points()
            at_teeth = k == len(outlines)
            found = distances(record.profile, points) if at_teeth else distance_to_chain(outlines[k], points)
            off.append(found - wanted)
            at.append(points)
    return np.concatenate(at), np.concatenate(off)
