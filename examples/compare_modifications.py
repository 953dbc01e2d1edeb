"""Five modifications with the same radial clearance on one RV-40E: backlash, load sharing, lost motion, rigidity.

Radial clearance is Δr_rp + Δr_p, the gap at root and tip. The last row turns the flanks of the conjugate pair
towards their pins until 0.2′ of backlash is left.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from tempfile import mkdtemp

import numpy as np

from cycloid_profile import (
    Accuracy,
    Cranks,
    Drive,
    Equidistant,
    Equilibrium,
    FlankRotation,
    InvoluteStage,
    LoadCase,
    LoadSharing,
    ToothProfile,
    Trochoid,
    accuracy,
    compensate,
    conjugate_pair,
    modify,
    zero_backlash_pair,
)
from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.backlash import first_order_backlash
from cycloid_profile.export.deviation import distances
from cycloid_profile.plot.style import BLACK, BLUE, GREEN, GREY, ORANGE, SKY, new_figure, phase_axis, save, style
from cycloid_profile.units import ARCMIN, DEGREE, NEWTON_METRE, UM

DRIVE = Drive(Trochoid(40, 64.0, 1.3), 3.0, 11.5, 2, Cranks(3, 36.0, 4.0e5), InvoluteStage(12, 36, 1.5))
TORQUE = 412.0 * NEWTON_METRE
CLEARANCES = (6.0 * UM, 22.5 * UM)
BACKLASH_LEFT = 0.2 * ARCMIN
POSES = 6


@dataclass(frozen=True, slots=True)
class Modified:
    """One modified tooth under rated load."""

    name: str
    clearance: float
    profile: ToothProfile
    sharing: LoadSharing
    accuracy: Accuracy

    @property
    def rigidity(self) -> float:
        """Torsional rigidity [N·m/′]."""
        return self.accuracy.torsional_rigidity * ARCMIN / NEWTON_METRE


def profiles(clearance: float) -> dict[str, ToothProfile]:
    """The five teeth with the radial clearance ``clearance`` [mm]."""
    theory = DRIVE.theoretical_profile
    equidistant, radial_moving = conjugate_pair(DRIVE.trochoid, clearance)
    conjugate = modify(theory, equidistant, radial_moving)
    compensated = compensate(LoadCase(DRIVE, conjugate, TORQUE), Equilibrium(), poses=POSES).profile
    excess = first_order_backlash(DRIVE, equidistant.amount, radial_moving.amount) - BACKLASH_LEFT
    return {
        "equidistant": modify(theory, Equidistant(clearance)),
        "zero-backlash pair": modify(theory, *zero_backlash_pair(DRIVE.trochoid, clearance)),
        "conjugate pair": conjugate,
        "conjugate, compensated": compensated,
        "conjugate, flanks turned": modify(conjugate, FlankRotation(-0.5 * excess)),
    }


def loaded(name: str, clearance: float, profile: ToothProfile) -> Modified:
    """Load one tooth."""
    case = LoadCase(DRIVE, profile, TORQUE)
    return Modified(name, clearance, profile, Equilibrium().solve(case), accuracy(case, POSES))


compared = {c: {name: loaded(name, c, profile) for name, profile in profiles(c).items()} for c in CLEARANCES}


def normal_removal(profile: ToothProfile, phase: FloatArray) -> FloatArray:
    """Material ``profile`` lacks against theory along the normal, in the shape of ``phase`` [mm]; exact distances."""
    removal: FloatArray = -distances(DRIVE.theoretical_profile, profile.at(phase).position)
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
    looks = ((BLACK, "-"), (GREY, "--"), (BLUE, "-"), (SKY, "--"), (ORANGE, "-"))
    phase = np.linspace(-np.pi, np.pi, 721)
    psi0 = DRIVE.trochoid.critical_phase
    with style():
        figure = new_figure(10.0, 5.0)
        axes = figure.subplots(1, len(compared))
        for ax, (clearance, teeth) in zip(axes, compared.items(), strict=True):
            for (colour, dash), m in zip(looks, teeth.values(), strict=True):
                removal = normal_removal(m.profile, phase)
                ax.plot(phase / DEGREE, removal / UM, color=colour, linestyle=dash, label=m.name)
            for side in (-1.0, 1.0):
                ax.axvline(side * psi0 / DEGREE, color=GREEN, linewidth=0.9, linestyle=":")
            phase_axis(ax)
            ax.set(title=f"radial clearance {clearance / UM:g} µm", ylabel="material removed along the normal [µm]")
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=5)
        figure.suptitle("RV-40E: equal at root and tip, different where the load is (dotted: ±ψ0)")
    return save(figure, folder, "compare_modifications")


if __name__ == "__main__":
    print(table())
    print(*visualize(Path(mkdtemp())), sep="\n")
