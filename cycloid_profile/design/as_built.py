"""Accuracy of the reducer with its effects, over a whole turn of the output."""

from __future__ import annotations

from dataclasses import dataclass

from cycloid_profile.effects.built import Built
from cycloid_profile.rig.evaluation import LoopFigures, evaluate_loop
from cycloid_profile.rig.hysteresis import hysteresis_loop
from cycloid_profile.rig.maps import AngleMap, lost_motion_map
from cycloid_profile.rig.transmission import TransmissionError, transmission_error


@dataclass(frozen=True, slots=True)
class AsBuiltAccuracy:
    """What a bench would read: ``lost_motion`` over a turn, ``loop`` at angle 0, ``transmission`` at rated torque."""

    built: Built
    lost_motion: AngleMap
    loop: LoopFigures
    transmission: TransmissionError


def accuracy_as_built(built: Built) -> AsBuiltAccuracy:
    """Measure the reducer on the rig."""
    loop = hysteresis_loop(built)
    return AsBuiltAccuracy(
        built,
        lost_motion_map(built),
        evaluate_loop(loop.torque, loop.angle),
        transmission_error(built, abs(built.case.torque)),
    )
