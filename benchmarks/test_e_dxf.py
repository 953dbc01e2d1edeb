"""(e) A dense curve as DXF against the fewest lines that print its numbers."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile.export.dxf import write_polyline

VERTICES = 100_000


def test_polyline(side_by_side: Callable[..., Any], tmp_path: Path) -> None:
    angle = np.linspace(0.0, 2.0 * math.pi, VERTICES, endpoint=False)
    points = (60.0 + np.cos(39.0 * angle)) * np.exp(-1j * angle)
    # Both sides print nine decimals.
    points = np.round(points, 9)
    bare = tmp_path / "bare.dxf"

    def plain() -> None:
        with bare.open("w") as file:
            file.write(f"0\nSECTION\n2\nENTITIES\n0\nLWPOLYLINE\n8\nPROFILE\n90\n{VERTICES}\n70\n1\n")
            for x, y in zip(points.real.tolist(), points.imag.tolist(), strict=True):
                file.write(f"10\n{x}\n20\n{y}\n")
            file.write("0\nENDSEC\n0\nEOF\n")

    side_by_side(
        ours=lambda: write_polyline(tmp_path / "ours.dxf", points),
        plain=plain,
        rounds=9,
        row="(e) a polyline of 100,000 vertices as DXF R2010 with header, layers and line types: `write_polyline`",
        against="a bare entity, number by number",
        figure="ours / bare",
        most=3.0,
        most_seconds=0.5,
    )

    assert (tmp_path / "ours.dxf").stat().st_size > bare.stat().st_size > 0
