"""A reducer with some effects, the quantities there and their derivatives by the coordinates of every effect."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property, reduce

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.effects import (
    AsBuiltReducer,
    Coordinates,
    Effect,
    FlankWear,
    Parameter,
    ReducerChange,
    coordinates,
    parameters,
)
from cycloid_profile.tolerance.inputs import PARTS, Tolerances
from cycloid_profile.tolerance.model._crank_locked import backlash_derivatives
from cycloid_profile.tolerance.model._directional import DirectionalDerivative, Gradient, largest, least, weighted_sum
from cycloid_profile.tolerance.model._loaded import loaded_derivatives
from cycloid_profile.tolerance.model.quantities import (
    BACKLASH_POSES,
    QUANTITIES,
    crank_angles,
    lost_motion_loads,
    rated_loads,
)
from cycloid_profile.units import ARCMIN, ARCSEC

# Of the manufacturing tolerance: effects are linear in their coordinates, curvature of a profile adds less than 1e-5.
_STEP = 1e-3
_WAVES_STEP = 1e-4
# Poses that mirror each other agree within the rounding of a balance.
_TIE_ANGLE, _TIE_PRESSURE = 1e-12, 1e-7  # rad, MPa

# Quantities with a derivative: those of a study, and means over the turn, which no single pose decides.
RESPONSES = {
    "backlash_arcmin": QUANTITIES["backlash_arcmin"],
    "least_backlash_arcmin": QUANTITIES["least_backlash_arcmin"],
    "backlash_mean_arcmin": "backlash, crank locked, mean over a turn",
    "lost_motion_arcmin": QUANTITIES["lost_motion_arcmin"],
    "lost_motion_mean_arcmin": "lost motion at ±3 % of rated torque, mean over a turn",
    "transmission_error_arcsec": QUANTITIES["transmission_error_arcsec"],
    "peak_pressure_mpa": QUANTITIES["peak_pressure_mpa"],
}


@dataclass(frozen=True)
class Response:
    """A quantity at the working point: ``value`` and ``derivative`` by the coordinates, in the unit of its ``name``."""

    name: str
    value: float
    derivative: DirectionalDerivative


def responses(reducer: AsBuiltReducer, changes: Sequence[ReducerChange]) -> tuple[Response, ...]:
    """All of ``RESPONSES``, in their order, at the poses and torques of a study.

    Raises
    ------
    SolveError
        If a disc finds no first touch, or the stage no equilibrium.
    """
    crank = crank_angles(reducer.case.drive.trochoid, BACKLASH_POSES)
    backlash, by_pose = backlash_derivatives(reducer, changes, crank)
    swing = loaded_derivatives(reducer, changes, *lost_motion_loads(reducer))
    half = len(swing.rotation) // 2
    lost = swing.rotation[:half] - swing.rotation[half:]
    lost_by_unit = swing.rotation_by_unit[:half] - swing.rotation_by_unit[half:]
    rated = loaded_derivatives(reducer, changes, *rated_loads(reducer))
    ahead, behind = _rows(rated.rotation_by_unit), _rows(-rated.rotation_by_unit)
    error = weighted_sum([largest(rated.rotation, ahead, _TIE_ANGLE), largest(-rated.rotation, behind, _TIE_ANGLE)])
    found: tuple[tuple[float, DirectionalDerivative, float], ...] = (
        (backlash.max(), largest(backlash, by_pose, _TIE_ANGLE), ARCMIN),
        (backlash.min(), least(backlash, by_pose, _TIE_ANGLE), ARCMIN),
        (backlash.mean(), weighted_sum(by_pose, 1.0 / len(by_pose)), ARCMIN),
        (lost.max(), largest(lost, _rows(lost_by_unit), _TIE_ANGLE), ARCMIN),
        (lost.mean(), Gradient(np.mean(lost_by_unit, axis=0)), ARCMIN),
        (np.ptp(rated.rotation), error, ARCSEC),
        (rated.pressure.max(), largest(rated.pressure, _rows(rated.pressure_by_unit), _TIE_PRESSURE), 1.0),
    )
    return tuple(
        Response(name, float(value) / unit, weighted_sum([derivative], 1.0 / unit))
        for name, (value, derivative, unit) in zip(RESPONSES, found, strict=True)
    )


def _rows(by_unit: FloatArray) -> list[DirectionalDerivative]:
    return [Gradient(row) for row in by_unit]


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
    def nonlinear_parameters(self) -> tuple[Parameter, ...]:
        """Continuous parameters on which the effect depends nonlinearly, such as the number of waves of chatter."""
        return _nonlinear_parameters(type(self.effect))

    @property
    def count(self) -> int:
        """Number of coordinates, the linear ones first, then those of ``nonlinear_parameters``."""
        return self.axes.count + len(self.nonlinear_parameters)

    @property
    def size(self) -> float:
        """Its size, in its own unit."""
        return float(getattr(self.effect, self.axes.size.name))

    @property
    def part(self) -> str:
        """Part it acts on, such as "disc 1, lobe 7"; "" for all."""
        known = [field.name for field in fields(self.effect) if field.name in PARTS]  # type: ignore[arg-type]
        numbers = ((name, getattr(self.effect, name)) for name in known)
        return ", ".join(f"{name} {number}" for name, number in numbers if number is not None)

    @property
    def at(self) -> slice:
        """Position of its coordinates among those of all effects."""
        return slice(self.first, self.first + self.count)

    def along_size(self, angle: float | None = None) -> FloatArray:
        """Direction in its coordinates in which the size grows by 1, shape (count,); towards its own angle unless one
        is given [rad of the coordinates].
        """
        found = np.zeros(self.count)
        if self.axes.reciprocal:
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
        rate = self.size * self.axes.harmonic * math.pi / 180.0
        found[:2] = -rate * math.sin(self._turned), rate * math.cos(self._turned)
        return found

    @property
    def _turned(self) -> float:
        assert self.axes.angle is not None
        return math.radians(getattr(self.effect, self.axes.angle.name)) * self.axes.harmonic


@dataclass(frozen=True)
class WorkingPoint:
    """``reducer`` with ``effects``, whose sizes may be zero: where derivatives are taken."""

    reducer: AsBuiltReducer
    effects: tuple[Effect, ...]

    @classmethod
    def of(cls, reducer: AsBuiltReducer, tolerances: Tolerances, x: FloatArray | None = None) -> WorkingPoint:
        """Every part of every scatter at its coordinates ``x`` in the order of ``Draws``, shape (coordinates,).

        Without ``x`` at the mean of each size, zero where it may have any direction.
        """
        found: list[Effect] = []
        at = 0
        for one in tolerances.scatters:
            for choice in one.choices:
                if x is None:
                    mean = np.full(1, getattr(one.size, "mean", 0.0))
                    angle = 0.0 if one.angle_deg is None else one.angle_deg.from_normal(np.zeros(1))
                    own = one.axes.of(mean, angle)[0]
                else:
                    own = x[at : at + one.axes.count]
                found.append(one.axes.effect(own, choice))
                at += one.axes.count
        return cls(reducer, tuple(found))

    @cached_property
    def placed(self) -> tuple[PlacedEffect, ...]:
        """The effects with the positions of their coordinates."""
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
    def whole(self) -> AsBuiltReducer:
        """The reducer with all effects."""
        return _with(self.reducer, self.effects)

    @cached_property
    def responses(self) -> tuple[Response, ...]:
        """The quantities there and their derivatives by the coordinates.

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
        return {one.name: 0.5 * (one.derivative.along(every) - one.derivative.along(-every)) for one in self.responses}

    def changes(self, placed: PlacedEffect) -> list[ReducerChange]:
        """Change of the reducer by a unit of each coordinate of one of the effects, about the working point."""
        axes, effect = placed.axes, placed.effect
        tolerance = axes.size.tolerance or 1.0
        step = _STEP * (1.0 / tolerance if axes.reciprocal else tolerance)
        if isinstance(effect, FlankWear) and placed.size > 0.0:
            # Wear has the shape of the load on the reducer it is applied to; effects after it do not change that.
            found = [self._rebuilt(effect, axes.size.name, min(step, placed.size))]
        else:
            used = {axes.size.name} if axes.angle is None else {axes.size.name, axes.angle.name}
            choice = {p.name: getattr(effect, p.name) for p in parameters(type(effect)) if p.name not in used}
            # More of an effect on top of all others: in its coordinates it adds.
            found = [
                ReducerChange(self.whole, axes.effect(step * unit, choice).apply(self.whole), step)
                for unit in np.eye(axes.count)
            ]
        return found + [self._rebuilt(effect, parameter.name, _WAVES_STEP) for parameter in placed.nonlinear_parameters]

    def _rebuilt(self, effect: Effect, parameter: str, step: float) -> ReducerChange:
        """The reducer with one parameter of one effect a ``step`` below and above."""
        value = getattr(effect, parameter)
        below, above = (
            _with(self.reducer, [replace(one, **{parameter: other}) if one is effect else one for one in self.effects])  # type: ignore[type-var]
            for other in (value - step, value + step)
        )
        return ReducerChange(below, above, 2.0 * step)


def _with(reducer: AsBuiltReducer, effects: Sequence[Effect]) -> AsBuiltReducer:
    """Effects of size zero are omitted: they would cost time on every tooth and change nothing."""
    acting = (one for one in effects if getattr(one, _axes(type(one)).size.name) != 0.0)
    return reduce(lambda before, one: one.apply(before), acting, reducer)


def _axes(kind: type[Effect]) -> Coordinates:
    return coordinates(kind, frozenset(p.name for p in _nonlinear_parameters(kind)))


def _nonlinear_parameters(kind: type[Effect]) -> tuple[Parameter, ...]:
    return tuple(p for p in parameters(kind) if p.tolerance is not None)[1:]
