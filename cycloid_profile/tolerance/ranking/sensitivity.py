"""Derivatives of the quantities by the parameters of effects (docs/tolerance.md, "Sensitivities").

A maximum over poses or pins has the derivative of the pose or pin that decides; where several tie, the derivative as a
parameter rises and the one as it falls differ. Both are given.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.effects import AsBuiltReducer, Effect, Parameter
from cycloid_profile.tolerance.inputs import Tolerances
from cycloid_profile.tolerance.model import RESPONSES, PlacedEffect, WorkingPoint
from cycloid_profile.units import sign_of

_DIRECTIONS = 720  # tried for a size at zero; the best of all is larger than the best of these by 1e-5 of it


@dataclass(frozen=True, slots=True)
class Derivative:
    """Per unit of a parameter, ``rising`` from the working point and ``falling`` below it; the same but at a kink."""

    rising: float
    falling: float

    @property
    def kink(self) -> bool:
        """Whether ``rising`` and ``falling`` differ by more than rounding errors."""
        return abs(self.rising - self.falling) > 1e-6 * self.largest

    @property
    def largest(self) -> float:
        """Larger of the magnitudes of ``rising`` and ``falling``."""
        return max(abs(self.rising), abs(self.falling))

    @property
    def mean_square(self) -> float:
        """Mean of the squares of ``rising`` and ``falling``."""
        return 0.5 * (self.rising**2 + self.falling**2)


@dataclass(frozen=True, kw_only=True)
class ParameterSensitivity:
    """One parameter of one effect.

    ``effect``, ``part`` (such as "pin 7"; "" for all) and ``parameter`` with its ``unit`` and ``value`` at the working
    point; ``tolerance`` of a size as plus and minus, None for others. ``derivatives`` in the order of ``RESPONSES``,
    unit of the quantity per unit of the parameter. ``over_direction`` where the effect has a direction and its size is
    zero: its effect then depends on the direction, and the derivatives are the largest over direction, and
    the least as ``falling``.
    """

    effect: str
    part: str
    parameter: str
    unit: str
    value: float
    tolerance: float | None
    over_direction: bool
    derivatives: tuple[Derivative, ...]

    def of(self, quantity: str) -> Derivative:
        """Derivative of one quantity."""
        return self.derivatives[list(RESPONSES).index(quantity)]

    def effect_of_tolerance(self, quantity: str) -> float:
        """Size of the derivative times the tolerance, 0 without one [unit of quantity]."""
        return self.of(quantity).largest * (self.tolerance or 0.0)

    def change_range(self, quantity: str) -> tuple[float, float]:
        """Least and largest change of a quantity with the size at either limit of its tolerance [its unit]."""
        one, width = self.of(quantity), self.tolerance or 0.0
        changes = (width * one.rising, width * (one.falling if self.over_direction else -one.falling), 0.0)
        return min(changes), max(changes)


@dataclass(frozen=True, kw_only=True)
class ToleranceSensitivity:
    """The size of one kind of effect over all ``count`` parts that have their own.

    ``label`` of the scatter, ``parameter``, ``unit`` and ``tolerance`` of each part; ``worst``, the part with the
    largest derivative for each quantity; ``root_sum_square`` of the derivatives of all parts, which err independently.
    """

    label: str
    parameter: str
    unit: str
    tolerance: float | None
    count: int
    worst: tuple[ParameterSensitivity, ...]
    root_sum_square: tuple[float, ...]

    def effect_of_tolerance(self, quantity: str) -> float:
        """Root-sum-square times the tolerance of each part [unit of quantity]."""
        return self.root_sum_square[list(RESPONSES).index(quantity)] * (self.tolerance or 0.0)


def sensitivities(
    reducer: AsBuiltReducer, effects: Sequence[Effect], tolerances: Sequence[float | None] | None = None
) -> tuple[ParameterSensitivity, ...]:
    """Derivatives by every continuous parameter of ``effects``, about ``reducer`` with all of them; sizes may be zero.

    ``tolerances`` of their sizes, the usual manufacturing tolerances unless given. While the size of an effect is zero
    it has no derivative by its direction.

    Raises
    ------
    SolveError
        If a disc finds no first touch, or the stage no equilibrium.
    """
    point = WorkingPoint(reducer, tuple(effects))
    widths = [one.axes.size.tolerance for one in point.placed] if tolerances is None else tolerances
    return tuple(row for placed, width in zip(point.placed, widths, strict=True) for row in _rows(point, placed, width))


def scatter_sensitivities(tolerances: Tolerances, point: WorkingPoint) -> tuple[ToleranceSensitivity, ...]:
    """Derivatives by the size of each scatter, worst part and all parts together; ``point`` comes from
    ``WorkingPoint.of``.

    Raises ``SolveError`` as ``sensitivities`` does.
    """
    found, at = [], 0
    for one in tolerances.scatters:
        parts = point.placed[at : at + len(one.choices)]
        at += len(parts)
        rows = [_size_row(point, placed, one.plus_minus) for placed in parts]
        worst = tuple(max(rows, key=partial(_largest, i)) for i in range(len(RESPONSES)))
        squares = [[row.derivatives[i].mean_square for row in rows] for i in range(len(RESPONSES))]
        found.append(
            ToleranceSensitivity(
                label=one.label,
                parameter=rows[0].parameter,
                unit=rows[0].unit,
                tolerance=one.plus_minus,
                count=len(rows),
                worst=worst,
                root_sum_square=tuple(math.sqrt(sum(each)) for each in squares),
            )
        )
    return tuple(found)


def _largest(response: int, row: ParameterSensitivity) -> float:
    return row.derivatives[response].largest


def _rows(point: WorkingPoint, placed: PlacedEffect, tolerance: float | None) -> list[ParameterSensitivity]:
    rows = [_size_row(point, placed, tolerance)]
    axes = placed.axes
    if axes.angle is not None and placed.size != 0.0:
        rows.append(_row(placed, axes.angle, None, _derivatives(point, placed, placed.along_angle())))
    for number, parameter in enumerate(placed.nonlinear_parameters):
        direction = np.eye(placed.count)[axes.count + number]
        rows.append(_row(placed, parameter, None, _derivatives(point, placed, direction)))
    return rows


def _size_row(point: WorkingPoint, placed: PlacedEffect, tolerance: float | None) -> ParameterSensitivity:
    if placed.axes.angle is not None and placed.size == 0.0:
        return _row(placed, placed.axes.size, tolerance, _over_directions(point, placed), over_direction=True)
    return _row(placed, placed.axes.size, tolerance, _derivatives(point, placed, placed.along_size()))


def _derivatives(point: WorkingPoint, placed: PlacedEffect, direction: FloatArray) -> tuple[Derivative, ...]:
    both = np.stack([direction, -direction], axis=1)
    found = (one.derivative.along(both, placed.at) for one in point.responses)
    return tuple(Derivative(float(ahead), -float(behind)) for ahead, behind in found)


def _over_directions(point: WorkingPoint, placed: PlacedEffect) -> tuple[Derivative, ...]:
    angles = np.linspace(0.0, 2.0 * math.pi, _DIRECTIONS, endpoint=False)
    every = np.stack([placed.along_size(float(angle)) for angle in angles], axis=1)
    found = (one.derivative.along(every, placed.at) for one in point.responses)
    return tuple(Derivative(float(np.max(each)), float(np.min(each))) for each in found)


def _row(
    placed: PlacedEffect,
    parameter: Parameter,
    tolerance: float | None,
    derivatives: tuple[Derivative, ...],
    over_direction: bool = False,
) -> ParameterSensitivity:
    name = parameter.name
    return ParameterSensitivity(
        effect=placed.effect.name,
        part=placed.part,
        parameter=name,
        unit=sign_of(name),
        value=float(getattr(placed.effect, name)),
        tolerance=tolerance,
        over_direction=over_direction,
        derivatives=derivatives,
    )
