"""The command line: one subcommand a file, one library call each.

Exit status 0 done, 1 a check failed, 2 bad input (one sentence, no traceback).
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from cyclopts import App, CycloptsError

from cycloid_profile.cli.accuracy import accuracy
from cycloid_profile.cli.build import build
from cycloid_profile.cli.catalog import catalog
from cycloid_profile.cli.compare import compare
from cycloid_profile.cli.correct import correct
from cycloid_profile.cli.diagnose import diagnose
from cycloid_profile.cli.export import export
from cycloid_profile.cli.simulate import simulate
from cycloid_profile.cli.tolerance import tolerance
from cycloid_profile.errors import CycloidError

EPILOGUE = "Example: cycloid-profile build examples/rv40e.toml"


def application() -> App:
    """The command line application with its subcommands."""
    app = App(
        name="cycloid-profile",
        help="Design, compensate and export the cycloid discs of RV reducers and cycloidal drives.",
        help_epilogue=EPILOGUE,
        help_format="plaintext",
        version_flags=["--version"],
    )
    for command in (build, accuracy, simulate, compare, diagnose, correct, tolerance, export, catalog):
        app.command(command, help_epilogue="")
    return app


def main(tokens: Sequence[str] | None = None) -> None:
    """Run the command line and exit with its status."""
    sys.exit(run(tokens))


def run(tokens: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit status."""
    try:
        status = application()(tokens, exit_on_error=False, print_error=False, result_action="return_value")
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
