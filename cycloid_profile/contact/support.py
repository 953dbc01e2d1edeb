"""What carries the discs: how carrier, cranks and discs move together to first order (docs/theory.md, Eqs. 35–36).

Unknowns of one pose are u = (Θ, then each disc's own freedoms); Θ is the carrier's rotation [rad].
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.geometry.drive import CentralEccentric, Cranks, Drive


@dataclass(frozen=True, slots=True)
class SupportModel:
    """Linear kinematics of the supports over poses.

    ``disc_motion`` shape (poses, discs, 3, unknowns): maps u to (x, y, θ) of each disc [mm, mm, rad].
    ``spring_stretch`` shape (poses, springs, 2, unknowns): maps u to the stretch of each bearing [mm].
    ``stiffness`` of every bearing, the same in all directions [N/mm].
    ``rigid_motion`` shape (poses, unknowns): u per rad of Θ that stretches no spring.
    ``arm`` shape (unknowns,): brings every generalised force to N·mm, 1 for rotations [mm for shifts].
    """

    disc_motion: FloatArray
    spring_stretch: FloatArray
    stiffness: float
    rigid_motion: FloatArray
    arm: FloatArray


def support_model(drive: Drive, crank_angle: FloatArray) -> SupportModel:
    """Kinematics at crank angles of shape (poses, discs) [rad]."""
    if isinstance(drive.support, Cranks):
        return _cranks(drive, drive.support, crank_angle)
    return _central(drive, drive.support, crank_angle)


def crank_turn_per_carrier_turn(drive: Drive) -> float:
    """Turn of a crank against the housing per carrier turn with the input held: 1 + z1/z2 (Eq. 33).

    Zero without a first stage: the eccentric itself is the input and is held.
    """
    return 0.0 if drive.first_stage is None else 1.0 + drive.first_stage.tooth_ratio


def _cranks(drive: Drive, cranks: Cranks, crank_angle: FloatArray) -> SupportModel:
    poses, discs = crank_angle.shape
    unknowns = 1 + 3 * discs
    disc_motion = np.zeros((poses, discs, 3, unknowns))
    stretch = np.zeros((poses, discs, cranks.count, 2, unknowns))
    rigid = np.zeros((poses, unknowns))
    rigid[:, 0] = 1.0
    # Velocity of an eccentric's centre per unit Θ: carried round with the carrier, and turned by its crank.
    swing = 1j * drive.trochoid.eccentricity * crank_turn_per_carrier_turn(drive) * np.exp(1j * crank_angle)
    for j in range(discs):
        own = 1 + 3 * j
        disc_motion[:, j, range(3), range(own, own + 3)] = 1.0
        rigid[:, own], rigid[:, own + 1], rigid[:, own + 2] = swing[:, j].real, swing[:, j].imag, 1.0
        for i in range(cranks.count):
            arm = 1j * cranks.circle_radius * np.exp(2j * math.pi * i / cranks.count)
            eccentric = arm + swing[:, j]
            stretch[:, j, i, 0, 0], stretch[:, j, i, 1, 0] = eccentric.real, eccentric.imag
            stretch[:, j, i, range(2), range(own, own + 2)] = -1.0
            stretch[:, j, i, :, own + 2] = -arm.real, -arm.imag
    return SupportModel(
        disc_motion, stretch.reshape(poses, -1, 2, unknowns), cranks.bearing_stiffness, rigid, _arms(drive, unknowns, 3)
    )


def _central(drive: Drive, eccentric: CentralEccentric, crank_angle: FloatArray) -> SupportModel:
    """Central eccentric: each disc turns with the carrier and shifts against its own bearing."""
    poses, discs = crank_angle.shape
    unknowns = 1 + 2 * discs
    disc_motion = np.zeros((poses, discs, 3, unknowns))
    stretch = np.zeros((poses, discs, 2, unknowns))
    rigid = np.zeros((poses, unknowns))
    rigid[:, 0] = 1.0
    for j in range(discs):
        own = 1 + 2 * j
        disc_motion[:, j, range(2), range(own, own + 2)] = 1.0
        disc_motion[:, j, 2, 0] = 1.0
        stretch[:, j, range(2), range(own, own + 2)] = -1.0
    return SupportModel(disc_motion, stretch, eccentric.bearing_stiffness, rigid, _arms(drive, unknowns, 2))


def _arms(drive: Drive, unknowns: int, per_disc: int) -> FloatArray:
    """The pin circle is the arm of a disc's shift; rotations are moments already."""
    arm = np.ones(unknowns)
    for own in range(1, unknowns, per_disc):
        arm[own : own + 2] = drive.trochoid.pin_circle_radius
    return arm
