"""Chains of lines and arcs on the way to a machine: offset, cut, reversed, and turned into blocks."""

from __future__ import annotations

import cmath
import math
from dataclasses import replace

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.errors import ExportError
from cycloid_profile.export.biarc import Arcs
from cycloid_profile.export.post import Block, Post
from cycloid_profile.geometry.contour import Arc, Contour

_STRAIGHT = 1e-4  # 1/mm; flatter arcs are written as lines while they stay within the sagitta allowed
_TANGENT = 1e-6  # rad; a smaller turn between neighbours moves a joint by less than is printed
_STEPS = 20


def chain_of(contour: Contour) -> Arcs:
    """The closed contour of an opening as a chain, every arc at most a quarter of a circle."""
    ends, bend = [contour.segments[0].start], []
    for segment in contour.segments:
        if isinstance(segment, Arc):
            parts = max(1, math.ceil(abs(segment.turn) / (0.5 * math.pi) - 1e-12))
            angles = np.linspace(segment.from_angle, segment.to_angle, parts + 1)[1:]
            ends += [complex(z) for z in segment.centre + segment.radius * np.exp(1j * angles)]
            bend += parts * [math.copysign(1.0 / segment.radius, segment.turn)]
        else:
            ends.append(segment.end)
            bend.append(0.0)
    return Arcs(np.array([*ends[:-1], ends[0]]), np.array(bend))


def reversed_chain(chain: Arcs) -> Arcs:
    """The same chain run backwards."""
    return Arcs(chain.ends[::-1], -chain.bend[::-1])


def started_at(chain: Arcs, first: int) -> Arcs:
    """The same closed chain begun at the joint ``first``."""
    ends = np.roll(chain.ends[:-1], -first)
    return replace(chain, ends=np.append(ends, ends[0]), bend=np.roll(chain.bend, -first))


def begun_near(chain: Arcs, point: complex) -> Arcs:
    """The same closed chain begun at its place nearest to ``point``, where a segment is divided."""
    samples = 64
    along = chain.points(samples).reshape(-1, samples)
    # Rounded, so that of places equally near it is always the first.
    k, i = np.unravel_index(int(np.argmin(np.round(np.abs(along - point), 6))), along.shape)
    ends = np.insert(chain.ends, k + 1, along[k, i])
    return started_at(Arcs(ends, np.insert(chain.bend, k, chain.bend[k])), int(k) + 1)


def part_of(chain: Arcs, first: int, last: int) -> Arcs:
    """The segments from joint ``first`` to joint ``last``."""
    return Arcs(chain.ends[first : last + 1], chain.bend[first:last])


def away_from(chain: Arcs, points: ComplexArray) -> FloatArray:
    """Distance of points, shape (n,), from the nearest place of the chain, shape (n,) [mm]; exact."""
    nearest = np.full(points.shape, math.inf)
    segments = zip(chain.ends[:-1], chain.ends[1:], chain.bend, chain.centres, strict=True)
    for start, end, bend, centre in segments:
        to_ends = np.minimum(np.abs(points - start), np.abs(points - end))
        if bend == 0.0:
            share = ((points - start) * np.conj(end - start)).real / abs(end - start) ** 2
            beside = np.where((share > 0.0) & (share < 1.0), np.abs(points - start - share * (end - start)), to_ends)
        else:
            # In the sector of the arc, seen from its middle, the way is radial.
            middle = cmath.phase(complex((start + end) * 0.5 - centre))
            half = 0.5 * abs(cmath.phase(complex((end - centre) / (start - centre))))
            inside = np.abs(np.angle((points - centre) * np.exp(-1j * middle))) < half
            beside = np.where(inside, np.abs(np.abs(points - centre) - 1.0 / abs(bend)), to_ends)
        nearest = np.minimum(nearest, beside)
    return nearest


def tangents(chain: Arcs) -> tuple[ComplexArray, ComplexArray]:
    """Unit tangents at start and end of every arc, shape (n,) both."""
    chord = np.diff(chain.ends)
    half_turn = np.arcsin(np.clip(0.5 * chain.bend * np.abs(chord), -1.0, 1.0))
    along = chord / np.abs(chord)
    return along * np.exp(-1j * half_turn), along * np.exp(1j * half_turn)


def lengths(chain: Arcs) -> FloatArray:
    """Length of every arc, shape (n,) [mm]."""
    chord = np.abs(np.diff(chain.ends))
    half_turn = np.arcsin(np.clip(0.5 * chain.bend * chord, -1.0, 1.0))
    length: FloatArray = chord / np.sinc(half_turn / math.pi)
    return length


