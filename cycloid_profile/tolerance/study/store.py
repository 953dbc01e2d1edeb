"""Results of a study on disk, one Parquet file per chunk, written atomically; an interrupted run resumes.

Every column carries the SHA-256 of its study, its chunk, its name and its numbers: a file that was damaged, or is from
another study or chunk, is computed again.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.errors import ToleranceError
from cycloid_profile.filesystem import lock, new_file
from cycloid_profile.tolerance.study.chunks import Study

_STUDY = "study.json"
_OWN_PART = re.compile(r"part-\d{5,}\.(parquet|partial)|\.part-\d{5,}\.parquet\.\w+\.partial")
_DIGEST = b"sha256"


@dataclass(frozen=True)
class Store:
    """The files of one study in ``folder``: ``names`` of the columns, and the ``study`` they belong to."""

    folder: Path
    study: Study
    names: tuple[str, ...]

    def missing(self) -> list[int]:
        """Chunks that are not on disk yet, or of another study."""
        numbers = range(self.study.chunks)
        return [number for number in numbers if not self._whole(number)] if self._is_same else list(numbers)

    @contextmanager
    def claimed(self) -> Iterator[None]:
        """Make the folder that of this study, and of this process within the context.

        Files of another study in it, and those that a killed process left, are deleted. Raises ``ToleranceError`` if
        the folder cannot be made or written to, or another process computes a study there.
        """
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            handle = _lock(self.folder)
        except OSError as error:
            raise _not_written(self.folder, error) from None
        try:
            self._claim()
            yield
        finally:
            if handle >= 0:
                os.close(handle)

    def _claim(self) -> None:
        try:
            kept = {self.path(number) for number in range(self.study.chunks)} if self._is_same else set()
            for old in set(self.folder.glob("*part-*")) - kept:
                if _OWN_PART.fullmatch(old.name) and old.is_file():
                    old.unlink()
            if not self._is_same:
                text = json.dumps(self._header, indent=1) + "\n"
                with new_file(self.folder / _STUDY) as scratch:
                    scratch.write_text(text, encoding="utf-8", newline="\n")
        except OSError as error:
            raise _not_written(self.folder, error) from None

    def put(self, number: int, values: FloatArray) -> None:
        """Write the results of a chunk, shape (count, quantities); the file appears only when it is complete."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        first, count = self.study.span(number)
        columns = {"reducer": np.arange(first, first + count), **dict(zip(self.names, values.T, strict=True))}
        arrays = [pa.array(column) for column in columns.values()]
        fields = [
            pa.field(name, array.type, metadata={_DIGEST: self._digest(number, name, column)})
            for (name, column), array in zip(columns.items(), arrays, strict=True)
        ]
        path = self.path(number)
        try:
            with new_file(path) as scratch:
                pq.write_table(pa.table(arrays, schema=pa.schema(fields)), scratch)
        except OSError as error:
            raise _not_written(path, error) from None

    def columns(self, name: str) -> Iterator[FloatArray]:
        """One quantity, chunk by chunk in order, shape (count,)."""
        return (table[:, 0] for table in self.tables([name]))

    def tables(self, names: Sequence[str] | None = None) -> Iterator[FloatArray]:
        """The quantities ``names``, all unless given, chunk by chunk in order, shape (count, quantities)."""
        some = list(self.names if names is None else names)
        for number in range(self.study.chunks):
            try:
                columns = self._read(number, some)
            except (OSError, ValueError, KeyError) as error:
                reason = next(iter(str(error).splitlines()), type(error).__name__)
                limit = f"was changed while the study ran ({reason})"
                raise ToleranceError("samples", f"'{self.path(number)}'", limit, "run it again", " ") from None
            yield np.stack(columns, axis=1)

    @property
    def _header(self) -> dict[str, Any]:
        study = self.study
        return {"schema": 1, "fingerprint": study.fingerprint, "columns": list(self.names), "chunk": study.chunk}

    @property
    def _is_same(self) -> bool:
        """Whether the files in the folder are of this study."""
        return _read_header(self.folder / _STUDY) == self._header

    def path(self, number: int) -> Path:
        """File of a chunk."""
        return self.folder / f"part-{number:05d}.parquet"

    def _whole(self, number: int) -> bool:
        try:
            reducers, *_ = self._read(number, ["reducer", *self.names])
        except (OSError, ValueError, KeyError):
            return False
        return len(reducers) == self.study.span(number)[1]

    def _read(self, number: int, names: Sequence[str]) -> list[FloatArray]:
        """Columns of a chunk. Raises ``OSError``, ``ValueError`` or ``KeyError`` where they are not what was stored."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        path = self.path(number)
        if not path.is_file():
            raise FileNotFoundError(2, "No such file", str(path))
        try:
            table = pq.read_table(path, columns=list(names))
            columns = [table[name].to_numpy() for name in names]
        except pa.ArrowException as error:
            raise ValueError(str(error)) from None
        for name, column in zip(names, columns, strict=True):
            if (table.schema.field(name).metadata or {}).get(_DIGEST) != self._digest(number, name, column):
                raise ValueError(f"the checksum of {name} does not fit")
        return columns

    def _digest(self, number: int, name: str, values: np.ndarray) -> bytes:
        """Checksum of a column, which binds its numbers to their place."""
        place = f"{self.study.fingerprint} {number} {name} {values.dtype} "
        return hashlib.sha256(place.encode() + np.ascontiguousarray(values).tobytes()).hexdigest().encode()


def open_store(folder: Path, study: Study) -> Store:
    """The store of a study, after a claim: see ``Store.claimed``."""
    store = Store(folder, study, study.quantity_model.names)
    with store.claimed():
        return store


def _lock(folder: Path) -> int:
    """Handle of the locked folder, −1 where the system has no locks."""
    try:
        handle = lock(folder)
    except ImportError:
        return -1
    if handle is None:
        limit = "are being computed by another process"
        raise ToleranceError(
            "samples", f"in '{folder}'", limit, "wait for it, or choose another folder with --out", " "
        )
    return handle


def _read_header(path: Path) -> object:
    try:
        return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None
    except (OSError, ValueError, RecursionError):
        return None


def _not_written(path: Path, error: OSError) -> ToleranceError:
    limit = f"cannot be written ({error.strerror or error})"
    return ToleranceError("samples", f"'{path}'", limit, "choose another folder with --out", " ")
