"""A reader of DXF that knows nothing but pairs of group code and value, with its own B-spline and bulge."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np

Tags = list[tuple[int, str]]


def entities(path: Path, kind: str, layer: str) -> list[Tags]:
    """The entities of one kind on a layer, in order, from the ENTITIES section only."""
    lines = path.read_text(encoding="utf-8").splitlines()
    pairs = [(int(code), value.strip()) for code, value in zip(lines[0::2], lines[1::2], strict=True)]
    start = pairs.index((2, "ENTITIES"))
    pairs = pairs[start : pairs.index((0, "ENDSEC"), start)]
    edges = [i for i, (code, _) in enumerate(pairs) if code == 0] + [len(pairs)]
    found = [pairs[a:b] for a, b in itertools.pairwise(edges)]
    return [tags for tags in found if tags[0][1] == kind and (8, layer) in tags]


def header(path: Path, name: str) -> str:
    """Value of a header variable."""
    lines = [line.strip() for line in path.read_text(encoding="utf-8").splitlines()]
    return lines[lines.index(name) + 2]


def numbers(tags: Tags, code: int) -> np.ndarray:
    """All values of one group code."""
    return np.array([float(value) for found, value in tags if found == code])


def spline_points(tags: Tags, per_span: int) -> np.ndarray:
    """Points inside every knot span by de Boor's recursion, shape (n, 2)."""
    degree, knots = int(numbers(tags, 71)[0]), numbers(tags, 40)
    control = np.stack([numbers(tags, 10), numbers(tags, 20)], axis=-1)
    spans = [i for i in range(degree, len(knots) - degree - 1) if knots[i + 1] > knots[i]]
    inner = (np.arange(per_span) + 0.5) / per_span
    points = []
    for i in spans:
        t = knots[i] + (knots[i + 1] - knots[i]) * inner[:, None]
        d = [np.broadcast_to(control[j], (per_span, 2)) for j in range(i - degree, i + 1)]
        for r in range(1, degree + 1):
            for j in range(degree, r - 1, -1):
                low, high = knots[i - degree + j], knots[i + 1 + j - r]
                a = (t - low) / (high - low)
                d[j] = (1.0 - a) * d[j - 1] + a * d[j]
        points.append(d[degree])
    return np.concatenate(points)


def polyline_arcs(vertices: np.ndarray, bulge: np.ndarray, per_arc: int) -> np.ndarray:
    """Points on the arcs of a closed polyline, ends included, shape (arcs, per_arc, 2): by centre and angle."""
    start = vertices[:, 0] + 1j * vertices[:, 1]
    end = np.roll(start, -1)
    angle = 4.0 * np.arctan(bulge)
    centre = start + 0.5 * (end - start) * (1.0 - 1j / np.tan(0.5 * angle)).conj()
    t = np.linspace(0.0, 1.0, per_arc)
    z = centre[:, None] + (start - centre)[:, None] * np.exp(1j * angle[:, None] * t)
    assert np.max(np.abs(z[:, -1] - end)) < 1e-9, "the arc does not end at the next vertex"
    return np.stack([z.real, z.imag], axis=-1)


def turns_between(arcs: np.ndarray, bulge: np.ndarray) -> np.ndarray:
    """Angle by which the tangent turns from each arc to the next [rad]."""
    chord = (arcs[:, -1] - arcs[:, 0]) @ np.array([1.0, 1j])
    leave = np.angle(chord) + 2.0 * np.arctan(bulge)
    enter = np.angle(chord) - 2.0 * np.arctan(bulge)
    return np.abs((np.roll(enter, -1) - leave + math.pi) % (2.0 * math.pi) - math.pi)
