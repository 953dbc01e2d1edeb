"""How the pins share the load: the result type of every load-sharing solver."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from enum import Enum
from itertools import zip_longest
from typing import Any

import numpy as np

from cycloid_profile.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.meshing import Meshing


class Status(Enum):
    """How a solve ended; the value is the sentence shown."""

    CONVERGED = "converged"
    INTERFERENCE = "pin and disc overlap before any load: raise the clearance"
    NO_CONTACT = "no first touch was found: check the modification amounts"
    NOT_CONVERGED = "stopped at the step limit before converging: check the modification amounts"
    LOST = "ran off to where no contact is: check torque, bearing stiffness and play"


STATUSES = tuple(Status)


@dataclass(frozen=True, slots=True)
class StagePlace:
    """Where the parts of a stage rest: ``rotation`` of the output, shape (poses,) [rad], and ``motion`` (x, y, θ) of
    each disc from its nominal place, shape (poses, discs, 3) [mm, mm, rad]; ``foot`` of each pin on its tooth, shape
    (poses, discs, pins), if known [rad].
    """

    rotation: FloatArray
    motion: FloatArray
    foot: FloatArray | None = None

    def poses(self, which: slice | IntArray) -> StagePlace:
        """The place at some of the poses."""
        return StagePlace(self.rotation[which], self.motion[which], None if self.foot is None else self.foot[which])


@dataclass(frozen=True, slots=True)
class StageMotion:
    """How the discs of a whole stage lie under load, and what their bearings carry.

    ``meshing`` of all discs; ``motion`` (x, y, θ) of each disc from its nominal place, shape
    (poses, discs, 3) [mm, mm, rad]; ``foot``, phase of the foot of each pin on its tooth [rad], and ``normal`` of each
    pin contact, outwards from the disc, housing frame, shape (poses, discs, pins); ``bearing_force`` that the eccentric
    puts on the disc, x + iy in the housing frame, shape (poses, discs, bearings of a disc) [N]; ``energy``, total
    potential, shape (poses,) [N·mm].
    """

    meshing: Meshing
    motion: FloatArray
    foot: FloatArray
    normal: ComplexArray
    bearing_force: ComplexArray
    energy: FloatArray


@dataclass(frozen=True, slots=True)
class LoadSharing:
    """Load on the pins at one or more poses.

    Arrays over poses × discs × pins; solvers of one disc on a held crank have one disc. ``phase`` ψ,
    positive on the loaded flank of either direction [rad]; ``gap`` left when the first pin touches [mm];
    ``approach`` [mm], ``force`` [N] and peak ``pressure`` [MPa] under load; ``lever`` of the pin force about
    the disc's centre, positive where it resists the torque [mm]; ``curvature`` of the tooth there, convex
    negative [1/mm]; ``pin_stiffness`` dF/dδ [N/mm].

    Arrays over poses: ``crank_angle`` of disc 1 [rad]; ``torque`` on the output, signed [N·mm];
    ``rotation`` of the output from its nominal place with ``touch`` the part of it at first touch, signed
    [rad]; ``torsional_stiffness`` dT/dΘ of the output [N·mm/rad]; ``residual``, largest error of the balances
    of forces and moments over the torque; ``outcome``, an index into ``STATUSES``.

    ``delta_max`` is the deformation at the critical phase [mm]. ``history`` holds (largest force [N],
    δmax [mm]) after each iteration. ``stage`` is None where the crank is held.
    """

    case: LoadCase
    solver: str
    crank_angle: FloatArray
    torque: FloatArray
    phase: FloatArray
    gap: FloatArray
    approach: FloatArray
    force: FloatArray
    pressure: FloatArray
    lever: FloatArray
    curvature: FloatArray
    pin_stiffness: FloatArray
    rotation: FloatArray
    touch: FloatArray
    torsional_stiffness: FloatArray
    residual: FloatArray
    outcome: IntArray
    max_force: float
    delta_max: float
    history: tuple[tuple[float, float], ...]
    stage: StageMotion | None = None

    @property
    def statuses(self) -> tuple[Status, ...]:
        """How each pose ended."""
        return tuple(STATUSES[i] for i in self.outcome)

    @property
    def status(self) -> Status:
        """How the solve as a whole ended: the worst of the poses."""
        return STATUSES[int(np.max(self.outcome))]

    @property
    def settled(self) -> BoolArray:
        """Which poses have an answer, shape (poses,): overlap before load is reported, but solved."""
        ok: BoolArray = self.outcome <= STATUSES.index(Status.INTERFERENCE)
        return ok

    @property
    def converged(self) -> bool:
        """Whether every pose has an answer."""
        return bool(np.all(self.settled))

    @property
    def loaded(self) -> BoolArray:
        """Which pins carry; one that merely touches may show a force of rounding size and does not."""
        carrying: BoolArray = self.force > 1e-9 * self.max_force
        return carrying

    @property
    def loaded_pins(self) -> int:
        """Most pins of one disc that carry at one pose."""
        return int(np.max(np.sum(self.loaded, axis=-1)))

    @property
    def fewest_loaded_pins(self) -> int:
        """Fewest pins of one disc that carry at one pose."""
        return int(np.min(np.sum(self.loaded, axis=-1)))

    @property
    def max_pressure(self) -> float:
        """Highest peak pressure [MPa]."""
        return float(np.max(self.pressure))

    @property
    def max_residual(self) -> float:
        """Largest residual of all poses."""
        return float(np.max(self.residual))

    @property
    def place(self) -> StagePlace:
        """Where the parts of a whole stage rest."""
        assert self.stage is not None
        return StagePlace(self.rotation, self.stage.motion, self.stage.foot)

    @property
    def twist(self) -> FloatArray:
        """Rotation beyond first touch, shape (poses,), signed [rad]."""
        beyond: FloatArray = self.rotation - self.touch
        return beyond

    @property
    def iterations(self) -> int:
        """Number of iterations."""
        return len(self.history)


def joined(blocks: list[LoadSharing]) -> LoadSharing:
    """Blocks of one case as one result."""
    if len(blocks) == 1:
        return blocks[0]
    first = blocks[0]
    arrays: dict[str, Any] = {
        field.name: np.concatenate([getattr(block, field.name) for block in blocks])
        for field in fields(LoadSharing)
        if isinstance(getattr(first, field.name), np.ndarray)
    }
    rounds = zip_longest(*(block.history for block in blocks), fillvalue=(0.0, 0.0))
    return replace(
        first,
        **arrays,
        max_force=max(block.max_force for block in blocks),
        delta_max=max(block.delta_max for block in blocks),
        history=tuple((max(f for f, _ in each), max(d for _, d in each)) for each in rounds),
        stage=None if first.stage is None else _joined_stages([block.stage for block in blocks if block.stage]),
    )


def _joined_stages(blocks: list[StageMotion]) -> StageMotion:
    names = ("motion", "foot", "normal", "bearing_force", "energy")
    return StageMotion(
        meshing=Meshing.of_blocks([block.meshing for block in blocks]),
        **{name: np.concatenate([getattr(block, name) for block in blocks]) for name in names},
    )
