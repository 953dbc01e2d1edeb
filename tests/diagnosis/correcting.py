"""Reducers with a hidden flank error, named without a search, for tests of the correction.

Sizes are manufacturing tolerances; noise is 0.3 µm, as on a good measuring machine. Target: the new scan is within 10 %
of the noise, which a correction error of 0.46 σ would exceed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cycloid_profile.contact import LoadCase
from cycloid_profile.correction import Correction
from cycloid_profile.diagnosis import NamedEffect
from cycloid_profile.diagnosis.data.recording import record
from cycloid_profile.diagnosis.model.candidate import NOT_YET_PROPOSED, candidate_of
from cycloid_profile.diagnosis.model.priors import priors_of
from cycloid_profile.effects import AsBuiltReducer, Effect, as_drawn, effect_from_table, effect_to_table
from cycloid_profile.geometry import Cranks, Drive, InvoluteStage, Trochoid
from cycloid_profile.measurement import Measurement
from cycloid_profile.modification import Equidistant, modify
from cycloid_profile.rig import Settings, measurement_residual, simulate
from cycloid_profile.units import UM

NOISE = 0.3  # µm
CLOSED = 1.1  # times the noise
LOBES = 39
HIDDEN = (
    {"name": "equidistant_error", "amount_um": 3.0},
    {"name": "radial_moving_error", "amount_um": -3.0},
    {"name": "generating_eccentricity_error", "amount_um": 2.0},
    {"name": "thermal_growth", "temperature_k": 3.0},
    {"name": "disc_runout", "amplitude_um": 3.0, "phase_deg": 40.0},
    {"name": "disc_runout", "amplitude_um": 3.0, "phase_deg": 40.0, "form": 2},
    {"name": "disc_oval", "amplitude_um": 3.0, "phase_deg": 20.0},
    {"name": "cumulative_pitch_error", "amplitude_um": 2.0, "phase_deg": 100.0},
    {"name": "wheel_wear_drift", "amount_um": 2.0, "first_lobe": 5},
    {"name": "grinding_chatter", "amplitude_um": 0.5, "waves_per_turn": 300.0, "phase_deg": 10.0},
    {"name": "missing_deformation_compensation", "amount_um": 2.0},
    {"name": "flank_wear", "amount_um": 2.0},
    {"name": "single_tooth_error", "amount_um": 3.0, "lobe": 7},
    {"name": "tooth_form_error", "amplitude_um": 2.0, "phase_deg": 30.0},
)


def _each(tables: Sequence[dict[str, Any]]) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("hidden", tables, ids=lambda t: t["name"] + ("_2" if "form" in t else ""))


every_effect = _each(HIDDEN)
every_proposed_effect = _each([one for one in HIDDEN if one["name"] not in NOT_YET_PROPOSED])


@lru_cache
def drawn() -> AsBuiltReducer:
    """An RV-40E with 6 µm equidistant."""
    drive = Drive(Trochoid(40, 64.0, 1.3), 3.0, 11.5, 2, Cranks(3, 36.0, 4.0e5), InvoluteStage(12, 36, 1.5))
    return as_drawn(LoadCase(drive, modify(drive.theoretical_profile, Equidistant(6.0 * UM)), 412_000.0))


def of_table(values: dict[str, Any]) -> Effect:
    """The effect on disc 1."""
    return effect_from_table(values | {"disc": 1})


def named(one: Effect, *others: str) -> NamedEffect:
    """The effect as named by a diagnosis, with its exact size; ``others``: rest of its ambiguity group."""
    values = effect_to_table(one)
    kind, priors = type(one), priors_of(drawn())
    bare = candidate_of(kind, {"waves_per_turn": 100.0} if kind.name == "grinding_chatter" else {}, priors)
    own = (bare.size, bare.angle, "name")
    candidate = candidate_of(kind, {key: value for key, value in values.items() if key not in own}, priors)
    size = values[candidate.size]
    turn = 0.0 if candidate.angle is None else math.radians(candidate.waves * values.get(candidate.angle, 0.0))
    x = np.array([size * math.cos(turn), size * math.sin(turn)])
    return NamedEffect(candidate, x, 1e-4 * np.eye(2), (candidate.name, *others), None, 9.0)


def found(reducer: AsBuiltReducer, effects: list[NamedEffect], *scans: Measurement) -> Any:
    """A diagnosis with the named effects, without a search."""
    gaps = tuple(SimpleNamespace(recording=record(reducer, scan)) for scan in scans)
    return SimpleNamespace(
        reducer=reducer, effects=tuple(effects), gaps=gaps, verdict="effects_found", remainder=None, unexplained=False
    )


def scan_of(reducer: AsBuiltReducer, seed: int, noise: float = NOISE) -> Measurement:
    """A scan of disc 1."""
    return replace(simulate(reducer, "profile_scan", Settings(points=4680, noise=noise, seed=seed)), name="scan.csv")


def reground(corrected: Correction, errors: list[Effect], seed: int = 77) -> float:
    """Gap to the drawing [µm, rms] of a scan after the machine, with unchanged errors, has ground the program."""
    reducer = as_drawn(drawn().case).with_tooth(0, corrected.program)
    for one in errors:
        reducer = one.apply(reducer)
    return measurement_residual(as_drawn(drawn().case), scan_of(reducer, seed), 0).rms
