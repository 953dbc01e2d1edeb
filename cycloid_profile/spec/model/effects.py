"""Names that `[[effects]]` may use, those of plug-ins included, and keys of `[[empirical]]`."""

from __future__ import annotations

from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Annotated, Literal

from cycloid_profile.errors import did_you_mean
from cycloid_profile.spec.model.checks._table import Table, key
from cycloid_profile.spec.model.modification import EFFECT_NAMES

# Installed packages list their effects under this group: the name of the effect, and the class that it is.
PLUGIN_GROUP = "cycloid_profile.effects"
EMPIRICAL_NAMES = ("form_deviation", "torque_twist_residual")
EMPIRICAL_LABEL = "empirical, not physical"
# Names of the effects registered while the program runs. A spec may use them; it can never load them.
registered_names: set[str] = set()


@cache
def installed_effects() -> dict[str, EntryPoint]:
    """Effects of installed packages by name, from their metadata: none of their code is run."""
    return {one.name: one for one in entry_points(group=PLUGIN_GROUP)}


def is_effect_name(name: str) -> bool:
    """Whether an effect of this name is built in, registered or installed."""
    return name in EFFECT_NAMES or name in registered_names or name in installed_effects()


def remedy_of_unknown_effect(name: str) -> str:
    """Remedy of an unknown name: the nearest known one, and the plug-in that may be missing."""
    if name in EMPIRICAL_NAMES:
        return "it is empirical and no effect: write it under [[empirical]]"
    known = sorted({*EFFECT_NAMES, *registered_names, *installed_effects()})
    return f"{did_you_mean(name, known, 'see docs/effects.md for the names')} (an effect of a plug-in needs --plugin)"


class DataFileSpec(Table, frozen=True):
    """A measured file that a curve was fitted to."""

    file: Annotated[str, key("Name of the measured file.", "give a name")]
    sha256: Annotated[str, key("SHA-256 of its content, 64 hexadecimal digits.", "give 64 hexadecimal digits")]
    date: Annotated[str | None, key("Date of the measurement, such as 2026-01-31.", "give a date as text")] = None


_LIST = "give a list of numbers"
Numbers = tuple[float, ...]


class EmpiricalSpec(Table, frozen=True, kw_only=True):
    """A curve fitted to a measured gap that no effect explains; `diagnose` writes it. See docs/effects.md."""

    name: Annotated[
        Literal["form_deviation", "torque_twist_residual"], key("Which curve, of the flanks or of a loop.", "")
    ]
    label: Annotated[Literal["empirical, not physical"], key("Says that no physics stands behind it.", "")]
    disc: Annotated[int, key("form_deviation: number of the disc; absent: all.", "give 1 to 6", ge=1)] | None = None
    lobes: (
        Annotated[int, key("form_deviation: lobes after which it repeats, 1 or all of the disc.", "give 1", ge=1)]
        | None
    ) = None
    removal_um: Annotated[
        Numbers, key("form_deviation: material removed, at even phases from the root of lobe 1 on [µm].", _LIST)
    ] = ()
    uncertainty_um: Annotated[
        float, key("form_deviation: root mean square standard error [µm].", "give a number", ge=0)
    ] = 0.0
    rising_torque_nm: Annotated[
        Numbers, key("torque_twist_residual: knots of the branch of rising torque [N·m].", _LIST)
    ] = ()
    rising_twist_arcmin: Annotated[
        Numbers, key("torque_twist_residual: further twist at these knots [arc minutes].", _LIST)
    ] = ()
    rising_uncertainty_arcmin: Annotated[
        Numbers, key("torque_twist_residual: its standard error at these knots [arc minutes].", _LIST)
    ] = ()
    falling_torque_nm: Annotated[
        Numbers, key("torque_twist_residual: knots of the branch of falling torque [N·m].", _LIST)
    ] = ()
    falling_twist_arcmin: Annotated[
        Numbers, key("torque_twist_residual: further twist at these knots [arc minutes].", _LIST)
    ] = ()
    falling_uncertainty_arcmin: Annotated[
        Numbers, key("torque_twist_residual: its standard error at these knots [arc minutes].", _LIST)
    ] = ()
    data: tuple[DataFileSpec, ...] = ()
