"""Model on with build123d: fillet the bore of an RV-40E disc, drill three bolt holes, and export STEP."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from build123d import Cylinder, GeomType, PolarLocations, export_step, fillet
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

import cycloid_profile as cp

BOLT_RADIUS, BOLT_CIRCLE = 3.3, 42.0  # mm, free holes for M6 between the crank holes
FILLET = 0.8  # mm, where the bore meets both faces

record = cp.design_disc(cp.catalog_drive("rv40e"))
disc = cp.export.to_build123d(record)  # its flanks are the exact splines of disc.step
bore = [
    edge for edge in disc.edges().filter_by(GeomType.CIRCLE) if abs(edge.arc_center.X) + abs(edge.arc_center.Y) < 1e-9
]
bolts = PolarLocations(BOLT_CIRCLE, 3, start_angle=60.0).locations
drilled = fillet(bore, FILLET)
for place in bolts:
    drilled -= place * Cylinder(BOLT_RADIUS, 4.0 * record.drive.disc_width)
drilled.label, drilled.color = disc.label, disc.color
removed = disc.volume - drilled.volume  # mm³


def visualize(folder: Path) -> tuple[Path, Path]:
    """Draw the finished disc from above at a slant, as PNG and SVG."""
    points, triangles = drilled.tessellate(0.05, 0.3)
    figure = Figure(figsize=(6.0, 5.0))
    axes = figure.add_subplot()
    # Oblique view: height is shown upwards, faces that point down are hidden.
    seen = [[(points[i].X, 0.7 * points[i].Y + 0.7 * points[i].Z) for i in corners] for corners in triangles]
    depth = [sum(0.7 * points[i].Z - 0.7 * points[i].Y for i in corners) for corners in triangles]
    normals = [(points[b] - points[a]).cross(points[c] - points[a]).normalized() for a, b, c in triangles]
    order = [k for k in sorted(range(len(seen)), key=depth.__getitem__) if normals[k].Z - normals[k].Y > 0.0]
    grey = [str(round(0.3 + 0.6 * max(0.0, 0.9 * normals[k].Z + 0.3 * normals[k].X), 3)) for k in order]
    axes.add_collection(PolyCollection([seen[k] for k in order], facecolors=grey, edgecolors=grey, linewidths=0.2))
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set_axis_off()
    return cp.plot.save(figure, folder, "model_in_build123d")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the volume removed, write STEP and draw the part."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/model_in_build123d"), help="folder for the files")
    folder = parser.parse_args(arguments).out
    folder.mkdir(parents=True, exist_ok=True)
    export_step(drilled, folder / "disc_with_bolt_holes.step")
    print(f"{drilled.label}: {removed:.1f} mm³ removed by fillets and bolt holes")
    print(*visualize(folder), sep="\n")


if __name__ == "__main__":
    main()
