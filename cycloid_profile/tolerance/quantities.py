"""What of a reducer is counted: backlash by geometry; lost motion, transmission error and pressure by load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.meshing import output_turn
from cycloid_profile.effects.built import Built
from cycloid_profile.rig.maps import LOST_MOTION_SHARE
from cycloid_profile.tolerance.clearance import Clearance, clearance, spread
from cycloid_profile.tolerance.loaded import LoadedStage, loaded_stage
from cycloid_profile.tolerance.patterns import UnitChange
from cycloid_profile.units import ARCMIN, ARCSEC

BACKLASH_POSES, LOST_MOTION_POSES, TURN_POSES = 47, 17, 97


class Answers(Protocol):
    """One way to compute some quantities of many reducers."""

    @property
    def names(self) -> tuple[str, ...]:
        """Quantities, each named with its unit."""
        ...

    def of(self, x: FloatArray) -> FloatArray:
        """Values of reducers with coordinates ``x``, shape (reducers, quantities); NaN where there is no answer."""
        ...


@dataclass(frozen=True)
class BacklashAnswers:
    """Largest and least crank-locked backlash over a turn of the output; the least is negative where a disc binds.

    How far below zero says little: near root and tip no turn opens a gap.
    """

    clearance: Clearance
    names: tuple[str, ...] = ("backlash_arcmin", "least_backlash_arcmin")

    def of(self, x: FloatArray) -> FloatArray:
        """See ``Answers.of``."""
        turn = self.clearance.by_pose(x) / ARCMIN
        return np.stack([np.max(turn, axis=1), np.min(turn, axis=1)], axis=1)


@dataclass(frozen=True)
class LostMotionAnswers:
    """Largest rotation between ∓3 % of the rated torque over a turn of the output."""

    stage: LoadedStage
    names: tuple[str, ...] = ("lost_motion_arcmin",)

    def of(self, x: FloatArray) -> FloatArray:
        """See ``Answers.of``."""
        rotation, _ = self.stage.answers(x)
        there, back = np.split(rotation, 2, axis=1)
        return np.asarray(np.max(there - back, axis=1)[:, np.newaxis] / ARCMIN)


@dataclass(frozen=True)
class RatedAnswers:
    """Transmission error, peak to peak over a turn, and the highest peak pressure, at rated torque."""

    stage: LoadedStage
    names: tuple[str, ...] = ("transmission_error_arcsec", "peak_pressure_mpa")

    def of(self, x: FloatArray) -> FloatArray:
        """See ``Answers.of``."""
        rotation, pressure = self.stage.answers(x)
        return np.stack([np.ptp(rotation, axis=1) / ARCSEC, np.max(pressure, axis=1)], axis=1)


# Signs of the units that names of quantities end with.
# Quantities in the order they are told, and what each is.
QUANTITIES = {
    "backlash_arcmin": "backlash, crank locked, largest over a turn",
    "least_backlash_arcmin": "least backlash over a turn, negative where the reducer binds",
    "lost_motion_arcmin": "lost motion at ±3 % of rated torque, largest over a turn",
    "transmission_error_arcsec": "transmission error at rated torque, peak to peak over a turn",
    "peak_pressure_mpa": "highest contact pressure at rated torque",
}


@dataclass(frozen=True)
class Measures:
    """The quantities ``wanted`` of reducers that depart from ``built`` by some ``changes``."""

    built: Built
    changes: Sequence[UnitChange]
    wanted: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Quantities that are computed: those wanted, and what comes with them at no cost."""
        return tuple(name for answers in self.answers for name in answers.names)

    @cached_property
    def answers(self) -> tuple[Answers, ...]:
        """The ways to compute them, made once for all reducers."""
        trochoid, torque = self.built.case.drive.trochoid, abs(self.built.case.torque)
        orders, changes = trochoid.lobes * trochoid.pins, list(self.changes)
        found: list[Answers] = []
        if {"backlash_arcmin", "least_backlash_arcmin"} & set(self.wanted):
            found.append(BacklashAnswers(clearance(self.built, changes, BACKLASH_POSES)))
        if "lost_motion_arcmin" in self.wanted:
            crank = output_turn(trochoid, spread(LOST_MOTION_POSES, orders))
            light = np.repeat([LOST_MOTION_SHARE * torque, -LOST_MOTION_SHARE * torque], len(crank))
            found.append(LostMotionAnswers(loaded_stage(self.built, changes, np.tile(crank, 2), light)))
        if {"transmission_error_arcsec", "peak_pressure_mpa"} & set(self.wanted):
            crank = output_turn(trochoid, spread(TURN_POSES, orders))
            found.append(RatedAnswers(loaded_stage(self.built, changes, crank, np.full(len(crank), torque))))
        return tuple(found)

    def of(self, x: FloatArray) -> FloatArray:
        """Values of reducers with coordinates ``x``, shape (reducers, quantities), in the units of ``names``."""
        return np.concatenate([answers.of(x) for answers in self.answers], axis=1)
