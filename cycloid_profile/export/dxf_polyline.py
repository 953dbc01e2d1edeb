"""Polylines of many vertices in a DXF, written about as fast as their numbers can be printed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.export.dxf_document import LAYERS, new_document, repeatable_bytes, save

_DECIMALS, _BULGE_DECIMALS = 9, 13


def add_polyline(
    space: Any, points: ComplexArray, bulge: FloatArray | None = None, layer: str = "PROFILE", closed: bool = True
) -> Any:
    """One LWPOLYLINE through ``points``, complex, shape (n,) [mm]; the entity.

    ``bulge``, shape (n,), is tan(θ/4) of the arc after each point, θ its angle, positive to the left; None for
    straight segments.
    """
    # Made here, so that ezdxf is imported only where a file is written.
    from ezdxf.entities.lwpolyline import LWPolylinePoints

    class Vertices(LWPolylinePoints):  # type: ignore[misc]
        """Vertices that print themselves at once: tag by tag ezdxf takes four times as long."""

        def dxftags(self) -> list[_Printed]:
            x, y, _, _, bend = self.values.T.tolist()
            if any(bend):
                lines = [f" 10\n{a!r}\n 20\n{b!r}\n 42\n{c!r}\n" for a, b, c in zip(x, y, bend, strict=True)]
            else:
                lines = [f" 10\n{a!r}\n 20\n{b!r}\n" for a, b in zip(x, y, strict=True)]
            return [_Printed("".join(lines))]

    vertices = Vertices()
    rows = np.zeros((len(points), Vertices.VERTEX_SIZE))
    # Adding zero turns −0.0 into 0.0.
    rows[:, 0], rows[:, 1] = np.round(points.real, _DECIMALS) + 0.0, np.round(points.imag, _DECIMALS) + 0.0
    if bulge is not None:
        rows[:, 4] = np.round(bulge, _BULGE_DECIMALS) + 0.0
    # Not vertex by vertex, which copies all before it each time.
    vertices.set(rows)
    polyline = space.add_lwpolyline([], close=closed, dxfattribs={"layer": layer})
    polyline.lwpoints = vertices
    return polyline


def write_polyline(path: Path, points: ComplexArray, bulge: FloatArray | None = None) -> None:
    """A DXF with one closed LWPOLYLINE on layer PROFILE; see ``add_polyline``."""
    with repeatable_bytes():
        doc = new_document(LAYERS)
        add_polyline(doc.modelspace(), points, bulge)
        save(doc, path)


class _Printed:
    """Stands for tags that are text already."""

    def __init__(self, text: str) -> None:
        self.text = text

    def dxfstr(self) -> str:
        """The text."""
        return self.text
