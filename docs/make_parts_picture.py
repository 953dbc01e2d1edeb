"""Draw every part of the printed drive of the catalogue: ``python docs/make_parts_picture.py``."""

from __future__ import annotations

import io
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
import trimesh
from matplotlib.colors import LightSource
from PIL import Image

PROGRAM = (sys.executable, "-m", "cycloid_profile")
PICTURE = Path(__file__).parent / "pictures" / "parts.png"
# Files of the package, in the order of the parts list.
PARTS = (
    "disc",
    "disc_2",
    "pin_ring",
    "pin",
    "crank_shaft",
    "crank_bearing",
    "output_roller",
    "output_pin",
    "carrier_plate",
)


def main() -> None:
    """Export the parts as STL, read them back and draw them, each at its own scale."""
    with TemporaryDirectory() as folder:
        spec = Path(folder) / "drive.toml"
        subprocess.run([*PROGRAM, "catalog", "printed_11", "--out", str(spec)], check=True, capture_output=True)
        # Rollers on the output pins: the hole is as large as roller, eccentricity and clearance together.
        text = spec.read_text(encoding="utf-8")
        holes = "roller_radius_mm = 1.9\npin_radius_mm = 1.2\nclearance_um = 100.0\n"
        spec.write_text(text.replace("radius_mm = 3.5\n", holes), encoding="utf-8")
        out = Path(folder) / "parts"
        words = ("export", str(spec), "--format", "stl", "parts-stl", "--out", str(out))
        subprocess.run([*PROGRAM, *words], check=True, capture_output=True)
        files = {path.stem: path for path in out.rglob("*.stl")}
        figure, axes = plt.subplots(3, 3, figsize=(5.5, 5.5), subplot_kw={"projection": "3d"}, layout="constrained")
        for ax, name in zip(axes.flat, PARTS, strict=True):
            mesh = trimesh.load_mesh(files[name])
            # Without antialiasing no seams show between triangles.
            look = {"color": "#a9bfe0", "lightsource": LightSource(azdeg=225, altdeg=60), "antialiased": False}
            ax.plot_trisurf(*mesh.vertices.T, triangles=mesh.faces, linewidth=0.0, **look)
            low, high = mesh.bounds
            ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
            ax.set_box_aspect(high - low, zoom=1.3 if high[2] - low[2] < high[0] - low[0] else 0.9)
            ax.set_axis_off()
            ax.view_init(elev=35, azim=-60)
            ax.set_title(name.replace("_", " "), fontsize=8)
        drawn = io.BytesIO()
        figure.savefig(drawn, dpi=300)
        Image.open(drawn).convert("RGB").reduce(3).quantize(64).save(PICTURE, optimize=True)


if __name__ == "__main__":
    main()
