"""Published drives, one TOML each, with its source and assumptions."""

from __future__ import annotations

from importlib import resources

from cycloid_profile.errors import SpecError, did_you_mean
from cycloid_profile.spec import parse_spec
from cycloid_profile.spec.model import Spec

_SUFFIX = ".toml"


def catalog_names() -> tuple[str, ...]:
    """Names of all drives of the catalogue, sorted alphabetically."""
    folder = resources.files("cycloid_profile.catalog")
    return tuple(sorted(f.name.removesuffix(_SUFFIX) for f in folder.iterdir() if f.name.endswith(_SUFFIX)))


def catalog_text(name: str) -> str:
    """The TOML text of a drive. Raises ``SpecError`` with the nearest name for an unknown one."""
    names = catalog_names()
    if name not in names:
        remedy = did_you_mean(name.lower(), names, f"known are {', '.join(names)}")
        raise SpecError("drive", f"'{name}'", "is not in the catalogue", remedy, " ")
    return resources.files("cycloid_profile.catalog").joinpath(f"{name}{_SUFFIX}").read_text(encoding="utf-8")


def catalog_drive(name: str) -> Spec:
    """The spec of a drive of the catalogue."""
    return parse_spec(catalog_text(name), name=f"catalogue drive {name}")
