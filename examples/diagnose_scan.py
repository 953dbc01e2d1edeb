"""From a measured disc to the names of what went wrong when it was ground.

A disc is simulated with two errors nobody is told: an index error of the work spindle, and half of the deformation
compensation forgotten. The scan is laid beside the drawing, the errors are named with their sizes and uncertainties,
and a spec file with both added predicts the scan down to its noise.
"""

from __future__ import annotations

from pathlib import Path
from tempfile import mkdtemp

import cycloid_profile as cp
from cycloid_profile.design.ground import built_reducer
from cycloid_profile.discrepancy.diagnosis import diagnose
from cycloid_profile.discrepancy.outcome import Diagnosis
from cycloid_profile.discrepancy.told import effect_tables
from cycloid_profile.effects.process import CumulativePitchError, MissingDeformationCompensation
from cycloid_profile.measurement.files import format_measurement, read_measurement
from cycloid_profile.report.diagnosis_package import with_effects
from cycloid_profile.rig.simulate import Settings, simulate

SPEC = Path(__file__).with_name("rv40e.toml")
HIDDEN = (
    CumulativePitchError(amplitude_um=1.5, phase_deg=70.0, disc=1),
    MissingDeformationCompensation(amount_um=1.0, disc=1),
)


def main(folder: Path, points: int = 5000) -> tuple[Diagnosis, Path]:
    """Measure, diagnose, write the new spec; returns the diagnosis and the path of that spec."""
    drawn = built_reducer(cp.read_spec(SPEC))
    ground = drawn
    for effect in HIDDEN:
        ground = effect.apply(ground)
    scan = folder / "scan.csv"
    measured = simulate(ground, "profile_scan", Settings(points=points, noise=0.3, seed=3))
    scan.write_text(format_measurement(measured), encoding="utf-8")

    found = diagnose(drawn, [read_measurement(scan)])
    print(f"{found.verdict}; chance that noise alone leaves as much: {found.detection.p_value:.0e}")
    for one in found.effects:
        print(f"  {one.candidate.name}, not told from {', '.join(one.group[1:]) or 'no other'}")
        for key, value in one.parameters.items():
            if key in one.uncertainty:
                print(f"    {key} = {value:.3f} ± {one.uncertainty[key]:.3f}")
    for gap in found.gaps:
        print(f"gap in µm rms: {gap.fit_before:.3f} → {gap.fit_after:.3f}, of which noise {gap.noise:.3f}")
        print(f"  in rows that were not fitted: {gap.held_out_before:.3f} → {gap.held_out_after:.3f}")

    spec = folder / "rv40e_diagnosed.toml"
    text = with_effects(SPEC.read_text(encoding="utf-8"), effect_tables(found, {scan.name: scan.read_bytes()}))
    spec.write_text(text, encoding="utf-8")
    again = diagnose(built_reducer(cp.read_spec(spec)), [read_measurement(scan)])
    print(f"what is left: chance {found.left.p_value:.2f}; with {spec.name}: {again.verdict}")
    return found, spec


if __name__ == "__main__":
    main(Path(mkdtemp()))
