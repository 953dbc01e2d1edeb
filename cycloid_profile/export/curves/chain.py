"""Chains of lines and arcs: contours as chains, exact offsets, intersections and distances."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from functools import partial

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.errors import ExportError
from cycloid_profile.export.curves.biarc import Arcs
from cycloid_profile.geometry import Arc, Contour

_TANGENT = 1e-6  # rad; smaller corners move a joint by less than the last decimal
_SHORT = 1e-7  # mm; a shorter piece is left out
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


def nearest_length(chain: Arcs, point: complex) -> float:
    """Arc length from the start of a chain to its exact nearest point to ``point`` [mm].

    The first of equal ones, on an arc about ``point`` its middle: far from corners.
    """
    best, nearest, passed, on_arc_about = 0.0, math.inf, 0.0, False
    for k, length in enumerate(chain.lengths.tolist()):
        start, curvature, centre = complex(chain.ends[k]), float(chain.curvature[k]), complex(chain.centres[k])
        about = curvature != 0.0 and abs(point - centre) < _SHORT
        if curvature == 0.0:
            along = ((point - start) * complex(chain.ends[k + 1] - start).conjugate()).real / length
        elif about:
            along = 0.5 * length
        else:
            turn = cmath.phase((point - centre) / (start - centre)) * math.copysign(1.0, curvature)
            # Beyond the end counts as nearer to the end than to the start by half the rest of the circle.
            half = 0.5 * length * abs(curvature)
            along = ((turn - half + math.pi) % (2.0 * math.pi) - math.pi + half) / abs(curvature)
        at = min(max(along, 0.0), length)
        distance = abs(_along_arc(chain, k, at) - point)
        # A later point must be clearly nearer, so that rounding does not choose.
        if distance < nearest - _SHORT or (about and not on_arc_about and distance < nearest + _SHORT):
            best, nearest, on_arc_about = passed + at, distance, about
        passed += length
    return best


def stretch(chain: Arcs, begin: float, length: float) -> Arcs:
    """The part of a closed chain from the arc length ``begin``, of any ``length`` [mm]; cut segments keep their
    circles."""
    lengths = chain.lengths
    whole = float(np.sum(lengths))
    begin = begin % whole
    at = np.concatenate([[0.0], np.cumsum(lengths)])
    k = min(int(np.searchsorted(at, begin, side="right")) - 1, lengths.size - 1)
    ends, curvature = [_along_arc(chain, k, begin - float(at[k]))], []
    left, offset = length, begin - float(at[k])
    while left > _SHORT:
        step = min(left, float(lengths[k]) - offset)
        if step > _SHORT:
            full = step == float(lengths[k]) - offset
            ends.append(complex(chain.ends[k + 1]) if full else _along_arc(chain, k, offset + step))
            curvature.append(float(chain.curvature[k]))
        left, offset, k = left - step, 0.0, (k + 1) % lengths.size
    if abs(length - whole) <= _SHORT:
        ends[-1] = ends[0]
    return Arcs(np.array(ends), np.array(curvature))


def _along_arc(chain: Arcs, k: int, length: float) -> complex:
    """Point on arc ``k`` at the arc ``length`` from its start [mm]."""
    return _along(complex(chain.ends[k]), complex(chain.tangents[0][k]), float(chain.curvature[k]), length)[0]


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
