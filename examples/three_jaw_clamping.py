"""Teach the package an effect of your own, the form of a three-jaw chuck, then find it in a scan and cancel it.

The plug-in examples/plugins/three_jaw.py holds the effect. The scan is simulated with it; the diagnosis sees the scan
and the drawing only, and has the new name in its library next to the built-in ones.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import cycloid_profile as cp

HERE = Path(__file__).parent
POINTS, NOISE = 1500, 0.3  # [1, µm]
HIDDEN = {"name": "three_jaw_clamping", "amplitude_um": 2.4, "phase_deg": 20.0, "disc": 1}

cp.effects.load_plugins([str(HERE / "plugins" / "three_jaw.py")])
drawn = cp.design.as_built_reducer(cp.read_spec(HERE / "rv40e.toml"))
ground = cp.effects.apply_effects(drawn.case, [cp.effects.effect_from_table(HIDDEN)])
scan = cp.rig.simulate(ground, "profile_scan", cp.rig.Settings(points=POINTS, noise=NOISE, seed=3))
found = cp.diagnosis.diagnose(drawn, [scan])
(gap,) = found.gaps
corrected = cp.correction.correction(found)


def table() -> str:
    """What was found, the gap, and the scan expected after the correction."""
    lines = [f"{found.verdict}: {', '.join(one.candidate.name for one in found.effects)}"]
    for one in found.effects:
        lines += [
            f"  {key} = {value:.3g} ± {one.uncertainty[key]:.1g}"
            for key, value in one.parameters.items()
            if key in one.uncertainty
        ]
    return "\n".join(
        [
            *lines,
            f"gap of the scan: {gap.fit_before:.1f} → {gap.fit_after:.1f} µm rms, noise {gap.noise:.1f}",
            f"expected scan of a disc ground with the correction: {corrected.rms_expected:.1f} µm rms",
        ]
    )


def visualize(folder: Path) -> tuple[Path, Path]:
    """Scan minus drawing along the disc with the form found, and with that form added, as PNG and SVG."""
    figure = Figure(figsize=(10.0, 4.4), layout="constrained")
    axes = figure.subplots(1, 2, sharex=True, sharey=True)
    for ax, residuals, title in zip(axes, (gap.before, gap.after), ("drawing", "effect added"), strict=True):
        along = residuals.lobe + np.mod(residuals.phase, 2.0 * np.pi) / (2.0 * np.pi)
        ax.plot(along, residuals.residual, ".", markersize=2.0, color="tab:blue")
        ax.set(title=title, xlabel="lobe of the disc")
        ax.grid(alpha=0.4)
    axes[0].set_ylabel("material removed beyond the prediction [µm]")
    figure.suptitle("RV-40E, disc clamped in three jaws: an effect from a plug-in")
    return cp.plot.save(figure, folder, "three_jaw_clamping")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table and draw the residuals."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--out", type=Path, default=Path("out/three_jaw_clamping"), help="folder for the picture")
    folder = parser.parse_args(arguments).out
    folder.mkdir(parents=True, exist_ok=True)
    print(table())
    print(*visualize(folder), sep="\n")


if __name__ == "__main__":
    main()
