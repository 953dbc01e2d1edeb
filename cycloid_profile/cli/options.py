"""Options that several subcommands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

OutFolder = Annotated[Path | None, Parameter(help="Output folder, default exports/NAME of the spec file.")]
Json = Annotated[bool, Parameter(negative=(), help="Print the result as one JSON object.")]
