"""Tolerances from the tables ``[[tolerance.effects]]`` and ``[[tolerance.correlations]]`` of a spec file."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Annotated, Any, Literal

import numpy as np
from msgspec import Meta

from cycloid_profile.contact.bodies import bearing_law
from cycloid_profile.effects import EFFECTS, AsBuiltReducer, Coordinates, Effect, coordinates, parameters
from cycloid_profile.errors import CycloidError, SpecError, did_you_mean
from cycloid_profile.spec import validated
from cycloid_profile.spec.model import Table, remedy_of_unknown_effect
from cycloid_profile.tolerance.inputs.distribution import (
    Distribution,
    Normal,
    Rayleigh,
    Triangular,
    Uniform,
    rayleigh_within,
)
from cycloid_profile.tolerance.inputs.scatter import PARTS, Correlation, Cost, Scatter, Tolerances

_WITHIN = "give a number within"
_FARTHEST = 6.0  # standard deviations, beyond which no reducer of any study lies


def _between(low: float, high: float) -> Meta:
    """Limits of a number in the spec file."""
    return Meta(ge=low, le=high, extra={"remedy": f"give a number from {low:g} to {high:g}"})


Width = Annotated[float, _between(0.0, 1e6)]
Amount = Annotated[float, _between(0.0, 1e12)]
Ratio = Annotated[float, _between(1e-3, 1e3)]


class SizeTable(Table, frozen=True):
    """Distribution of a size, such as ``{ plus_minus = 2.0, cp = 1.33 }``, in the unit of the size."""

    plus_minus: Width | None = None
    sigma: Width | None = None
    mean: Annotated[float, Meta(extra={"remedy": "give a number"})] = 0.0
    cp: Annotated[float, _between(1e-3, 100.0)] | None = None
    distribution: Literal["normal", "uniform", "triangular", "rayleigh"] | None = None
    inspected: Annotated[bool, Meta(extra={"remedy": "give true or false"})] = False


class DirectionTable(Table, frozen=True):
    """Distribution of a direction [°]: any, unless one is given."""

    mean: Annotated[float, _between(-3600.0, 3600.0)] = 0.0
    plus_minus: Annotated[float, _between(0.0, 180.0)] = 180.0


class EntryTable(Table, frozen=True):
    """Keys of every entry of ``[[tolerance.effects]]``, in addition to the parameters of its effect."""

    name: Any = ""
    label: str | None = None
    each: Any = ()
    batch_share: Annotated[float, _between(0.0, 1.0)] = 0.0
    neighbours: Annotated[float, _between(0.0, 1000.0)] = 0.0
    cost: Amount | None = None
    cost_exponent: Annotated[float, _between(0.05, 10.0)] = 1.0
    cost_fixed: Amount = 0.0
    finest: Ratio = 0.2
    coarsest: Ratio = 5.0


class CorrelationTable(Table, frozen=True):
    """Correlation of two sizes."""

    value: Annotated[float, _between(-1.0, 1.0)]
    between: Any = ()


def tolerances_of(
    tables: Sequence[Mapping[str, Any]], correlated: Sequence[Mapping[str, Any]], reducer: AsBuiltReducer
) -> Tolerances:
    """Tolerances of a ``reducer`` from the tables of its spec file.

    Raises
    ------
    SpecError
        If an effect, key or part is unknown or impossible, a width is negative, or the correlations contradict.
    """
    scatters = tuple(_scatter(table, reducer, f"tolerance.effects[{i}]") for i, table in enumerate(tables, start=1))
    labels = [one.label for one in scatters]
    if len(set(labels)) < len(labels):
        scatters = tuple(replace(one, label=f"{one.label} ({i})") for i, one in enumerate(scatters, start=1))
    return Tolerances(scatters, _correlations(correlated, scatters))


def typical_tolerances(reducer: AsBuiltReducer) -> Tolerances:
    """Typical manufacturing tolerances of every effect that this drive can have, for a spec without tolerances."""
    entries: list[tuple[str, list[str], dict[str, Any]]] = [
        ("equidistant_error", ["disc"], {}),
        ("radial_moving_error", ["disc"], {}),
        ("disc_runout", ["disc"], {}),
        ("cumulative_pitch_error", ["disc"], {}),
        ("single_tooth_error", ["disc", "lobe"], {"plus_minus": 1.0}),
        ("pin_radius_error", [], {}),
        ("single_pin_error", ["pin"], {}),
        ("pin_position_error", ["pin"], {}),
        ("pin_circle_radius_error", [], {}),
        ("pin_ring_runout", [], {}),
        ("pin_ring_cumulative_pitch", [], {}),
    ]
    if reducer.cranks:
        entries += [
            ("crank_eccentricity_error", ["crank", "disc"], {}),
            ("crank_hole_error", ["crank", "disc"], {}),
            ("crank_bearing_clearance", [], {"mean": 1.0, "plus_minus": 1.0}),
        ]
    tables = [{"name": name, "each": each, coordinates(EFFECTS[name]).size.name: size} for name, each, size in entries]
    return replace(tolerances_of(tables, (), reducer), assumed=True)


def _scatter(table: Mapping[str, Any], reducer: AsBuiltReducer, where: str) -> Scatter:
    common = EntryTable.__struct_fields__
    entry: EntryTable = validated({key: value for key, value in table.items() if key in common}, EntryTable, where)
    name = str(entry.name)
    kind = EFFECTS.get(name)
    if kind is None:
        remedy = remedy_of_unknown_effect(name)
        raise SpecError(f"{where}.name", f"'{name}'", "is not the name of an effect", remedy)
    given = {key: value for key, value in table.items() if key not in common}
    fixed = {key: value for key, value in given.items() if not isinstance(value, Mapping)}
    size_name = _size_name(kind, given, fixed, where)
    fixed |= {p.name: p.tolerance for p in parameters(kind)
              if p.tolerance is not None and p.name not in fixed and p.name != size_name}  # fmt: skip
    axes = coordinates(kind, frozenset(fixed))
    size, plus_minus = _size(given[size_name], axes, f"{where}.{size_name}")
    angle = None if axes.angle is None else axes.angle.name
    direction = None if angle is None else validated(given.get(angle, {}), DirectionTable, f"{where}.{angle}")
    costs = entry.cost_exponent, entry.cost_fixed, entry.finest, entry.coarsest
    scatter = Scatter(
        kind=kind,
        axes=axes,
        choices=_choices(entry.each, kind, fixed, reducer, where),
        size=size,
        angle_deg=None if direction is None else Uniform(direction.mean, direction.plus_minus),
        plus_minus=plus_minus,
        batch_share=entry.batch_share,
        neighbours=entry.neighbours,
        cost=None if entry.cost is None else Cost(entry.cost, *costs),
        label=name if entry.label is None else entry.label,
    )
    one_part = bool(scatter.neighbours) and len(scatter.choices) < 2
    refuse(one_part, f"{where}.neighbours", f"{scatter.neighbours:g}", "has only one part to act on", "give 'each'")
    limit = f"is above coarsest = {entry.coarsest:g}"
    swapped = entry.cost is not None and entry.finest > entry.coarsest
    refuse(swapped, f"{where}.finest", entry.finest, limit, "swap them")
    soft = axes.reciprocal and size.from_normal(np.array([-_FARTHEST]))[0] <= 0.0
    limit = "reaches zero, a part that is infinitely soft"
    refuse(soft, f"{where}.{size_name}", "given", limit, "make it narrower", " ")
    _reject_impossible(scatter, reducer, where)
    return scatter


def _size_name(kind: type[Effect], given: Mapping[str, Any], fixed: Mapping[str, Any], where: str) -> str:
    """The one parameter that scatters."""
    known = {p.name: p for p in parameters(kind)}
    for key in given:
        if key not in known:
            every = sorted([*known, *EntryTable.__struct_fields__])
            remedy = did_you_mean(key, every, f"choose from {', '.join(every)}")
            raise SpecError(f"{where}.{key}", "…", f"is not a parameter of {kind.name}", remedy, " ")
    first, *_ = (name for name, p in known.items() if p.tolerance is not None)
    sizes = [name for name, p in known.items() if p.tolerance is not None and name in given and name not in fixed]
    remedy = f"give {first} = {{ plus_minus = 1.0 }}"
    refuse(not sizes, f"{where}.{first}", fixed.get(first, "not given"), "is no distribution", remedy)
    limit = f"scatters next to {sizes[0]}"
    refuse(len(sizes) > 1, f"{where}.{sizes[-1]}", "given", limit, "give one of them a number", " ")
    for name, p in known.items():
        scatters = p.tolerance is None and not p.is_angle and name in given and name not in fixed
        limit, remedy = "is a part and no size", "give its number, or 'each' for all of them"
        if not p.whole:
            limit, remedy = "is a shape and no size", "give its value"
        refuse(scatters, f"{where}.{name}", "given", limit, remedy, " ")
    return sizes[0]


def _size(value: Mapping[str, Any], axes: Coordinates, where: str) -> tuple[Distribution, float | None]:
    """Distribution of a size, and its ± tolerance on the drawing; None where only a standard deviation is given."""
    given: SizeTable = validated(value, SizeTable, where)
    directed = axes.angle is not None
    shape = given.distribution or ("rayleigh" if directed else "normal")
    sigma, mean, low, high = given.sigma, given.mean, axes.size.low, axes.size.high
    refuse(not low <= mean <= high, f"{where}.mean", f"{mean:g}", f"is outside {low:g} to {high:g}", _WITHIN)
    limit = "is for a size with a direction and without a mean"
    undirected = shape == "rayleigh" and (not directed or mean != 0.0)
    refuse(undirected, f"{where}.distribution", "'rayleigh'", limit, "choose normal")
    if sigma is not None:
        both, at = given.plus_minus is not None, f"{where}.sigma"
        refuse(both, at, sigma, "is given next to plus_minus", "give one of them")
        limit = "is given next to sigma, which has no limits to compare with"
        refuse(given.cp is not None, f"{where}.cp", given.cp, limit, "give plus_minus in place of sigma")
        limit = f"goes with a distribution without limits, no {shape} or inspected"
        refuse(shape not in ("normal", "rayleigh") or given.inspected, at, sigma, limit, "give plus_minus")
        return (Rayleigh(sigma) if shape == "rayleigh" else Normal(mean, sigma)), None
    wide = (axes.size.tolerance or 1.0) if given.plus_minus is None else given.plus_minus
    cp = 1.0 if given.cp is None else given.cp
    shapes: dict[str, Distribution] = {
        "normal": Normal(mean, wide / (3.0 * cp), wide if given.inspected else math.inf),
        "uniform": Uniform(mean, wide),
        "triangular": Triangular(mean, wide),
        "rayleigh": rayleigh_within(wide, cp, given.inspected),
    }
    return shapes[shape], wide


def _choices(
    each: Any, kind: type[Effect], fixed: Mapping[str, Any], reducer: AsBuiltReducer, where: str
) -> tuple[Mapping[str, Any], ...]:
    """Parameters of the effect for every part with its own size."""
    parts = list(each) if isinstance(each, list | tuple) else [each]
    trochoid = reducer.case.drive.trochoid
    counts = {"pin": trochoid.pins, "disc": reducer.discs, "crank": reducer.cranks, "lobe": trochoid.lobes,
              "planet": reducer.cranks}  # fmt: skip
    known = {p.name for p in parameters(kind)}
    own = [part for part in PARTS if part in known]
    for part in parts:
        key, acts = f"{where}.each", isinstance(part, str) and part in own
        remedy = f"choose from {', '.join(own)}" if own else "leave 'each' out: the effect is one a reducer"
        refuse(not acts, key, f"'{part}'", f"is no part that {kind.name} knows", remedy)
        refuse(counts[part] == 0, key, f"'{part}'", "is a part this drive has not", "leave the entry out")
        given = fixed.get(part)
        refuse(given is not None, key, f"'{part}'", f"is fixed by {part} = {given}", "leave one of them out")
        refuse(parts.count(part) > 1, key, repr(parts), "names a part twice", "name each once")
    numbers = product(*(range(1, counts[part] + 1) for part in parts))
    return tuple({**fixed, **dict(zip(parts, n, strict=True))} for n in numbers)


def _reject_impossible(scatter: Scatter, reducer: AsBuiltReducer, where: str) -> None:
    """Raise ``SpecError`` now for an effect that is impossible, or changes no quantity of a study, by applying it."""
    x = np.zeros(scatter.axes.count)
    x[0] = 1.0 / (scatter.axes.size.high) if scatter.axes.reciprocal else 1e-3
    try:
        first, _ = (scatter.axes.effect(x, scatter.choices[i]).apply(reducer) for i in (0, -1))
    except CycloidError as error:
        raise SpecError(f"{where}: {error.what}", error.value, error.limit, error.remedy) from None
    before, after = ((one.coulomb_torque, one.friction_spread, one.proportional_friction) for one in (reducer, first))
    old, new = reducer.case, first.case
    designed = new.law is not old.law or bearing_law(new.drive.support) != bearing_law(old.drive.support)
    name, remedy = f"'{scatter.kind.name}'", "leave it out, or give it under [[effects]]"
    refuse(
        before != after,
        f"{where}.name",
        name,
        "moves both branches of the loop and none of these quantities",
        remedy,
        " ",
    )
    refuse(designed, f"{where}.name", name, "is a property of the design, the same in every reducer", remedy, " ")


def _correlations(tables: Sequence[Mapping[str, Any]], scatters: Sequence[Scatter]) -> tuple[Correlation, ...]:
    names = [one.parameter if one.label == one.kind.name else one.label for one in scatters]
    found = []
    matrix = np.eye(len(scatters))
    for i, table in enumerate(tables, start=1):
        where = f"tolerance.correlations[{i}]"
        one: CorrelationTable = validated(table, CorrelationTable, where)
        a, b = _pair(one.between, names, scatters, where)
        given = f"'{names[a]}' and '{names[b]}'"
        refuse(bool(matrix[a, b]), f"{where}.between", given, "is given twice", "give it once", " ")
        matrix[a, b] = matrix[b, a] = one.value
        found.append(Correlation(a, b, one.value))
    smallest = float(np.min(np.linalg.eigvalsh(matrix))) if len(scatters) else 1.0
    remedy = "make them smaller: sizes that correlate with a third one correlate with each other"
    value = f"with a least eigenvalue of {smallest:.3g}"
    refuse(smallest <= 1e-12, "tolerance.correlations", value, "are not positive definite", remedy, " ")
    return tuple(found)


def _pair(between: Any, names: list[str], scatters: Sequence[Scatter], where: str) -> tuple[int, int]:
    """Indices of two scatters by their names."""
    key = f"{where}.between"
    two = isinstance(between, list | tuple) and len(between) == 2
    refuse(not two, key, repr(between), "is not two names", f"choose from {', '.join(names)}")
    for name in between:
        remedy = did_you_mean(str(name), names, f"choose from {', '.join(sorted(names))}")
        refuse(name not in names, key, repr(name), "is none of the tolerances", remedy)
    a, b = (names.index(name) for name in between)
    unlike = a == b or len(scatters[a].choices) != len(scatters[b].choices)
    limit = "are not two tolerances of as many parts each"
    refuse(unlike, key, f"'{names[a]}' and '{names[b]}'", limit, "give both the same 'each'", " ")
    return a, b


def refuse(broken: object, what: str, value: object, limit: str, remedy: str, joint: str = " = ") -> None:
    """Raise ``SpecError`` where a rule is ``broken``."""
    if broken:
        raise SpecError(what, value, limit, remedy, joint)
