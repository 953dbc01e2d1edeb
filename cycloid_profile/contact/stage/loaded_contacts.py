"""Contacts that carry a force, and their response to motions of the disc and to changes of tooth and pin.

The response is exact if it includes the geometry of the curve at the foot point (docs/tolerance.md, Eqs. 62, 63).
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import NamedTuple

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray, IntArray
from cycloid_profile.contact.bodies import FaceWidth, PartDeviations
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.laws import LineContact
from cycloid_profile.contact.mesh import nearest_foot
from cycloid_profile.contact.result import LoadSharing

_PHASE_STEP = 1e-6  # rad, for the rate of the curvature
_CURVATURE_STEP = 1e-6  # 1/mm, for the derivative of law and pressure by the curvature


@dataclass(frozen=True, eq=False)
class ContactPoints:
    """Places at which pins meet flanks, arrays that broadcast to one shape.

    Number of ``discs``; number of the ``disc`` and of the ``pin`` from 0, phase of the ``foot`` [rad], ``lobe``, and
    ``normal`` outwards from the disc, x + iy in the housing frame.
    """

    discs: int
    disc: IntArray
    pin: IntArray
    foot: FloatArray
    lobe: FloatArray
    normal: ComplexArray

    @classmethod
    def on_grid(cls, foot: FloatArray, lobe: FloatArray, normal: ComplexArray) -> ContactPoints:
        """All pins on all discs, arrays of shape (poses, discs, pins)."""
        numbers: IntArray = np.indices(foot.shape, dtype=np.intp)
        return ContactPoints(foot.shape[1], numbers[1], numbers[2], foot, lobe, normal)

    @cached_property
    def by_disc(self) -> tuple[tuple[tuple[IntArray, ...], FloatArray, FloatArray], ...]:
        """For each disc the indices of its points, their feet and their lobes."""
        found = []
        for j in range(self.discs):
            own = np.nonzero(self.disc == j)
            found.append((own, self.foot[own], self.lobe[own]))
        return tuple(found)


class ContactChange(NamedTuple):
    """A small change of tooth and pin at some contacts, each of shape (contacts,).

    ``gap`` opened [mm]; ``pin_across``, shift of the pin along the tangent, −i times the normal [mm]; ``foot_across``,
    shift of the pin's centre relative to the tooth, across the normal [mm]; ``turn`` of the normal [rad]; ``curvature``
    gained [1/mm].
    """

    gap: FloatArray
    pin_across: FloatArray
    foot_across: FloatArray
    turn: FloatArray
    curvature: FloatArray


class ContactDerivatives(NamedTuple):
    """Derivatives of ``force`` and ``curvature`` at contacts; ``turned``, those of the generalised force on the disc
    because the normal turns and shifts under the present force.
    """

    force: FloatArray
    curvature: FloatArray
    turned: FloatArray


@dataclass(frozen=True, eq=False)
class LoadedContacts(ContactPoints):
    """Contacts that carry a force, each array of shape (contacts,).

    Number of the ``pose``; ``lever`` of the normal about the disc's centre [mm]; ``curvature`` of the tooth [1/mm];
    ``force`` [N], ``stiffness`` [N/mm] and peak ``pressure`` [MPa].
    """

    pose: IntArray
    lever: FloatArray
    curvature: FloatArray
    force: FloatArray
    stiffness: FloatArray
    pressure: FloatArray

    @cached_property
    def along(self) -> FloatArray:
        """Approach per motion (x, y, θ) of the disc, shape (contacts, 3)."""
        return np.stack([self.normal.real, self.normal.imag, self.lever], axis=-1)

    def by_motion(self) -> ContactDerivatives:
        """Derivatives by the motion (x, y, θ) of the disc; ``turned`` of shape (contacts, 3, 3)."""
        force = self.stiffness[:, np.newaxis] * self.along
        return ContactDerivatives(force, np.zeros_like(force), np.zeros((*force.shape, 3)))

    def by_change(self, change: ContactChange) -> ContactDerivatives:
        """Response to a change with the discs fixed; ``turned`` of shape (contacts, 3)."""
        force = -self.stiffness * change.gap
        return ContactDerivatives(force, change.curvature, np.zeros((*force.shape, 3)))

    def pressure_change(self, force: FloatArray, curvature: FloatArray) -> FloatArray:
        """Change of the peak pressure, proportional to the root of the force, by changes of shape (contacts, …)."""
        del curvature
        each = (slice(None), *(np.newaxis,) * (force.ndim - 1))
        changed: FloatArray = (0.5 * self.pressure / self.force)[each] * force
        return changed


@dataclass(frozen=True, eq=False)
class CurvedContacts(LoadedContacts):
    """Loaded contacts with the exact geometry of the curve at the foot (docs/tolerance.md, Eqs. 62, 63).

    Motion of the pin along the normal of the tooth changes the approach. Motion along the tangent shifts the foot
    point along the curve, where normal and curvature differ.

    ``reach``, distance of the contact from the disc's centre along the normal [mm]; ``distance`` of the pin's centre
    from the foot point [mm]; ``curvature_rate`` along the curve [1/mm²]; ``force_by_curvature`` at the same approach
    [N·mm]; ``pressure_by_curvature`` at the same force [MPa·mm].
    """

    reach: FloatArray
    distance: FloatArray
    curvature_rate: FloatArray
    force_by_curvature: FloatArray
    pressure_by_curvature: FloatArray

    @cached_property
    def across(self) -> FloatArray:
        """Shift of the tooth along its own tangent per motion of the disc, shape (contacts, 3)."""
        tangent = -1j * self.normal
        return np.stack([tangent.real, tangent.imag, -self.reach], axis=-1)

    @property
    def slide(self) -> FloatArray:
        """Shift of the foot along the curve per shift of the pin's centre across the normal."""
        free: FloatArray = 1.0 / (1.0 - self.curvature * self.distance)
        return free

    def by_motion(self) -> ContactDerivatives:
        """See ``LoadedContacts.by_motion``."""
        J, B = self.along, self.across
        slid = -self.slide[:, np.newaxis] * B
        curvature = self.curvature_rate[:, np.newaxis] * slid
        by_curvature = self.force_by_curvature[:, np.newaxis] * curvature
        turned = self.curvature[:, np.newaxis] * slid
        frame = -B[:, :, np.newaxis] * turned[:, np.newaxis, :]
        frame[:, :2, 2] -= B[:, :2]
        frame[:, 2, :] -= B
        turned_force = self.force[:, np.newaxis, np.newaxis] * frame
        return ContactDerivatives(self.stiffness[:, np.newaxis] * J + by_curvature, curvature, turned_force)

    def by_change(self, change: ContactChange) -> ContactDerivatives:
        """See ``LoadedContacts.by_change``."""
        slid = self.slide * change.foot_across
        curvature = self.curvature_rate * slid + change.curvature
        force = -self.stiffness * change.gap + self.force_by_curvature * curvature
        turned = -(self.force * (self.curvature * slid + change.turn))[:, np.newaxis] * self.across
        turned[:, 2] += self.force * change.pin_across
        return ContactDerivatives(force, curvature, turned)

    def pressure_change(self, force: FloatArray, curvature: FloatArray) -> FloatArray:
        """See ``LoadedContacts.pressure_change``."""
        each = (slice(None), *(np.newaxis,) * (force.ndim - 1))
        return super().pressure_change(force, curvature) + self.pressure_by_curvature[each] * curvature


