"""A diagnosis as plain values for JSON, and as tables of a spec file."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from typing import Any

from cycloid_profile.discrepancy.detection import Finding
from cycloid_profile.discrepancy.outcome import Diagnosis, FileGap, NamedEffect
from cycloid_profile.units import SIGNS, unit_of

_DIGITS = 6


def told(diagnosis: Diagnosis, name: str) -> dict[str, Any]:
    """The JSON object of a diagnosis (docs/diagnosis.md, "JSON")."""
    return {
        "schema": 1,
        "name": name,
        "verdict": diagnosis.verdict,
        "effects": [
            {**effect_told(one), "separate_by": one.separate_by, "ln_evidence": number(one.evidence)}
            for one in diagnosis.effects
        ],
        "where": [_place(finding) for finding in diagnosis.where],
        "remainder": None if diagnosis.remainder is None else _place(diagnosis.remainder),
        "nearest": [
            {
                "name": one.name,
                "share_explained": number(one.share),
                "parameters": rounded(one.parameters),
                "why_not": one.why,
            }
            for one in diagnosis.nearest
        ],
        "not_seen": [
            {"name": n, "smallest_detectable": smallest(size, parameter)}
            for n, (size, parameter) in diagnosis.not_seen.items()
        ],
        "p_value": number(diagnosis.detection.p_value),
        "p_value_after": number(diagnosis.left.p_value),
        "gap": [_gap(gap) for gap in diagnosis.gaps],
        "notes": list(diagnosis.notes),
    }


def effect_told(one: NamedEffect) -> dict[str, Any]:
    """An effect with its sizes, and what could stand in its place."""
    return {
        "name": one.candidate.name,
        "parameters": rounded(one.parameters),
        "uncertainty": rounded(one.uncertainty),
        "group": list(one.group),
        "elsewhere": [
            {"parameters": rounded(other.parameters), "uncertainty": rounded(other.uncertainty)}
            for other in one.elsewhere
        ],
    }


def effect_tables(diagnosis: Diagnosis, files: Mapping[str, bytes]) -> list[dict[str, Any]]:
    """Tables ``[[effects]]`` of what was found, with uncertainty and origin; ``files``, name and content of each."""
    data = ", ".join(f"{name} (sha256 {hashlib.sha256(text).hexdigest()[:16]})" for name, text in files.items())
    p_before, p_after = diagnosis.detection.p_value, diagnosis.left.p_value
    tables = []
    for one in diagnosis.effects:
        alike = f"; not told from {', '.join(one.group[1:])}" if len(one.group) > 1 else ""
        alike += "; its place is not told from others" if one.elsewhere else ""
        origin = f"diagnosed from {data}; p {chance(p_before)} before, {chance(p_after)} after{alike}"
        values = rounded(one.parameters)
        tables.append(
            {"name": one.candidate.name} | values | {"uncertainty": rounded(one.uncertainty), "origin": origin}
        )
    return tables


def chance(p: float) -> str:
    """A p-value for people: no chance is zero."""
    return f"{p:.2g}" if p > 1e-300 else "< 1e-300"


def smallest(size: float, parameter: str, symbols: bool = False) -> str:
    """A smallest detectable size with its unit, as a symbol if wanted; of a stiffness, the largest that is seen."""
    if not math.isfinite(size):
        return "not visible in these files"
    unit = unit_of(parameter)
    if symbols and unit == "nm_per_arcmin":
        return f"< {1.0 / size:.2g} {SIGNS[unit]}"
    if symbols:
        return f"{size:.2g} {SIGNS.get(unit, unit)}".strip()
    if unit == "nm_per_arcmin":
        return f"softer than {1.0 / size:.2g} {unit}"
    return f"{size:.2g} {'K' if unit == 'k' else unit}".strip()


def rounded(values: Mapping[str, Any]) -> dict[str, Any]:
    """Numbers with as many digits as anyone can use."""
    return {key: number(value) if isinstance(value, float) else value for key, value in values.items()}


def _place(finding: Finding) -> dict[str, Any]:
    return {
        "file": finding.file,
        "coordinate": finding.coordinate,
        "from": number(finding.start),
        "to": number(finding.end),
        f"rms_{finding.unit}": number(abs(finding.amplitude)),
        "p_value": number(finding.p_value),
    }


def _gap(gap: FileGap) -> dict[str, Any]:
    return {
        "file": gap.recording.name,
        "unit": gap.recording.unit,
        "noise": number(gap.noise),
        "noise_correlation": number(gap.recording.noise.rho),
        "fit_before": number(gap.fit_before),
        "fit_after": number(gap.fit_after),
        "held_out_before": number(gap.held_out_before),
        "held_out_after": number(gap.held_out_after),
        "chi2_per_row": number(gap.chi2_per_row),
        "closure": None if gap.closure is None else number(gap.closure),
    }


def number(value: float) -> float | None:
    """A number with as many digits as anyone can use, None where it is not finite."""
    return float(f"{value:.{_DIGITS}g}") if math.isfinite(value) else None
