"""A correction as plain values for JSON."""

from __future__ import annotations

from typing import Any

from cycloid_profile.discrepancy.correction import Correction
from cycloid_profile.discrepancy.correction_limits import STEEPEST
from cycloid_profile.discrepancy.outcome import Diagnosis
from cycloid_profile.discrepancy.remainder import in_words
from cycloid_profile.discrepancy.told import effect_told, number
from cycloid_profile.effects.registry import table
from cycloid_profile.units import DEGREE, UM


def correction_told(
    found: Correction, diagnosis: Diagnosis, name: str, limit_um: float, remainder_asked: bool
) -> dict[str, Any]:
    """The JSON object of a correction but for its files (docs/diagnosis.md, "What the correction does")."""
    shape, smooth = found.shape, found.remainder
    return {
        "schema": 1,
        "name": name,
        "disc": found.disc + 1,
        "verdict": diagnosis.verdict,
        "effects": [effect_told(one) for one in found.named],
        "known_effects": [
            {"name": one.name, "parameters": {k: v for k, v in table(one).items() if k != "name"}}
            for one in found.known
        ],
        "remainder": None
        if smooth is None
        else {
            "label": smooth.label,
            "rms_um": number(smooth.rms / UM),
            "largest_um": number(smooth.largest / UM),
            "lobes_without_points": list(smooth.lobes_without),
        },
        "largest_um": number(shape.largest / UM),
        "limit_um": limit_um,
        "adds_um": number(shape.added / UM),
        "steepest_um_per_mm": number(shape.steepest / UM),
        "limit_um_per_mm": number(STEEPEST / UM),
        "change_of_curvature_per_mm": number(shape.bending),
        "least_concave_radius_mm": number(shape.concave),
        "lobes_alike": found.program.lobes_alike,
        "scans": [
            {
                "file": scan.name,
                "noise_um": number(scan.noise),
                "rms_before_um": number(scan.rms_before),
                "rms_after_um": number(scan.rms_after),
                "lobe_1_at_deg": round(scan.turn / DEGREE, 4),
            }
            for scan in found.scans
        ],
        "rms_expected_um": number(found.rms_expected),
        "uncertainty_um": number(found.uncertainty / UM),
        "left_by_the_model_nm": number(found.residual / UM * 1e3),
        "not_ground_away": list(found.left),
        "notes": [*found.cautions, *_stock(shape.added / UM), *_not_named(found, diagnosis, remainder_asked)],
    }


def _stock(added_um: float) -> list[str]:
    if added_um < 0.05:
        return []
    return [
        f"the program leaves up to {added_um:.2f} µm more on than the drawing: it is for the next disc, or for stock"
    ]


def _not_named(found: Correction, diagnosis: Diagnosis, remainder_asked: bool) -> list[str]:
    if found.remainder is not None:
        return [in_words(found.remainder)]
    if remainder_asked:
        return ["beyond what is named nothing smooth stands above the noise: no remainder was ground"]
    if diagnosis.remainder is not None:
        return ["something without a name is left over: --remainder would grind its smooth part away"]
    return []
