"""Suggestions for unknown keys of the spec file: by unit, by meaning, by beginning, by likeness."""

from __future__ import annotations

import json
import typing
from dataclasses import dataclass
from functools import cache
from typing import Any

import msgspec

from cycloid_profile.errors import nearest_name
from cycloid_profile.units import ARCMIN

_SEE = "see docs/spec.md"
_LONGEST_SHOWN = 60  # characters of a refused value in a sentence
_MOST_LISTED = 16  # keys in a sentence
_SHORTEST_PREFIX = 3  # letters
# Size of each unit in the first of its family; a key's suffix names one of them.
_UNITS = {
    "nm": ("length", 1e-6), "um": ("length", 1e-3), "mm": ("length", 1.0), "cm": ("length", 10.0),
    "m": ("length", 1e3), "in": ("length", 25.4), "inch": ("length", 25.4),
    "mpa": ("stress", 1e-3), "gpa": ("stress", 1.0), "pa": ("stress", 1e-9),
    "nm_torque": ("torque", 1.0), "nmm": ("torque", 1e-3),
    "rad": ("angle", 1.0 / ARCMIN), "deg": ("angle", 60.0), "arcmin": ("angle", 1.0),
    "arcsec": ("angle", 1 / 60.0),
    "n_per_mm": ("stiffness", 1.0), "n_per_um": ("stiffness", 1e3), "n_per_m": ("stiffness", 1e-3),
    "rpm": ("speed", 1.0),
}  # fmt: skip
# Words for a key, without their unit: the key, and the offset that turns their value into its own.
_MEANINGS = {
    **dict.fromkeys(("lobes", "teeth", "disc_teeth", "reduction", "reduction_ratio", "gear_ratio"), ("pins", 1)),
    **dict.fromkeys(("pin_count", "pin_number", "number_of_pins", "num_pins", "rollers", "z_p"), ("pins", 0)),
    **dict.fromkeys(("roller_radius", "ring_pin_radius", "r_rp"), ("pin_radius_mm", 0)),
    **dict.fromkeys(("ring_radius", "pitch_radius", "pitch_circle_radius", "r_p"), ("pin_circle_radius_mm", 0)),
    **dict.fromkeys(("offset", "excentricity", "crank_throw", "e"), ("eccentricity_mm", 0)),
    **dict.fromkeys(("thickness", "width", "disc_thickness", "disk_thickness", "face_width", "disk_width"),
                    ("disc_width_mm", 0)),
    **dict.fromkeys(("disks", "number_of_discs", "disc_count", "disk_count"), ("discs", 0)),
    **dict.fromkeys(("torque", "rated_load", "output_torque", "nominal_torque"), ("rated_torque_nm", 0)),
    **dict.fromkeys(("speed", "output_rpm", "output_speed"), ("output_speed_rpm", 0)),
    **dict.fromkeys(("modulus", "e_modulus", "elastic_modulus", "young", "youngs", "stiffness"),
                    ("youngs_modulus_gpa", 0)),
    **dict.fromkeys(("poisson", "poissons_ratio", "nu"), ("poisson_ratio", 0)),
    **dict.fromkeys(("clearance", "gap", "offset_modification"), ("equidistant_um", 0)),
    **dict.fromkeys(("friction", "mu"), ("friction_coefficient", 0)),
    **dict.fromkeys(("compensation", "compensate"), ("deformation_compensation", 0)),
}  # fmt: skip


def shown(value: Any) -> str:
    """A value as messages show it: strings in quotes, tables as {…}, long text cut."""
    if isinstance(value, dict):
        return "{…}"
    text = json.dumps(value, ensure_ascii=False) if isinstance(value, str) else str(value)
    return text if len(text) <= _LONGEST_SHOWN else f"{text[:_LONGEST_SHOWN]}…"


@cache
def fields_of(table: type[msgspec.Struct]) -> dict[str, Any]:
    """Name and annotated type of each key of a table."""
    return {field.name: field.type for field in msgspec.structs.fields(table)}


def tables_in(annotation: Any) -> list[type[msgspec.Struct]]:
    """The spec tables inside a key's type, seen through unions, tuples and annotations."""
    if isinstance(annotation, type) and issubclass(annotation, msgspec.Struct):
        return [annotation]
    return [table for inner in typing.get_args(annotation) for table in tables_in(inner)]


@dataclass(frozen=True)
class Suggestion:
    """What is wrong with an unknown key, the remedy, and the key that may be meant, empty where none is."""

    limit: str
    remedy: str
    key: str = ""


