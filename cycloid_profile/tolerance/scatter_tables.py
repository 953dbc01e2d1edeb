"""What scatters, read from ``[[tolerance.effects]]`` and ``[[tolerance.correlations]]`` of a spec file."""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from cycloid_profile.effects.built import Built
from cycloid_profile.effects.coordinates import Coordinates, coordinates
from cycloid_profile.effects.effect import Effect, parameters
from cycloid_profile.effects.registry import EFFECTS
from cycloid_profile.errors import CycloidError, SpecError
from cycloid_profile.tolerance.distribution import Distribution, Normal, Rayleigh, Triangular, Uniform, rayleigh_within
from cycloid_profile.tolerance.scatter import PARTS, Correlation, Cost, Scatter, Tolerances

_FARTHEST = 6.0  # standard deviations, beyond which no reducer of any study lies
# Effects that none of the quantities sees, or that change more than gaps and fits, with the reason.
_REFUSED = {
    "coulomb_friction": "moves both branches of the loop alike and none of these quantities",
    "load_proportional_friction": "moves both branches of the loop alike and none of these quantities",
    "pin_support_compliance": "is a property of the design, the same in every reducer",
    "crank_bearing_compliance": "is a property of the design, the same in every reducer",
}


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
    return Tolerances(scatters, _correlations(correlated, scatters))


def workshop_tolerances(built: Built) -> Tolerances:
    """What a good workshop holds, for every effect this drive can have: a start where a spec names no tolerances."""
    tables: list[dict[str, Any]] = [
        {"name": "equidistant_error", "each": "disc", "amount_um": {}},
        {"name": "radial_moving_error", "each": "disc", "amount_um": {}},
        {"name": "disc_runout", "each": "disc", "amplitude_um": {}},
        {"name": "cumulative_pitch_error", "each": "disc", "amplitude_um": {}},
        {"name": "single_tooth_error", "each": ["disc", "lobe"], "amount_um": {"plus_minus": 1.0}},
        {"name": "pin_radius_error", "amount_um": {}},
        {"name": "single_pin_error", "each": "pin", "amount_um": {}},
        {"name": "pin_position_error", "each": "pin", "amplitude_um": {}},
        {"name": "pin_circle_radius_error", "amount_um": {}},
        {"name": "pin_ring_runout", "amplitude_um": {}},
        {"name": "pin_ring_cumulative_pitch", "amplitude_um": {}},
    ]
    if built.cranks:
        tables += [
            {"name": "crank_eccentricity_error", "each": ["crank", "disc"], "amount_um": {}},
            {"name": "crank_hole_error", "each": ["crank", "disc"], "amplitude_um": {}},
            {"name": "crank_bearing_clearance", "radial_um": {"mean": 1.0, "plus_minus": 1.0}},
        ]
    return replace(tolerances_of(tables, (), built), assumed=True)


