"""How one loaded contact answers to its disc, its pin and its tooth (docs/tolerance.md, Eqs. 62, 63).

Seen from the tooth the pin moves along the normal, which presses, and across it, which lets the foot slide: the normal
turns by the curvature, and the curvature itself changes. All of it is exact geometry of the curve at the foot.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray, IntArray
from cycloid_profile.contact.gap import nearest_foot
from cycloid_profile.contact.sharing import LoadSharing
from cycloid_profile.effects.built import Built
from cycloid_profile.tolerance.patterns import UnitChange

_PHASE_STEP = 1e-6  # rad, for the rate of the curvature
_CURVATURE_STEP = 1e-6  # 1/mm, for the answer of law and pressure to the curvature


@dataclass(frozen=True)
class LoadedContacts:
    """Loaded contacts of all loads in a row, each array of shape (contacts,) unless said otherwise.

    ``load``, ``disc`` and ``pin`` they belong to; ``foot`` phase, ``lobe``; ``normal`` in the housing, complex;
    ``lever`` and ``reach`` of the contact normal, across and along it from the disc's centre [mm]; ``distance`` of the
    pin's centre from the foot [mm]; ``curvature`` [1/mm] and its rate along the curve ``bend_rate`` [1/mm²]; ``force``
    [N], ``stiffness`` [N/mm] and ``pressure`` [MPa]; ``force_by_curvature`` at the same approach [N·mm],
    ``pressure_by_curvature`` at the same force [MPa·mm].
    """

    load: IntArray
    disc: IntArray
    pin: IntArray
    foot: FloatArray
    lobe: FloatArray
    normal: ComplexArray
    lever: FloatArray
    reach: FloatArray
    distance: FloatArray
    curvature: FloatArray
    bend_rate: FloatArray
    force: FloatArray
    stiffness: FloatArray
    pressure: FloatArray
    force_by_curvature: FloatArray
    pressure_by_curvature: FloatArray

    @property
    def along(self) -> FloatArray:
        """Approach per motion (x, y, θ) of the disc, shape (contacts, 3)."""
        return np.stack([self.normal.real, self.normal.imag, self.lever], axis=-1)

    @property
    def across(self) -> FloatArray:
        """How far the tooth runs along its own direction per motion of the disc, shape (contacts, 3)."""
        tangent = -1j * self.normal
        return np.stack([tangent.real, tangent.imag, -self.reach], axis=-1)

    @property
    def slide(self) -> FloatArray:
        """Way of the foot along the curve per way of the pin's centre across the normal."""
        free: FloatArray = 1.0 / (1.0 - self.curvature * self.distance)
        return free

    def by_motion(self) -> MotionSlopes:
        """Answer to motions of the own disc."""
        J, B, F = self.along, self.across, self.force[:, np.newaxis, np.newaxis]
        slid = -self.slide[:, np.newaxis] * B
        curvature = self.bend_rate[:, np.newaxis] * slid
        force = self.stiffness[:, np.newaxis] * J + self.force_by_curvature[:, np.newaxis] * curvature
        turned = self.curvature[:, np.newaxis] * slid
        frame = -B[:, :, np.newaxis] * turned[:, np.newaxis, :]
        frame[:, :2, 2] -= B[:, :2]
        frame[:, 2, :] -= B
        return MotionSlopes(force, curvature, J[:, :, np.newaxis] * force[:, np.newaxis, :] + F * frame)

    def by_change(self, change: UnitChange) -> ChangeSlopes:
        """Answer to a unit of a change, the discs held where they are."""
        before, after = change.before, change.after
        opened, across, twist, bend = (np.zeros(self.force.shape) for _ in range(4))
        sideways = np.zeros(self.force.shape)
        if after.pin_shift is not before.pin_shift:
            moved = (after.pin_shift - before.pin_shift)[self.pin] * np.conj(self.normal)
            opened += moved.real - (after.pin_oversize - before.pin_oversize)[self.pin]
            # The tangent is −i times the normal.
            sideways -= moved.imag
            across += sideways
        for j, (old, new) in enumerate(zip(before.teeth, after.teeth, strict=True)):
            if new is old:
                continue
            own = self.disc == j
            here, there = (tooth.at(self.foot[own], None, self.lobe[own]) for tooth in (old, new))
            gone = np.conj(here.normal) * (there.position - here.position)
            turned = (np.conj(here.normal) * (there.normal - here.normal)).imag
            opened[own] -= gone.real
            across[own] += gone.imag + self.distance[own] * turned
            twist[own] += turned
            bend[own] += there.curvature - here.curvature
        if after.case.law is not before.case.law:
            contact = before.case.line_contact(self.curvature)
            opened += after.case.law.approach(self.force, contact) - before.case.law.approach(self.force, contact)
        slid = self.slide * across
        curvature = self.bend_rate * slid + bend
        force = -self.stiffness * opened + self.force_by_curvature * curvature
        pushed = force[:, np.newaxis] * self.along
        turned_by = self.curvature * slid + twist
        pushed -= (self.force * turned_by)[:, np.newaxis] * self.across
        pushed[:, 2] += self.force * sideways
        return ChangeSlopes(force / change.step, curvature / change.step, pushed / change.step)


