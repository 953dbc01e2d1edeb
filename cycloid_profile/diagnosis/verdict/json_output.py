"""Diagnosis as plain values for JSON, and as tables of a spec file."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from cycloid_profile.diagnosis.model.detection import Finding
from cycloid_profile.diagnosis.verdict.result import Diagnosis, FileGap, NamedEffect
from cycloid_profile.effects import data_file, empirical_to_table
from cycloid_profile.units import SIGNS, unit_of

_DIGITS = 6  # far below any uncertainty; equal results print equal


def diagnosis_to_json(diagnosis: Diagnosis, name: str) -> dict[str, Any]:
    """JSON object of a diagnosis (docs/diagnosis.md, "JSON")."""
    return {
        "schema": 1,
        "name": name,
        "verdict": diagnosis.verdict,
        "effects": [
            {**effect_to_json(one), "separate_by": one.separate_by, "ln_evidence": rounded_number(one.evidence)}
            for one in diagnosis.effects
        ],
        "where": [_place(finding) for finding in diagnosis.where],
        "remainder": _remainder(diagnosis),
        "nearest": [
            {
                "name": one.name,
                "share_explained": rounded_number(one.share),
                "parameters": rounded(one.parameters),
                "why_not": one.why,
            }
            for one in diagnosis.nearest
        ],
        "not_seen": [
            {"name": n, "smallest_detectable": detectable_text(size, parameter)}
            for n, (size, parameter) in diagnosis.not_seen.items()
        ],
        "empirical": [
            {
                **empirical_to_table(one.effect),
                "file": one.file,
                "held_out_before": rounded_number(one.held_out_before),
                "held_out_after": rounded_number(one.held_out_after),
                "unit": one.unit,
            }
            for one in diagnosis.empirical
        ],
        "p_value": rounded_number(diagnosis.detection.p_value),
        "p_value_after": rounded_number(diagnosis.residual_detection.p_value),
        "gap": [_gap(gap) for gap in diagnosis.gaps],
        "notes": list(diagnosis.notes),
    }


def effect_to_json(one: NamedEffect) -> dict[str, Any]:
    """An effect with its sizes, ambiguity group and other locations."""
    return {
        "name": one.candidate.name,
        "parameters": rounded(one.parameters),
        "uncertainty": rounded(one.uncertainty),
        "group": list(one.group),
        "elsewhere": [
            {"parameters": rounded(other.parameters), "uncertainty": rounded(other.uncertainty)}
            for other in one.other_locations
        ],
    }


def effect_tables(diagnosis: Diagnosis, files: Mapping[str, bytes]) -> list[dict[str, Any]]:
    """Tables ``[[effects]]`` of the named effects, with uncertainty and origin; ``files``: name and content of each
    file.
    """
    data = ", ".join(f"{name} (sha256 {hashlib.sha256(text).hexdigest()[:16]})" for name, text in files.items())
    p_before, p_after = diagnosis.detection.p_value, diagnosis.residual_detection.p_value
    tables = []
    for one in diagnosis.effects:
        doubts = f"; not separated from {', '.join(one.group[1:])}" if len(one.group) > 1 else ""
        doubts += "; other locations fit as well" if one.other_locations else ""
        origin = f"diagnosed from {data}; p {p_value_text(p_before)} before, {p_value_text(p_after)} after{doubts}"
        values = rounded(one.parameters)
        tables.append(
            {"name": one.candidate.name} | values | {"uncertainty": rounded(one.uncertainty), "origin": origin}
        )
    return tables


def empirical_tables(diagnosis: Diagnosis, files: Mapping[str, bytes]) -> list[dict[str, Any]]:
    """Tables ``[[empirical]]`` of the curves, each with the file it was fitted to."""
    return [
        empirical_to_table(replace(one.effect, data=(data_file(one.file, files[one.file]),)))
        for one in diagnosis.empirical
    ]


def p_value_text(p: float) -> str:
    """Text of a p-value; never zero."""
    return f"{p:.2g}" if p > 1e-300 else "< 1e-300"


def detectable_text(size: float, parameter: str, symbols: bool = False) -> str:
    """Text of a smallest detectable size with its unit; for a stiffness, the largest detectable one.

    ``symbols``: write the unit as a symbol, such as µm.
    """
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
    """The same mapping with floats rounded to ``_DIGITS`` significant digits."""
    return {key: rounded_number(value) if isinstance(value, float) else value for key, value in values.items()}


def _remainder(diagnosis: Diagnosis) -> dict[str, Any] | None:
    if diagnosis.remainder is None:
        return None
    within = diagnosis.within_model_error
    # The tests allow for the error of the model: they have no probability for what it may explain.
    return _place(diagnosis.remainder) | ({"p_value": None} if within else {}) | {"within_model_error": within}


def _place(finding: Finding) -> dict[str, Any]:
    return {
        "file": finding.file,
        "coordinate": finding.coordinate,
        "from": rounded_number(finding.start),
        "to": rounded_number(finding.end),
        f"rms_{finding.unit}": rounded_number(abs(finding.amplitude)),
        "p_value": rounded_number(finding.p_value),
    }


def _gap(gap: FileGap) -> dict[str, Any]:
    return {
        "file": gap.recording.name,
        "unit": gap.recording.unit,
        "noise": rounded_number(gap.noise),
        "noise_correlation": rounded_number(gap.recording.noise.rho),
        "fit_before": rounded_number(gap.fit_before),
        "fit_after": rounded_number(gap.fit_after),
        "held_out_before": rounded_number(gap.held_out_before),
        "held_out_after": rounded_number(gap.held_out_after),
        "chi2_per_row": rounded_number(gap.chi2_per_row),
        "closure": None if gap.closure is None else rounded_number(gap.closure),
    }


def rounded_number(value: float) -> float | None:
    """A number rounded to ``_DIGITS`` significant digits, None if it is not finite."""
    return float(f"{value:.{_DIGITS}g}") if math.isfinite(value) else None
