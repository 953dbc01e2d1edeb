"""Readers and an exact curve that share no code with the package, for round trips.

The curve is the textbook formula for x(ψ), y(ψ) with the deformation written into the pin radius; the
DXF, STEP and NC readers go by the text of the files alone.
"""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
from scipy.interpolate import BSpline
from scipy.spatial import cKDTree


def textbook_curve(
    psi: np.ndarray, equidistant: float = 0.0, delta_max: float = 0.0, z_p: int = 40, r_p: float = 64.0,
    r_rp: float = 3.0, a: float = 1.3,
) -> np.ndarray:  # fmt: skip
    """Points of the compensated tooth, shape (n, 2) [mm]."""
    z_c = z_p - 1
    i_H = z_p / z_c
    K1 = a * z_p / r_p
    S = (1.0 + K1**2 - 2.0 * K1 * np.cos(psi)) ** -0.5
    r = r_rp + equidistant - delta_max * np.abs(np.sin(psi)) * S
    u, v = r_p - r * S, a - K1 * r * S
    x = u * np.cos((1.0 - i_H) * psi) - v * np.cos(i_H * psi)
    y = u * np.sin((1.0 - i_H) * psi) + v * np.sin(i_H * psi)
    return np.stack([x, y], axis=-1)


class ExactCurve:
    """The textbook curve of the RV-40E with the distance of any point from it."""

    _PER_LOBE = 6000
    _LOCAL = np.linspace(-1.0, 1.0, 161)

    def __init__(self, equidistant: float, delta_max: float) -> None:
        self.equidistant, self.delta_max = equidistant, delta_max
        self.psi = np.linspace(0.0, 2.0 * math.pi * 39, 39 * self._PER_LOBE, endpoint=False)
        self.points = self.at(self.psi)
        self._tree = cKDTree(self.points)

    def at(self, psi: np.ndarray) -> np.ndarray:
        """Points at phases, shape (…, 2) [mm]."""
        return textbook_curve(psi, self.equidistant, self.delta_max)

    def corner_turns(self) -> np.ndarray:
        """Sudden turn of the tangent where the deformation has its kink: at the root ψ = 0 and the tip ψ = π [rad]."""
        at = np.array([0.0, math.pi])
        before, corner, after = (self.at(at + step) for step in (-1e-5, 0.0, 1e-5))
        directions = [np.arctan2(step[:, 1], step[:, 0]) for step in (corner - before, after - corner)]
        # Without deformation the curve turns as well within these steps.
        smooth = [textbook_curve(at + step, self.equidistant) for step in (-1e-5, 0.0, 1e-5)]
        plain = [np.arctan2(step[:, 1], step[:, 0]) for step in (smooth[1] - smooth[0], smooth[2] - smooth[1])]
        turns: np.ndarray = (directions[1] - directions[0]) - (plain[1] - plain[0])
        return turns

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Distance of each point [mm]: nearest vertex first, then chords 80 times finer about it (3e-9 mm)."""
        _, nearest = self._tree.query(points)
        local = self.at(self.psi[nearest, None] + self._LOCAL * (self.psi[1] - self.psi[0]))
        step = np.diff(local, axis=1)
        away = points[:, None, :] - local[:, :-1]
        t = np.clip(np.sum(away * step, axis=-1) / np.sum(step**2, axis=-1), 0.0, 1.0)
        return np.min(np.linalg.norm(away - t[..., None] * step, axis=-1), axis=1)


def area_inside(points: np.ndarray) -> float:
    """Area of a closed polygon by Green's theorem [mm²]."""
    x, y = points.T
    return 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))


def sample_spline(degree: int, knots: np.ndarray, control: np.ndarray, per_span: int = 6) -> np.ndarray:
    """Points inside every knot span, by scipy's evaluation."""
    edges = np.unique(knots)
    t = (edges[:-1, None] + np.diff(edges)[:, None] * (np.arange(per_span) + 0.5) / per_span).ravel()
    return BSpline(knots, control, degree)(t)


def read_dxf_splines(path: Path, layer: str) -> list[tuple[int, int, np.ndarray, np.ndarray]]:
    """Splines of a layer by their group codes: (degree, flags, knots, control points)."""
    lines = path.read_text(encoding="utf-8").splitlines()
    pairs = list(zip((int(code) for code in lines[0::2]), lines[1::2], strict=True))
    starts = [i for i, (code, value) in enumerate(pairs) if code == 0]
    found = []
    for start, end in zip(starts, [*starts[1:], len(pairs)], strict=True):
        tags = pairs[start:end]
        if tags[0][1] != "SPLINE" or (8, layer) not in tags:
            continue
        values = {code: [v for c, v in tags if c == code] for code in (10, 20, 40, 70, 71)}
        control = np.stack([np.array(values[10], float), np.array(values[20], float)], axis=-1)
        found.append((int(values[71][0]), int(values[70][0]), np.array(values[40], float), control))
    return found


def read_step_splines(path: Path) -> list[tuple[int, np.ndarray, np.ndarray]]:
    """All B-spline curves of a STEP file by its text: (degree, knots, control points x y z)."""
    text = re.sub(r"\s+", "", path.read_text(encoding="ascii"))
    points = {
        key: np.array(value.split(","), float)
        for key, value in re.findall(r"#(\d+)=CARTESIAN_POINT\('[^']*',\(([^)]*)\)\)", text)
        if value.count(",") == 2
    }
    curves = []
    pattern = (
        r"B_SPLINE_CURVE_WITH_KNOTS\('[^']*',(\d+),\(([^)]*)\),\.\w+\.,\.\w\.,\.\w\.,\(([^)]*)\),\(([^)]*)\),\.\w+\.\)"
    )
    for degree, poles, counts, knots in re.findall(pattern, text):
        control = np.array([points[pole.strip().lstrip("#")] for pole in poles.split(",")])
        curves.append(
            (int(degree), np.repeat(np.array(knots.split(","), float), np.array(counts.split(","), int)), control)
        )
    return curves


def read_nc_points(path: Path, per_arc: int = 7) -> tuple[np.ndarray, list[str]]:
    """Points along the G1, G2 and G3 blocks by angle about each centre, with the code of every block."""
    here = np.zeros(2)
    points, codes = [], []
    for block in path.read_text(encoding="ascii").splitlines():
        word = {
            letter: float(number) for letter, number in re.findall(r"([GXYIJ])(-?[\d.]+)", block) if block[0] == "G"
        }
        if "X" not in word:
            continue
        there = np.array([word["X"], word["Y"]])
        code = f"G{int(word['G'])}"
        t = (np.arange(per_arc) + 0.5) / per_arc
        if code in ("G2", "G3"):
            centre = here + np.array([word["I"], word["J"]])
            a0, a1 = (math.atan2(*(p - centre)[::-1]) for p in (here, there))
            turn = (a1 - a0) % (2.0 * math.pi) if code == "G3" else -((a0 - a1) % (2.0 * math.pi))
            r0, r1 = np.linalg.norm(here - centre), np.linalg.norm(there - centre)
            angle, radius = a0 + turn * t, r0 + (r1 - r0) * t
            points.append(centre + radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1))
        else:
            points.append(here + t[:, None] * (there - here))
        codes.append(code)
        here = there
    return np.array(points), codes
