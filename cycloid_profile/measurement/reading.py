"""Reading of measured files: those of this program as they are, those of others by their header or a mapping."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from cycloid_profile.errors import MeasurementError
from cycloid_profile.measurement._strict import joined
from cycloid_profile.measurement.files import Measurement, is_own_format, parse_measurement
from cycloid_profile.measurement.foreign import (
    MAPPING_FILE,
    ColumnMapping,
    SourceTable,
    decode,
    mapping_for,
    measurement_of,
    parse_columns,
    place_of,
    read_source,
    remember,
    remembered,
)
from cycloid_profile.resources import Need, is_large_allowed

_MEMORY_PER_BYTE = 25.0  # of a file of numbers as text, with its rows and pictures
_LARGEST_STREAM = 160_000_000  # bytes read from a pipe, which does not say how many come


def read_measurement(path: Path, columns: Sequence[str] = (), spec_columns: Sequence[str] = ()) -> Measurement:
    """Read a measured file, also one of another program.

    ``columns``: mappings such as ``x=X,y=Y,unit=mm``, of which the first that fits the header is used; else the one
    that ``.mapping.toml`` next to the file holds for its header, else one of ``spec_columns``, else the header itself.

    Raises ``MeasurementError`` if the file cannot be read, its kind is unknown, or a row is not made of finite
    numbers; all faults of the file are in one sentence. Raises ``ResourceError`` if the file is larger than allowed.
    """
    given = [parse_columns(text) for text in columns]
    source = _source(path, given)
    if isinstance(source, Measurement):
        return source
    mapping, origin = _mapping(path, source, given, spec_columns)
    found = measurement_of(source, mapping)
    return replace(found, notes=tuple(f"{note}{origin}" for note in found.notes))


def read_measurements(
    paths: Sequence[Path], columns: Sequence[str] = (), spec_columns: Sequence[str] = ()
) -> list[Measurement]:
    """Read measured files as ``read_measurement`` does; the faults of all files are in one sentence.

    Raises ``MeasurementError``, too, if ``columns`` are given and every file states its columns itself.
    """
    found, faults = [], []
    for path in paths:
        try:
            found.append(read_measurement(path, columns, spec_columns))
        except MeasurementError as fault:
            faults.append(fault)
    if faults:
        raise joined(faults)
    if columns and not any(one.notes for one in found):
        limit, remedy = (
            "has no file of another program to read",
            "leave it out, files of our format name their columns",
        )
        raise MeasurementError("--columns", f"'{columns[0]}'", limit, remedy, " ")
    return found


def remember_columns(paths: Sequence[Path], columns: Sequence[str]) -> list[Path]:
    """Keep the ``columns`` given for files of other programs in ``.mapping.toml`` next to each.

    Returns the files written: none where a file of that name is not ours, or its folder cannot be written.
    """
    given = [parse_columns(text) for text in columns]
    written: list[Path] = []
    for path in paths if given else ():
        source = _source(path, given)
        mapping = None if isinstance(source, Measurement) else mapping_for(source.columns, given)
        if mapping is None or isinstance(source, Measurement) or not source.has_header:
            continue
        file = remember(path.parent, source.columns, mapping)
        written += [file] if file is not None and file not in written else []
    return written


def _source(path: Path, given: Sequence[ColumnMapping]) -> Measurement | SourceTable:
    """The measurement of a file in our format, else the table of a foreign one."""
    try:
        data = _bytes(path)
        text = _text(data)
        if text is not None and is_own_format(text):
            return parse_measurement(text, path.name)
        settings = {key: value for one in given for key, value in one.settings.items()}
        return read_source(data, path.name, settings)
    except (OSError, UnicodeError) as error:
        reason = getattr(error, "strerror", None)
        limit = f"cannot be read ({reason or 'is no text file'})"
        remedy = "give a CSV file" if reason else "save it as CSV in UTF-8"
        raise MeasurementError("measured file", f"'{path}'", limit, remedy, " ") from None


def _bytes(path: Path) -> bytes:
    """The content of a file, or of a pipe up to a limit; raises ``ResourceError`` if it is larger than allowed."""
    if path.is_char_device() or path.is_block_device():
        raise MeasurementError("measured file", f"'{path}'", "is a device", "give a CSV file", " ")
    if path.is_file():
        _need(path, path.stat().st_size).require()
        return path.read_bytes()
    with path.open("rb") as stream:
        data = stream.read(-1 if is_large_allowed() else _LARGEST_STREAM + 1)
    _need(path, len(data)).require()
    return data


def _need(path: Path, size: int) -> Need:
    what, value = "measured file", f"'{path}' of {size / 1e6:,.0f} MB"
    return Need(what, value, "thin it out", memory=_MEMORY_PER_BYTE * size, joint=" ")


def _text(data: bytes) -> str | None:
    """The text of a file, None if it is none."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        pass
    try:
        return decode(data)[0]
    except UnicodeError:
        return None


def _mapping(
    path: Path, source: SourceTable, given: Sequence[ColumnMapping], spec_columns: Sequence[str]
) -> tuple[ColumnMapping | None, str]:
    """The mapping of a table, None if its header decides, and where the mapping is from, in words."""
    mapping = mapping_for(source.columns, given)
    if mapping is None and given:
        for role, column in given[0].columns.items():
            place_of(column.column, source.columns, f"{source.name}: --columns {role}")
    if mapping is not None:
        return mapping, ""
    kept = remembered(path.parent, source.columns)
    if kept is not None:
        return kept, f"; columns from {MAPPING_FILE}"
    in_spec = mapping_for(source.columns, [parse_columns(text, "measurement.columns") for text in spec_columns])
    return in_spec, "; columns from [measurement] of the spec" if in_spec is not None else ""
