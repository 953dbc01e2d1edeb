"""Measured files: CSV with a header of ``# key: value`` lines, read and written (docs/rig.md, "Files").

``#`` lines of ``key: value``, one header row, then numbers. Rows keep the order of measurement.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cycloid_profile._display import Described, frame
from cycloid_profile.arrays import FloatArray
from cycloid_profile.errors import MeasurementError
from cycloid_profile.measurement._strict import finite_number, is_comment, joined
from cycloid_profile.measurement.kinds import KINDS, MeasurementKind, kind_named

FORMAT = "cycloid-profile measurement 1"
_NOISES = ("noise_um", "noise_arcsec", "noise_arcmin")
_NUMBERS = ("torque_nm", "output_angle_deg", "temperature_c", "datum_um", *_NOISES)
_DATUMS = ("bore", "free")
_DECIMALS = 7  # rounding of 1e-4 µm, far below any noise


@dataclass(frozen=True, eq=False)
class PendingSteps:
    """Steps from the coordinates of a scan to points of the tooth that need the tooth itself.

    ``probe_radius`` of the ball whose centres the file holds, 0 for points of the surface [mm]; ``deviation`` along the
    outward normal, positive outwards as machines print it, shape (rows,) [mm], or None; ``nominal``: the file states
    that its coordinates are nominal. Where it does not, coordinates on the nominal tooth are nominal ones.
    """

    probe_radius: float = 0.0
    deviation: FloatArray | None = None
    nominal: bool = False


@dataclass(frozen=True, eq=False, repr=False)
class Measurement(Described):
    """One measured or simulated file.

    ``columns`` by name, each shape (rows,), in the unit of its name; ``keys``, header entries as written, unknown ones
    included; ``name`` of the file, for messages; ``notes``: how a file of another program was understood; ``pending``
    steps before its points are points of the tooth.
    """

    kind: MeasurementKind
    columns: Mapping[str, FloatArray]
    keys: Mapping[str, str] = field(default_factory=dict)
    name: str = ""
    notes: tuple[str, ...] = ()
    pending: PendingSteps | None = None

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


def is_own_format(text: str) -> bool:
    """Whether ``text`` says that it is a measured file of this program: by its format, or its kind and columns."""
    keys, rows, _ = _keys_and_rows(text, "")
    header = tuple(word.strip() for word in rows[0][1].split(",")) if rows else ()
    own = not rows or header in {kind.columns for kind in KINDS.values()}
    return "format" in keys or (own and ("kind" in keys or not rows))


def parse_measurement(text: str, name: str = "") -> Measurement:
    """The measurement in ``text``.

    Raises ``MeasurementError`` with all faults if its kind is unknown, or a row is not made of finite numbers.
    """
    keys, rows, faults = _keys_and_rows(text, name)
    if keys.get("format", FORMAT) != FORMAT:
        raise MeasurementError(f"{name}: format", f"'{keys['format']}'", "is not known", f"write '{FORMAT}'")
    if not keys and not rows:
        remedy = f"export it again, as one of {', '.join(KINDS)}"
        raise MeasurementError(f"{name}: kind", "not given", "in an empty file", remedy)
    kind = kind_named(keys.get("kind", ""), f"{name}: kind")
    header = tuple(word.strip() for word in rows[0][1].split(",")) if rows else ()
    faults += key_faults(keys, kind, name)
    if header != kind.columns:
        limit, remedy = f"is not that of a {kind}", f"write {','.join(kind.columns)}"
        raise joined([MeasurementError(f"{name}: header", f"'{','.join(header)}'", limit, remedy), *faults])
    values = []
    for number, line in rows[1:]:
        row = [finite_number(word) for word in line.split(",")]
        if len(row) != 2 or None in row:
            limit, remedy = "is not 2 finite numbers", "give numbers with commas between"
            faults.append(MeasurementError(f"{name}: line {number}", f"'{line[:40]}'", limit, remedy))
        values.append(row)
    if faults:
        raise joined(faults)
    table = np.array(values, dtype=np.float64)
    if len(table) < 2:
        raise MeasurementError(f"{name}: rows", len(table), "are too few", "give at least two")
    return Measurement(kind, dict(zip(kind.columns, table.T.copy(), strict=True)), keys, name)


def _keys_and_rows(text: str, name: str) -> tuple[dict[str, str], list[tuple[int, str]], list[MeasurementError]]:
    """Keys of the ``#`` lines, the numbered other lines, and a fault for each key that is given again."""
    keys: dict[str, str] = {}
    lines: dict[str, int] = {}
    rows: list[tuple[int, str]] = []
    faults = []
    for number, line in enumerate(text.splitlines(), 1):
        bare = line.strip()
        if bare.startswith("#") and (not rows or is_comment(bare)):
            word, colon, value = bare[1:].partition(":")
            key = word.strip().lower()
            if colon and key in keys:
                limit, remedy = f"is given in line {lines[key]} already", "keep one of them"
                faults.append(MeasurementError(f"{name}: line {number}", f"'{key}'", limit, remedy))
            elif colon:
                keys[key], lines[key] = value.strip(), number
        elif bare:
            rows.append((number, bare))
    return keys, rows, faults


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


def key_faults(keys: Mapping[str, str], kind: MeasurementKind, name: str) -> list[MeasurementError]:
    """A fault for each key that is no number, not positive, not known or missing."""
    faults = []
    for key in (key for key in _NUMBERS if key in keys):
        value = finite_number(keys[key])
        if value is None:
            remedy = "write a number without its unit"
            faults.append(MeasurementError(f"{name}: {key}", f"'{keys[key]}'", "is not a number", remedy))
        elif (key in _NOISES and value <= 0.0) or (key == "datum_um" and value < 0.0):
            remedy = "give a standard deviation, or leave it out"
            faults.append(MeasurementError(f"{name}: {key}", keys[key], "is not positive", remedy))
    if keys.get("datum", "bore") not in _DATUMS:
        faults.append(MeasurementError(f"{name}: datum", f"'{keys['datum']}'", "is not known", "write bore or free"))
    for key in kind.needed_keys:
        if key not in keys:
            remedy = f"write '# {key}: '"
            faults.append(MeasurementError(f"{name}: {key}", "not given", f"is needed for a {kind}", remedy))
    return faults
