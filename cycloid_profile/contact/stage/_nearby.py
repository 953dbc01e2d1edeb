"""Equilibria of a stage from nearby starting points, all poses at once in compiled code.

A tooth differs from the parallel curve of its trochoid by removals, any formulas. The compiled code sees their Taylor
series about a phase near each foot, and the series is expanded again until the feet stay where it holds.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray
from cycloid_profile.contact.bodies import PartDeviations, SupportModel
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.laws import compiled_law
from cycloid_profile.contact.mesh import LEAST_REACH, Gaps, Meshing, capture_radius
from cycloid_profile.contact.stage.over_width import sliced_width
from cycloid_profile.geometry import ToothProfile

# Rounds of exact gaps, and of whole steps among them: an unloaded disc within its play can swing between two places.
REFRESHES, WHOLE_STEPS = 80, 6
_ROUNDS = 5
# A removal of micrometres errs by its third derivative times a sixth of the cube of this: below 1e-11 mm.
_SERIES_HOLDS = 3e-4  # rad
# The curvature of short waves and measured points changes within this distance, and contacts stiffen with it.
_SERIES_HOLDS_ON_WAVES = 1e-7  # rad
_MATTERS = 0.005  # mm; pins with a wider gap press on nothing


def settled_near(
    case: LoadCase,
    deviations: PartDeviations,
    meshing: Meshing,
    support: SupportModel,
    torque: FloatArray,
    tolerance: FloatArray,
    overclosure: FloatArray,
    compliance: FloatArray,
    begin: FloatArray,
    foot: FloatArray | None,
    load: FloatArray,
) -> tuple[FloatArray, Gaps, BoolArray]:
    """Unknowns at equilibrium, shape (poses, unknowns), the gaps there, and the poses that this holds for, found from
    the unknowns ``begin`` and the feet near them, shape (poses, discs, pins). The forces ``load`` that deform elastic
    bodies of this ``compliance`` are replaced.

    On a tooth with corners the gaps are those of its smooth branches near the feet, and a balance is to be checked with
    exact ones. A pose is left out that does not settle, or with a pin that may have a second foot.
    """
    teeth = [case.profile] * case.drive.discs if deviations.teeth is None else list(deviations.teeth)
    from cycloid_profile.compiled import on_all_cores
    from cycloid_profile.contact.stage._settle import settle

    u, shape = begin.copy(), meshing.phase.shape
    found = np.broadcast_to(meshing.phase if foot is None else foot, shape).copy()
    known = np.all(np.isfinite(u), axis=-1) & np.all(np.isfinite(found), axis=(1, 2))
    u[~known], found[~known] = 0.0, meshing.phase[~known]
    contact = case.line_contact(np.zeros(1))
    drive, pins = case.drive, shape[-1]
    oversize = 0.0 if deviations.pin_oversize is None else deviations.pin_oversize
    gap, curvature, settled = np.empty(shape), np.empty(shape), np.zeros(shape[0], dtype=np.bool_)
    frame = np.empty((shape[0], 3, *shape[1:]))
    constants = np.array([_constants(tooth) for tooth in teeth])
    capture = np.stack([_capture(tooth, found[:, j], meshing.lobe[:, j]) for j, tooth in enumerate(teeth)], axis=1)
    short = any(removal.point_spacing is not None for tooth in teeth for removal in tooth.removals)
    near_enough = _SERIES_HOLDS_ON_WAVES if short else _SERIES_HOLDS
    holds = known
    for _ in range(_ROUNDS):
        about = found.copy()
        fill = partial(
            settle, constants, capture, np.zeros(pins) + drive.pin_radius + oversize,
            np.zeros(pins) + (0j if deviations.pin_shift is None else deviations.pin_shift),
            np.ascontiguousarray(meshing.pin_centre), np.ascontiguousarray(meshing.into_lobe),
            _removals(teeth, meshing, about), about,
            compiled_law(case.law, contact),
            support.disc_unknowns, np.ascontiguousarray(support.spring_stretch),
            np.ascontiguousarray(support.misfit), support.bearing.compiled(), float(support.play), np.array(torque),
            support.arm, np.ascontiguousarray(support.rigid_motion),
            LEAST_REACH * case.profile.trochoid.longest_lever, overclosure, tolerance,
            np.array([REFRESHES, WHOLE_STEPS]), compliance,
            sliced_width(case.width, support.tilt_unknowns, np.zeros((0, 2)), support.tilt_stiffness),
            u, load, found, gap, frame, curvature, settled,
        )  # fmt: skip
        on_all_cores(fill, len(u))
        moved = np.where(gap < _MATTERS, np.abs(found - about), 0.0)
        holds = known & settled
        if any(tooth.removals for tooth in teeth):
            holds &= np.max(moved, axis=(1, 2)) < near_enough
        if np.all(holds | ~(known & settled)):
            break
    return u, Gaps(gap, found, frame[:, 0] + 1j * frame[:, 1], frame[:, 2], curvature), holds


def _capture(tooth: ToothProfile, foot: FloatArray, lobe: FloatArray) -> FloatArray:
    """Distance below which a foot is the nearest; where that is checked later, none is too far."""
    return np.full(foot.shape, np.inf) if tooth.corners else capture_radius(tooth, foot, lobe)


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
            along = about[:, j] if tooth.identical_lobes else about[:, j] + 2.0 * math.pi * meshing.lobe[:, j]
            found[:, j] = np.stack(tooth.removal(along), axis=-1)
    return found
