"""All effects by name, and their conversion from and to tables of a spec file."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from functools import reduce
from typing import Any

from cycloid_profile.contact import LoadCase
from cycloid_profile.effects import compliance_and_friction, crank, first_stage, process, ring
from cycloid_profile.effects.base import Effect, parameters
from cycloid_profile.effects.reducer import AsBuiltReducer, as_drawn
from cycloid_profile.errors import SpecError, did_you_mean

EFFECTS: dict[str, type[Effect]] = {
    kind.name: kind
    for module in (process, ring, crank, first_stage, compliance_and_friction)
    for kind in vars(module).values()
    if isinstance(kind, type) and issubclass(kind, Effect) and dataclasses.is_dataclass(kind)
}


def effect_from_table(table: Mapping[str, Any]) -> Effect:
    """The effect of one table of ``[[effects]]``.

    Raises ``SpecError`` if name or parameter is unknown (offering the nearest), one is missing, or a value out of
    bounds.
    """
    values = {key: value for key, value in table.items() if key not in {"name", "uncertainty", "origin"}}
    name = str(table.get("name", ""))
    kind = EFFECTS.get(name)
    if kind is None:
        remedy = did_you_mean(name, EFFECTS, "see docs/effects.md for the names")
        raise SpecError("effects.name", f"'{name}'", "is not known", remedy)
    known = {parameter.name: parameter for parameter in parameters(kind)}
    for key, value in values.items():
        if key not in known:
            remedy = did_you_mean(key, known, f"known are {', '.join(known)}")
            raise SpecError(f"{name}.{key}", repr(value), "is not a parameter of this effect", remedy)
    missing = [p for p in known.values() if p.required and p.name not in values]
    if missing:
        raise SpecError(f"{name}.{missing[0].name}", "not given", "is required", f"give the {missing[0].text}")
    return kind(**values)


def effect_to_table(of: Effect) -> dict[str, Any]:
    """The effect as a table for a spec file; parts that mean "all" are left out."""
    values = {field.name: getattr(of, field.name) for field in dataclasses.fields(of)}  # type: ignore[arg-type]
    return {"name": of.name} | {key: value for key, value in values.items() if value is not None}


def apply_effects(case: LoadCase, effects: Iterable[Effect]) -> AsBuiltReducer:
    """The nominal reducer with all ``effects``, one after the other."""
    return reduce(lambda reducer, one: one.apply(reducer), effects, as_drawn(case))
