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
    """The TOML text of a drive; the beginning of its name is enough. Raises ``SpecError`` with the nearest name."""
    known = _full_name(name)
    return resources.files("cycloid_profile.catalog").joinpath(f"{known}{_SUFFIX}").read_text(encoding="utf-8")


def _full_name(name: str) -> str:
    """The drive of this name, or the only one whose name begins with it, whatever its capitals and hyphens."""
    names = catalog_names()
    wanted = name.lower().replace("-", "")
    found = [each for each in names if each == wanted] or [each for each in names if wanted and each.startswith(wanted)]
    if len(found) == 1:
        return found[0]
    remedy = did_you_mean(wanted, names, f"known are {', '.join(names)}")
    if found:
        remedy = f"choose from {', '.join(found)}"
    raise SpecError("drive", f"'{name}'", "is not in the catalogue", remedy, " ")


def catalog_drive(name: str) -> Spec:
    """The spec of a drive of the catalogue."""
    return parse_spec(catalog_text(name), name=f"catalogue drive {name}")