def _scatter(table: Mapping[str, Any], built: Built, where: str) -> Scatter:
    name = str(table.get("name", ""))
    kind = EFFECTS.get(name)
    if kind is None:
        raise SpecError(f"{where}.name", f"'{name}'", "is not the name of an effect", _nearest(name, EFFECTS))
    if name in _REFUSED:
        raise SpecError(f"{where}.name", f"'{name}'", _REFUSED[name], "leave it out, or give it under [[effects]]", " ")
    known = {p.name for p in parameters(kind)}
    given = {key: value for key, value in table.items() if key not in _OTHER_KEYS}
    for key in given:
        if key not in known:
            raise SpecError(
                f"{where}.{key}", "…", f"is not a parameter of {name}", _nearest(key, [*known, *_OTHER_KEYS]), " "
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
    size, plus_minus = _distribution(given[size_name], axes, f"{where}.{size_name}")
    choices = _choices(table, kind, fixed, built, where)
    scatter = Scatter(
        kind=kind,
        axes=axes,
        choices=choices,
        size=size,
        angle_deg=None if axes.angle is None else _angle(given.get(axes.angle.name, {}), f"{where}.{axes.angle.name}"),
        plus_minus=plus_minus,
        batch_share=_number(table, "batch_share", 0.0, where, 0.0, 1.0),
        neighbours=_number(table, "neighbours", 0.0, where, 0.0, 1000.0),
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


_OTHER_KEYS = ("name", "label", "each", "batch_share", "neighbours", "cost", "cost_exponent", "cost_fixed", "finest",
               "coarsest")  # fmt: skip
_CORRELATION_KEYS = ("between", "value")
_ANGLE_KEYS = ("mean", "plus_minus")
_SIZE_KEYS = ("plus_minus", "sigma", "mean", "cp", "distribution", "inspected")


def _normal(mean: float, wide: float, sigma: float, inspected: bool) -> Distribution:
    return Normal(mean, sigma, wide if inspected else math.inf)


_SHAPES: dict[str, Callable[[float, float, float, bool], Distribution]] = {
    "normal": _normal,
    "uniform": lambda mean, wide, _sigma, _inspected: Uniform(mean, wide),
    "triangular": lambda mean, wide, _sigma, _inspected: Triangular(mean, wide),
}


def _distribution(value: Mapping[str, Any], axes: Coordinates, where: str) -> tuple[Distribution, float | None]:
    for key in value:
        if key not in _SIZE_KEYS:
            raise SpecError(f"{where}.{key}", value[key], "is not a key of a distribution", _nearest(key, _SIZE_KEYS))
    cp = _number(value, "cp", 1.0, where, 1e-3, 100.0)
    directed = axes.angle is not None
    shape = value.get("distribution", "rayleigh" if directed else "normal")
    if shape not in (*_SHAPES, "rayleigh"):
        raise SpecError(f"{where}.distribution", f"'{shape}'", "is not known",
                        f"choose from {', '.join((*_SHAPES, 'rayleigh'))}")  # fmt: skip
    if shape == "rayleigh" and (not directed or value.get("mean")):
        raise SpecError(f"{where}.distribution", "'rayleigh'", "is for a size with a direction and without a mean",
                        "choose normal")  # fmt: skip
    inspected = value.get("inspected", False)
    if not isinstance(inspected, bool):
        raise SpecError(f"{where}.inspected", repr(inspected), "is neither true nor false", "give true or false")
    if "sigma" in value:
        sigma = _number(value, "sigma", 0.0, where, 0.0, 1e6)
        if "plus_minus" in value:
            raise SpecError(f"{where}.sigma", sigma, "is given beside plus_minus", "give one of them")
        if "cp" in value:
            raise SpecError(f"{where}.cp", cp, "is given beside sigma, which it has no limits to compare with",
                            "give plus_minus in place of sigma")  # fmt: skip
        if shape not in ("normal", "rayleigh") or inspected:
            raise SpecError(f"{where}.sigma", sigma,
                            f"goes with a distribution without limits, no {shape} or inspected",
                            "give plus_minus")  # fmt: skip
        return (Rayleigh(sigma) if shape == "rayleigh" else Normal(_mean(value, axes, where), sigma)), None
    wide = _number(value, "plus_minus", axes.size.tolerance or 1.0, where, 0.0, 1e6)
    if shape == "rayleigh":
        return rayleigh_within(wide, cp, inspected), wide
    return _SHAPES[shape](_mean(value, axes, where), wide, wide / (3.0 * cp), inspected), wide


def _mean(value: Mapping[str, Any], axes: Coordinates, where: str) -> float:
    return _number(value, "mean", 0.0, where, axes.size.low, axes.size.high)


def _angle(value: Mapping[str, Any], where: str) -> Distribution:
    """Any direction, unless one is given."""
    for key in value:
        if key not in _ANGLE_KEYS:
            raise SpecError(f"{where}.{key}", value[key], "is not a key of a direction", _nearest(key, _ANGLE_KEYS))
    mean = _number(value, "mean", 0.0, where, -3600.0, 3600.0)
    return Uniform(mean, _number(value, "plus_minus", 180.0, where, 0.0, 180.0))


def _cost(table: Mapping[str, Any], where: str) -> Cost | None:
    if "cost" not in table:
        return None
    cost = Cost(
        at_drawing=_number(table, "cost", 1.0, where, 0.0, 1e12),
        exponent=_number(table, "cost_exponent", 1.0, where, 0.05, 10.0),
        fixed=_number(table, "cost_fixed", 0.0, where, 0.0, 1e12),
        finest=_number(table, "finest", 0.2, where, 1e-3, 1e3),
        coarsest=_number(table, "coarsest", 5.0, where, 1e-3, 1e3),
    )
    if cost.finest > cost.coarsest:
        raise SpecError(f"{where}.finest", cost.finest, f"is above coarsest = {cost.coarsest:g}", "swap them")
    return cost


def _number(table: Mapping[str, Any], key: str, default: float, where: str, low: float, high: float) -> float:
    value = table.get(key, default)
    # Whole numbers of a spec file can be larger than any float.
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e300:
        raise SpecError(f"{where}.{key}", repr(value)[:40], "is not a number", "give a number")
    if not low <= value <= high:
        raise SpecError(f"{where}.{key}", f"{value:g}", f"is outside {low:g} to {high:g}", "give a number within")
    return float(value)


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


def _correlations(tables: Sequence[Mapping[str, Any]], scatters: Sequence[Scatter]) -> tuple[Correlation, ...]:
    names = [one.parameter if one.label == one.kind.name else one.label for one in scatters]
    found = []
    matrix = np.eye(len(scatters))
    for i, table in enumerate(tables, start=1):
        where = f"tolerance.correlations[{i}]"
        for key in table:
            if key not in _CORRELATION_KEYS:
                raise SpecError(f"{where}.{key}", table[key], "is not a key of a correlation",
                                _nearest(key, _CORRELATION_KEYS))  # fmt: skip
        between = table.get("between", ())
        if not isinstance(between, list | tuple) or len(between) != 2:
            raise SpecError(f"{where}.between", repr(between), "is not two names", f"choose from {', '.join(names)}")
        for name in between:
            if name not in names:
                raise SpecError(f"{where}.between", repr(name), "is none of the tolerances", _nearest(str(name), names))
        a, b = (names.index(name) for name in between)
        if a == b or len(scatters[a].choices) != len(scatters[b].choices):
            raise SpecError(
                f"{where}.between",
                f"'{between[0]}' and '{between[1]}'",
                "are not two tolerances of as many parts each",
                "give both the same 'each'",
                " ",
            )
        if "value" not in table:
            raise SpecError(f"{where}.value", "", "is not given", "give a number from -1 to 1", "")
        if matrix[a, b] != 0.0:
            raise SpecError(f"{where}.between", f"'{between[0]}' and '{between[1]}'", "is given twice",
                            "give it once", " ")  # fmt: skip
        value = _number(table, "value", 0.0, where, -1.0, 1.0)
        matrix[a, b] = matrix[b, a] = value
        found.append(Correlation(a, b, value))
    least = float(np.min(np.linalg.eigvalsh(matrix))) if len(scatters) else 1.0
    if least <= 1e-12:
        raise SpecError(
            "tolerance.correlations",
            f"with a least eigenvalue of {least:.3g}",
            "are not positive definite",
            "make them smaller: what hangs on one thing must hang together",
            " ",
        )
    return tuple(found)


def _nearest(word: str, known: Any) -> str:
    close = difflib.get_close_matches(word, list(known), n=1, cutoff=0.4)
    return f"did you mean {close[0]}?" if close else f"choose from {', '.join(sorted(known))}"
