"""What the terminal shows: progress on stderr, tables or JSON on stdout."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any


@contextmanager
def progress() -> Iterator[Callable[[str], None]]:
    """A line on stderr that tells the step under way; plain lines where stderr is no terminal."""
    from rich.console import Console

    console = Console(stderr=True, highlight=False, markup=False)
    if not console.is_terminal:
        yield lambda step: print(f"… {step}", file=sys.stderr, flush=True)
        return
    with console.status("") as status:
        yield lambda step: status.update(step)


def print_json(value: dict[str, Any]) -> None:
    """One JSON object on stdout."""
    print(json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False))


def print_table(title: str, columns: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> None:
    """A table on stdout, the first column left, the others right."""
    from rich.console import Console
    from rich.table import Table

    table = Table(title=title, title_justify="left", box=None, pad_edge=False, padding=(0, 3, 0, 0))
    for i, column in enumerate(columns):
        table.add_column(column, justify="left" if i == 0 else "right", no_wrap=i > 0, overflow="fold")
    for row in rows:
        table.add_row(*row)
    # A pipe has no width of its own: nothing is folded there.
    width = None if sys.stdout.isatty() else 400
    Console(highlight=False, markup=False, width=width).print(table)


def output_folder(out: Path | None, spec_file: Path) -> Path:
    """The folder asked for, or exports/NAME, NAME being the spec file's without its ending."""
    return Path("exports") / spec_file.stem if out is None else out


def warn(sentence: str) -> None:
    """A sentence on stderr."""
    print(f"cycloid-profile: {sentence}", file=sys.stderr)
