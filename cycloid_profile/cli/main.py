"""The command line: one subcommand a file, one library call each.

Exit status 0 done, 1 a check failed, 2 bad input (one sentence, no traceback), 128 + n ended by signal n, as of shells.
"""

from __future__ import annotations

import inspect
import os
import signal
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, TextIO

from cycloid_profile.cli.output._encoding import fit_streams, said, said_error
from cycloid_profile.cli.output._progress import command_words
from cycloid_profile.cli.output._terminal import with_json_file, without_language
from cycloid_profile.errors import CycloidError
from cycloid_profile.language import ENGLISH, chosen_language, use_language

if TYPE_CHECKING:
    from cyclopts import App

COMMANDS = (
    "build", "accuracy", "simulate", "compare", "diagnose", "correct", "inspect", "tolerance", "export", "catalog",
    "new",
)  # fmt: skip
EPILOGUE = """Example: cycloid-profile new --ratio 11 --outer-diameter 60 --material PLA --out my.toml

Then: cycloid-profile build my.toml --out exports/my

Language of every command: --language zh, or CYCLOID_PROFILE_LANGUAGE=zh"""
_SIGNALS = {"SIGINT": "interrupted by the keyboard", "SIGTERM": "asked to end", "SIGHUP": "its terminal was closed"}
_STANDARD_STREAMS = 3
_received: list[int] = []


def application(commands: Sequence[str] = COMMANDS) -> App:
    """The command line application with these subcommands."""
    from cyclopts import App, Parameter

    from cycloid_profile.cli.output._options import option_value

    app = App(
        name="cycloid-profile",
        help="Design, compensate and export the cycloid discs of RV reducers and cycloidal drives.",
        help_epilogue=EPILOGUE,
        help_format="plaintext",
        version_flags=["--version"],
        suppress_keyboard_interrupt=False,
        # The defaults of a switch and of an empty list need not be shown.
        default_parameter=Parameter(negative=(), show_default=False, converter=option_value),
    )
    if chosen_language() != ENGLISH:
        from cycloid_profile.cli.output._help import TranslatedHelp, translated_paragraphs

        app.help_formatter, app.help_epilogue = TranslatedHelp(), translated_paragraphs(EPILOGUE)
    for command in commands:
        function = getattr(import_module(f"cycloid_profile.cli.{command}"), command)
        app.command(function, help_epilogue="", usage=_usage(command, function))
    if len(commands) > 1:
        app.register_install_completion_command(help="Complete commands and options in this shell, from now on.")
    return app


def _usage(name: str, function: Callable[..., int]) -> str:
    """Usage of a command: its files by name, repeated ones with an ellipsis, optional ones in brackets."""
    kinds = inspect.Parameter
    words = ["Usage: cycloid-profile", name, "[OPTIONS]"]
    for one in inspect.signature(function).parameters.values():
        if one.kind is kinds.VAR_POSITIONAL:
            words.append(f"{one.name.upper()}...")
        elif one.kind is kinds.POSITIONAL_ONLY:
            words.append(one.name.upper() if one.default is kinds.empty else f"[{one.name.upper()}]")
    return " ".join(words)


def main(tokens: Sequence[str] | None = None) -> None:
    """Run the command line and exit with its status."""
    _open_standard_streams()
    for name in _SIGNALS:
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _stop)
    status = _flushed(run(tokens))
    if _received:
        # Threads that still compute would be waited for at the end of the interpreter.
        os._exit(status)
    sys.exit(status)


def run(tokens: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit status."""
    fit_streams()
    given, language = without_language(sys.argv[1:] if tokens is None else tokens)
    try:
        with use_language(language):
            return _run(given)
    except CycloidError as error:
        return _refuse(*error.sentences, status=error.exit_code)


def _run(given: list[str]) -> int:
    earlier = len(_written())
    try:
        return _answer(given)
    except BrokenPipeError:
        return _broken_pipe()
    except SystemExit as end:
        # Tables are printed by a library that ends the process itself when the reader has left.
        if isinstance(end.__context__, BrokenPipeError):
            return _broken_pipe()
        raise
    except CycloidError as error:
        return _stopped(earlier) if _received else _refuse(*said_error(error), status=error.exit_code)
    except MemoryError:
        sentence = "the memory of this machine is too small for this: ask for fewer points, pins or samples"
        return _refuse(said(sentence, sys.stderr), status=2)
    except OSError as error:
        what = "the result cannot be printed" if error.filename is None else f"'{error.filename}' cannot be used"
        return _refuse(said(f"{what} ({error.strerror})", sys.stderr), status=2)
    except KeyboardInterrupt as error:
        return _stopped(earlier, *error.args[:1])
    except Exception:
        # Libraries written in C turn an interrupt of their import into an error of their own.
        if _received:
            return _stopped(earlier)
        raise


def _answer(given: list[str]) -> int:
    from cyclopts import CycloptsError

    # The module of a command is imported when it is used; all are for the overview and to suggest a near name.
    command_words.set(tuple(given))
    commands = given[:1] if given and given[0] in COMMANDS else COMMANDS
    try:
        status = application(commands)(
            with_json_file(given), exit_on_error=False, print_error=False, result_action="return_value"
        )
    except CycloptsError as error:
        return _refuse(said(str(error), sys.stderr), status=2)
    return status if isinstance(status, int) else 0


def _stop(number: int, _: FrameType | None) -> None:
    _received.append(number)
    raise KeyboardInterrupt


def _stopped(earlier: int, state: str = "nothing was written, files of earlier runs are as they were") -> int:
    """Status and sentence after a signal: which files are there, after those of ``earlier`` commands."""
    number = _received[0] if _received else signal.SIGINT
    if fresh := dict.fromkeys(_written()[earlier:]):
        state = f"the new files in {' and '.join(repr(str(one)) for one in fresh)} are whole"
    return _refuse(said(f"{_SIGNALS[signal.Signals(number).name]}: {state}", sys.stderr), status=128 + number)


def _written() -> tuple[Path, ...]:
    """Folders that received files; asked without loading the room that writes them."""
    room = sys.modules.get("cycloid_profile.export.writing.folder")
    return () if room is None else room.written_folders()


def _refuse(*sentences: str, status: int) -> int:
    try:
        for sentence in sentences:
            print(f"cycloid-profile: {' '.join(sentence.split())}", file=sys.stderr)
    except OSError:
        _let_go_of(sys.stderr)
    return status


def _open_standard_streams() -> None:
    """Open missing standard streams on nothing: the next file that is opened would receive what is printed."""
    handle = os.open(os.devnull, os.O_RDWR)
    while handle < _STANDARD_STREAMS:
        handle = os.open(os.devnull, os.O_RDWR)
    os.close(handle)
    sys.stdout = sys.stdout or open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, PTH123 - as long as the process
    sys.stderr = sys.stderr or open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, PTH123


def _flushed(status: int) -> int:
    """The status, after all that was printed has left the process."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        return _broken_pipe()
    except OSError as error:
        _let_go_of(sys.stdout)
        return _refuse(said(f"the result cannot be printed ({error.strerror})", sys.stderr), status=2)
    return status


def _broken_pipe() -> int:
    """The reader has left, as ``head`` does: the status that the shell gives a program ended by this signal."""
    _let_go_of(sys.stdout)
    return 128 + getattr(signal, "SIGPIPE", 13)


def _let_go_of(stream: TextIO) -> None:
    """What is still to be printed goes nowhere, without a message or another status at the end of the interpreter."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
