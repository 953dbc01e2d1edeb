"""The wire-cutting program: every opening from inside, then the teeth from outside, a full cut and skim cuts each.

The path is that of the wire's centre, beside the outline by wire radius, spark gap and the stock the cut leaves.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.design.record import DesignRecord
from cycloid_profile.errors import ExportError
from cycloid_profile.export.biarc import Arcs, disc_arcs
from cycloid_profile.export.cnc_chain import (
    away_from,
    begun_near,
    chain_blocks,
    chain_of,
    line_block,
    offset_left,
    part_of,
    reversed_chain,
)
from cycloid_profile.export.cnc_read import cutting_runs, read_moves
from cycloid_profile.export.deviation import Deviation, distances
from cycloid_profile.export.gcode import comments, from_tip, lobes_note
from cycloid_profile.export.post import Block, Post, post_of, render
from cycloid_profile.export.refine import FIT_SHARE
from cycloid_profile.export.text import plain_name
from cycloid_profile.export.written import WrittenFile
from cycloid_profile.geometry.contour import Contour
from cycloid_profile.spec.machining import WireSpec
from cycloid_profile.units import UM

_PROGRAM = {"program": "WIRE_EDM"}
_CHORDS = 1e-3  # mm, of the polygon in which a start hole is placed


@dataclass(frozen=True, slots=True)
class Cut:
    """One contour: ``start`` hole, the chains run one after the other, a stop before one of them, the hole again.

    ``last`` tells which chains are the finishing ones.
    """

    name: str
    start: complex
    end: complex
    chains: tuple[Arcs, ...]
    remarks: tuple[str, ...]
    last: tuple[int, ...]
    stop_before: int | None = None
    stop: str = ""


@dataclass(frozen=True, slots=True)
class WireExporter:
    """Writes ``wire_edm.nc``: the wire's centre round all openings and the teeth."""

    format: str = "gcode-wire"
    filenames: tuple[str, ...] = ("wire_edm.nc",)

    def write(self, record: DesignRecord, folder: Path) -> tuple[WrittenFile, ...]:
        """Write, read back and measure the finishing cuts: how far off the outline by more or less than they should.

        Raises ``ExportError`` where the wire does not go into a corner.
        """
        export = record.spec.export
        tolerance = export.chord_tolerance_um * UM
        path = folder / self.filenames[0]
        cuts = [*(_opening(contour, export.wire) for contour in record.outline.contours), _teeth(record, tolerance)]
        post = post_of(export)
        text = render(_program(record, cuts, tolerance, post), post)
        path.write_text(text, encoding="ascii", newline="\n")
        moves = read_moves(path)
        off, angle = _measured(record, cuts, cutting_runs(moves))
        worst = int(np.argmax(np.abs(off)))
        found = Deviation(float(np.abs(off[worst])), float(np.sqrt(np.mean(off**2))), float(angle[worst]), off.size)
        count = {"contours": len(cuts), "cuts_each": len(offsets(export.wire)), "blocks": len(moves)}
        return (WrittenFile(path.name, self.format, tolerance + post.rounding, found, "own reader of G1/G2/G3", count),)


def offsets(wire: WireSpec) -> list[float]:
    """How far the wire's centre is beside the outline in each cut [mm].

    Raises
    ------
    ExportError
        If the stock does not fall from cut to cut.
    """
    stock = [*wire.skim_stock_um, 0.0]
    if any(not a > b for a, b in itertools.pairwise(stock)):
        raise ExportError(
            "export.wire.skim_stock_um",
            list(wire.skim_stock_um),
            "does not fall from cut to cut to above zero",
            "give what each cut but the last leaves, such as [40, 10]",
        )
    return [0.5 * wire.wire_diameter_mm + (wire.spark_gap_um + left) * UM for left in stock]


