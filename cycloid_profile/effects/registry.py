"""All effects by name, and back and forth between them and the tables of a spec file."""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Iterable, Mapping
from functools import reduce
from typing import Any

from cycloid_profile.contact.case import LoadCase
from cycloid_profile.effects import compliance, crank, friction, process, ring
from cycloid_profile.effects.built import Built, as_drawn
from cycloid_profile.effects.effect import Effect, parameters
from cycloid_profile.errors import SpecError

EFFECTS: dict[str, type[Effect]] = {
    kind.name: kind
    for module in (process, ring, crank, compliance, friction)
    for kind in vars(module).values()
    if isinstance(kind, type) and issubclass(kind, Effect) and dataclasses.is_dataclass(kind)
}


def effect(table: Mapping[str, Any]) -> Effect:
    """The effect of one table of ``[[effects]]``.

    Raises
    ------
    SpecError
        If name or parameter is unknown (offering the nearest), one is missing, or a value out of bounds.
    """
    values = {key: value for key, value in table.items() if key not in {"name", "uncertainty", "origin"}}
    name = str(table.get("name", ""))
    kind = EFFECTS.get(name)
    if kind is None:
        close = difflib.get_close_matches(name, EFFECTS, n=1, cutoff=0.4)
        remedy = f"did you mean {close[0]}?" if close else "see docs/rig.md for the names"
        raise SpecError("effects.name", f"'{name}'", "is not known", remedy)
    known = {parameter.name: parameter for parameter in parameters(kind)}
    for key in values:
        if key not in known:
            close = difflib.get_close_matches(key, known, n=1, cutoff=0.4)
            remedy = f"did you mean {close[0]}?" if close else f"known are {', '.join(known)}"
            raise SpecError(f"{name}.{key}", repr(values[key]), "is not a parameter of this effect", remedy)
    missing = [p for p in known.values() if p.required and p.name not in values]
    if missing:
        raise SpecError(f"{name}.{missing[0].name}", "not given", "is required", f"give the {missing[0].text}")
    return kind(**values)


def table(of: Effect) -> dict[str, Any]:
    """The effect as a table for a spec file; parts that mean "all" are left out."""
    values = {field.name: getattr(of, field.name) for field in dataclasses.fields(of)}  # type: ignore[arg-type]
    return {"name": of.name} | {key: value for key, value in values.items() if value is not None}


def build(case: LoadCase, effects: Iterable[Effect]) -> Built:
    """The reducer of the drawing with all ``effects``, one after the other."""
    return reduce(lambda built, one: one.apply(built), effects, as_drawn(case))
