"""All effects by name, those of plug-ins included, and their conversion from and to tables of a spec file.

An effect of a user is registered by Python, by ``load_plugins`` or by an installed package. A spec file may use its
name, and never loads it: a file from a stranger must not run code.
"""

from __future__ import annotations

import dataclasses
import hashlib
import importlib
import importlib.util
import re
import sys
import warnings
from collections.abc import Iterable, Iterator, Mapping
from functools import reduce
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol, TypeVar

from cycloid_profile.contact import LoadCase
from cycloid_profile.effects import compliance_and_friction, crank, first_stage, process, ring
from cycloid_profile.effects.base import Effect, EffectLocation, parameters
from cycloid_profile.effects.reducer import AsBuiltReducer, as_drawn
from cycloid_profile.errors import CycloidError, PluginError, SpecError, did_you_mean
from cycloid_profile.spec.model import (
    EMPIRICAL_NAMES,
    installed_effects,
    registered_names,
    remedy_of_unknown_effect,
)

_NOTES = frozenset({"name", "uncertainty", "origin"})  # keys of a table that are no parameters
_NAME = re.compile(r"[a-z][a-z0-9_]*")
_PACKAGE = __name__.split(".")[0]
_SEE = "see docs/own-effect.md"

Kind = TypeVar("Kind", bound=type[Effect])


class EffectRegistry(Mapping[str, type[Effect]]):
    """Kinds of effects by name: the built-in ones, those registered, and those of installed packages.

    Installed packages are imported when all names are asked for, or one that is neither built in nor registered.
    """

    def __init__(self, built_in: Mapping[str, type[Effect]]) -> None:
        self._built_in = frozenset(built_in)
        self._kinds = dict(built_in)
        self._installed = False

    def __getitem__(self, name: str) -> type[Effect]:
        if name not in self._kinds:
            self._load_installed()
        return self._kinds[name]

    def __iter__(self) -> Iterator[str]:
        self._load_installed()
        return iter(self._kinds)

    def __len__(self) -> int:
        self._load_installed()
        return len(self._kinds)

    @property
    def of_plugins(self) -> tuple[type[Effect], ...]:
        """Kinds that are not built in, in the order of their registration."""
        return tuple(kind for name, kind in self._kinds.items() if name not in self._built_in)

    def add(self, kind: type[Effect]) -> None:
        """Add a kind of effect; raises ``PluginError`` if it is incomplete or its name is taken.

        A class defined again, as a notebook cell does, replaces its earlier self.
        """
        _check(kind)
        known = self._kinds.get(kind.name)
        if kind.name in EMPIRICAL_NAMES or (known is not None and _origin(known) != _origin(kind)):
            by = "an empirical effect" if known is None else f"{known.__module__}.{known.__qualname__}"
            raise PluginError("effect", f"'{kind.name}'", f"is the name of {by}", "rename the class", " ")
        self._kinds[kind.name] = kind
        registered_names.add(kind.name)

    def remove(self, name: str) -> None:
        """Remove a kind that was added; raises ``PluginError`` for a built-in or unknown one."""
        if name in self._built_in or name not in self._kinds:
            raise PluginError(
                "effect", f"'{name}'", "is not one of a plug-in", "give the name of a registered one", " "
            )
        del self._kinds[name]
        registered_names.discard(name)

    def _load_installed(self) -> None:
        if self._installed:
            return
        self._installed = True
        for name, entry in installed_effects().items():
            try:
                kind = entry.load()
                if getattr(kind, "name", None) != name:
                    raise PluginError("entry point", name, "is no effect of that name", "give both the same name")
                self.add(kind)
            except Exception as error:  # the code of others may raise anything; the rest of the package still works
                warnings.warn(f"the effect '{name}' of '{entry.value}' is left out: {error}", stacklevel=2)


def _origin(kind: type[Effect]) -> tuple[str, str]:
    return kind.__module__, kind.__qualname__


def _check(kind: type[Effect]) -> None:
    """Raise ``PluginError`` unless a class is a whole effect."""
    what, value = "effect", f"'{getattr(kind, '__name__', kind)}'"

    def need(holds: object, limit: str, remedy: str) -> None:
        if not holds:
            raise PluginError(what, value, limit, f"{remedy}; {_SEE}", " ")

    need(isinstance(kind, type) and issubclass(kind, Effect), "is no effect", "derive it from cp.effects.Effect")
    frozen = dataclasses.is_dataclass(kind) and kind.__dataclass_params__.frozen
    need(frozen, "is no frozen dataclass", "decorate it with @dataclass(frozen=True)")
    need(_NAME.fullmatch(kind.name), "has no name of small letters", "name the class in letters, as DiscRunout")
    need(isinstance(getattr(kind, "location", None), EffectLocation), "has no location", "give an EffectLocation")
    need(isinstance(getattr(kind, "remedy", None), str), "has no remedy", "give a text")
    need(kind.apply is not Effect.apply, "has no method 'apply'", "return the changed reducer")
    made = all("text" in field.metadata for field in dataclasses.fields(kind))  # type: ignore[arg-type]
    need(made, "has a plain field", "make each with size_field, angle_field, shape_field or part_field")
    known = parameters(kind)
    need(not _NOTES & {p.name for p in known}, "has a reserved parameter", f"avoid {', '.join(sorted(_NOTES))}")
    sizes = [p for p in known if p.tolerance is not None]
    need(len(sizes) == 1, f"has {len(sizes)} sizes", "give it one size_field, and shape_field for other numbers")
    zero = kind.linear_in_reciprocal or sizes[0].low <= 0.0 <= sizes[0].high
    need(zero, "has a size that cannot be zero", "let its bounds include 0")
    whole = all(not p.required or p.tolerance is not None for p in known)
    need(whole, "needs more than its size", "give every other parameter a default")


