"""How the pins share the load: the result type of every load-sharing solver."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from enum import Enum
from itertools import zip_longest
from typing import Any

import numpy as np

from cycloid_profile._display import Described, frame
from cycloid_profile.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from cycloid_profile.contact.bodies import bearing_law, stage_displacements
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.mesh import Meshing
from cycloid_profile.units import ARCMIN, NEWTON_METRE


class SolveStatus(Enum):
    """How a solve ended; the value is the sentence shown."""

    CONVERGED = "converged"
    INTERFERENCE = "pin and disc overlap before any load: raise the clearance"
    NO_CONTACT = "no first touch was found: bring modification.equidistant_um and radial_moving_um nearer to zero"
    NOT_CONVERGED = (
        "stopped at the step limit before converging: "
        "bring modification.equidistant_um and radial_moving_um nearer to zero"
    )
    LOST = "ran off to where no contact is: check torque, bearing stiffness and play"


STATUSES = tuple(SolveStatus)


@dataclass(frozen=True, eq=False, slots=True)
class StagePositions:
    """Positions of the parts of a stage: ``rotation`` of the output, shape (poses,) [rad], and ``motion`` (x, y, θ) of
    each disc from its nominal place, shape (poses, discs, 3) [mm, mm, rad]; ``foot`` of each pin on its tooth, shape
    (poses, discs, pins), if known [rad]; forces ``load`` that deform elastic discs, see ``LoadSharing.load``, if known;
    ``tilt`` of each disc, see ``StageMotion``, if known.
    """

    rotation: FloatArray
    motion: FloatArray
    foot: FloatArray | None = None
    load: FloatArray | None = None
    tilt: FloatArray | None = None

    def poses(self, which: slice | IntArray) -> StagePositions:
        """The place at some of the poses."""
        known = (None if each is None else each[which] for each in (self.foot, self.load, self.tilt))
        return StagePositions(self.rotation[which], self.motion[which], *known)


@dataclass(frozen=True, eq=False, slots=True)
class StageMotion:
    """Displacements of the discs under load, and bearing forces.

    ``meshing`` of all discs; ``motion`` (x, y, θ) of each disc from its nominal place, shape
    (poses, discs, 3) [mm, mm, rad]; ``foot``, phase of the foot of each pin on its tooth [rad], and ``normal`` of each
    pin contact, outwards from the disc, housing frame, shape (poses, discs, pins); ``bearing_force`` that the eccentric
    puts on the disc, x + iy in the housing frame, shape (poses, discs, bearings of a disc) [N]; ``energy``, total
    potential, shape (poses,) [N·mm]; ``tilt``, shift of the disc along x and y per height above its mid-plane, shape
    (poses, discs, 2) [rad], None without slices over the width.
    """

    meshing: Meshing
    motion: FloatArray
    foot: FloatArray
    normal: ComplexArray
    bearing_force: ComplexArray
    energy: FloatArray
    tilt: FloatArray | None = None

    def of_poses(self, which: slice | IntArray) -> StageMotion:
        """The motion at some of the poses."""
        names = ("motion", "foot", "normal", "bearing_force", "energy")
        some: dict[str, Any] = {name: getattr(self, name)[which] for name in names}
        tilt = None if self.tilt is None else self.tilt[which]
        return replace(self, meshing=self.meshing.poses(which), **some, tilt=tilt)


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class LoadSharing(Described):
    """Load on the pins at one or more poses.

    Arrays over poses × discs × pins; solvers of one disc on a held crank have one disc. ``phase`` ψ,
    positive on the loaded flank of either direction [rad]; ``gap`` left when the first pin touches [mm];
    ``approach`` of contact [mm], ``force`` [N] and peak ``pressure`` [MPa] under load; ``receded``, how far an elastic
    disc gives way there [mm]; ``lever`` of the pin force about
    the disc's centre, positive where it resists the torque [mm]; ``curvature`` of the tooth there, convex
    negative [1/mm]; ``pin_stiffness`` dF/dδ [N/mm].

    Arrays over poses: ``crank_angle`` of disc 1 [rad]; ``torque`` on the output, signed [N·mm];
    ``rotation`` of the output from its nominal place with ``touch`` the part of it at first touch, signed
    [rad]; ``torsional_stiffness`` dT/dΘ of the output, NaN if it was not asked for [N·mm/rad]; ``residual``, largest
    error of the balances of forces and moments over the torque; ``outcome``, an index into ``STATUSES``.

    ``deformation`` of contact and disc together, shape (poses,): of one disc that at the critical phase, of a stage
    the largest of its loaded pins [mm]. ``history`` holds (largest force [N], deformation [mm]) after each iteration.
    ``stage`` is None where the crank is held.
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
    receded: FloatArray
    rotation: FloatArray
    touch: FloatArray
    torsional_stiffness: FloatArray
    residual: FloatArray
    outcome: IntArray
    deformation: FloatArray
    max_force: float
    history: tuple[tuple[float, float], ...]
    stage: StageMotion | None = None

    def _key_figures(self) -> Mapping[str, str]:
        poses, discs, pins = self.force.shape
        return {
            "solver": f"{self.solver}: {self.status.value}",
            "contact law": self.case.law.name,
            "poses × discs × pins": f"{poses} × {discs} × {pins}",
            "largest pin force": f"{self.max_force:.1f} N",
            "peak pressure": f"{self.max_pressure:.0f} MPa",
            "loaded pins of a disc": f"{self.fewest_loaded_pins} to {self.loaded_pins}",
            "twist": f"{np.max(np.abs(self.twist)) / ARCMIN:.4f}′",
            "torsional stiffness": f"{np.min(self.torsional_stiffness) / NEWTON_METRE * ARCMIN:.1f} N·m/′",
            "residual": f"{self.max_residual:.1e}",
        }

    def to_frame(self) -> Any:
        """``pandas.DataFrame`` with one row per pose, disc and pin, all counted from 0; columns as the attributes."""
        pose, disc, pin = (each.ravel() for each in np.indices(self.force.shape))
        columns = {"pose": pose, "disc": disc, "pin": pin, "crank_angle": self.crank_angle[pose]}
        names = ("phase", "gap", "approach", "force", "pressure", "lever", "curvature", "pin_stiffness", "receded")
        return frame({**columns, **{name: getattr(self, name).ravel() for name in names}})

    @property
    def statuses(self) -> tuple[SolveStatus, ...]:
        """How each pose ended."""
        return tuple(STATUSES[i] for i in self.outcome)

    @property
    def status(self) -> SolveStatus:
        """How the solve as a whole ended: the worst of the poses."""
        return STATUSES[int(np.max(self.outcome))]

    @property
    def settled(self) -> BoolArray:
        """Which poses have an answer, shape (poses,): overlap before load is reported, but solved."""
        ok: BoolArray = self.outcome <= STATUSES.index(SolveStatus.INTERFERENCE)
        return ok

    @property
    def converged(self) -> bool:
        """Whether every pose has an answer."""
        return bool(np.all(self.settled))

    @property
    def loaded(self) -> BoolArray:
        """Which pins carry load; a force of the size of rounding does not count."""
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
    def slope(self) -> FloatArray:
        """Slope of the tooth along the normal at each pin, closing above the mid-plane, shape of ``force`` [rad]."""
        if self.stage is None or self.stage.tilt is None:
            return np.zeros_like(self.force)
        tilt = self.stage.tilt[:, :, np.newaxis]
        along: FloatArray = self.stage.normal.real * tilt[..., 0] + self.stage.normal.imag * tilt[..., 1]
        return along

    def pressure_at(self, height: float) -> FloatArray:
        """Peak pressure at a ``height`` above the mid-plane of each disc [mm], shape of ``force`` [MPa] (Eq. 120)."""
        if self.case.width is None:
            return self.pressure
        return self._pressure_after(height * self.slope - self.case.width.relief(height))

    @property
    def edge_pressure(self) -> FloatArray:
        """Largest peak pressure over the face width, shape of ``force`` [MPa]; ``pressure`` is that of an even load.

        Edges count as they are in the slices; a sharp edge presses harder than any slice (docs/theory.md).
        """
        if self.case.width is None:
            return self.pressure
        return self._pressure_after(self.case.width.closest(self.slope))

    @property
    def max_edge_pressure(self) -> float:
        """Highest peak pressure over the face width [MPa]."""
        return float(np.max(self.edge_pressure))

    def _pressure_after(self, closer: FloatArray) -> FloatArray:
        """Peak pressure where tooth and pin are ``closer`` than at mid-height [mm]."""
        case, contact = self.case, self.case.line_contact(self.curvature)
        approach = np.where(self.force > 0.0, self.approach + closer, 0.0)
        pressure: FloatArray = case.law.peak_pressure(case.law.force(approach, contact), contact)
        return pressure

    @property
    def delta_max(self) -> float:
        """δmax, which a compensation adds to the tooth [mm]: with rigid discs the largest deformation of the poses.

        With elastic discs the mean over the poses, which go through all carrier angles: a tooth meets its pins at each.
        """
        return float(np.mean(self.deformation) if self.case.disc_bodies else np.max(self.deformation))

    @property
    def max_residual(self) -> float:
        """Largest residual of all poses."""
        return float(np.max(self.residual))

    @property
    def place(self) -> StagePositions:
        """Positions of the parts of a whole stage."""
        assert self.stage is not None
        return StagePositions(self.rotation, self.stage.motion, self.stage.foot, self.load, self.stage.tilt)

    @property
    def load(self) -> FloatArray:
        """Forces that deform elastic discs and supports, shape (poses, forces) [N]: of the pins, disc by disc, then
        both components of each bearing in the housing frame; without columns where all is rigid.
        """
        poses = len(self.force)
        if not self.case.elastic:
            return np.zeros((poses, 0))
        assert self.stage is not None
        bearings = self.stage.bearing_force
        both = np.stack([bearings.real, bearings.imag], axis=-1)
        return np.concatenate([self.force.reshape(poses, -1), both.reshape(poses, -1)], axis=1)

    @property
    def receded_supports(self) -> dict[str, FloatArray]:
        """How far each elastic support gives way at each pin, by name, shape (poses, discs, pins) [mm].

        It is no part of ``receded`` and ``deformation``. Pillars give way at the bearings, so that theirs is zero.
        """
        pins = self.force[0].size
        return {name: each[:, :pins].reshape(self.force.shape) for name, each in self._moved_supports().items()}

    def _moved_supports(self) -> dict[str, FloatArray]:
        """Displacements of each support by the forces on it, shape (poses, forces) [mm]."""
        if self.stage is None or not self.case.supports:
            return {}
        parts = self.case.supports.matrices(self.case.drive, self.stage.meshing)
        return {name: np.einsum("pij,pj->pi", one, self.load) for name, one in parts.items()}

    @property
    def rotation_by_part(self) -> dict[str, FloatArray]:
        """Shares of the parts in ``rotation``, shape (poses,) [rad], signed: their sum is the rotation (Eq. 94).

        By virtual work: forces in equilibrium with the torque times the deflections of each part. The clearance is the
        rest: gaps and play that the load closes. Of a whole stage only.
        """
        assert self.stage is not None
        support = self.case.drive.support
        pressed = np.abs(self.stage.bearing_force)
        beyond = bearing_law(support).displacement(pressed, support.bearing_play) - max(support.bearing_play, 0.0)
        work = {
            "contact": np.sum(self.force * self.approach, axis=(1, 2)),
            "discs": np.zeros(len(self.force)),
            "crank bearings": np.sum(pressed * beyond, axis=(1, 2)),
        }
        if self.case.disc_bodies:
            moved = stage_displacements(self.case.disc_bodies, self.stage.meshing, self.load)
            work["discs"] = np.sum(moved * self.load, axis=1)
        work |= {name: np.sum(moved * self.load, axis=1) for name, moved in self._moved_supports().items()}
        found: dict[str, FloatArray] = {name: each / self.torque for name, each in work.items()}
        clearance = self.rotation - np.sum(list(found.values()), axis=0)
        return {"clearance": clearance, **found}

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
        history=tuple((max(f for f, _ in each), max(d for _, d in each)) for each in rounds),
        stage=None if first.stage is None else _joined_stages([block.stage for block in blocks if block.stage]),
    )


def _joined_stages(blocks: list[StageMotion]) -> StageMotion:
    names = ("motion", "foot", "normal", "bearing_force", "energy")
    tilts = [block.tilt for block in blocks if block.tilt is not None]
    return StageMotion(
        meshing=Meshing.of_blocks([block.meshing for block in blocks]),
        **{name: np.concatenate([getattr(block, name) for block in blocks]) for name in names},
        tilt=np.concatenate(tilts) if tilts else None,
    )
