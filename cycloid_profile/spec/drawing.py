"""``[export.drawing]``: what a workshop drawing says beside the geometry. What is absent stays an empty field."""

from __future__ import annotations

from typing import Annotated

from cycloid_profile.spec.table import Table, key

_TEXT = {"max_length": 60, "pattern": r"^[^\x00-\x1f\x7f]*$"}
_FIT = {"pattern": r"^[A-Za-z]{1,2}[0-9]{1,2}$"}
_TOLERANCE = {"gt": 0, "le": 1e4}  # µm
_GIVE_TOLERANCE = "give a tolerance in µm"
_GIVE_FIT = "give a class such as H7"


class DrawingSpec(Table, frozen=True):
    """Fields, tolerances and notes of the drawing."""

    number: Annotated[str, key("Number of the drawing.", "give a short text", **_TEXT)] = ""
    drawn_by: Annotated[str, key("Who has drawn it.", "give a short text", **_TEXT)] = ""
    date: Annotated[
        str, key("Date field; empty unless given, so that files repeat.", "give a date as text", **_TEXT)
    ] = ""
    heat_treatment: Annotated[str, key("Heat treatment and hardness.", "give a short text", **_TEXT)] = ""
    general_tolerance: Annotated[
        str, key("General tolerances of what has none of its own.", "give a standard", **_TEXT)
    ] = "ISO 2768-mK"
    tooth_roughness_ra_um: (
        Annotated[float, key("Roughness Ra of the tooth flanks [µm].", "give 0.1 to 12.5", gt=0, le=100)] | None
    ) = None
    roughness_ra_um: (
        Annotated[float, key("Roughness Ra of all other surfaces [µm].", "give 0.1 to 25", gt=0, le=100)] | None
    ) = None
    bore_fit: Annotated[str, key("Tolerance class of the bore.", _GIVE_FIT, **_FIT)] | None = None
    hole_fit: Annotated[str, key("Tolerance class of crank and output holes.", _GIVE_FIT, **_FIT)] | None = None
    keyway_fit: Annotated[str, key("Tolerance class of the keyway's width.", _GIVE_FIT, **_FIT)] | None = None
    hole_position_um: (
        Annotated[float, key("Position tolerance of the holes, a diameter [µm].", _GIVE_TOLERANCE, **_TOLERANCE)] | None
    ) = None
    width_tolerance_um: (
        Annotated[float, key("Tolerance of the width, ± [µm].", _GIVE_TOLERANCE, **_TOLERANCE)] | None
    ) = None
    profile_tolerance_um: (
        Annotated[float, key("Profile tolerance of the tooth, whole zone [µm].", _GIVE_TOLERANCE, **_TOLERANCE)] | None
    ) = None
    single_pitch_tolerance_um: (
        Annotated[float, key("Single pitch deviation, ± [µm].", _GIVE_TOLERANCE, **_TOLERANCE)] | None
    ) = None
    cumulative_pitch_tolerance_um: (
        Annotated[float, key("Cumulative pitch deviation, whole range [µm].", _GIVE_TOLERANCE, **_TOLERANCE)] | None
    ) = None
    runout_tolerance_um: (
        Annotated[float, key("Runout of the teeth against the datum [µm].", _GIVE_TOLERANCE, **_TOLERANCE)] | None
    ) = None
    datum: Annotated[str, key("Surface that is datum A for measuring.", "give a short text", **_TEXT)] = "axis of bore"
    notes: Annotated[
        tuple[Annotated[str, key("A note.", "give a short text", **_TEXT)], ...],
        key("Further notes, one line each.", "give a list of short texts", max_length=6),
    ] = ()