EFFECTS = EffectRegistry(
    {
        kind.name: kind
        for module in (process, ring, crank, first_stage, compliance_and_friction)
        for kind in vars(module).values()
        if isinstance(kind, type) and issubclass(kind, Effect) and dataclasses.is_dataclass(kind)
    }
)


def register(kind: Kind) -> Kind:
    """Add a kind of effect to ``EFFECTS``; a decorator of the class, too.

    Raises ``PluginError`` if the class is incomplete, or its name is that of another effect.
    """
    EFFECTS.add(kind)
    return kind


def load_plugins(names: Iterable[str], must_register: bool = True) -> None:
    """Import plug-ins: modules by their dotted name, or files by a path that ends in ``.py``.

    Raises ``PluginError`` if one cannot be imported or, with ``must_register``, registers no effect.
    """
    for name in names:
        before = EFFECTS.of_plugins
        module = _from_file(Path(name)) if name.endswith(".py") else _imported(name)
        own = (kind.__module__ for kind in EFFECTS.of_plugins)
        nothing = EFFECTS.of_plugins == before and not any(_is_inside(one, module.__name__) for one in own)
        if nothing and must_register:
            remedy = f"decorate its classes with @cp.effects.register; {_SEE}"
            raise PluginError("plug-in", f"'{name}'", "registers no effect", remedy, " ")


def plugin_sources() -> tuple[str, ...]:
    """Modules and files of all registered effects, as ``load_plugins`` takes them: what another process imports.

    Raises ``PluginError`` for an effect of a script or notebook, which another process cannot import.
    """
    found = dict.fromkeys(kind.__module__ for kind in EFFECTS.of_plugins if kind.name not in installed_effects())
    if "__main__" in found:
        names = ", ".join(kind.name for kind in EFFECTS.of_plugins if kind.__module__ == "__main__")
        limit = "is defined in a script or notebook, which workers cannot import"
        raise PluginError("effect", f"'{names}'", limit, "move it into a module of its own", " ")
    return tuple(_FILES.get(name, name) for name in found)


def plugin_code(types: Iterable[type]) -> str:
    """SHA-256 of the source files of those types that are not of this package; "" if all are."""
    names = sorted({one.__module__ for one in types if not _is_inside(one.__module__, _PACKAGE)})
    files = (getattr(sys.modules.get(name), "__file__", None) for name in names)
    code = [Path(file).read_bytes() for file in files if file is not None and Path(file).is_file()]
    return hashlib.sha256(b"\0".join(code)).hexdigest() if code else ""


# Path of each module that was loaded from a file.
_FILES: dict[str, str] = {}


def _imported(name: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except CycloidError:
        raise
    except Exception as error:  # a plug-in may raise anything
        raise _not_loaded(name, error) from error


def _from_file(path: Path) -> ModuleType:
    """The module of a file, under the name of the file: other processes find its classes by that name."""
    name, whole = path.stem, str(path.resolve())
    there = sys.modules.get(name)
    if there is not None:
        if str(Path(getattr(there, "__file__", None) or "").resolve()) != whole:
            raise PluginError("plug-in", f"'{path}'", "has the name of another module", "rename the file", " ")
        _FILES[name] = whole
        return there
    spec = importlib.util.spec_from_file_location(name, whole)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look their module up
    try:
        spec.loader.exec_module(module)
    except CycloidError:
        del sys.modules[name]
        raise
    except Exception as error:  # a plug-in may raise anything
        del sys.modules[name]
        raise _not_loaded(str(path), error) from error
    _FILES[name] = whole
    return module


def _not_loaded(name: str, error: Exception) -> PluginError:
    remedy = "give the name of an installed module, or the path of a .py file"
    return PluginError("plug-in", f"'{name}'", f"cannot be imported ({type(error).__name__}: {error})", remedy, " ")


def _is_inside(module: str, package: str) -> bool:
    return module == package or module.startswith(f"{package}.")


def effect_from_table(table: Mapping[str, Any]) -> Effect:
    """The effect of one table of ``[[effects]]``.

    Raises ``SpecError`` if name or parameter is unknown (offering the nearest), one is missing, or a value out of
    bounds.
    """
    values = {key: value for key, value in table.items() if key not in _NOTES}
    name = str(table.get("name", ""))
    kind = EFFECTS.get(name)
    if kind is None:
        raise SpecError("effects.name", f"'{name}'", "is not known", remedy_of_unknown_effect(name))
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


class ChangesReducer(Protocol):
    """What an effect does, physical or empirical."""

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        """The reducer with this effect."""
        ...


def apply_effects(case: LoadCase, effects: Iterable[ChangesReducer]) -> AsBuiltReducer:
    """The nominal reducer with all ``effects``, one after the other."""
    return reduce(lambda reducer, one: one.apply(reducer), effects, as_drawn(case))
