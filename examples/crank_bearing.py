"""Carry the discs on rollers: force and stiffness of a crank bearing by clearance, and what they do to the drive."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import cycloid_profile as cp
from cycloid_profile.units import ARCMIN, ARCSEC, NEWTON_METRE, UM

# 14 rollers are assumed, between the 12 and 16 of needle cages of this size; the spec estimates the other sizes.
SPEC = cp.catalog_drive("rv40e").replace(
    {"drive.crank_bearing.roller_count": 14, "disc.bore_radius_mm": 16.0, "disc.crank_hole_radius_mm": 13.0}
).replace("load.disc_body", "rigid")  # fmt: skip
KEY = "drive.crank_bearing."
BEARINGS = {
    "spring": {KEY + "model": "spring"},
    "preload 5 µm": {KEY + "preload_um": 5.0},
    "clearance 0": {KEY + "model": "rollers"},
    "clearance 5 µm": {KEY + "radial_clearance_um": 5.0},
    "class C2": {KEY + "clearance_class": "C2"},
    "class CN": {KEY + "clearance_class": "CN"},
}
FORCE = 3600.0  # N, largest at rated torque


def load_case(keys: dict[str, object]) -> cp.LoadCase:
    """Rated load on the conventional tooth."""
    spec = SPEC.replace(keys)
    drive = cp.design.drive_of(spec)
    return cp.design.load_case(spec, drive, cp.design.conventional_profile(spec, drive))


cases = {name: load_case(keys) for name, keys in BEARINGS.items()}
accuracies = {name: cp.design.accuracy(case, 24) for name, case in cases.items()}
bearings = {name: cp.design.bearing_stiffness(case.drive.support, FORCE) for name, case in cases.items()}


def table() -> str:
    """One row for each bearing: its displacement and stiffness under ``FORCE``, and the drive."""
    rows = [
        f"{'bearing':<16}{'r [µm]':>8}{'dF/dr [N/µm]':>14}{'lost motion [′]':>17}{'rigidity [N·m/′]':>18}{'TE [″]':>8}"
    ]
    for name, one in accuracies.items():
        held = bearings[name]
        rows.append(
            f"{name:<16}{held.displacement / UM:>8.2f}{held.tangent * UM:>14.0f}{one.lost_motion / ARCMIN:>17.3f}"
            f"{one.torsional_rigidity * ARCMIN / NEWTON_METRE:>18.0f}{one.transmission_error / ARCSEC:>8.3f}"
        )
    return "\n".join(rows)


def visualize(folder: Path) -> tuple[Path, Path]:
    """Force and stiffness over the radial displacement, as PNG and SVG."""
    figure = Figure(figsize=(8.0, 6.4), layout="constrained")
    top, bottom = figure.subplots(2, sharex=True)
    r = np.linspace(0.0, 35.0 * UM, 400)
    for name, case in cases.items():
        support = case.drive.support
        found = cp.contact.bodies.bearing_law(support).response(r, support.bearing_play)
        style = {"color": "0.5", "linestyle": "--"} if name == "spring" else {}
        top.plot(r / UM, found.secant * r / 1e3, label=name, **style)
        bottom.plot(r / UM, found.tangent * UM, **style)
    top.set(ylabel="force [kN]", ylim=(0.0, 8.0), title="RV-40E, one crank bearing: 14 rollers of 2.99 mm × 8.62 mm")
    bottom.set(xlabel="radial displacement [µm]", ylabel="stiffness dF/dr [N/µm]", ylim=(0.0, None))
    for ax in (top, bottom):
        ax.grid(alpha=0.4)
    top.legend(loc="upper left")
    return cp.plot.save(figure, folder, "crank_bearing")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table and draw the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/crank_bearing"), help="folder for the picture")
    folder = parser.parse_args(arguments).out
    folder.mkdir(parents=True, exist_ok=True)
    print(table())
    print(*visualize(folder), sep="\n")


if __name__ == "__main__":
    main()
