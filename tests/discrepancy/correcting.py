"""Reducers with a hidden error of the flank, named without a search, for tests of the correction.

Sizes are those a workshop sees; noise is 0.3 µm, that of a good measuring machine. "Within 10 % of the noise" is the
aim: an error of the correction of 0.46 σ would use it up.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cycloid_profile.contact.case import LoadCase
from cycloid_profile.discrepancy.candidates import candidate_of
from cycloid_profile.discrepancy.correction import Correction
from cycloid_profile.discrepancy.outcome import NamedEffect
from cycloid_profile.discrepancy.recording import record
from cycloid_profile.effects.built import Built, as_drawn
from cycloid_profile.effects.effect import Effect
from cycloid_profile.effects.registry import effect, table
from cycloid_profile.geometry.drive import Cranks, Drive, InvoluteStage
from cycloid_profile.geometry.trochoid import Trochoid
from cycloid_profile.measurement.files import Measurement
from cycloid_profile.modification.setup import Equidistant, modify
from cycloid_profile.rig.gap import gap
from cycloid_profile.rig.simulate import Settings, simulate
from cycloid_profile.units import UM

NOISE = 0.3  # µm
CLOSED = 1.1  # of the noise
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
)
every_effect = pytest.mark.parametrize("hidden", HIDDEN, ids=lambda t: t["name"] + ("_2" if "form" in t else ""))


@lru_cache
def drawn() -> Built:
    """An RV-40E with 6 µm equidistant."""
    drive = Drive(Trochoid(40, 64.0, 1.3), 3.0, 11.5, 2, Cranks(3, 36.0, 4.0e5), InvoluteStage(12, 36, 1.5))
    return as_drawn(LoadCase(drive, modify(drive.theoretical_profile, Equidistant(6.0 * UM)), 412_000.0))


def of_table(values: dict[str, Any]) -> Effect:
    """The effect on disc 1."""
    return effect(values | {"disc": 1})


def named(one: Effect, *others: str) -> NamedEffect:
    """The effect as a diagnosis would name it, its size exactly right; ``others`` could stand in its place."""
    values = table(one)
    kind = type(one)
    bare = candidate_of(kind, {"waves_per_turn": 100.0} if kind.name == "grinding_chatter" else {})
    own = (bare.size, bare.angle, "name")
    candidate = candidate_of(kind, {key: value for key, value in values.items() if key not in own})
    size = values[candidate.size]
    turn = 0.0 if candidate.angle is None else math.radians(candidate.waves * values.get(candidate.angle, 0.0))
    x = np.array([size * math.cos(turn), size * math.sin(turn)])
    return NamedEffect(candidate, x, 1e-4 * np.eye(2), (candidate.name, *others), None, 9.0)


def found(built: Built, effects: list[NamedEffect], *scans: Measurement) -> Any:
    """A diagnosis that names the effects, without the search."""
    gaps = tuple(SimpleNamespace(recording=record(built, scan)) for scan in scans)
    return SimpleNamespace(built=built, effects=tuple(effects), gaps=gaps, verdict="effects_found", remainder=None)


def scan_of(built: Built, seed: int, noise: float = NOISE) -> Measurement:
    """A scan of disc 1."""
    return replace(simulate(built, "profile_scan", Settings(points=4680, noise=noise, seed=seed)), name="scan.csv")


def reground(corrected: Correction, errors: list[Effect], seed: int = 77) -> float:
    """Gap to the drawing [µm, rms] of a scan of what the machine, its errors unchanged, makes of the program."""
    built = as_drawn(drawn().case).with_tooth(0, corrected.program)
    for one in errors:
        built = one.apply(built)
    return gap(as_drawn(drawn().case), scan_of(built, seed), 0).rms
