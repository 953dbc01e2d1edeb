"""``cycloid-profile catalog``: the drives that come with the package."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cycloid_profile.cli.output._encoding import ascii_unless_unicode
from cycloid_profile.cli.output._options import Force, Json, Quiet, print_written_spec, protection_of, write_spec_file
from cycloid_profile.cli.output._terminal import print_tables, printed_as_json
from cycloid_profile.errors import SpecError


def catalog(
    name: str | None = None,
    /,
    *,
    out: Annotated[
        Path | None, Parameter(help="Write the drive as a spec file, and its JSON Schema next to it.")
    ] = None,
    json: Json = None,
    force: Force = False,
    quiet: Quiet = False,
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

    if name is None and out is not None:
        raise SpecError("--out", f"'{out}'", "needs a drive", "name one of 'cycloid-profile catalog'", " ")
    protection = protection_of(force, json=json)
    if name is None:
        drives = {n: catalog_drive(n) for n in catalog_names()}
        listed = {"schema": 1, "drives": {n: msgspec.to_builtins(d) for n, d in drives.items()}}
        if not printed_as_json(listed, json, protection):
            from cycloid_profile.report.design import drive_table

            print_tables([drive_table(drives)])
        return 0
    if out is not None:
        write_spec_file(catalog_text(name), out, protection)
    printed = printed_as_json({"schema": 1, **msgspec.to_builtins(catalog_drive(name))}, json, protection)
    if not printed and out is None:
        sys.stdout.write(ascii_unless_unicode(catalog_text(name)))
    if not printed and out is not None and not quiet:
        print_written_spec(out)
    return 0
