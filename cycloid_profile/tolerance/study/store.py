"""Results of a study on disk, one Parquet file per chunk, written atomically; an interrupted run resumes."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.errors import ToleranceError
from cycloid_profile.tolerance.study.chunks import Study

_STUDY = "study.json"
_OWN_PART = re.compile(r"part-\d{5,}\.(parquet|partial)")


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

    def claim(self) -> None:
        """Make the folder that of this study; files of another study in it are deleted.

        Raises ``ToleranceError`` if the folder cannot be made or written to.
        """
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            kept = {self.path(number) for number in range(self.study.chunks)} if self._is_same else set()
            for old in set(self.folder.glob("part-*")) - kept:
                if _OWN_PART.fullmatch(old.name) and old.is_file():
                    old.unlink()
            if not self._is_same:
                text = json.dumps(self._header, indent=1) + "\n"
                (self.folder / _STUDY).write_text(text, encoding="utf-8", newline="\n")
        except OSError as error:
            raise _not_written(self.folder, error) from None

    def put(self, number: int, values: FloatArray) -> None:
        """Write the results of a chunk, shape (count, quantities); the file appears only when it is complete."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        first, count = self.study.span(number)
        columns = {"reducer": np.arange(first, first + count), **dict(zip(self.names, values.T, strict=True))}
        path = self.path(number)
        scratch = path.with_suffix(".partial")
        try:
            pq.write_table(pa.table(columns), scratch, write_page_checksum=True)
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
            try:
                table = pq.read_table(self.path(number), columns=some, page_checksum_verification=True)
                values = np.stack([table[name].to_numpy() for name in some], axis=1)
            except (OSError, ValueError, KeyError) as error:
                limit = f"was changed while the study ran ({str(error).splitlines()[0]})"
                raise ToleranceError("samples", f"'{self.path(number)}'", limit, "run it again", " ") from None
            yield values

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
        import pyarrow as pa
        import pyarrow.parquet as pq

        path = self.path(number)
        try:
            if not path.is_file():
                return False
            first, count = self.study.span(number)
            table = pq.read_table(path, page_checksum_verification=True)
        except (OSError, pa.ArrowException, ValueError):
            return False
        whole = set(table.column_names) == {"reducer", *self.names} and table.num_rows == count
        return whole and bool(np.array_equal(table["reducer"].to_numpy(), np.arange(first, first + count)))


def open_store(folder: Path, study: Study) -> Store:
    """The store of a study, claimed: see ``Store.claim``."""
    store = Store(folder, study, study.quantity_model.names)
    store.claim()
    return store


def _read_header(path: Path) -> object:
    try:
        return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None
    except (OSError, ValueError, RecursionError):
        return None


def _not_written(path: Path, error: OSError) -> ToleranceError:
    limit = f"cannot be written ({error.strerror or error})"
    return ToleranceError("samples", f"'{path}'", limit, "choose another folder with --out", " ")
