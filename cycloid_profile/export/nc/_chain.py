"""NC blocks along chains of lines and arcs."""

from __future__ import annotations

from cycloid_profile.export.curves import Arcs
from cycloid_profile.export.nc.dialects import Block, Post

_STRAIGHT = 1e-4  # 1/mm; flatter arcs are written as lines while they stay within the sagitta allowed


def chain_blocks(chain: Arcs, sagitta: float, post: Post) -> list[Block]:
    """Blocks along the chain; arcs within ``sagitta`` [mm] of a line become lines.

    Centres are relative to the rounded start, the actual position of the machine; pieces below its resolution are
    left out.
    """
    blocks = []
    here = post.rounded(complex(chain.ends[0]))
    for end, curvature, centre in zip(
        chain.ends[1:].tolist(), chain.curvature.tolist(), chain.centres.tolist(), strict=True
    ):
        if post.rounded(end) == here:
            continue
        if curvature == 0.0 or (abs(curvature) < _STRAIGHT and abs(curvature) * abs(end - here) ** 2 / 8.0 < sagitta):
            blocks.append(line_block(end))
        else:
            blocks.append(arc_block(here, end, centre, curvature))
        here = post.rounded(end)
    return blocks


def line_block(end: complex, kind: str = "line", **words: float | str) -> Block:
    """A straight block of the given kind."""
    return Block(kind, {"x": end.real, "y": end.imag, **words})


def arc_block(here: complex, end: complex, centre: complex, turn: float) -> Block:
    """An arc from the rounded ``here``, anticlockwise for a positive ``turn``."""
    offset = centre - here
    words = {"x": end.real, "y": end.imag, "i": offset.real, "j": offset.imag, "cx": centre.real, "cy": centre.imag}
    return Block("anticlockwise" if turn > 0.0 else "clockwise", words)
