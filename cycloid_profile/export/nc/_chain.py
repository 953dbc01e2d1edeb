"""Chains of lines and arcs for a machine: contours as chains, exact offsets, distances, and NC blocks."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from functools import partial

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.errors import ExportError
from cycloid_profile.export.curves import Arcs
from cycloid_profile.export.nc.dialects import Block, NcDialect
from cycloid_profile.geometry import Arc, Contour

_STRAIGHT = 1e-4  # 1/mm; flatter arcs are written as lines while they stay within the sagitta allowed
_TANGENT = 1e-6  # rad; smaller corners move a joint by less than the last decimal
_NEWTON_STEPS = 30  # a tangent crossing converges slowly

Curve = Callable[[float], tuple[complex, complex]]  # point and derivative by the parameter


def chain_of(contour: Contour) -> Arcs:
    """The closed contour of an opening as a chain, every arc at most a quarter of a circle."""
    ends, curvature = [contour.segments[0].start], []
    for segment in contour.segments:
        if isinstance(segment, Arc):
            parts = max(1, math.ceil(abs(segment.sweep) / (0.5 * math.pi) - 1e-12))
            angles = np.linspace(segment.from_angle, segment.to_angle, parts + 1)[1:]
            ends += [complex(z) for z in segment.centre + segment.radius * np.exp(1j * angles)]
            curvature += parts * [math.copysign(1.0 / segment.radius, segment.sweep)]
        else:
            ends.append(segment.end)
            curvature.append(0.0)
    return Arcs(np.array([*ends[:-1], ends[0]]), np.array(curvature))


def started_near(chain: Arcs, point: complex) -> Arcs:
    """The same closed chain started at its nearest point to ``point``, where a segment is divided."""
    samples = 64
    along = chain.points(samples).reshape(-1, samples)
    # Rounded, so that the first of several equally near points is chosen.
    k, i = np.unravel_index(int(np.argmin(np.round(np.abs(along - point), 6))), along.shape)
    ends = np.insert(chain.ends, k + 1, along[k, i])
    return Arcs(ends, np.insert(chain.curvature, k, chain.curvature[k])).started_at(int(k) + 1)


def distance_to_chain(chain: Arcs, points: ComplexArray) -> FloatArray:
    """Exact distance of points, shape (n,) [mm], from the chain, shape (n,) [mm]."""
    nearest = np.full(points.shape, math.inf)
    segments = zip(chain.ends[:-1], chain.ends[1:], chain.curvature, chain.centres, strict=True)
    for start, end, curvature, centre in segments:
        to_ends = np.minimum(np.abs(points - start), np.abs(points - end))
        if curvature == 0.0:
            share = ((points - start) * np.conj(end - start)).real / abs(end - start) ** 2
            distance = np.where((share > 0.0) & (share < 1.0), np.abs(points - start - share * (end - start)), to_ends)
        else:
            # In the sector of the arc the distance is radial.
            middle = cmath.phase(complex((start + end) * 0.5 - centre))
            half = 0.5 * abs(cmath.phase(complex((end - centre) / (start - centre))))
            inside = np.abs(np.angle((points - centre) * np.exp(-1j * middle))) < half
            distance = np.where(inside, np.abs(np.abs(points - centre) - 1.0 / abs(curvature)), to_ends)
        nearest = np.minimum(nearest, distance)
    return nearest


def offset_left(chain: Arcs, distance: float, closed: bool = True) -> Arcs:
    """The chain ``distance`` to the left of its direction [mm], exact: arcs stay arcs about the same centres.

    At corners to the left neighbouring arcs are trimmed at their intersection; at corners to the right an arc about
    the corner joins them.

    Raises ``ExportError`` if ``distance`` is not below the least radius of arcs to the left.
    """
    tightest = float(np.max(chain.curvature))
    if tightest * distance >= 1.0:
        raise ExportError(
            "offset", f"{distance:.4f} mm", f"is not below the least concave radius {1.0 / tightest:.4f} mm",
            "take a thinner tool, or a larger corner radius",
        )  # fmt: skip
    entering, leaving = chain.tangents
    start, end = chain.ends[:-1] + 1j * distance * entering, chain.ends[1:] + 1j * distance * leaving
    curvature = chain.curvature / (1.0 - chain.curvature * distance)
    count = curvature.size
    corner: dict[int, float] = {}
    for k in range(count if closed else count - 1):
        turn = cmath.phase(complex(entering[(k + 1) % count] / leaving[k]))
        if abs(turn) <= _TANGENT:
            continue
        if turn > 0.0:
            _trim(k, (k + 1) % count, turn, distance, start, end, curvature, entering, leaving)
        else:
            corner[k] = turn
    ends, curvatures = [complex(start[0])], []
    for k in range(count):
        ends.append(complex(end[k]))
        curvatures.append(float(curvature[k]))
        if k in corner:
            # About the corner, in the direction of the chain.
            ends.append(complex(start[(k + 1) % count]))
            curvatures.append(-1.0 / distance)
    if closed:
        ends[-1] = ends[0]
    return Arcs(np.array(ends), np.array(curvatures))


def _trim(
    one: int, other: int, turn: float, distance: float, start: ComplexArray, end: ComplexArray, curvature: FloatArray,
    entering: ComplexArray, leaving: ComplexArray,
) -> None:  # fmt: skip
    """Move the end of one arc and the start of the next to their intersection, by Newton on the trimmed lengths."""
    first = partial(_along, complex(end[one]), complex(leaving[one]), float(curvature[one]))
    second = partial(_along, complex(start[other]), complex(entering[other]), float(curvature[other]))
    length = distance * math.tan(0.5 * turn)
    u, ahead = intersection(first, second, -length, length)
    back = -u
    if not (0.0 <= back < abs(end[one] - start[one]) and 0.0 <= ahead < abs(end[other] - start[other])):
        raise ExportError(
            "offset", f"{distance:.4f} mm", "does not fit into a corner of the outline", "take a thinner tool"
        )
    end[one] = start[other] = first(u)[0]


def intersection(first: Curve, second: Curve, u: float, v: float) -> tuple[float, float]:
    """Parameters at which two curves intersect, by Newton from ``u`` and ``v``."""
    for _ in range(_NEWTON_STEPS):
        (p, p_rate), (q, q_rate) = first(u), second(v)
        # q + q_rate·dv = p + p_rate·du
        miss, cross = q - p, (p_rate.conjugate() * q_rate).imag
        du, dv = -(q_rate.conjugate() * miss).imag / cross, -(p_rate.conjugate() * miss).imag / cross
        u, v = u + du, v + dv
        if abs(du) + abs(dv) < 1e-13:
            break
    return u, v


def _along(point: complex, tangent: complex, curvature: float, length: float) -> tuple[complex, complex]:
    """Point and unit tangent at the arc ``length`` [mm] from ``point`` on an arc."""
    half = 0.5 * curvature * length
    ratio = 1.0 if half == 0.0 else math.sin(half) / half
    return point + tangent * length * ratio * cmath.exp(1j * half), tangent * cmath.exp(2j * half)


def chain_blocks(chain: Arcs, sagitta: float, post: NcDialect) -> list[Block]:
    """Blocks along the chain; arcs within ``sagitta`` [mm] of a line become lines.

    Centres are relative to the rounded start, the actual position of the machine.
    """
    blocks = []
    here = post.rounded(complex(chain.ends[0]))
    for end, curvature, centre in zip(
        chain.ends[1:].tolist(), chain.curvature.tolist(), chain.centres.tolist(), strict=True
    ):
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