def loaded_contacts(sharing: LoadSharing) -> LoadedContacts:
    """Contacts that carry a force, with the phase of each pin as an approximation to that of its foot point."""
    assert sharing.stage is not None
    some = pose, disc, pin = np.nonzero(sharing.force > 0.0)
    sense = np.sign(sharing.torque)[pose]
    return LoadedContacts(
        discs=sharing.force.shape[1],
        disc=disc,
        pin=pin,
        foot=sense * sharing.phase[some],
        lobe=sharing.stage.meshing.lobe[some],
        normal=sharing.stage.normal[some],
        pose=pose,
        lever=sense * sharing.lever[some],
        curvature=sharing.curvature[some],
        force=sharing.force[some],
        stiffness=sharing.pin_stiffness[some],
        pressure=sharing.pressure[some],
    )


def curved_contacts(sharing: LoadSharing, deviations: PartDeviations) -> CurvedContacts:
    """Contacts that carry a force, at exact foot points, with the geometry of the curve there."""
    stage, case, loaded = sharing.stage, sharing.case, loaded_contacts(sharing)
    assert stage is not None
    some = (loaded.pose, loaded.disc, loaded.pin)
    motion, shift = stage.motion, 0.0 if deviations.pin_shift is None else deviations.pin_shift
    centre = stage.meshing.pin_in_lobe(motion[..., 0] + 1j * motion[..., 1], motion[..., 2], shift)[some]
    near = stage.meshing.phase[some]
    teeth = (case.profile,) * case.drive.discs if deviations.teeth is None else deviations.teeth
    foot, curvature, rate, reach = (np.empty(loaded.force.size) for _ in range(4))
    for tooth, (own, _, lobe) in zip(teeth, loaded.by_disc, strict=True):
        psi, side = nearest_foot(tooth, centre[own], near[own], None if tooth.identical_lobes else lobe)
        here = tooth.at(psi, side, lobe)
        ahead, behind = (tooth.at(psi + sign * _PHASE_STEP, side, lobe).curvature for sign in (1.0, -1.0))
        foot[own], curvature[own] = psi, here.curvature
        rate[own] = (ahead - behind) / (2.0 * _PHASE_STEP * np.abs(here.first))
        reach[own] = (np.conj(here.normal) * centre[own]).real
    around = [case.line_contact(curvature + sign * _CURVATURE_STEP) for sign in (1.0, -1.0)]
    approach, pressure = (
        (of(loaded.force, around[0]) - of(loaded.force, around[1])) / (2.0 * _CURVATURE_STEP)
        for of in (case.law.approach, case.law.peak_pressure)
    )
    by_curvature = -loaded.stiffness * approach
    if case.width is not None:
        there = (sharing.approach[some], sharing.slope[some])
        ahead, behind = (_force_on_slices(case, case.width, *there, contact) for contact in around)
        by_curvature = (ahead - behind) / (2.0 * _CURVATURE_STEP)
    oversize = 0.0 if deviations.pin_oversize is None else deviations.pin_oversize[loaded.pin]
    return CurvedContacts(
        **{one.name: getattr(loaded, one.name) for one in fields(loaded) if one.name not in ("foot", "curvature")},
        foot=foot,
        curvature=curvature,
        reach=reach,
        distance=case.drive.pin_radius + oversize - sharing.approach[some],
        curvature_rate=rate,
        force_by_curvature=by_curvature,
        pressure_by_curvature=pressure,
    )


def _force_on_slices(
    case: LoadCase, width: FaceWidth, approach: FloatArray, slope: FloatArray, contact: LineContact
) -> FloatArray:
    """Force of each contact over the slices of the width, its ``approach`` at mid-height, shape (contacts,) [N]."""
    force = np.zeros_like(approach)
    for z, weight in zip(*width.rule, strict=True):
        force += weight * case.law.force(approach + z * slope - width.relief(z), contact)
    return force
