"""Equilibria of a stage beside those of a slightly different one: all poses at once, compiled where it can be.

A tooth differs from the parallel curve of its trochoid by removals, any formulas. The compiled code sees their Taylor
series about a phase near each foot, and the series is taken anew until the feet stay where it holds.
"""

from __future__ import annotations

import math
from importlib.util import find_spec

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray
from cycloid_profile.contact.as_built import AsBuilt
from cycloid_profile.contact.backlash import LEAST_REACH
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.gap import Gaps, least_bed
from cycloid_profile.contact.law_forms import Logarithmic
from cycloid_profile.contact.meshing import Meshing
from cycloid_profile.contact.support import SupportModel
from cycloid_profile.geometry.profile import ToothProfile

_NUMBA = find_spec("numba") is not None
# Poses × pins; below, the compiled code would take longer to load than it saves.
_WORTH_COMPILING = 4000
# Rounds of exact gaps, and of whole steps among them: a disc afloat in its play can swing between two places.
REFRESHES, WHOLE_STEPS = 80, 6
_ROUNDS = 5
# A removal of micrometres errs by its third derivative times a sixth of the cube of this: below 1e-11 mm.
_SERIES_HOLDS = 3e-4  # rad
# Short waves and measured points bend otherwise a little further on, and contacts are as stiff as the tooth is bent.
_SERIES_HOLDS_ON_WAVES = 1e-7  # rad
_MATTERS = 0.005  # mm; pins with a wider gap press on nothing


def settled_near(
    case: LoadCase,
    as_built: AsBuilt,
    meshing: Meshing,
    support: SupportModel,
    torque: FloatArray,
    tolerance: FloatArray,
    overclosure: FloatArray,
    begin: FloatArray,
    foot: FloatArray | None,
) -> tuple[FloatArray, Gaps, BoolArray] | None:
    """Unknowns at equilibrium, shape (poses, unknowns), the gaps there, and the poses that this holds for, found from
    the unknowns ``begin`` and the feet near them, shape (poses, discs, pins).

    On a tooth with corners the gaps are those of its smooth branches near the feet, and a balance is to be checked with
    exact ones. A pose is left out that does not settle, or with a pin that may have a second foot. None where the plain
    way is the only one or no slower: without numba, for another contact law, few poses.
    """
    if not (_NUMBA and isinstance(case.law, Logarithmic) and meshing.phase.size >= _WORTH_COMPILING):
        return None
    teeth = [case.profile] * case.drive.discs if as_built.teeth is None else list(as_built.teeth)
    from cycloid_profile.contact.compiled_stage import settle

    u, shape = begin.copy(), meshing.phase.shape
    found = np.broadcast_to(meshing.phase if foot is None else foot, shape).copy()
    known = np.all(np.isfinite(u), axis=-1) & np.all(np.isfinite(found), axis=(1, 2))
    u[~known], found[~known] = 0.0, meshing.phase[~known]
    contact = case.line_contact(np.zeros(1))
    scale = case.law.scale(contact)
    drive, pins = case.drive, shape[-1]
    oversize = 0.0 if as_built.pin_oversize is None else as_built.pin_oversize
    gap, curvature, settled = np.empty(shape), np.empty(shape), np.zeros(shape[0], dtype=np.bool_)
    frame = np.empty((shape[0], 3, *shape[1:]))
    constants = np.array([_constants(tooth) for tooth in teeth])
    bed = np.stack([_bed(tooth, found[:, j], meshing.lobe[:, j]) for j, tooth in enumerate(teeth)], axis=1)
    short = any(removal.spacing is not None for tooth in teeth for removal in tooth.removals)
    near_enough = _SERIES_HOLDS_ON_WAVES if short else _SERIES_HOLDS
    holds = known
    for _ in range(_ROUNDS):
        about = found.copy()
        settle(
            constants, bed, np.zeros(pins) + drive.pin_radius + oversize,
            np.zeros(pins) + (0j if as_built.pin_shift is None else as_built.pin_shift),
            np.ascontiguousarray(meshing.pin_centre), np.ascontiguousarray(meshing.into_lobe),
            _removals(teeth, meshing, about), about,
            np.array([scale.G, scale.K0, float(scale.by_tooth_radius), 1.0 / contact.radius_cap,
                      1.0 / contact.pin_radius]),
            support.disc_unknowns, np.ascontiguousarray(support.spring_stretch),
            np.ascontiguousarray(support.misfit), float(support.stiffness), float(support.play), np.array(torque),
            support.arm, np.ascontiguousarray(support.rigid_motion),
            LEAST_REACH * case.profile.trochoid.longest_lever, overclosure, tolerance,
            np.array([REFRESHES, WHOLE_STEPS]), u, found, gap, frame, curvature, settled,
        )  # fmt: skip
        moved = np.where(gap < _MATTERS, np.abs(found - about), 0.0)
        holds = known & settled
        if any(tooth.removals for tooth in teeth):
            holds &= np.max(moved, axis=(1, 2)) < near_enough
        if np.all(holds | ~(known & settled)):
            break
    return u, Gaps(gap, found, frame[:, 0] + 1j * frame[:, 1], frame[:, 2], curvature), holds


def _bed(tooth: ToothProfile, foot: FloatArray, lobe: FloatArray) -> FloatArray:
    """Distance below which a foot is the nearest; where that is checked later, none is too far."""
    return np.full(foot.shape, np.inf) if tooth.corners else least_bed(tooth, foot, lobe)


def _constants(tooth: ToothProfile) -> tuple[float, ...]:
    path = tooth.trochoid
    return (
        float(path.pins), path.pin_circle_radius, path.eccentricity, path.short_width_ratio, float(path.lobes),
        tooth.pin_radius,
    )  # fmt: skip


def _removals(teeth: list[ToothProfile], meshing: Meshing, about: FloatArray) -> FloatArray:
    """Removals with two derivatives at the phases ``about``, shape (poses, discs, pins, 3)."""
    found = np.zeros((*about.shape, 3))
    for j, tooth in enumerate(teeth):
        if tooth.removals:
            along = about[:, j] if tooth.lobes_alike else about[:, j] + 2.0 * math.pi * meshing.lobe[:, j]
            found[:, j] = np.stack(tooth.removal(along), axis=-1)
    return found
