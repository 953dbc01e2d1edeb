"""Measured files: CSV with a header of ``# key: value`` lines, read and written (docs/rig.md, "Files").

``#`` lines of ``key: value``, one header row, then numbers. Rows keep the order of measurement.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile._display import Described, frame
from cycloid_profile.arrays import FloatArray
from cycloid_profile.errors import MeasurementError
from cycloid_profile.measurement.kinds import MeasurementKind, kind_named

FORMAT = "cycloid-profile measurement 1"
_NOISES = ("noise_um", "noise_arcsec", "noise_arcmin")
_NUMBERS = ("torque_nm", "output_angle_deg", "temperature_c", "datum_um", *_NOISES)
_DATUMS = ("bore", "free")
_DECIMALS = 7  # rounding of 1e-4 µm, far below any noise


@dataclass(frozen=True, eq=False, repr=False)
class Measurement(Described):
    """One measured or simulated file.

    ``columns`` by name, each shape (rows,), in the unit of its name; ``keys``, header entries as written, unknown ones
    included; ``name`` of the file, for messages.
    """

    kind: MeasurementKind
    columns: Mapping[str, FloatArray]
    keys: Mapping[str, str] = field(default_factory=dict)
    name: str = ""

    def number(self, key: str) -> float | None:
        """A key as a number, None where it is not given."""
        return float(self.keys[key]) if key in self.keys else None

    def __getitem__(self, column: str) -> FloatArray:
        """A column by name."""
        return self.columns[column]

    @property
    def value(self) -> FloatArray:
        """The measured column of a curve, shape (rows,), in ``kind.unit``."""
        return self.columns[self.kind.value_column]

    @property
    def rows(self) -> int:
        """Number of rows."""
        return self.columns[self.kind.value_column].size

    @property
    def stated_noise(self) -> float | None:
        """Standard deviation of the noise that the file states, in ``kind.unit``; None where it states none."""
        return self.number(self.kind.noise_key)

    @property
    def datum_free(self) -> bool:
        """Whether the origin of a scan is unknown."""
        return self.keys.get("datum", "bore") == "free"

    def to_frame(self) -> Any:
        """The columns as a ``pandas.DataFrame``."""
        return frame(self.columns)

    def _key_figures(self) -> dict[str, str]:
        ranges = {name: f"{np.min(values):.6g} to {np.max(values):.6g}" for name, values in self.columns.items()}
        named = {"file": self.name} if self.name else {}
        return {**named, "kind": self.kind.title, "rows": str(self.rows), **ranges, **self.keys}


def scanned_disc(measurement: Measurement, discs: int) -> int:
    """Index of the scanned disc, from 0: that of a ``specimen`` such as "disc 2", else the first."""
    specimen = re.search(r"disc\s*(\d+)", measurement.keys.get("specimen", ""), re.IGNORECASE)
    number = int(specimen.group(1)) if specimen else 1
    return number - 1 if 1 <= number <= discs else 0


def read_measurement(path: Path) -> Measurement:
    """Read a measured file.

    Raises ``MeasurementError`` if the file cannot be read, its kind is unknown, or a row is not made of finite
    numbers.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "is no text file"
        limit = f"cannot be read ({reason})"
        raise MeasurementError("measured file", f"'{path}'", limit, "give a CSV file", " ") from None
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
    kind = kind_named(keys.get("kind", ""), f"{name}: kind")
    header = tuple(word.strip() for word in rows[0][1].split(",")) if rows else ()
    if header != kind.columns:
        limit, remedy = f"is not that of a {kind}", f"write {','.join(kind.columns)}"
        raise MeasurementError(f"{name}: header", f"'{','.join(header)}'", limit, remedy)
    _check_keys(keys, kind, name)
    values = np.array([_row(number, line, name) for number, line in rows[1:]])
    if len(values) < 2:
        raise MeasurementError(f"{name}: rows", len(values), "are too few", "give at least two")
    return Measurement(kind, dict(zip(kind.columns, values.T.copy(), strict=True)), keys, name)


def format_measurement(measurement: Measurement) -> str:
    """The text of a measured file, which ``parse_measurement`` reads back."""
    lines = [f"# format: {FORMAT}", f"# kind: {measurement.kind}"]
    lines += [f"# {key}: {value}" for key, value in measurement.keys.items() if key not in {"format", "kind"}]
    names = measurement.kind.columns
    lines.append(",".join(names))
    table = np.column_stack([measurement[name] for name in names])
    # Adding 0.0 turns −0.0 into 0.0.
    lines += [",".join(f"{value:.{_DECIMALS}f}" for value in row) for row in np.round(table, _DECIMALS) + 0.0]
    return "\n".join(lines) + "\n"


def _check_keys(keys: Mapping[str, str], kind: MeasurementKind, name: str) -> None:
    for key in (key for key in _NUMBERS if key in keys):
        try:
            value = float(keys[key])
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            remedy = "write a number without its unit"
            raise MeasurementError(f"{name}: {key}", f"'{keys[key]}'", "is not a number", remedy)
        if (key in _NOISES and value <= 0.0) or (key == "datum_um" and value < 0.0):
            remedy = "give a standard deviation, or leave it out"
            raise MeasurementError(f"{name}: {key}", keys[key], "is not positive", remedy)
    if keys.get("datum", "bore") not in _DATUMS:
        raise MeasurementError(f"{name}: datum", f"'{keys['datum']}'", "is not known", "write bore or free")
    for key in kind.needed_keys:
        if key not in keys:
            raise MeasurementError(f"{name}: {key}", "not given", f"is needed for a {kind}", f"write '# {key}: '")


def _row(number: int, line: str, name: str) -> list[float]:
    try:
        values = [float(word) for word in line.split(",")]
    except ValueError:
        values = []
    if len(values) != 2 or not all(map(math.isfinite, values)):
        remedy = "give numbers with commas between"
        raise MeasurementError(f"{name}: line {number}", f"'{line[:40]}'", "is not 2 finite numbers", remedy)
    return values
