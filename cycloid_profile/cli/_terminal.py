"""Options that several commands share; progress and warnings on stderr, tables or JSON on stdout."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from cycloid_profile.errors import MeasurementError

if TYPE_CHECKING:
    from cycloid_profile.articles import PlainTable
    from cycloid_profile.spec import Spec

SpecFile = Annotated[Path, Parameter(help="Spec file (TOML).")]
OutFolder = Annotated[Path | None, Parameter(help="Output folder, default exports/NAME of the spec file.")]
Json = Annotated[bool, Parameter(negative=(), help="Print the result as one JSON object.")]

Plugins = Annotated[
    tuple[str, ...],
    Parameter(negative=(), help="Module or .py file with effects of your own; may be repeated."),
]


def read_with_plugins(spec: Path, plugins: Sequence[str]) -> Spec:
    """The spec file, after the plug-ins whose effects it may name; raises ``PluginError`` and ``SpecError``."""
    from cycloid_profile.spec import read_spec

    if plugins:
        from cycloid_profile.effects import load_plugins

        load_plugins(plugins)
    return read_spec(spec)


@contextmanager
def progress() -> Iterator[Callable[[str], None]]:
    """A line on stderr with the current step; plain lines where stderr is no terminal."""
    from rich.console import Console

    console = Console(stderr=True, highlight=False, markup=False)
    if not console.is_terminal:
        yield lambda step: print(f"… {step}", file=sys.stderr, flush=True)
        return
    with console.status("") as status:
        yield lambda step: status.update(step)


def print_json(value: dict[str, Any]) -> None:
    """One JSON object on stdout."""
    import json

    print(json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False))


def _print_table(title: str, columns: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> None:
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


def print_tables(tables: Iterable[PlainTable]) -> None:
    """Tables on stdout, a blank line between them."""
    for number, table in enumerate(tables):
        if number:
            print()
        _print_table(table.title, table.head, table.rows)
        if table.note:
            print(table.note)


def output_folder(out: Path | None, spec_file: Path, *inner: str) -> Path:
    """The folder given, or exports/NAME and ``inner`` folders with NAME of the spec file."""
    return Path("exports").joinpath(spec_file.stem, *inner) if out is None else out


def require_files(files: Sequence[Path], what: str) -> None:
    """Raises ``MeasurementError`` where no file was given."""
    if not files:
        raise MeasurementError(what, "none", "were given", "name at least one CSV file after the spec", " ")


def warn(*sentences: str) -> None:
    """Sentences on stderr."""
    for sentence in sentences:
        print(f"cycloid-profile: {sentence}", file=sys.stderr)
