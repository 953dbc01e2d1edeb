"""``cycloid-profile catalog``: the drives that come with the package."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cycloid_profile.cli._terminal import Json, print_json, print_tables
from cycloid_profile.errors import SpecError


def catalog(
    name: str | None = None,
    /,
    *,
    out: Annotated[
        Path | None, Parameter(help="Write the drive as a spec file, and its JSON Schema next to it.")
    ] = None,
    json: Json = False,
) -> int:
    """List the published drives, or print one as a spec file with its source.

    Example: cycloid-profile catalog rv80e --out rv80e.toml

    Parameters
    ----------
    name
        Drive to print, default: list all.
    """
    import msgspec

    from cycloid_profile.catalog import catalog_drive, catalog_names, catalog_text
    from cycloid_profile.report.design import drive_table

    if name is None and out is not None:
        raise SpecError("--out", f"'{out}'", "needs a drive", "name one of 'cycloid-profile catalog'", " ")
    if name is None:
        drives = {n: catalog_drive(n) for n in catalog_names()}
        if json:
            print_json({"schema": 1, "drives": {n: msgspec.to_builtins(d) for n, d in drives.items()}})
            return 0
        print_tables([drive_table(drives)])
        return 0
    if json:
        print_json({"schema": 1, **msgspec.to_builtins(catalog_drive(name))})
    elif out is None:
        sys.stdout.write(catalog_text(name))
    if out is not None:
        _write_with_schema(name, out)
    return 0


def _write_with_schema(name: str, out: Path) -> None:
    from cycloid_profile.catalog import catalog_text
    from cycloid_profile.export.writing import atomic_folder
    from cycloid_profile.spec import SCHEMA_FILE, spec_schema

    with atomic_folder(out.parent) as scratch:
        (scratch / out.name).write_text(catalog_text(name), encoding="utf-8", newline="\n")
        (scratch / SCHEMA_FILE).write_text(spec_schema(), encoding="utf-8", newline="\n")