def _opening(contour: Contour, wire: WireSpec) -> Cut:
    start = _middle(contour)
    # The outline runs counterclockwise with the opening on its left.
    chain = chain_of(contour) if contour.circle is not None else begun_near(chain_of(contour), start)
    chains = tuple(offset_left(chain, offset) for offset in offsets(wire))
    last = len(chains) - 1
    return Cut(contour.name, start, start, chains, _remarks(wire), (last,), 1 if last else None, "REMOVE THE SLUG")


def _middle(contour: Contour) -> complex:
    """Where a start hole has most room inside a contour."""
    if contour.circle is not None:
        return contour.circle.centre
    from shapely import Polygon
    from shapely.ops import polylabel

    points = contour.points(_CHORDS)
    label = polylabel(Polygon(np.stack([points.real, points.imag], axis=-1)), 0.01)
    return complex(label.x, label.y)


def _teeth(record: DesignRecord, tolerance: float) -> Cut:
    """All lobes but the last, forth and back; then, clamped, the last one, which has held the disc till then."""
    wire = record.spec.export.wire
    # Clockwise from a tip, with the outside on the left.
    chain = from_tip(disc_arcs(record.profile, FIT_SHARE * tolerance), record)
    held, lobe = [], []
    for offset in offsets(wire):
        path = offset_left(chain, offset)
        before = path.ends[0] * np.exp(2j * math.pi / record.drive.trochoid.lobes)
        joint = int(np.argmin(np.abs(np.angle(path.ends / before))))
        held.append(part_of(path, 0, joint))
        lobe.append(part_of(path, joint, path.bend.size))
    chains = _forth_and_back([*held], forth=True)
    count = len(chains)
    chains += _forth_and_back(lobe, forth=count % 2 == 1)
    away = 1.0 + wire.start_distance_mm / abs(chain.ends[0])
    start, end = (complex(away * z) for z in (chain.ends[0], chains[-1].ends[-1]))
    remarks = _remarks(wire)
    return Cut(
        "teeth", start, end, tuple(chains), (*remarks, *(f"LAST LOBE, {r}" for r in remarks)),
        (count - 1, 2 * count - 1), count, "CLAMP THE DISC, THE LAST LOBE SETS IT FREE",
    )  # fmt: skip


def _forth_and_back(chains: Sequence[Arcs], forth: bool) -> list[Arcs]:
    return [chain if (k % 2 == 0) == forth else reversed_chain(chain) for k, chain in enumerate(chains)]


def _remarks(wire: WireSpec) -> tuple[str, ...]:
    beside = offsets(wire)
    stock = [*wire.skim_stock_um, 0.0]
    return tuple(
        f"CUT {k + 1} OF {len(beside)}: WIRE {at:.4f} MM BESIDE THE OUTLINE, LEAVES {left:g} MICROMETRE"
        for k, (at, left) in enumerate(zip(beside, stock, strict=True))
    )


def _program(record: DesignRecord, cuts: list[Cut], tolerance: float, post: Post) -> dict[str, list[Block]]:
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


def _measured(record: DesignRecord, cuts: list[Cut], runs: list[Arcs]) -> tuple[FloatArray, FloatArray]:
    """How much further from the outline than it should be the wire is, and its polar angle, in the finishing cuts."""
    beside = offsets(record.spec.export.wire)[-1]
    outlines = [chain_of(contour) for contour in record.outline.contours]
    off, angle = [], []
    for k, (cut, run) in enumerate(zip(cuts, runs, strict=True)):
        # Before every chain one straight move leads to it.
        ends = np.cumsum([chain.bend.size + 1 for chain in cut.chains])
        for which in cut.last:
            points = part_of(run, int(ends[which]) - cut.chains[which].bend.size, int(ends[which])).points()
            at = distances(record.profile, points) if k == len(outlines) else away_from(outlines[k], points)
            off.append(at - beside)
            angle.append(np.angle(points))
    return np.concatenate(off), np.concatenate(angle)
