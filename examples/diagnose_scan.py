"""Find two hidden grinding errors in the scan of a disc, with their sizes and uncertainties.

The scan is simulated with an index error of the work spindle and with half of the deformation compensation left out.
The diagnosis sees the scan and the drawing only. A spec with both effects added predicts the scan down to its noise.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np
from matplotlib.figure import Figure

import cycloid_profile as cp

POINTS, NOISE = 5000, 0.3  # [1, µm]
HIDDEN = (
    {"name": "cumulative_pitch_error", "amplitude_um": 1.5, "phase_deg": 70.0, "disc": 1},
    {"name": "missing_deformation_compensation", "amount_um": 1.0, "disc": 1},
)

spec = cp.read_spec(Path(__file__).with_name("rv40e.toml"))
drawn = cp.design.as_built_reducer(spec)
ground = cp.effects.apply_effects(drawn.case, [cp.effects.effect_from_table(table) for table in HIDDEN])
scan = cp.rig.simulate(ground, "profile_scan", cp.rig.Settings(points=POINTS, noise=NOISE, seed=3))
found = cp.diagnosis.diagnose(drawn, [scan])
(gap,) = found.gaps

tables = cp.diagnosis.effect_tables(found, {})
new_spec = msgspec.structs.replace(spec, effects=[*spec.effects, *tables])
again = cp.diagnosis.diagnose(cp.design.as_built_reducer(new_spec), [scan])


def report() -> str:
    """The verdict, the effects with their sizes, and the gap before and after."""
    lines = [f"{found.verdict}; probability of this difference by noise alone: {found.detection.p_value:.0e}"]
    for one in found.effects:
        lines.append(f"  {one.candidate.name}, possible confusions: {', '.join(one.group[1:]) or 'none'}")
        lines += [
            f"    {key} = {value:.3f} ± {one.uncertainty[key]:.3f}"
            for key, value in one.parameters.items()
            if key in one.uncertainty
        ]
    return "\n".join(
        [
            *lines,
            f"gap in µm rms: {gap.fit_before:.3f} → {gap.fit_after:.3f}, of which noise {gap.noise:.3f}",
            f"  in held-out rows: {gap.held_out_before:.3f} → {gap.held_out_after:.3f}",
            f"with the effects added: {again.verdict}",
        ]
    )


def visualize(folder: Path) -> tuple[Path, Path]:
    """Scan minus prediction along the disc, before and after the effects are added, as PNG and SVG."""
    figure = Figure(figsize=(10.0, 4.4), layout="constrained")
    axes = figure.subplots(1, 2, sharex=True, sharey=True)
    for ax, residuals, title in zip(axes, (gap.before, gap.after), ("drawing", "effects added"), strict=True):
        along = residuals.lobe + np.mod(residuals.phase, 2.0 * np.pi) / (2.0 * np.pi)
        ax.plot(along, residuals.residual, ".", markersize=2.0, color="tab:blue")
        ax.set(title=title, xlabel="lobe of the disc")
        ax.grid(alpha=0.4)
    axes[0].set_ylabel("material removed beyond the prediction [µm]")
    figure.suptitle("RV-40E: " + " and ".join(one.candidate.name for one in found.effects))
    return cp.plot.save(figure, folder, "diagnose_scan")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the report, write scan and new spec, and draw the residuals."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--out", type=Path, default=Path("out/diagnose_scan"), help="folder for the files")
    folder = parser.parse_args(arguments).out
    folder.mkdir(parents=True, exist_ok=True)
    print(report())
    (folder / "scan.csv").write_text(cp.measurement.format_measurement(scan), encoding="utf-8")
    (folder / "rv40e_diagnosed.toml").write_text(cp.format_spec(new_spec), encoding="utf-8")
    print(folder / "scan.csv", folder / "rv40e_diagnosed.toml", *visualize(folder), sep="\n")


if __name__ == "__main__":
    main()
