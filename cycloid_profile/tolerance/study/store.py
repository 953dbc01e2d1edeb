"""Results of a study on disk, one Parquet file per chunk, written atomically; an interrupted run resumes."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.errors import ToleranceError
from cycloid_profile.tolerance.study.chunks import Study

_STUDY = "study.json"


@dataclass(frozen=True)
class Store:
    """The files of one study in ``folder``: ``names`` of the columns, and the ``study`` they belong to."""

    folder: Path
    study: Study
    names: tuple[str, ...]

    def missing(self) -> list[int]:
        """Chunks that are not on disk yet."""
        return [number for number in range(self.study.chunks) if not self._whole(number)]

    def put(self, number: int, values: FloatArray) -> None:
        """Write the results of a chunk, shape (count, quantities); the file appears only when it is complete."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        first, count = self.study.span(number)
        columns = {"reducer": np.arange(first, first + count), **dict(zip(self.names, values.T, strict=True))}
        path = self.path(number)
        scratch = path.with_suffix(".partial")
        try:
            pq.write_table(pa.table(columns), scratch)
            scratch.replace(path)
        except OSError as error:
            raise _not_written(path, error) from None

    def columns(self, name: str) -> Iterator[FloatArray]:
        """One quantity, chunk by chunk in order, shape (count,)."""
        return (table[:, 0] for table in self.tables([name]))

    def tables(self, names: Sequence[str] | None = None) -> Iterator[FloatArray]:
        """The quantities ``names``, all unless given, chunk by chunk in order, shape (count, quantities)."""
        import pyarrow.parquet as pq

        some = list(self.names if names is None else names)
        for number in range(self.study.chunks):
            table = pq.read_table(self.path(number), columns=some)
            yield np.stack([table[name].to_numpy() for name in some], axis=1)

    def path(self, number: int) -> Path:
        """File of a chunk."""
        return self.folder / f"part-{number:05d}.parquet"

    def _whole(self, number: int) -> bool:
        import pyarrow as pa
        import pyarrow.parquet as pq

        path = self.path(number)
        try:
            return bool(path.is_file() and pq.read_metadata(path).num_rows == self.study.span(number)[1])
        except (OSError, pa.ArrowException):
            return False


def open_store(folder: Path, study: Study) -> Store:
    """The store of a study; files of another study in that folder are deleted.

    Raises ``ToleranceError`` if the folder cannot be made or written to.
    """
    names = study.quantity_model.names
    header: dict[str, Any] = {
        "schema": 1,
        "fingerprint": study.fingerprint,
        "columns": list(names),
        "chunk": study.chunk,
    }
    try:
        folder.mkdir(parents=True, exist_ok=True)
        path, store = folder / _STUDY, Store(folder, study, names)
        try:
            same = json.loads(path.read_text(encoding="utf-8")) == header
        except (OSError, ValueError):
            same = False
        kept = {store.path(number) for number in range(study.chunks)} if same else set()
        for old in set(folder.glob("part-*")) - kept:
            old.unlink()
        if not same:
            path.write_text(json.dumps(header, indent=1) + "\n", encoding="utf-8", newline="\n")
    except OSError as error:
        raise _not_written(folder, error) from None
    return store


def _not_written(path: Path, error: OSError) -> ToleranceError:
    limit = f"cannot be written ({error.strerror or error})"
    return ToleranceError("samples", f"'{path}'", limit, "choose another folder with --out", " ")
