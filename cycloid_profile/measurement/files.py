"""Measured files: CSV with keys in front, read and written (docs/rig.md, "Files").

``#`` lines of ``key: value``, one header row, then numbers. Rows stand in the order of measurement.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.errors import MeasurementError

FORMAT = "cycloid-profile measurement 1"
COLUMNS = {
    "profile_scan": ("x_mm", "y_mm"),
    "hysteresis": ("torque_nm", "angle_arcmin"),
    "transmission_error": ("output_angle_deg", "error_arcsec"),
    "lost_motion_map": ("output_angle_deg", "lost_motion_arcmin"),
}
_NEEDED = {"transmission_error": ("torque_nm",), "lost_motion_map": ("torque_nm",)}
_NUMBERS = ("torque_nm", "output_angle_deg", "noise_um", "noise_arcsec", "noise_arcmin", "temperature_c", "datum_um")
_POSITIVE = ("noise_um", "noise_arcsec", "noise_arcmin")
_DATUMS = ("bore", "free")
_DECIMALS = 7


@dataclass(frozen=True, eq=False)
class Measurement:
    """One measured or simulated file.

    ``kind``, one of ``COLUMNS``; ``columns`` by name, each shape (rows,), in the unit of its name; ``keys`` as
    written in front, unknown ones included; ``name`` of the file, for messages.
    """

    kind: str
    columns: Mapping[str, FloatArray]
    keys: Mapping[str, str] = field(default_factory=dict)
    name: str = ""

    def number(self, key: str) -> float | None:
        """A key as a number, None where it is not given."""
        return float(self.keys[key]) if key in self.keys else None

    def __getitem__(self, column: str) -> FloatArray:
        """A column by name."""
        return self.columns[column]


def scanned_disc(measurement: Measurement, discs: int) -> int:
    """Disc that a scan is of, counted from 0: that of a ``specimen`` such as "disc 2", else the first."""
    told = re.search(r"disc\s*(\d+)", measurement.keys.get("specimen", ""), re.IGNORECASE)
    number = int(told.group(1)) if told else 1
    return number - 1 if 1 <= number <= discs else 0


def read_measurement(path: Path) -> Measurement:
    """Read a measured file.

    Raises
    ------
    MeasurementError
        If the file cannot be read, is of no known kind, or a row is no row of finite numbers.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "is no text file"
        raise MeasurementError(
            "measured file", f"'{path}'", f"cannot be read ({reason})", "give a CSV file", " "
        ) from None
    return parse_measurement(text, path.name)


def parse_measurement(text: str, name: str = "") -> Measurement:
    """The measurement in ``text``; raises ``MeasurementError`` as ``read_measurement`` does."""
    keys: dict[str, str] = {}
    rows: list[tuple[int, str]] = []
    for number, line in enumerate(text.splitlines(), 1):
        bare = line.strip()
        if bare.startswith("#"):
            key, colon, value = bare[1:].partition(":")
            if colon:
                keys[key.strip().lower()] = value.strip()
        elif bare:
            rows.append((number, bare))
    if keys.get("format", FORMAT) != FORMAT:
        raise MeasurementError(f"{name}: format", f"'{keys['format']}'", "is not known", f"write '{FORMAT}'")
    kind = keys.get("kind", "")
    if kind not in COLUMNS:
        known = ", ".join(COLUMNS)
        raise MeasurementError(f"{name}: kind", f"'{kind}'", "is not known", f"write '# kind: ' and one of {known}")
    wanted = COLUMNS[kind]
    header = tuple(word.strip() for word in rows[0][1].split(",")) if rows else ()
    if header != wanted:
        raise MeasurementError(
            f"{name}: header", f"'{','.join(header)}'", f"is not that of a {kind}", f"write {','.join(wanted)}"
        )
    for key in _NUMBERS:
        _check_number(keys, key, name)
    if keys.get("datum", "bore") not in _DATUMS:
        raise MeasurementError(f"{name}: datum", f"'{keys['datum']}'", "is not known", "write bore or free")
    for key in _NEEDED.get(kind, ()):
        if key not in keys:
            raise MeasurementError(f"{name}: {key}", "not given", f"is needed for a {kind}", f"write '# {key}: '")
    values = np.array([_row(number, line, len(wanted), name) for number, line in rows[1:]])
    if len(values) < 2:
        raise MeasurementError(f"{name}: rows", len(values), "are too few", "give at least two")
    return Measurement(kind, dict(zip(wanted, values.T.copy(), strict=True)), keys, name)


def format_measurement(measurement: Measurement) -> str:
    """The text of a measured file, which ``parse_measurement`` reads back."""
    lines = [f"# format: {FORMAT}", f"# kind: {measurement.kind}"]
    lines += [f"# {key}: {value}" for key, value in measurement.keys.items() if key not in {"format", "kind"}]
    names = COLUMNS[measurement.kind]
    lines.append(",".join(names))
    table = np.column_stack([measurement[name] for name in names])
    # Adding zero makes minus zero plain.
    lines += [",".join(f"{value:.{_DECIMALS}f}" for value in row) for row in np.round(table, _DECIMALS) + 0.0]
    return "\n".join(lines) + "\n"


def _check_number(keys: Mapping[str, str], key: str, name: str) -> None:
    if key not in keys:
        return
    try:
        finite = math.isfinite(float(keys[key]))
    except ValueError:
        finite = False
    if finite and ((key in _POSITIVE and float(keys[key]) <= 0.0) or (key == "datum_um" and float(keys[key]) < 0.0)):
        raise MeasurementError(
            f"{name}: {key}", keys[key], "is not positive", "give a standard deviation, or leave it out"
        )
    if not finite:
        raise MeasurementError(f"{name}: {key}", f"'{keys[key]}'", "is not a number", "write a number without its unit")


def _row(number: int, line: str, count: int, name: str) -> list[float]:
    try:
        values = [float(word) for word in line.split(",")]
    except ValueError:
        values = []
    if len(values) != count or not all(map(math.isfinite, values)):
        raise MeasurementError(
            f"{name}: line {number}",
            f"'{line[:40]}'",
            f"is not {count} finite numbers",
            "give numbers with commas between",
        )
    return values
