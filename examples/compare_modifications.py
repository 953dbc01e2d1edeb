"""Compare five grinding modifications with the same radial clearance: backlash, load sharing, lost motion, rigidity.

Radial clearance is Δr_rp + Δr_p, the gap at root and tip. The last row rotates the flanks of the conjugate pair
towards their pins to a backlash of 0.2′.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import cycloid_profile as cp
from cycloid_profile.units import ARCMIN, DEGREE, NEWTON_METRE, UM

DRIVE = cp.Drive(cp.Trochoid(40, 64.0, 1.3), 3.0, 11.5, 2, cp.Cranks(3, 36.0, 4.0e5), cp.InvoluteStage(12, 36, 1.5))
TORQUE = 412.0 * NEWTON_METRE
CLEARANCES = (6.0 * UM, 22.5 * UM)
BACKLASH_LEFT = 0.2 * ARCMIN
POSES = 6


@dataclass(frozen=True, slots=True)
class Modified:
    """One modified tooth under rated load."""

    name: str
    clearance: float
    profile: cp.ToothProfile
    sharing: cp.LoadSharing
    accuracy: cp.Accuracy

    @property
    def rigidity(self) -> float:
        """Torsional rigidity [N·m/′]."""
        return self.accuracy.torsional_rigidity * ARCMIN / NEWTON_METRE


def profiles(clearance: float) -> dict[str, cp.ToothProfile]:
    """The five teeth with the radial clearance ``clearance`` [mm]."""
    theory = DRIVE.theoretical_profile
    equidistant, radial_moving = cp.conjugate_pair(DRIVE.trochoid, clearance)
    conjugate = cp.modify(theory, equidistant, radial_moving)
    compensated = cp.compensate(cp.LoadCase(DRIVE, conjugate, TORQUE), cp.Equilibrium(), poses=POSES).profile
    excess = cp.contact.first_order_backlash(DRIVE, equidistant.amount, radial_moving.amount) - BACKLASH_LEFT
    return {
        "equidistant": cp.modify(theory, cp.Equidistant(clearance)),
        "zero-backlash pair": cp.modify(theory, *cp.zero_backlash_pair(DRIVE.trochoid, clearance)),
        "conjugate pair": conjugate,
        "conjugate, compensated": compensated,
        "conjugate, flanks turned": cp.modify(conjugate, cp.FlankRotation(-0.5 * excess)),
    }


def loaded(name: str, clearance: float, profile: cp.ToothProfile) -> Modified:
    """Load one tooth."""
    case = cp.LoadCase(DRIVE, profile, TORQUE)
    return Modified(name, clearance, profile, cp.Equilibrium().solve(case), cp.accuracy(case, POSES))


compared = {c: {name: loaded(name, c, profile) for name, profile in profiles(c).items()} for c in CLEARANCES}


def normal_removal(profile: cp.ToothProfile, phase: np.ndarray) -> np.ndarray:
    """Material ``profile`` lacks against theory along the normal, in the shape of ``phase`` [mm]; exact distances."""
    removal: np.ndarray = -cp.export.distances(DRIVE.theoretical_profile, profile.at(phase).position)
    return removal


def table() -> str:
    """All numbers, one line per tooth."""
    rows = [
        f"{'':<26}{'backlash [′]':>18}{'loaded':>8}{'F_max':>7}{'p0':>7}{'lost motion':>13}{'rigidity':>10}",
        f"{'':<26}{'least … worst':>18}{'pins':>8}{'[N]':>7}{'[MPa]':>7}{'[′]':>13}{'[N·m/′]':>10}",
    ]
    for clearance, teeth in compared.items():
        rows.append(f"radial clearance {clearance / UM:g} µm")
        for m in teeth.values():
            play = m.accuracy.backlash
            rows.append(
                f"  {m.name:<24}{play.least / ARCMIN:>8.4f} … {play.worst / ARCMIN:.4f} "
                f"{m.sharing.loaded_pins:>8}{m.sharing.max_force:>7.0f}{m.sharing.max_pressure:>7.0f}"
                f"{m.accuracy.lost_motion / ARCMIN:>13.3f}{m.rigidity:>10.1f}"
            )
    return "\n".join(rows)


def visualize(folder: Path) -> tuple[Path, Path]:
    """Normal removal of the five teeth, one panel per radial clearance, as PNG and SVG."""
    looks = (("black", "-"), ("grey", "--"), ("tab:blue", "-"), ("deepskyblue", "--"), ("tab:orange", "-"))
    phase = np.linspace(-np.pi, np.pi, 721)
    psi0 = DRIVE.trochoid.critical_phase
    figure = Figure(figsize=(10.0, 5.0), layout="constrained")
    axes = figure.subplots(1, len(compared))
    for ax, (clearance, teeth) in zip(axes, compared.items(), strict=True):
        for (colour, dash), m in zip(looks, teeth.values(), strict=True):
            removal = normal_removal(m.profile, phase)
            ax.plot(phase / DEGREE, removal / UM, color=colour, linestyle=dash, label=m.name)
        for side in (-1.0, 1.0):
            ax.axvline(side * psi0 / DEGREE, color="tab:green", linewidth=0.9, linestyle=":")
        ax.set(xlim=(-180, 180), xticks=range(-180, 181, 60), xlabel="phase ψ [°]   (0 root, ±180 tip)")
        ax.set(title=f"radial clearance {clearance / UM:g} µm", ylabel="material removed along the normal [µm]")
        ax.grid(alpha=0.4)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5)
    figure.suptitle("RV-40E: equal at root and tip, different on the loaded flank (dotted: ±ψ0)")
    return cp.plot.save(figure, folder, "compare_modifications")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table and draw the picture."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--out", type=Path, default=Path("out/compare_modifications"), help="folder for the picture")
    folder = parser.parse_args(arguments).out
    folder.mkdir(parents=True, exist_ok=True)
    print(table())
    print(*visualize(folder), sep="\n")


if __name__ == "__main__":
    main()