@dataclass(frozen=True)
class MotionSlopes:
    """Per motion (x, y, θ) of the disc: ``force`` and ``curvature``, shape (contacts, 3), and what the contact puts on
    the disc, ``push`` shape (contacts, 3, 3).
    """

    force: FloatArray
    curvature: FloatArray
    push: FloatArray


@dataclass(frozen=True)
class ChangeSlopes:
    """Per unit of a change: ``force`` and ``curvature``, shape (contacts,), and ``push``, shape (contacts, 3)."""

    force: FloatArray
    curvature: FloatArray
    push: FloatArray


def loaded_contacts(built: Built, sharing: LoadSharing) -> LoadedContacts:
    """Contacts of a solved stage as ``built`` that carry a force."""
    stage = sharing.stage
    assert stage is not None
    load, disc, pin = np.nonzero(sharing.force > 0.0)
    some = (load, disc, pin)
    motion, lobe = stage.motion, stage.meshing.lobe[some]
    centre = stage.meshing.pin_in_lobe(motion[..., 0] + 1j * motion[..., 1], motion[..., 2], built.pin_shift)[some]
    foot, curvature, rate, reach = (np.empty(load.size) for _ in range(4))
    for j, tooth in enumerate(built.teeth):
        own = disc == j
        of = lobe[own]
        psi, side = nearest_foot(tooth, centre[own], stage.meshing.phase[some][own], None if tooth.lobes_alike else of)
        here = tooth.at(psi, side, of)
        ahead, behind = (tooth.at(psi + way * _PHASE_STEP, side, of).curvature for way in (1.0, -1.0))
        foot[own], curvature[own] = psi, here.curvature
        rate[own] = (ahead - behind) / (2.0 * _PHASE_STEP * np.abs(here.first))
        reach[own] = (np.conj(here.normal) * centre[own]).real
    case, F, k = built.case, sharing.force[some], sharing.pin_stiffness[some]
    around = [case.line_contact(curvature + way * _CURVATURE_STEP) for way in (1.0, -1.0)]
    deeper = (case.law.approach(F, around[0]) - case.law.approach(F, around[1])) / (2.0 * _CURVATURE_STEP)
    higher = (case.law.peak_pressure(F, around[0]) - case.law.peak_pressure(F, around[1])) / (2.0 * _CURVATURE_STEP)
    radius = case.drive.pin_radius + built.pin_oversize[pin]
    return LoadedContacts(
        load=load,
        disc=disc,
        pin=pin,
        foot=foot,
        lobe=lobe,
        normal=stage.normal[some],
        lever=np.sign(sharing.torque)[load] * sharing.lever[some],
        reach=reach,
        distance=radius - sharing.approach[some],
        curvature=curvature,
        bend_rate=rate,
        force=F,
        stiffness=k,
        pressure=sharing.pressure[some],
        force_by_curvature=-k * deeper,
        pressure_by_curvature=higher,
    )
