"""What scatters, read from ``[[tolerance.effects]]`` of a spec file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from cycloid_profile.effects.built import Built
from cycloid_profile.effects.coordinates import coordinates
from cycloid_profile.effects.effect import Effect, parameters
from cycloid_profile.effects.registry import EFFECTS
from cycloid_profile.errors import CycloidError, SpecError
from cycloid_profile.tolerance.correlation_tables import correlations_of
from cycloid_profile.tolerance.distribution_tables import direction_of, size_of
from cycloid_profile.tolerance.scatter import PARTS, Cost, Scatter, Tolerances
from cycloid_profile.tolerance.table_values import nearest, number

_FARTHEST = 6.0  # standard deviations, beyond which no reducer of any study lies
# Effects that none of the quantities sees, or that change more than gaps and fits, with the reason.
_REFUSED = {
    "coulomb_friction": "moves both branches of the loop alike and none of these quantities",
    "load_proportional_friction": "moves both branches of the loop alike and none of these quantities",
    "pin_support_compliance": "is a property of the design, the same in every reducer",
    "crank_bearing_compliance": "is a property of the design, the same in every reducer",
}
_OTHER_KEYS = ("name", "label", "each", "batch_share", "neighbours", "cost", "cost_exponent", "cost_fixed", "finest",
               "coarsest")  # fmt: skip


def tolerances_of(
    tables: Sequence[Mapping[str, Any]], correlated: Sequence[Mapping[str, Any]], built: Built
) -> Tolerances:
    """From the tables of a spec file.

    Raises
    ------
    SpecError
        If an effect, key or part is unknown or impossible, a width is negative, or the correlations contradict.
    """
    scatters = tuple(_scatter(table, built, f"tolerance.effects[{i}]") for i, table in enumerate(tables, start=1))
    labels = [one.label for one in scatters]
    if len(set(labels)) < len(labels):
        scatters = tuple(replace(one, label=f"{one.label} ({i})") for i, one in enumerate(scatters, start=1))
    return Tolerances(scatters, correlations_of(correlated, scatters))


def _scatter(table: Mapping[str, Any], built: Built, where: str) -> Scatter:
    name = str(table.get("name", ""))
    kind = EFFECTS.get(name)
    if kind is None:
        raise SpecError(f"{where}.name", f"'{name}'", "is not the name of an effect", nearest(name, EFFECTS))
    if name in _REFUSED:
        raise SpecError(f"{where}.name", f"'{name}'", _REFUSED[name], "leave it out, or give it under [[effects]]", " ")
    known = {p.name for p in parameters(kind)}
    given = {key: value for key, value in table.items() if key not in _OTHER_KEYS}
    for key in given:
        if key not in known:
            raise SpecError(
                f"{where}.{key}", "…", f"is not a parameter of {name}", nearest(key, [*known, *_OTHER_KEYS]), " "
            )
    fixed = {key: value for key, value in given.items() if not isinstance(value, Mapping)}
    sizes = [p for p in parameters(kind) if p.tolerance is not None and p.name in given and p.name not in fixed]
    open_sizes = [p for p in parameters(kind) if p.tolerance is not None and p.name not in fixed]
    if not open_sizes or not sizes:
        first = next(p.name for p in parameters(kind) if p.tolerance is not None)
        raise SpecError(f"{where}.{first}", fixed.get(first, "not given"), "is no distribution",
                        f"give {first} = {{ plus_minus = 1.0 }}")  # fmt: skip
    if len(sizes) > 1:
        raise SpecError(f"{where}.{sizes[1].name}", "given", f"scatters beside {sizes[0].name}",
                        "give one of them a number", " ")  # fmt: skip
    for p in parameters(kind):
        if p.whole and p.name in given and p.name not in fixed:
            raise SpecError(f"{where}.{p.name}", "given", "is a part and no size",
                            "give its number, or 'each' for all of them", " ")  # fmt: skip
    size_name = sizes[0].name
    for p in open_sizes:
        if p.name != size_name:
            fixed[p.name] = p.tolerance
    axes = coordinates(kind, frozenset(fixed))
    size, plus_minus = size_of(given[size_name], axes, f"{where}.{size_name}")
    choices = _choices(table, kind, fixed, built, where)
    scatter = Scatter(
        kind=kind,
        axes=axes,
        choices=choices,
        size=size,
        angle_deg=None
        if axes.angle is None
        else direction_of(given.get(axes.angle.name, {}), f"{where}.{axes.angle.name}"),
        plus_minus=plus_minus,
        batch_share=number(table, "batch_share", 0.0, where, 0.0, 1.0),
        neighbours=number(table, "neighbours", 0.0, where, 0.0, 1000.0),
        cost=_cost(table, where),
        label=str(table.get("label", name)),
    )
    if scatter.neighbours and len(choices) < 2:
        raise SpecError(f"{where}.neighbours", f"{scatter.neighbours:g}", "has only one part to act on", "give 'each'")
    if axes.inverse and size.of(np.array([-_FARTHEST]))[0] <= 0.0:
        raise SpecError(f"{where}.{size_name}", "given", "reaches zero, a part that is infinitely soft",
                        "make it narrower", " ")  # fmt: skip
    _try(scatter, built, where)
    return scatter


def _cost(table: Mapping[str, Any], where: str) -> Cost | None:
    if "cost" not in table:
        return None
    cost = Cost(
        at_drawing=number(table, "cost", 1.0, where, 0.0, 1e12),
        exponent=number(table, "cost_exponent", 1.0, where, 0.05, 10.0),
        fixed=number(table, "cost_fixed", 0.0, where, 0.0, 1e12),
        finest=number(table, "finest", 0.2, where, 1e-3, 1e3),
        coarsest=number(table, "coarsest", 5.0, where, 1e-3, 1e3),
    )
    if cost.finest > cost.coarsest:
        raise SpecError(f"{where}.finest", cost.finest, f"is above coarsest = {cost.coarsest:g}", "swap them")
    return cost


def _choices(
    table: Mapping[str, Any], kind: type[Effect], fixed: Mapping[str, Any], built: Built, where: str
) -> tuple[Mapping[str, Any], ...]:
    each = table.get("each", [])
    parts = list(each) if isinstance(each, list | tuple) else [each]
    trochoid = built.case.drive.trochoid
    counts = {"pin": trochoid.pins, "disc": built.discs, "crank": built.cranks, "lobe": trochoid.lobes,
              "planet": built.cranks}  # fmt: skip
    known = {p.name for p in parameters(kind)}
    for part in parts:
        if not isinstance(part, str) or PARTS.get(part) not in known:
            own = [one for one, key in PARTS.items() if key in known]
            remedy = f"choose from {', '.join(own)}" if own else "leave 'each' out: the effect is one a reducer"
            raise SpecError(f"{where}.each", f"'{part}'", f"is no part that {kind.name} knows", remedy)
        if counts[part] == 0:
            raise SpecError(f"{where}.each", f"'{part}'", "is a part this drive has not", "leave the entry out")
        if PARTS[part] in fixed:
            raise SpecError(f"{where}.each", f"'{part}'", f"is fixed by {PARTS[part]} = {fixed[PARTS[part]]}",
                            "leave one of them out")  # fmt: skip
    if len(set(parts)) < len(parts):
        raise SpecError(f"{where}.each", repr(parts), "names a part twice", "name each once")
    numbers = product(*(range(1, counts[part] + 1) for part in parts))
    return tuple({**fixed, **dict(zip((PARTS[p] for p in parts), n, strict=True))} for n in numbers)


def _try(scatter: Scatter, built: Built, where: str) -> None:
    """Make one, so that what is impossible is said now."""
    x = np.zeros(scatter.axes.count)
    x[0] = 1.0 / (scatter.axes.size.high) if scatter.axes.inverse else 1e-3
    try:
        for choice in (scatter.choices[0], scatter.choices[-1]):
            scatter.axes.effect(x, choice).apply(built)
    except CycloidError as error:
        raise SpecError(f"{where}: {error.what}", error.value, error.limit, error.remedy) from None
