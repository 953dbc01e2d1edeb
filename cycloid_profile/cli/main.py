"""The command line: one subcommand a file, one library call each.

Exit status 0 done, 1 a check failed, 2 bad input (one sentence, no traceback).
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module

from cyclopts import App, CycloptsError

from cycloid_profile.errors import CycloidError

COMMANDS = ("build", "accuracy", "simulate", "compare", "diagnose", "correct", "tolerance", "export", "catalog")
EPILOGUE = "Example: cycloid-profile build examples/rv40e.toml"


def application(commands: Sequence[str] = COMMANDS) -> App:
    """The command line application with these subcommands."""
    app = App(
        name="cycloid-profile",
        help="Design, compensate and export the cycloid discs of RV reducers and cycloidal drives.",
        help_epilogue=EPILOGUE,
        help_format="plaintext",
        version_flags=["--version"],
    )
    for command in commands:
        app.command(getattr(import_module(f"cycloid_profile.cli.{command}"), command), help_epilogue="")
    return app


def main(tokens: Sequence[str] | None = None) -> None:
    """Run the command line and exit with its status."""
    sys.exit(run(tokens))


def run(tokens: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit status."""
    given = sys.argv[1:] if tokens is None else list(tokens)
    # The module of a command is imported when it is used; all are for the overview and to suggest a near name.
    commands = given[:1] if given and given[0] in COMMANDS else COMMANDS
    try:
        status = application(commands)(given, exit_on_error=False, print_error=False, result_action="return_value")
    except CycloptsError as error:
        return _refuse(str(error), 2)
    except CycloidError as error:
        return _refuse(str(error), error.exit_code)
    except BrokenPipeError:
        return 0
    except OSError as error:
        return _refuse(f"the result cannot be printed ({error.strerror})", 2)
    except KeyboardInterrupt:
        return _refuse("interrupted by the keyboard, nothing was written", 130)
    return status if isinstance(status, int) else 0


def _refuse(sentence: str, status: int) -> int:
    print(f"cycloid-profile: {' '.join(sentence.split())}", file=sys.stderr)
    return status
