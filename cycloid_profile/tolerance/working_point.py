"""A reducer with some effects, and the coordinates in which each effect may change further."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property, reduce

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.coordinates import Coordinates, coordinates
from cycloid_profile.effects.effect import Effect, Parameter, parameters
from cycloid_profile.tolerance.patterns import UnitChange
from cycloid_profile.tolerance.responses import Response, responses
from cycloid_profile.tolerance.scatter import PARTS, Tolerances

# Of the workshop tolerance: effects are linear in their coordinates, and what bends of a curve stays below 1e-5 of it.
_STEP = 1e-3
_WAVES_STEP = 1e-4
# Wear has the shape of the load on the reducer it is laid on, which effects after it do not change.
_SHAPED = ("flank_wear",)


@dataclass(frozen=True)
class PlacedEffect:
    """One effect of a working point, whose coordinates begin at ``first`` among those of all."""

    effect: Effect
    first: int

    @property
    def axes(self) -> Coordinates:
        """Its linear coordinates."""
        return _axes(type(self.effect))

    @property
    def further(self) -> tuple[Parameter, ...]:
        """Continuous parameters in which it is not linear: how many waves chatter has."""
        return _further(type(self.effect))

    @property
    def count(self) -> int:
        """Number of coordinates, those of ``further`` behind the linear ones."""
        return self.axes.count + len(self.further)

    @property
    def size(self) -> float:
        """Its size, in its own unit."""
        return float(getattr(self.effect, self.axes.size.name))

    @property
    def part(self) -> str:
        """The part it is of, such as "disc 1, lobe 7"; "" for all."""
        known = [field.name for field in fields(self.effect) if field.name in PARTS.values()]  # type: ignore[arg-type]
        numbers = ((name, getattr(self.effect, name)) for name in known)
        return ", ".join(f"{name} {number}" for name, number in numbers if number is not None)

    @property
    def at(self) -> slice:
        """Its coordinates among those of all."""
        return slice(self.first, self.first + self.count)

    def along_size(self, angle: float | None = None) -> FloatArray:
        """Direction in its coordinates in which the size grows by 1, shape (count,); towards its own angle unless one
        is given [rad of the coordinates].
        """
        found = np.zeros(self.count)
        if self.axes.inverse:
            found[0] = -1.0 / self.size**2
        elif self.axes.angle is None:
            found[0] = 1.0
        else:
            turned = self._turned if angle is None else angle
            found[:2] = math.cos(turned), math.sin(turned)
        return found

    def along_angle(self) -> FloatArray:
        """Direction in its coordinates in which the angle grows by 1°, shape (count,)."""
        found = np.zeros(self.count)
        rate = self.size * self.axes.waves * math.pi / 180.0
        found[:2] = -rate * math.sin(self._turned), rate * math.cos(self._turned)
        return found

    @property
    def _turned(self) -> float:
        assert self.axes.angle is not None
        return math.radians(getattr(self.effect, self.axes.angle.name)) * self.axes.waves


@dataclass(frozen=True)
class WorkingPoint:
    """``built`` with ``effects``, whose sizes may be zero: where derivatives are taken."""

    built: Built
    effects: tuple[Effect, ...]

    @classmethod
    def of(cls, built: Built, tolerances: Tolerances, x: FloatArray | None = None) -> WorkingPoint:
        """Every part of every scatter at its coordinates ``x`` as ``Draws`` has them, shape (coordinates,).

        Without ``x`` at the mean of each size, zero where it may have any direction.
        """
        found: list[Effect] = []
        at = 0
        for one in tolerances.scatters:
            for choice in one.choices:
                if x is None:
                    mean = np.full(1, getattr(one.size, "mean", 0.0))
                    angle = 0.0 if one.angle_deg is None else one.angle_deg.of(np.zeros(1))
                    own = one.axes.of(mean, angle)[0]
                else:
                    own = x[at : at + one.axes.count]
                found.append(one.axes.effect(own, choice))
                at += one.axes.count
        return cls(built, tuple(found))

    @cached_property
    def placed(self) -> tuple[PlacedEffect, ...]:
        """The effects with the places of their coordinates."""
        found, first = [], 0
        for one in self.effects:
            found.append(PlacedEffect(one, first))
            first += found[-1].count
        return tuple(found)

    @property
    def coordinates(self) -> int:
        """Number of coordinates of all effects."""
        return sum(one.count for one in self.placed)

    @cached_property
    def whole(self) -> Built:
        """The reducer with all effects."""
        return _with(self.built, self.effects)

    @cached_property
    def responses(self) -> tuple[Response, ...]:
        """The quantities there and their slopes by the coordinates.

        Raises
        ------
        SolveError
            If a disc finds no first touch, or the stage no equilibrium.
        """
        return responses(self.whole, [change for one in self.placed for change in self.changes(one)])

    @cached_property
    def gradients(self) -> dict[str, FloatArray]:
        """Central derivatives of each quantity by all coordinates, shape (coordinates,)."""
        every = np.eye(self.coordinates)
        return {one.name: 0.5 * (one.slope.along(every) - one.slope.along(-every)) for one in self.responses}

    def changes(self, placed: PlacedEffect) -> list[UnitChange]:
        """What a unit of each coordinate of one of the effects changes, about the working point."""
        axes, effect = placed.axes, placed.effect
        tolerance = axes.size.tolerance or 1.0
        step = _STEP * (1.0 / tolerance if axes.inverse else tolerance)
        if effect.name in _SHAPED and placed.size > 0.0:
            found = [self._rebuilt(effect, axes.size.name, min(step, placed.size))]
        else:
            used = {axes.size.name} if axes.angle is None else {axes.size.name, axes.angle.name}
            choice = {p.name: getattr(effect, p.name) for p in parameters(type(effect)) if p.name not in used}
            # More of an effect on top of all others: in its coordinates it adds.
            found = [
                UnitChange(self.whole, axes.effect(step * unit, choice).apply(self.whole), step)
                for unit in np.eye(axes.count)
            ]
        return found + [self._rebuilt(effect, parameter.name, _WAVES_STEP) for parameter in placed.further]

    def _rebuilt(self, effect: Effect, parameter: str, step: float) -> UnitChange:
        """All effects anew with one parameter of one of them a ``step`` below and above."""
        value = getattr(effect, parameter)
        below, above = (
            _with(self.built, [replace(one, **{parameter: other}) if one is effect else one for one in self.effects])  # type: ignore[type-var]
            for other in (value - step, value + step)
        )
        return UnitChange(below, above, 2.0 * step)


def _with(built: Built, effects: Sequence[Effect]) -> Built:
    """Effects of size zero are left out: they would cost time on every tooth and change nothing."""
    acting = (one for one in effects if getattr(one, _axes(type(one)).size.name) != 0.0)
    return reduce(lambda before, one: one.apply(before), acting, built)


def _axes(kind: type[Effect]) -> Coordinates:
    return coordinates(kind, frozenset(p.name for p in _further(kind)))


def _further(kind: type[Effect]) -> tuple[Parameter, ...]:
    return tuple(p for p in parameters(kind) if p.tolerance is not None)[1:]
