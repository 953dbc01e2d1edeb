"""Replace Roark's contact law by an own function, and compare pin forces, lost motion and torsional rigidity."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import cycloid_profile as cp
from cycloid_profile.units import ARCMIN, DEGREE, NEWTON_METRE, UM


def roller_test(force: np.ndarray, contact: cp.LineContact) -> np.ndarray:
    """Approach [mm] under forces [N], fitted to a roller test: δ = A F^n/b^m with the width b [mm]."""
    approach: np.ndarray = 4.2e-5 * force**0.91 / contact.width**0.82
    return approach


# A law that counts the deformation of the whole disc belongs to a rigid one.
roark = cp.design_disc(cp.catalog_drive("rv40e").replace("load.disc_body", "rigid")).case
own = replace(roark, law=cp.contact.LawFromApproach(roller_test, name="roller test"))
loads = {case.law.name: cp.StageEquilibrium().at(case, 0.0) for case in (roark, own)}
accuracies = {case.law.name: cp.accuracy(case) for case in (roark, own)}


def table() -> str:
    """One row for each law."""
    rows = [f"{'':<12}{'δmax [µm]':>10}{'F_max [N]':>11}{'lost motion [′]':>17}{'rigidity [N·m/′]':>18}"]
    for name, load in loads.items():
        found = accuracies[name]
        rigidity = found.torsional_rigidity * ARCMIN / NEWTON_METRE
        deformation = np.max(load.approach) / UM
        rows.append(
            f"{name:<12}{deformation:>10.3f}{load.max_force:>11.0f}{found.lost_motion / ARCMIN:>17.4f}{rigidity:>18.1f}"
        )
    return "\n".join(rows)


def visualize(folder: Path) -> tuple[Path, Path]:
    """Force on each pin of disc 1 by both laws, as PNG and SVG."""
    figure = Figure(figsize=(8.0, 4.2), layout="constrained")
    ax = figure.subplots()
    for (name, load), marker in zip(loads.items(), ("o", "s"), strict=True):
        loaded = load.loaded[0, 0]
        order = np.argsort(load.phase[0, 0][loaded])
        phase, force = load.phase[0, 0][loaded][order] / DEGREE, load.force[0, 0][loaded][order]
        ax.plot(phase, force, marker=marker, markersize=4, label=name)
    ax.set(xlabel="phase ψ of the pin [°]", ylabel="force [N]", title="RV-40E at 412 N·m: loaded pins of disc 1")
    ax.grid(alpha=0.4)
    ax.legend()
    return cp.plot.save(figure, folder, "own_contact_law")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table and draw the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/own_contact_law"), help="folder for the picture")
    folder = parser.parse_args(arguments).out
    folder.mkdir(parents=True, exist_ok=True)
    print(table())
    print(*visualize(folder), sep="\n")


if __name__ == "__main__":
    main()
