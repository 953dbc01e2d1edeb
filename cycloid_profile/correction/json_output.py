"""A correction as plain values for JSON."""

from __future__ import annotations

from typing import Any

from cycloid_profile.correction._limits import MAX_SLOPE
from cycloid_profile.correction.correction_path import Correction
from cycloid_profile.diagnosis import Diagnosis, effect_to_json, remainder_text, rounded_number
from cycloid_profile.effects import Effect, FormDeviation, effect_to_table, empirical_to_table
from cycloid_profile.units import DEGREE, UM


def correction_to_json(
    found: Correction, diagnosis: Diagnosis, name: str, limit_um: float, remainder_asked: bool
) -> dict[str, Any]:
    """JSON object of a correction without its files (docs/diagnosis.md, "What the correction does")."""
    shape, smooth = found.shape, found.remainder
    return {
        "schema": 1,
        "name": name,
        "disc": found.disc + 1,
        "verdict": diagnosis.verdict,
        "effects": [effect_to_json(one) for one in found.named],
        "known_effects": [
            {"name": one.name, "parameters": {k: v for k, v in effect_to_table(one).items() if k != "name"}}
            for one in found.known
            if isinstance(one, Effect)
        ],
        **_empirical([one for one in found.known if isinstance(one, FormDeviation)]),
        "remainder": None
        if smooth is None
        else {
            "label": smooth.label,
            "rms_um": rounded_number(smooth.rms / UM),
            "largest_um": rounded_number(smooth.largest / UM),
            "lobes_without_points": list(smooth.lobes_without),
        },
        "largest_um": rounded_number(shape.largest / UM),
        "limit_um": limit_um,
        "adds_um": rounded_number(shape.stock / UM),
        "steepest_um_per_mm": rounded_number(shape.max_slope / UM),
        "limit_um_per_mm": rounded_number(MAX_SLOPE / UM),
        "change_of_curvature_per_mm": rounded_number(shape.curvature_change),
        "least_concave_radius_mm": rounded_number(shape.least_concave_radius),
        "lobes_alike": found.program.identical_lobes,
        "scans": [
            {
                "file": scan.name,
                "noise_um": rounded_number(scan.noise),
                "rms_before_um": rounded_number(scan.rms_before),
                "rms_after_um": rounded_number(scan.rms_after),
                "lobe_1_at_deg": round(scan.lobe_1_angle / DEGREE, 4),
            }
            for scan in found.scans
        ],
        "rms_expected_um": rounded_number(found.rms_expected),
        "uncertainty_um": rounded_number(found.uncertainty / UM),
        "left_by_the_model_nm": rounded_number(found.residual / UM * 1e3),
        "not_ground_away": list(found.not_ground_away),
        "notes": [*found.cautions, *_stock_note(shape.stock / UM), *_not_named(found, diagnosis, remainder_asked)],
    }


def _empirical(known: list[FormDeviation]) -> dict[str, Any]:
    """Curves of the spec that are cancelled, without their points; nothing where there are none."""
    rows = [
        {key: value for key, value in empirical_to_table(one).items() if key != "removal_um"}
        | {"largest_um": rounded_number(max(abs(value) for value in one.removal_um))}
        for one in known
    ]
    return {"empirical": rows} if rows else {}


def _stock_note(added_um: float) -> list[str]:
    if added_um < 0.05:
        return []
    return [f"the program leaves up to {added_um:.2f} µm of stock on the drawing: use it for the next disc"]


def _not_named(found: Correction, diagnosis: Diagnosis, remainder_asked: bool) -> list[str]:
    if found.remainder is not None:
        return [remainder_text(found.remainder)]
    if remainder_asked:
        return ["no smooth remainder exceeds the noise: none is corrected"]
    if diagnosis.unexplained:
        return ["an unexplained residual remains: --remainder corrects its smooth part"]
    return []
