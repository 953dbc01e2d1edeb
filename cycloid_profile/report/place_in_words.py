"""Where measurement and simulation differ, and by how much, in words."""

from __future__ import annotations

import math

from cycloid_profile.discrepancy.detection import Finding
from cycloid_profile.discrepancy.outcome import Diagnosis
from cycloid_profile.report.effect_in_words import in_words
from cycloid_profile.report.number_in_words import joined, minus
from cycloid_profile.units import SIGNS


def place_in_words(finding: Finding, diagnosis: Diagnosis) -> str:
    """Where a finding is and how large, in words."""
    unit = SIGNS.get(finding.unit, finding.unit)
    size = joined(f"{abs(finding.amplitude):.2g}", unit)
    start = finding.start
    if finding.coordinate == "waves per turn":
        text = f"a wave of {start:g} per turn of the disc, amplitude {size}"
    elif finding.coordinate == "order":
        text = f"order {start:g} per turn of the output, amplitude {size}"
    elif finding.coordinate == "file":
        text = f"all over the file, {size} rms"
    else:
        text = f"{_range_in_words(finding, diagnosis)}, {_signed(finding)} {size} in the mean"
    return f"{text} ({finding.file})"


def _signed(finding: Finding) -> str:
    if finding.unit == "um":
        return "material missing," if finding.amplitude > 0.0 else "material standing out,"
    return "measured above predicted by" if finding.amplitude > 0.0 else "measured below predicted by"


def _range_in_words(finding: Finding, diagnosis: Diagnosis) -> str:
    start, end = finding.start, finding.end
    if finding.coordinate == "lobe":
        lobes = diagnosis.built.case.drive.trochoid.lobes
        if abs(end - start - 1.0) < 1e-9 and start == round(start):
            return f"lobe {start:.0f}"
        first, last = math.floor(start), math.ceil(end) - 1
        low, high = 360.0 * (start - first) - 180.0, 360.0 * (end - last) - 180.0
        if first == last:
            return f"lobe {first}, ψ from {_degrees(low)} to {_degrees(high)}"
        return f"lobe {first} from ψ = {_degrees(low)} to lobe {min(last, lobes)} at ψ = {_degrees(high)}"
    if finding.coordinate == "psi_deg":
        return f"ψ from {_degrees(start)} to {_degrees(end)} on all lobes"
    if finding.coordinate == "output_angle_deg":
        return f"output angle {start:.4g}° to {end:.4g}°"
    for gap in diagnosis.gaps:
        recording = gap.recording
        if finding.coordinate == "row" and recording.name == finding.file:
            rows = [recording.rows[min(max(int(at), 0), recording.rows.size - 1)] for at in (start, end)]
            torque = recording.measurement["torque_nm"][rows]
            return f"rows {rows[0] + 1} to {rows[1] + 1}, torque {_torque(torque[0])} to {_torque(torque[1])} N·m"
    return f"{in_words(finding.coordinate)} {start:.4g} to {end:.4g}"


def _degrees(value: float) -> str:
    return minus(f"{value:.0f}°")


def _torque(value: float) -> str:
    return minus(f"{value:.0f}")
