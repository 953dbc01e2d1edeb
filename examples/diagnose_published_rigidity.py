"""Explain published torsional rigidities of 72, 95 and 108 N·m/′: mesh and crank bearings alone give 560 N·m/′.

The tooth-profile article measures 72 before and 95 N·m/′ after its compensation; catalogues print 108 to 113
(docs/articles.md). No publication prints a loop, so each loop is constructed: the simulated loop, a spring in series
that brings it to the published number, and the noise of a good encoder. The diagnosis sees the loop only.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import cycloid_profile as cp

PUBLISHED = {"catalogue": 108.0, "article, compensated": 95.0, "article, conventional": 72.0}  # [N·m/′]
NOISE = 0.004  # of the angle [′]
ROWS = 250
CANNOT_KNOW = """These loops cannot show:
- which part is soft. Shaft, carrier, main bearings and housing are springs in series, and a loop at the output sees
  their sum. A load on one part alone, or a second encoder behind the carrier, separates them.
- whether the stiffness is equal at all output angles. The loop was taken at one output angle: a bearing or a bolt that
  is softer on one side shows in loops at several angles.
- whether the number belongs to this reducer. A published single number is no measurement: neither the loop, nor its
  evaluated part, nor the specimen or the load is printed. The loop here has that rigidity by construction.
- why 72 became 95 N·m/′. A compensated flank keeps the shape of its loop; another specimen, fit or preload may not."""


@dataclass(frozen=True)
class Explained:
    """One published rigidity [N·m/′]: that of the constructed ``loop``, the spring in series and the diagnosis."""

    published: float
    loop: cp.measurement.Measurement
    series: float
    found: cp.diagnosis.Diagnosis

    @property
    def made(self) -> float:
        """Rigidity of the constructed loop [N·m/′]."""
        return rigidity(self.loop)


def rigidity(loop: cp.measurement.Measurement) -> float:
    """Torsional rigidity of a loop, b/a [N·m/′]."""
    return cp.rig.key_figures(loop)["torsional_rigidity_nm_per_arcmin"]


def loop_of(published: float, seed: int) -> cp.measurement.Measurement:
    """The simulated loop with the additional twist T·(1/k_published − 1/k_simulated) and noise."""
    torque = simulated["torque_nm"]
    twist = torque * (1.0 / published - 1.0 / alone)
    noise = NOISE * np.random.default_rng(seed).standard_normal(torque.size)
    columns = {"torque_nm": torque, "angle_arcmin": simulated["angle_arcmin"] + twist + noise}
    return replace(simulated, columns=columns, name=f"loop_{published:.0f}.csv")


def explain(published: float, seed: int) -> Explained:
    """Construct a loop and diagnose it."""
    loop = loop_of(published, seed)
    series = 1.0 / (1.0 / published - 1.0 / alone)
    return Explained(published, loop, series, cp.diagnosis.diagnose(reducer, [loop]))


reducer = cp.design.as_built_reducer(cp.read_spec(Path(__file__).with_name("rv40e.toml")))
simulated = cp.rig.simulate(reducer, "hysteresis", cp.rig.Settings(points=ROWS))
alone = rigidity(simulated)
explained = {name: explain(published, seed) for seed, (name, published) in enumerate(PUBLISHED.items(), 1)}


def report() -> str:
    """The spring found for each published number, and the limits of such loops."""
    lines = [f"mesh, discs and crank bearings alone: {alone:.1f} N·m/′", ""]
    for name, one in explained.items():
        lines.append(
            f"{name}: published {one.published:.0f}, loop {one.made:.1f}, needs {one.series:.1f} N·m/′ in series"
        )
        for effect in one.found.effects:
            sizes = ", ".join(f"{k} = {v:.4g} ± {effect.uncertainty[k]:.1g}" for k, v in effect.parameters.items())
            confusions = ", ".join(effect.group[1:]) or "none"
            lines.append(f"  {effect.candidate.name}: {sizes}; possible confusions: {confusions}")
        (gap,) = one.found.gaps
        lines.append(
            f"  held-out rows: gap {gap.held_out_before:.3f}′ → {gap.held_out_after:.4f}′, noise {gap.noise:.4f}′"
        )
    return "\n".join([*lines, "", CANNOT_KNOW])


def visualize(folder: Path) -> tuple[Path, Path]:
    """The simulated loop and the three constructed ones, as PNG and SVG."""
    figure = Figure(figsize=(8.0, 5.0), layout="constrained")
    ax = figure.subplots()
    ax.plot(simulated["angle_arcmin"], simulated["torque_nm"], color="black", label=f"simulated, {alone:.0f} N·m/′")
    for (name, one), colour in zip(explained.items(), ("tab:blue", "tab:orange", "tab:green"), strict=True):
        label = f"{name}: {one.published:.0f} N·m/′, {one.series:.0f} in series"
        ax.plot(one.loop["angle_arcmin"], one.loop["torque_nm"], ".", markersize=3.0, color=colour, label=label)
    ax.set(xlabel="angle [′]", ylabel="torque [N·m]", title="RV-40E: published rigidities as springs in series")
    ax.grid(alpha=0.4)
    ax.legend()
    return cp.plot.save(figure, folder, "diagnose_published_rigidity")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the report and draw the loops."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument(
        "--out", type=Path, default=Path("out/diagnose_published_rigidity"), help="folder for the picture"
    )
    folder = parser.parse_args(arguments).out
    folder.mkdir(parents=True, exist_ok=True)
    print(report())
    print(*visualize(folder), sep="\n")


if __name__ == "__main__":
    main()
