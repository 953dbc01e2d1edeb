"""Machine files: the built-in machine of each control, and a user's own."""

from __future__ import annotations

import re
import tomllib
from importlib import resources
from pathlib import Path
from typing import Any, get_args

import msgspec

from cycloid_profile.errors import CycloidError, ExportError
from cycloid_profile.spec import plain_text, toml_values, unreadable, validated
from cycloid_profile.spec.model import BlocksSpec, Dialect, ExportSpec, MachineSpec

MACHINES: tuple[str, ...] = get_args(Dialect)
_PLACES = frozenset({"tool", "offset", "spindle", "z"})
# Not a format string: one reaches attributes, and widths of any size.
_PLACE = re.compile(r"\{([^{}]*)\}")
# Keys of [export.grinding] that override the machine, and where they stand in a machine file.
_OVERRIDES = {
    "stock_um": ("passes", "stock_um"),
    "infeed_um": ("passes", "infeed_um"),
    "spark_out_turns": ("passes", "spark_out_turns"),
    "infeed_feed_mm_per_min": ("passes", "infeed_feed_mm_per_min"),
    "c_speed_limit_deg_per_s": ("axes", "c_speed_deg_per_s"),
    "c_acceleration_limit_deg_per_s2": ("axes", "c_acceleration_deg_per_s2"),
    "x_speed_limit_mm_per_min": ("axes", "x_speed_mm_per_min"),
    "x_acceleration_limit_mm_per_s2": ("axes", "x_acceleration_mm_per_s2"),
}


def machine_text(name: str) -> str:
    """The TOML text of a built-in machine, named like its control."""
    return resources.files("cycloid_profile.export.nc").joinpath("machines", f"{name}.toml").read_text(encoding="utf-8")


def built_in_machine(name: str) -> MachineSpec:
    """The built-in machine of a control."""
    machine: MachineSpec = validated(tomllib.loads(machine_text(name)), MachineSpec)
    return machine


def read_machine(path: str | Path) -> MachineSpec:
    """A machine file; keys that it leaves out are those of the built-in file of its ``control``.

    Raises ``ExportError`` if the file is missing or not TOML, or a key is unknown or out of its limits.
    """
    file = Path(path)
    try:
        own = toml_values(plain_text(file))
    except (OSError, ValueError) as error:
        raise ExportError("export.machine", f"'{file}'", unreadable(error), "give the path of a machine file") from None
    control = own.get("control")
    if control not in MACHINES:
        raise _refusal(file, "control", f"{control!r}", "is not a known control", f"choose from {', '.join(MACHINES)}")
    try:
        machine: MachineSpec = validated(_merged(tomllib.loads(machine_text(control)), own), MachineSpec)
    except CycloidError as error:
        limit = error.limit.replace("the spec file", "a machine file")
        raise _refusal(file, error.what, error.value, limit, error.remedy) from None
    _check(file, machine)
    return machine


def machine_of(export: ExportSpec) -> MachineSpec:
    """Machine of the ``[export]`` table of a spec, with the decimals and the grinding settings that the spec gives.

    Raises ``ExportError`` as ``read_machine``.
    """
    machine = built_in_machine(export.nc_dialect) if export.machine is None else read_machine(export.machine)
    changes: dict[str, dict[str, Any]] = {}
    for key, (table, name) in _OVERRIDES.items():
        value = getattr(export.grinding, key)
        if value is not None:
            changes.setdefault(table, {})[name] = value
    if export.nc_decimals is not None:
        # One digit more has the same effect on C at a radius of about 60 mm.
        changes["numbers"] = {"decimals": export.nc_decimals, "angle_decimals": export.nc_decimals + 1}
    tables = {table: msgspec.structs.replace(getattr(machine, table), **values) for table, values in changes.items()}
    return msgspec.structs.replace(machine, **tables)


def filled(lines: tuple[str, ...], machine: MachineSpec, z: str = "0") -> list[str]:
    """Blocks of a machine file with tool, offset, spindle speed and the height ``z`` filled in."""
    tool = machine.tool
    values = {"tool": tool.number, "offset": tool.offset, "spindle": f"{tool.spindle_rpm:g}", "z": z}
    return [_PLACE.sub(lambda place: str(values[place[1]]), line) for line in lines]


def _merged(base: dict[str, Any], own: dict[str, Any]) -> dict[str, Any]:
    """Tables of ``own`` over those of ``base``, key by key."""
    both = {key: _merged(base[key], own[key]) for key in own if isinstance(own[key], dict) and key in base}
    return base | own | both


def _check(file: Path, machine: MachineSpec) -> None:
    """Refuse ranges that are empty, a safe height out of travel, and blocks with unknown places to fill."""
    axes, numbers = machine.axes, machine.numbers
    ranges = {f"axes.{axis}_mm": getattr(axes, f"{axis}_mm") for axis in "xyz"}
    ranges |= {f"numbers.{key}": getattr(numbers, key) for key in ("feed_mm_per_min", "inverse_time_per_min")}
    for key, (low, high) in ranges.items():
        if not low < high or (key.startswith("numbers") and low <= 0.0):
            raise _refusal(file, key, [low, high], "is no rising range", "give the least value, then the largest")
    for name in BlocksSpec.__struct_fields__:
        for line in getattr(machine.blocks, name):
            if not set(_PLACE.findall(line)) <= _PLACES or set("{}") & set(_PLACE.sub("", line)):
                remedy = "fill in {tool}, {offset}, {spindle} or {z} only"
                raise _refusal(file, f"blocks.{name}", f"'{line}'", "has an unknown place", remedy)


def _refusal(file: Path, key: str, value: object, limit: str, remedy: str) -> ExportError:
    return ExportError(f"machine file '{file}', {key}", value, limit, remedy)