@dataclass(frozen=True)
class Keys:
    """Every key below ``root``, a table whose path in the file is ``prefix``."""

    root: type[msgspec.Struct] | None
    prefix: str

    def suggestion(self, key: str, value: Any, path: str) -> Suggestion:
        """The key that an unknown ``key`` in the table at ``path`` may stand for, with its value converted."""
        known = self._known(path)
        elsewhere = [name for name in self._places() if name.rpartition(".")[2] == key]
        meaning = self._by_meaning(key, value, known)
        return (
            _other_unit(key, value, known)
            or (meaning if meaning and meaning.key else None)
            or (_unknown(f"did you mean {elsewhere[0]}?") if elsewhere else None)
            or meaning
            or self._by_likeness(key, path, known)
        )

    def _known(self, path: str) -> list[str]:
        inner = _without_numbers(path)
        start = f"{inner}." if inner else ""
        places = [place.removeprefix(start) for place in self._places() if place.startswith(start)]
        return [place for place in places if "." not in place]

    def _places(self) -> list[str]:
        start = f"{_without_numbers(self.prefix)}." if self.prefix else ""
        return [] if self.root is None else [start + place for place in _places_in(self.root, "")]

    def _by_meaning(self, key: str, value: Any, known: list[str]) -> Suggestion | None:
        """Suggestion for a diameter in place of a radius, and for other words for a key of any table."""
        stem, unit = _split(key)
        as_radius = stem.replace("diameter", "radius").replace("dia", "radius")
        factor = 1.0 if as_radius == stem else 0.5
        meant, offset = _MEANINGS.get(as_radius, ("", 0))
        names = [name for name in known if _split(name)[0] == as_radius or name == meant]
        places = [place for place in self._places() if place.rpartition(".")[2] == meant]
        if not names and not places:
            return None
        name = names[0] if names else places[0].rpartition(".")[2]
        place = name if names else places[0]
        converted = _converted(value, unit, name, factor, offset)
        remedy = f"write {place}" + (" and convert the value" if converted is None else f" = {converted}")
        return _unknown(remedy, name if names else "")

    def _by_likeness(self, key: str, path: str, known: list[str]) -> Suggestion:
        """Suggestion for the beginning of a key, else the most similar one."""
        stem, _ = _split(key)
        begun = [name for name in known if name.startswith(stem) or stem.startswith(_split(name)[0])]
        close = begun[0] if begun and len(stem) >= _SHORTEST_PREFIX else nearest_name(key, known)
        if close:
            return _unknown(f"did you mean {f'{path}.' if path else ''}{close}?", close)
        return _unknown(f"known here are {', '.join(known)}" if len(known) <= _MOST_LISTED else _SEE)


def _unknown(remedy: str, key: str = "") -> Suggestion:
    return Suggestion("is not a key of the spec file", remedy, key)


def _without_numbers(path: str) -> str:
    """A path without the numbers of repeated tables."""
    return ".".join(part.partition("[")[0] for part in path.split("."))


@cache
def _places_in(table: type[msgspec.Struct], path: str) -> tuple[str, ...]:
    found = [f"{path}{name}" for name in fields_of(table)]
    for name, annotation in fields_of(table).items():
        for inner in tables_in(annotation):
            found += _places_in(inner, f"{path}{name}.")
    return tuple(found)


def _other_unit(key: str, value: Any, known: list[str]) -> Suggestion | None:
    """Suggestion for a known key under another unit or none, else None."""
    stem, unit = _split(key)
    for name in known:
        name_stem, name_unit = _split(name)
        if name_stem != stem or name_unit is None or name == key:
            continue
        converted = _converted(value, unit, name)
        if unit is None:
            limit = f"has no unit in its key, which is {name}"
            given = name if converted is None else f"{name} = {converted}"
            return Suggestion(limit, f"write {given}, with the value in that unit", name)
        limit = f"carries the wrong unit, the key is {name}"
        if converted is None:
            return Suggestion(limit, f"write {name} and convert the value", name)
        return Suggestion(limit, f"write {name} = {converted}", name)
    return None


def _converted(value: Any, unit: str | None, name: str, factor: float = 1.0, offset: int = 0) -> str | None:
    """A number in ``unit`` as the value of the key ``name``, in its own unit where ``unit`` is None; else None."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    size = 1.0
    wanted = _split(name)[1]
    if unit is not None:
        if wanted is None or _UNITS[unit][0] != _UNITS[wanted][0]:
            return None
        size = _UNITS[unit][1] / _UNITS[wanted][1]
    return f"{value * size * factor + offset:.10g}"


def _split(key: str) -> tuple[str, str | None]:
    """Stem and unit suffix of a key; the suffix _nm of a torque is N·m, of a length nanometres."""
    for unit in sorted(_UNITS, key=len, reverse=True):
        if key.endswith(f"_{unit}"):
            stem = key[: -len(unit) - 1]
            return stem, "nm_torque" if unit == "nm" and "torque" in stem else unit
    return key, None
