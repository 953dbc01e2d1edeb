"""Kinematics of the disc supports: carrier, cranks and discs to first order (docs/theory.md, Eqs. 35–36).

Unknowns of one pose are u = (Θ, then the degrees of freedom of each disc); Θ is the carrier's rotation [rad].
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray, IntArray
from cycloid_profile.contact.bodies.deviations import NO_DEVIATIONS, PartDeviations
from cycloid_profile.contact.bodies.face_width import FaceWidth
from cycloid_profile.contact.bodies.radial_bearing import BearingLaw, bearing_law
from cycloid_profile.geometry import CentralEccentric, Cranks, Drive


@dataclass(frozen=True, eq=False, slots=True)
class SupportModel:
    """Linear kinematics of the supports over poses.

    ``disc_unknowns`` shape (discs, 3): which of the unknowns are (x, y, θ) of each disc [mm, mm, rad].
    ``spring_stretch`` shape (poses, springs, 2, unknowns): maps u to the stretch of each bearing [mm].
    ``misfit`` shape (poses, springs, 2): stretch at u = 0, from errors of eccentrics and bores [mm].
    ``bearing``, law of every bearing, the same in all directions; ``play``, radial, negative under preload [mm].
    ``rigid_motion`` shape (poses, unknowns): u per rad of Θ that stretches no spring.
    ``arm`` shape (unknowns,): brings every generalised force to N·mm, 1 for rotations [mm for shifts].
    ``tilt_unknowns`` shape (discs, 2), the last of the unknowns: slopes of each disc along x and y [rad]; (0, 2)
    without slices over the width. ``tilt_stiffness`` of all bearings of a disc [N·mm/rad].
    """

    disc_unknowns: IntArray
    spring_stretch: FloatArray
    misfit: FloatArray
    bearing: BearingLaw
    play: float
    rigid_motion: FloatArray
    arm: FloatArray
    tilt_unknowns: IntArray = field(default_factory=lambda: np.zeros((0, 2), dtype=np.intp))
    tilt_stiffness: float = 0.0

    def motion(self, u: FloatArray) -> FloatArray:
        """(x, y, θ) of each disc, shape (poses, discs, 3) [mm, mm, rad]."""
        moved: FloatArray = u[:, self.disc_unknowns]
        return moved

    def poses(self, which: slice | IntArray) -> SupportModel:
        """The model at some of the poses."""
        over_poses = ("spring_stretch", "misfit", "rigid_motion")
        return replace(self, **{name: getattr(self, name)[which] for name in over_poses})


def support_model(
    drive: Drive,
    crank_angle: FloatArray,
    deviations: PartDeviations = NO_DEVIATIONS,
    width: FaceWidth | None = None,
) -> SupportModel:
    """Kinematics at crank angles of shape (poses, discs) [rad]; discs with slices over their ``width`` can tilt."""
    if isinstance(drive.support, Cranks):
        plane = _cranks(drive, drive.support, crank_angle, deviations)
    else:
        plane = _central(drive, drive.support, crank_angle)
    return plane if width is None else _tilting(plane, width, drive.discs)


def _tilting(plane: SupportModel, width: FaceWidth, discs: int) -> SupportModel:
    """The supports with two slopes of each disc as further unknowns (Eq. 119)."""
    poses, bearings, _, before = plane.spring_stretch.shape
    tilt = before + np.arange(2 * discs).reshape(discs, 2)
    stretch = np.zeros((poses, bearings, 2, before + 2 * discs))
    stretch[..., :before] = plane.spring_stretch
    of_disc = bearings // discs
    for j in range(discs):
        for i in range(2):
            stretch[:, j * of_disc : (j + 1) * of_disc, i, tilt[j, i]] = -width.bearing_offset
    return replace(
        plane,
        spring_stretch=stretch,
        rigid_motion=np.concatenate([plane.rigid_motion, np.zeros((poses, 2 * discs))], axis=1),
        arm=np.concatenate([plane.arm, np.ones(2 * discs)]),
        tilt_unknowns=tilt,
        tilt_stiffness=of_disc * width.tilt_stiffness,
    )


def support_misfit(drive: Drive, crank_angle: FloatArray, deviations: PartDeviations) -> FloatArray:
    """``SupportModel.misfit`` alone, at crank angles of shape (poses, discs) [rad]."""
    if isinstance(drive.support, Cranks):
        return _misfit_of_cranks(drive, drive.support, crank_angle, deviations)
    return np.zeros((*crank_angle.shape, 2))


def crank_turn_per_carrier_turn(drive: Drive) -> float:
    """Turn of a crank against the housing per carrier turn with the input held: 1 + z1/z2 (Eq. 33).

    Zero without a first stage: the eccentric itself is the input and is held.
    """
    return 0.0 if drive.first_stage is None else 1.0 + drive.first_stage.tooth_ratio


def _cranks(drive: Drive, cranks: Cranks, crank_angle: FloatArray, deviations: PartDeviations) -> SupportModel:
    poses, discs = crank_angle.shape
    unknowns = 1 + 3 * discs
    stretch = np.zeros((poses, discs, cranks.count, 2, unknowns))
    rigid = np.zeros((poses, unknowns))
    rigid[:, 0] = 1.0
    a = drive.trochoid.eccentricity
    # Velocity of an eccentric's centre per unit Θ: carried round with the carrier, and turned by its crank.
    swing = 1j * a * crank_turn_per_carrier_turn(drive) * np.exp(1j * crank_angle)
    carrier = _carrier(drive, crank_angle)
    for j in range(discs):
        own = 1 + 3 * j
        rigid[:, own], rigid[:, own + 1], rigid[:, own + 2] = swing[:, j].real, swing[:, j].imag, 1.0
        for m in range(cranks.count):
            arm = 1j * cranks.circle_radius * np.exp(2j * math.pi * m / cranks.count) * carrier
            eccentric = arm + swing[:, j]
            stretch[:, j, m, 0, 0], stretch[:, j, m, 1, 0] = eccentric.real, eccentric.imag
            stretch[:, j, m, range(2), range(own, own + 2)] = -1.0
            stretch[:, j, m, 0, own + 2], stretch[:, j, m, 1, own + 2] = -arm.real, -arm.imag
    return SupportModel(
        disc_unknowns=np.arange(1, unknowns).reshape(discs, 3),
        spring_stretch=stretch.reshape(poses, -1, 2, unknowns),
        misfit=_misfit_of_cranks(drive, cranks, crank_angle, deviations),
        bearing=bearing_law(cranks),
        play=cranks.bearing_play,
        rigid_motion=rigid,
        arm=_arms(drive, unknowns, 3),
    )


def _carrier(drive: Drive, crank_angle: FloatArray) -> ComplexArray:
    """Direction of the carrier, which has turned by −φ/z_c when the crank of disc 1 is at φ, shape (poses,)."""
    direction: ComplexArray = np.exp(-1j * crank_angle[:, 0] / drive.trochoid.lobes)
    return direction


def _misfit_of_cranks(drive: Drive, cranks: Cranks, crank_angle: FloatArray, deviations: PartDeviations) -> FloatArray:
    carrier = _carrier(drive, crank_angle)
    misfit = np.zeros((*crank_angle.shape, cranks.count), dtype=np.complex128)
    turned = np.exp(1j * crank_angle)[..., np.newaxis]
    if deviations.eccentric_shift is not None:
        misfit += deviations.eccentric_shift * turned
    if deviations.bore_shift is not None:
        misfit -= deviations.bore_shift * carrier[:, np.newaxis, np.newaxis]
    # A planet turns on the carrier by the crank's angle less the carrier's own.
    planet = crank_angle[:, 0] * (1.0 + 1.0 / drive.trochoid.lobes)
    swing = 1j * drive.trochoid.eccentricity * turned
    if deviations.crank_lead is not None:
        misfit += swing * (deviations.crank_lead * np.exp(1j * planet)[:, np.newaxis]).real[:, np.newaxis, :]
    if deviations.sun_shift:
        misfit += swing * _lead_by_sun(drive, cranks, planet, deviations.sun_shift)[:, np.newaxis, :]
    return np.stack([misfit.real, misfit.imag], axis=-1).reshape(len(misfit), -1, 2)


def _lead_by_sun(drive: Drive, cranks: Cranks, planet: FloatArray, sun_shift: complex) -> FloatArray:
    """How far a sun off its axis drives each crank ahead (Eq. 46), shape (poses, cranks) [rad].

    Mean of both flanks of the involute mesh: the radial part of the offset shifts these in opposite directions.
    """
    assert drive.first_stage is not None
    # The sun turns against the planets. Where it moves along the path of a planet, it turns that planet back.
    sun = sun_shift * np.exp(-1j * planet / drive.first_stage.tooth_ratio)
    outwards = np.exp(2j * math.pi * np.arange(cranks.count) / cranks.count)
    along: FloatArray = (sun[:, np.newaxis] * np.conj(outwards)).imag
    return -along / drive.first_stage.planet_radius


def _central(drive: Drive, eccentric: CentralEccentric, crank_angle: FloatArray) -> SupportModel:
    """Central eccentric: each disc turns with the carrier and shifts against its own bearing."""
    poses, discs = crank_angle.shape
    unknowns = 1 + 2 * discs
    stretch = np.zeros((poses, discs, 2, unknowns))
    rigid = np.zeros((poses, unknowns))
    rigid[:, 0] = 1.0
    for j in range(discs):
        own = 1 + 2 * j
        stretch[:, j, range(2), range(own, own + 2)] = -1.0
    return SupportModel(
        disc_unknowns=np.array([[1 + 2 * j, 2 + 2 * j, 0] for j in range(discs)]),
        spring_stretch=stretch,
        misfit=support_misfit(drive, crank_angle, NO_DEVIATIONS),
        bearing=bearing_law(eccentric),
        play=eccentric.bearing_play,
        rigid_motion=rigid,
        arm=_arms(drive, unknowns, 2),
    )


def _arms(drive: Drive, unknowns: int, per_disc: int) -> FloatArray:
    """The pin circle is the arm of a disc's shift; rotations are moments already."""
    arm = np.ones(unknowns)
    for own in range(1, unknowns, per_disc):
        arm[own : own + 2] = drive.trochoid.pin_circle_radius
    return arm
