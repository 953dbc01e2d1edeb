"""Progress and warnings on stderr, tables or JSON on stdout."""

from __future__ import annotations

import os
import shutil
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cycloid_profile.cli.output._encoding import encodes_unicode, printable, said
from cycloid_profile.language import ENGLISH, VARIABLE
from cycloid_profile.resources import resource_limits

if TYPE_CHECKING:
    from cycloid_profile.articles import PlainTable
    from cycloid_profile.cli.output._progress import Steps
    from cycloid_profile.export.writing import Protection

_HEARTBEAT = 20.0  # s after which a step that still lasts is shown again

INPUTS = (".toml", ".csv")  # ends of files that are read


@contextmanager
def progress(quiet: bool = False, allow_large: bool = False) -> Iterator[Callable[[str], None]]:
    """A line on stderr with the current step and the time to go; plain lines where stderr is no terminal.

    Nothing is shown if ``quiet``. What needs much is stated, and refused above the limits unless ``allow_large``.
    """
    with _shown_steps(quiet) as show, resource_limits(allow_large, (lambda _: None) if quiet else warn):
        yield show


@contextmanager
def _shown_steps(quiet: bool) -> Iterator[Callable[[str], None]]:
    if quiet:
        yield lambda _: None
        return
    from rich.console import Console

    from cycloid_profile.cli.output._progress import Steps, keep_durations, known_durations

    console = Console(stderr=True, highlight=False, markup=False)
    steps = Steps(known_durations())
    if console.is_terminal:
        # The spinner and a blank stand before the text.
        with console.status(_Live(lambda: steps.text(console.width - 3))):
            yield steps.show
    else:
        with _lines(steps) as show:
            yield show
    keep_durations(steps.finish())


@contextmanager
def _lines(steps: Steps) -> Iterator[Callable[[str], None]]:
    """A line for each step, and another one with its time whenever it lasts."""
    shown = [time.monotonic()]
    ended = threading.Event()

    def print_line() -> None:
        shown[0] = time.monotonic()
        print(f"… {steps.text()}", file=sys.stderr, flush=True)

    def next_step(step: str) -> None:
        steps.show(step)
        print_line()

    def beat() -> None:
        while not ended.wait(_HEARTBEAT):
            if steps.step and time.monotonic() - shown[0] >= _HEARTBEAT:
                with suppress(OSError, ValueError):
                    print_line()

    beating = threading.Thread(target=beat, daemon=True)
    beating.start()
    try:
        yield next_step
    finally:
        ended.set()
        beating.join()


class _Live:
    """A text that is made again whenever it is drawn."""

    def __init__(self, text: Callable[[], str]) -> None:
        self._text = text

    def __rich__(self) -> str:
        return self._text()


def with_json_file(tokens: Sequence[str]) -> list[str]:
    """The words of a command line with the file of ``--json`` in one word; ``-`` stands for standard output.

    ``--json FILE`` is a file where it ends in ``.json`` or stands last, unless it is a spec or a measured file.
    """
    words, rest = list[str](), list(tokens)
    while rest:
        word = rest.pop(0)
        if word == "--json":
            following = rest[0] if rest else ""
            last = len(rest) == 1 and not following.startswith("-") and not following.endswith(INPUTS)
            named = following == "-" or following.lower().endswith(".json")
            word = f"--json={rest.pop(0) if named or last else '-'}"
        words.append(word)
    return words


def without_language(tokens: Sequence[str]) -> tuple[list[str], str]:
    """The words of a command line without ``--language CODE``, and the code; else that of the environment."""
    words, rest = list[str](), list(tokens)
    code = os.environ.get(VARIABLE, "") or ENGLISH
    while rest:
        word = rest.pop(0)
        if word == "--language":
            code = rest.pop(0) if rest else ""
        elif word.startswith("--language="):
            code = word.removeprefix("--language=")
        else:
            words.append(word)
    return words, code


def printed_as_json(value: dict[str, Any], file: Path | None, protection: Protection) -> bool:
    """Print or write the result as ``--json`` asks; True where it was printed and tables are not wanted.

    Raises ``ExportError`` where ``protection`` keeps ``file``.
    """
    if file is None:
        return False
    if str(file) == "-":
        print_json(value)
        return True
    from cycloid_profile.report.diagnosis import write_json

    write_json(file, value, protection)
    return False


def print_json(value: dict[str, Any]) -> None:
    """One JSON object on stdout."""
    import json

    print(json.dumps(value, indent=1, ensure_ascii=not encodes_unicode(), allow_nan=False))


def terminal_width() -> int | None:
    """Width of the terminal on stdout [cells]; None for a pipe or a file, which have none."""
    return shutil.get_terminal_size().columns if sys.stdout.isatty() else None


def print_tables(tables: Iterable[PlainTable]) -> None:
    """Tables on stdout, a blank line between them, in the width of the terminal."""
    from cycloid_profile.cli.output._tables import table_lines

    width = terminal_width()
    for number, table in enumerate(tables):
        if number:
            print()
        print_text(table.title)
        # In the language and the signs of the terminal first: their words are longer.
        plain = replace(
            table,
            head=tuple(printable(said(cell)) for cell in table.head),
            rows=tuple(tuple(printable(said(cell)) for cell in row) for row in table.rows),
        )
        print(*table_lines(plain, width), sep="\n")
        if table.note:
            print_text(table.note)


def print_text(*sentences: str) -> None:
    """Sentences on stdout, each on lines of its own, folded at blanks in a terminal."""
    from cycloid_profile.cli.output._tables import fold

    width = terminal_width()
    for sentence in map(said, sentences):
        print(*([sentence] if width is None else fold(printable(sentence), width)), sep="\n")


def hint(*sentences: str, quiet: bool) -> None:
    """Sentences on stderr that a ``quiet`` command leaves out: they change no result."""
    if not quiet:
        warn(*sentences)


def print_places(*sentences: str) -> None:
    """Sentences with names of files on stdout, each on one line, so that a name stays whole."""
    for sentence in sentences:
        print(said(sentence))


def warn(*sentences: str) -> None:
    """Sentences on stderr."""
    for sentence in sentences:
        print(f"cycloid-profile: {said(sentence, sys.stderr)}", file=sys.stderr)
