"""Answers of a study on disk, a Parquet file a chunk: written whole as they come, found again after a break."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.errors import ToleranceError
from cycloid_profile.tolerance.study import Study

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
        """Write the answers of a chunk, shape (count, quantities); the file appears when it is whole."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        first, count = self.study.span(number)
        columns = {"reducer": np.arange(first, first + count), **dict(zip(self.names, values.T, strict=True))}
        path = self._path(number)
        scratch = path.with_suffix(".partial")
        try:
            pq.write_table(pa.table(columns), scratch)
            scratch.replace(path)
        except OSError as error:
            raise _not_written(path, error) from None

    def columns(self, name: str) -> Iterator[FloatArray]:
        """One quantity, chunk by chunk in order."""
        import pyarrow.parquet as pq

        for number in range(self.study.chunks):
            yield pq.read_table(self._path(number), columns=[name])[name].to_numpy()

    def tables(self) -> Iterator[FloatArray]:
        """All quantities, chunk by chunk in order, shape (count, quantities)."""
        import pyarrow.parquet as pq

        for number in range(self.study.chunks):
            table = pq.read_table(self._path(number), columns=list(self.names))
            yield np.stack([table[name].to_numpy() for name in self.names], axis=1)

    def _path(self, number: int) -> Path:
        return self.folder / f"part-{number:05d}.parquet"

    def _whole(self, number: int) -> bool:
        import pyarrow as pa
        import pyarrow.parquet as pq

        path = self._path(number)
        try:
            return bool(path.is_file() and pq.read_metadata(path).num_rows == self.study.span(number)[1])
        except (OSError, pa.ArrowException):
            return False


def open_store(folder: Path, study: Study) -> Store:
    """The store of a study; files of another study in that folder are taken away.

    Raises ``ToleranceError`` if the folder cannot be made or written to.
    """
    names = study.measures.names
    told: dict[str, Any] = {"schema": 1, "fingerprint": study.fingerprint, "columns": list(names), "chunk": study.chunk}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / _STUDY
        try:
            known = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            known = None
        if known != told:
            for old in folder.glob("part-*"):
                old.unlink()
            path.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8", newline="\n")
        parts = {f"part-{number:05d}.parquet" for number in range(study.chunks)}
        for old in folder.glob("part-*"):
            if old.name not in parts:
                old.unlink()
    except OSError as error:
        raise _not_written(folder, error) from None
    return Store(folder, study, names)


def _not_written(path: Path, error: OSError) -> ToleranceError:
    return ToleranceError(
        "samples",
        f"'{path}'",
        f"cannot be written ({error.strerror or error})",
        "choose another folder with --out",
        " ",
    )
