"""Forces on carrier and discs in given poses, as the slope of the energy stored in contacts and bearings.

Parts move through finite angles, as rigid bodies but for the teeth of an elastic disc. The input is held: a turn Θ of
the carrier turns the cranks by 1 + z1/z2 of it, a central eccentric not at all. The unknowns u of a pose are Θ, then
x, y, θ of each disc, from where the drawing has them.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .clearance import Clearance, offset_from_path
from .contact import Body, Law, Pressed, Roark
from .parts import Parts
from .reducer import Reducer

Array = np.ndarray
_TOUCHES = 2
_LEAST_ARM = 0.05  # of a pin that can be turned against, over the longest
_OF_THE_WAY = 0.75  # all the way, the teeth of a soft disc swing for ever
_OVERLAP = 1e-4  # turn back from pins and discs that bind, at most [rad]


@dataclass(frozen=True)
class State:
    """Energy less the work of the torque, its slope and its stiffness, for each pose."""

    energy: Array
    slope: Array
    stiffness: Array

    def at(self, which: Array) -> State:
        """Some of the poses."""
        return State(self.energy[which], self.slope[which], self.stiffness[which])

    def where(self, which: Array, other: State) -> State:
        """These where ``which``, else the other ones."""
        return State(
            np.where(which, self.energy, other.energy),
            np.where(which[:, None], self.slope, other.slope),
            np.where(which[:, None, None], self.stiffness, other.stiffness),
        )


class Poses:
    """Poses with their loads: ``output`` angle of the carrier [rad], external ``torque`` on it [N·mm]."""

    def __init__(
        self,
        reducer: Reducer,
        parts: Parts,
        clearances: Sequence[Clearance],
        output: Array,
        torque: Array,
        contact: Law | None = None,
        body: Body | None = None,
    ) -> None:
        self.reducer, self.parts, self.clearances = reducer, parts, clearances
        self.contact, self.body = contact or Roark(), body or Body()
        r = reducer
        self.output, self.torque = output, torque
        self.unknowns = 1 + 3 * r.discs
        # The output runs against the input, once for z_c turns of the cranks.
        crank = -r.lobes * output[:, None] + 2.0 * math.pi * np.arange(r.discs) / r.discs
        self.crank = np.exp(1j * crank)
        self.carrier = np.exp(1j * output)
        self.disc = np.exp(-1j / r.lobes * crank)
        # A planet turns z_p times on the carrier, and leads or lags its crank once a turn.
        swing = np.real(parts.lead * np.exp(-1j * r.pins * output)[:, None])
        self.eccentric = parts.eccentric * np.exp(1j * swing)[:, None, :] * self.crank[:, :, None]
        self.shafts = r.crank_circle_radius_mm * np.exp(2j * math.pi * np.arange(r.cranks) / max(r.cranks, 1))
        angle = 2.0 * math.pi * np.arange(r.pins) / r.pins
        self.psi = np.mod(-crank[:, :, None] - r.lobes * angle, r.period)
        self.pins = np.broadcast_to(np.arange(r.pins), self.psi.shape)
        self.bend, self.push = np.zeros_like(self.psi), np.zeros_like(self.psi)

    def at(self, which: Array) -> Poses:
        """Some of the poses."""
        some = copy.copy(self)
        for name in ("output", "torque", "crank", "carrier", "disc", "eccentric", "psi", "pins", "bend", "push"):
            setattr(some, name, getattr(self, name)[which])
        return some

    def near(self, u: Array, count: int) -> Poses:
        """The same with the ``count`` pins that stand closest to each disc, seen from where they stand at ``u``."""
        gaps = np.stack([self._gaps(u, j)[0] for j in range(self.reducer.discs)], axis=1)
        some = copy.copy(self)
        chosen = np.argpartition(gaps, count - 1, axis=2)[:, :, :count]
        some.psi, some.pins, some.push = (
            np.take_along_axis(of, chosen, axis=2) for of in (self.psi, self.pins, self.push)
        )
        return some.seen_from(u)

    def seen_from(self, u: Array) -> Poses:
        """The same with phases and curvatures of the tooth where the pins touch at ``u``."""
        some = copy.copy(self)
        feet = [self._off_path(u, j)[1] for j in range(self.reducer.discs)]
        some.psi = np.stack(feet, axis=1)
        some.bend = np.stack([of.curvature_at(psi) for of, psi in zip(self.clearances, feet, strict=True)], axis=1)
        return some

    def pushed(self, u: Array) -> Poses:
        """The same with every tooth moved most of the way to where the forces at ``u`` on the other pins push it."""
        some = copy.copy(self)
        push = []
        for j in range(self.reducer.discs):
            gap, slope = self._gaps(u, j)
            force, _, _ = self._law(j).answer(-gap - self.push[:, j])
            normal = slope[..., 0] + 1j * slope[..., 1]
            push.append(self.body.push(self.pins[:, j], self.reducer.pins, normal / np.abs(normal), force))
        some.push = self.push + _OF_THE_WAY * (np.stack(push, axis=1) - self.push)
        return some

    def overlap(self, u: Array) -> Array:
        """How deep each pin sits in each disc, (poses, discs, pins) [mm]."""
        return np.stack([np.maximum(-self._gaps(u, j)[0], 0.0) for j in range(self.reducer.discs)], axis=1)

    def touch(self) -> Array:
        """Unknowns where carrier, cranks and discs have turned together to the first touch."""
        r = self.reducer
        side = np.sign(self.torque)
        turned = np.zeros(side.size)
        for _ in range(_TOUCHES):
            turn = np.full(side.size, np.inf)
            for j in range(r.discs):
                gap, slope = self._gaps(self.turned(turned), j)
                swing = 1j * r.crank_per_carrier * r.eccentricity_mm * self.crank[:, j, None]
                closing = -side[:, None] * (slope[..., 0] * swing.real + slope[..., 1] * swing.imag + slope[..., 2])
                far = closing > _LEAST_ARM * r.eccentricity_mm * r.lobes
                turn = np.minimum(turn, np.min(np.where(far, gap / np.where(far, closing, 1.0), np.inf), axis=1))
            turned = side * np.maximum(side * turned + turn, -_OVERLAP)
        return self.turned(turned)

    def turned(self, turn: Array) -> Array:
        """Unknowns where all parts have turned together by ``turn`` [rad], no bearing stretched."""
        r = self.reducer
        u = np.zeros((turn.size, self.unknowns))
        u[:, 0] = turn
        for j in range(r.discs):
            swung = self.crank[:, j] * (np.exp(1j * r.crank_per_carrier * turn) - 1.0) * r.eccentricity_mm
            u[:, 1 + 3 * j], u[:, 2 + 3 * j], u[:, 3 + 3 * j] = swung.real, swung.imag, turn
        return u

    def state(self, u: Array) -> State:
        """Energy and forces at ``u``, (poses, unknowns)."""
        n = u.shape[0]
        energy, slope = -self.torque * u[:, 0], np.zeros((n, self.unknowns))
        stiffness = np.zeros((n, self.unknowns, self.unknowns))
        slope[:, 0] -= self.torque
        for j in range(self.reducer.discs):
            for which, part in (([1, 2, 3], self._contacts(u, j)), ([0, 1, 2, 3], self._bearings(u, j))):
                own = [0 if i == 0 else i + 3 * j for i in which]
                energy += part.energy
                slope[:, own] += part.slope
                stiffness[np.ix_(np.arange(n), own, own)] += part.stiffness
        if not self.reducer.cranks:
            free = self.free
            slope, stiffness = slope @ free, free.T @ stiffness @ free
        return State(energy, slope, stiffness)

    @property
    def free(self) -> Array:
        """Unknowns by coordinates: rigid output pins turn the discs of a central eccentric with the carrier."""
        whole = np.eye(self.unknowns)
        if self.reducer.cranks:
            return whole
        turns = range(3, self.unknowns, 3)
        whole[turns, 0] = 1.0
        return np.delete(whole, turns, axis=1)

    @property
    def arm(self) -> Array:
        """Arm of the force of each coordinate, so that all are moments: 1, or the pin circle [mm]."""
        circle, discs = self.reducer.pin_circle_radius_mm, self.reducer.discs
        return np.array([1.0] + ([circle, circle, 1.0] if self.reducer.cranks else [circle, circle]) * discs)

    def _off_path(self, u: Array, j: int) -> tuple[Array, Array, Array, Array, Array]:
        """Pins as disc j sees them, and where they are off the path of the drawing."""
        turned = self.disc[:, j] * np.exp(1j * u[:, 3 + 3 * j])
        seen = (self.parts.pin_centre[self.pins[:, j]] - self._centre(u, j)[:, None]) * np.conj(turned)[:, None]
        return seen, *offset_from_path(self.reducer, seen, self.psi[:, j])

    def _gaps(self, u: Array, j: int) -> tuple[Array, Array]:
        """Gap of each pin to disc j, and its slopes by x, y, θ of the disc."""
        seen, psi, beyond, normal, speed = self._off_path(u, j)
        room, rise = self.clearances[j].at(psi)
        # The path runs at −i times its normal.
        away = normal - 1j * normal * (rise / speed)
        arm = (np.conj(seen) * away).imag
        away = away * (self.disc[:, j] * np.exp(1j * u[:, 3 + 3 * j]))[:, None]
        gap = beyond + room - (self.parts.pin_radius[self.pins[:, j]] - self.reducer.pin_radius_mm)
        return gap, np.stack([-away.real, -away.imag, -arm], axis=-1)

    def _centre(self, u: Array, j: int) -> Array:
        return self.reducer.eccentricity_mm * self.crank[:, j] + u[:, 1 + 3 * j] + 1j * u[:, 2 + 3 * j]

    def _contacts(self, u: Array, j: int) -> State:
        """Pins against disc j, by the curvatures where they were seen last: that keeps an energy."""
        gap, slope = self._gaps(u, j)
        force, stiff, tension = self._law(j).answer(-gap - self.push[:, j])
        block = np.matmul(np.swapaxes(slope * stiff[..., None], 1, 2), slope)
        return State(np.sum(tension, axis=1), -np.matmul(force[:, None], slope)[:, 0], block)

    def _law(self, j: int) -> Pressed:
        pin_radius = self.parts.pin_radius[self.pins[:, j]]
        return self.contact.of(self.reducer, self.bend[:, j], pin_radius, self.parts.seat + self.body.own)

    def _bearings(self, u: Array, j: int) -> State:
        """Springs between disc j and its eccentrics, equal in all directions, slack within their play."""
        r, p = self.reducer, self.parts
        if not r.cranks:
            return self._central(u, j)
        shaft = (self.carrier * np.exp(1j * u[:, 0]))[:, None] * self.shafts
        eccentric = np.exp(1j * r.crank_per_carrier * u[:, :1]) * self.eccentric[:, j]
        hole = (self.carrier * np.exp(1j * u[:, 3 + 3 * j]))[:, None] * (self.shafts + p.hole[j])
        stretch = shaft + eccentric - self._centre(u, j)[:, None] - hole
        one = np.ones_like(stretch)
        rate = np.stack([1j * (shaft + r.crank_per_carrier * eccentric), -one, -1j * one, -1j * hole], axis=-1)
        length = np.abs(stretch)
        taut = length >= p.play
        pull = np.where(taut, length - p.play, 0.0)
        towards = np.where(length > 0.0, stretch / np.where(length > 0.0, length, 1.0), 1.0)
        rate = np.conj(towards)[..., None] * rate
        swing = np.where(length > 0.0, pull / np.where(length > 0.0, length, 1.0), taut)
        block = _gram(rate.real, taut) + _gram(rate.imag, swing)
        k = p.stiffness
        return State(0.5 * k * np.sum(pull**2, axis=1), k * np.matmul(pull[:, None], rate.real)[:, 0], k * block)

    def _central(self, u: Array, j: int) -> State:
        """Spring from a held eccentric to the middle of disc j."""
        k = self.parts.stiffness
        away = u[:, [1 + 3 * j, 2 + 3 * j]]
        none = np.zeros(u.shape[0])
        return State(
            0.5 * k * np.sum(away**2, axis=1),
            np.stack([none, k * away[:, 0], k * away[:, 1], none], axis=1),
            np.broadcast_to(np.diag([0.0, k, k, 0.0]), (u.shape[0], 4, 4)),
        )


def _gram(rows: Array, weight: Array) -> Array:
    return np.matmul(np.swapaxes(rows * weight[..., None], 1, 2), rows)
