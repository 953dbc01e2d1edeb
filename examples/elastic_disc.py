"""Compare rigid and elastic discs, write the compliance of one to a file, and load the drive with that file."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import cycloid_profile as cp
from cycloid_profile.units import ARCMIN, ARCSEC, DEGREE, NEWTON_METRE, UM

SPEC = cp.catalog_drive("rv40e")
BODIES = ("rigid", "elastic")


def design(disc_body: str) -> cp.DesignRecord:
    """The RV-40E with one kind of disc; both with the law that counts the deformation near the contact alone."""
    return cp.design_disc(SPEC.replace({"load.disc_body": disc_body, "load.contact_law": "weber-banaschek"}))


records = {body: design(body) for body in BODIES}


def over_carrier_angles(record: cp.DesignRecord, poses: int = 156) -> cp.LoadSharing:
    """One disc of the tooth before compensation while the crank turns once on the carrier."""
    angles = 2.0 * math.pi * record.drive.trochoid.lobes / record.drive.trochoid.pins * np.arange(poses) / poses
    return cp.Equilibrium().at(record.case, angles)


def table() -> str:
    """One row for each kind of disc."""
    rows = [f"{'disc':<9}{'δmax [µm]':>10}{'pins':>6}{'ripple [″]':>12}{'F_max [N]':>11}{'rigidity [N·m/′]':>18}"]
    for body, record in records.items():
        one, figures = over_carrier_angles(record), record.conventional_accuracy
        rows.append(
            f"{body:<9}{np.mean(one.deformation) / UM:>10.3f}{np.mean(np.sum(one.force > 0.0, axis=-1)):>6.1f}"
            f"{np.ptp(one.rotation) / ARCSEC:>12.2f}{one.max_force:>11.0f}"
            f"{figures.torsional_rigidity * ARCMIN / NEWTON_METRE:>18.1f}"
        )
    return "\n".join(rows)


def from_file(folder: Path) -> float:
    """Write the disc to ``folder`` and read it back through the spec; the twist of the stage differs by this [rad]."""
    path = folder / "disc.npz"
    case = records["elastic"].case
    case.disc_bodies[0].save(path)
    spec = SPEC.replace({"load.disc_body": "file", "load.disc_body_file": str(path)})
    # Both discs take the one of the file; the second has its holes turned half a tooth.
    read = cp.StageEquilibrium().at(cp.design_disc(spec).case, 0.0)
    return float(np.max(np.abs(read.twist - cp.StageEquilibrium().at(case, 0.0).twist)))


def visualize(folder: Path) -> tuple[Path, Path]:
    """Deformation at the critical phase over the angle of the crank on the carrier, as PNG and SVG."""
    figure = Figure(figsize=(8.0, 4.2), layout="constrained")
    ax = figure.subplots()
    for body, record in records.items():
        one = over_carrier_angles(record)
        turned = one.crank_angle * record.drive.trochoid.pins / record.drive.trochoid.lobes
        ax.plot(turned / DEGREE, one.deformation / UM, label=f"{body} disc")
    ax.axhline(4.06, color="0.5", linestyle=":", label="published, 4.06 µm")
    ax.set(xlabel="angle of the crank on the carrier [°]", ylabel="deformation δmax [µm]", ylim=(0.0, None))
    ax.set_title("RV-40E, one disc at 206 N·m: three crank holes, three waves")
    ax.set_xticks(np.arange(0, 361, 60))
    ax.grid(alpha=0.4)
    ax.legend(loc="lower right")
    return cp.plot.save(figure, folder, "elastic_disc")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table and draw the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/elastic_disc"), help="folder for matrix and picture")
    folder = parser.parse_args(arguments).out
    folder.mkdir(parents=True, exist_ok=True)
    print(table())
    print(f"with the disc of the file the twist differs by {from_file(folder) / ARCSEC:.2f}″")
    print(*visualize(folder), sep="\n")


if __name__ == "__main__":
    main()
