"""Files that appear in a folder all together, or not at all."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from cycloid_profile.errors import ExportError


@contextmanager
def whole_or_nothing(folder: Path) -> Iterator[Path]:
    """A scratch folder whose files move into ``folder`` at the end, or vanish if anything fails.

    Every target is looked at before the first file moves, so that one that is taken stops them all.

    Raises
    ------
    ExportError
        If ``folder`` cannot be made or written to, or a target is taken by a folder.
    """
    # The folders that have to be made, innermost first: an attempt that fails takes them away again.
    made = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        scratch = Path(tempfile.mkdtemp(prefix=".partial-", dir=folder))
    except OSError as error:
        raise _refusal("output folder", str(folder), error.strerror) from None
    try:
        yield scratch
        moves = [(file, folder / file.relative_to(scratch)) for file in sorted(scratch.rglob("*")) if file.is_file()]
        for _, target in moves:
            if target.is_dir():
                raise _refusal("output file", str(target), "a folder has that name")
            target.parent.mkdir(parents=True, exist_ok=True)
        for file, target in moves:
            file.replace(target)
        made = []
    except OSError as error:
        named = error.filename2 or error.filename or folder
        raise _refusal("output file", str(named), error.strerror or str(error)) from None
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
        for path in made:
            if path.is_dir() and not any(path.iterdir()):
                path.rmdir()


def _refusal(what: str, path: str, reason: str | None) -> ExportError:
    return ExportError(what, f"'{path}'", f"cannot be written ({reason})", "choose another with --out", " ")