def offset_left(chain: Arcs, distance: float, closed: bool = True) -> Arcs:
    """The chain ``distance`` to the left of its direction [mm], exact: arcs stay arcs about the same centres.

    Where the chain turns left at a corner the neighbours are cut at their crossing, where it turns right an
    arc about the corner joins them.

    Raises
    ------
    ExportError
        If an arc bends to the left more tightly than ``distance``.
    """
    tightest = float(np.max(chain.bend))
    if tightest * distance >= 1.0:
        raise ExportError(
            "offset", f"{distance:.4f} mm", f"is not below the least concave radius {1.0 / tightest:.4f} mm",
            "take a thinner tool, or a larger corner radius",
        )  # fmt: skip
    entering, leaving = tangents(chain)
    start, end = chain.ends[:-1] + 1j * distance * entering, chain.ends[1:] + 1j * distance * leaving
    bend = chain.bend / (1.0 - chain.bend * distance)
    count = bend.size
    corner: dict[int, float] = {}
    for k in range(count if closed else count - 1):
        turn = cmath.phase(complex(entering[(k + 1) % count] / leaving[k]))
        if abs(turn) <= _TANGENT:
            continue
        if turn > 0.0:
            _cut(k, (k + 1) % count, turn, distance, start, end, bend, entering, leaving)
        else:
            corner[k] = turn
    ends, bends = [complex(start[0])], []
    for k in range(count):
        ends.append(complex(end[k]))
        bends.append(float(bend[k]))
        if k in corner:
            # About the corner itself, turning the way the chain does.
            ends.append(complex(start[(k + 1) % count]))
            bends.append(-1.0 / distance)
    if closed:
        ends[-1] = ends[0]
    return Arcs(np.array(ends), np.array(bends))


def _cut(
    one: int, other: int, turn: float, distance: float, start: ComplexArray, end: ComplexArray, bend: FloatArray,
    entering: ComplexArray, leaving: ComplexArray,
) -> None:  # fmt: skip
    """Move the end of one arc and the start of the next to where they cross, by Newton on the two lengths cut off."""
    back = ahead = distance * math.tan(0.5 * turn)
    for _ in range(_STEPS):
        p, p_rate = _along(complex(end[one]), complex(leaving[one]), float(bend[one]), -back)
        q, q_rate = _along(complex(start[other]), complex(entering[other]), float(bend[other]), ahead)
        miss = q - p
        # miss + q_rate·d_ahead + p_rate·d_back = 0
        cross = (q_rate.conjugate() * p_rate).imag
        d_ahead, d_back = -(miss * p_rate.conjugate()).imag / -cross, (miss * q_rate.conjugate()).imag / -cross
        ahead, back = ahead + d_ahead, back + d_back
        if abs(d_ahead) + abs(d_back) < 1e-13:
            break
    if not (0.0 <= back < abs(end[one] - start[one]) and 0.0 <= ahead < abs(end[other] - start[other])):
        raise ExportError(
            "offset", f"{distance:.4f} mm", "does not fit into a corner of the outline", "take a thinner tool"
        )
    end[one] = start[other] = _along(complex(end[one]), complex(leaving[one]), float(bend[one]), -back)[0]


def _along(point: complex, tangent: complex, bend: float, way: float) -> tuple[complex, complex]:
    """Point and unit tangent after ``way`` [mm] on an arc through ``point``."""
    half = 0.5 * bend * way
    ratio = 1.0 if half == 0.0 else math.sin(half) / half
    return point + tangent * way * ratio * cmath.exp(1j * half), tangent * cmath.exp(2j * half)


def chain_blocks(chain: Arcs, sagitta: float, post: Post) -> list[Block]:
    """Blocks along the chain from where it starts; arcs almost straight, within ``sagitta`` of a line, are lines.

    Centres are given from the rounded start, which is where the machine stands.
    """
    blocks = []
    here = post.stands(complex(chain.ends[0]))
    for end, bend, centre in zip(chain.ends[1:].tolist(), chain.bend.tolist(), chain.centres.tolist(), strict=True):
        if bend == 0.0 or (abs(bend) < _STRAIGHT and abs(bend) * abs(end - here) ** 2 / 8.0 < sagitta):
            blocks.append(line_block(end))
        else:
            blocks.append(arc_block(here, end, centre, bend))
        here = post.stands(end)
    return blocks


def line_block(end: complex, kind: str = "line", **words: float | str) -> Block:
    """A straight block of the given kind."""
    return Block(kind, {"x": end.real, "y": end.imag, **words})


def arc_block(here: complex, end: complex, centre: complex, turn: float) -> Block:
    """An arc from the rounded ``here``, anticlockwise for a positive ``turn``."""
    offset = centre - here
    words = {"x": end.real, "y": end.imag, "i": offset.real, "j": offset.imag, "cx": centre.real, "cy": centre.imag}
    return Block("anticlockwise" if turn > 0.0 else "clockwise", words)
