"""``cycloid-profile compare``: measured files minus the prediction of a spec."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cycloid_profile.cli.output._options import (
    AllowLarge,
    Columns,
    Force,
    Json,
    OutFolder,
    Plugins,
    Quiet,
    keep_columns,
    output_folder,
    protection_of,
    read_files,
    read_with_plugins,
    require_files,
)
from cycloid_profile.cli.output._terminal import print_places, print_tables, print_text, printed_as_json, progress


def compare(
    spec: Path,
    /,
    *data: Path,
    out: OutFolder = None,
    disc: Annotated[int, Parameter(help="Disc that was scanned, 1 for the first.", show_default=True)] = 1,
    columns: Columns = (),
    json: Json = None,
    force: Force = False,
    allow_large: AllowLarge = False,
    plugin: Plugins = (),
    quiet: Quiet = False,
) -> int:
    """Compare figures and curves of measured files with the prediction of the spec and its [[effects]].

    Example: cycloid-profile compare examples/rv40e.toml scan.csv loop.csv --out exports/rv40e

    Parameters
    ----------
    spec
        Spec file (TOML).
    data
        Measured files (CSV), also of other programs.
    """
    from cycloid_profile.design import as_built_reducer
    from cycloid_profile.report import comparison_table, comparison_to_json, figure_tables, write_comparison

    require_files(data, "measured files")
    protection = protection_of(force, spec, *data, *plugin, json=json)
    folder = output_folder(out, spec, protection) / "compare"
    with progress(quiet, allow_large) as show_step:
        wanted = read_with_plugins(spec, plugin)
        measured = read_files(data, columns, wanted, show_step)
        show_step("building the reducer")
        reducer = as_built_reducer(wanted)
        compared = write_comparison(reducer, wanted, measured, folder, disc - 1, show_step, protection)
    keep_columns(data, columns, quiet)
    if not printed_as_json(comparison_to_json(wanted.name, compared), json, protection):
        print_tables([comparison_table(wanted.name, compared), *figure_tables(compared)])
        for measurement in (one.residual.measurement for one in compared):
            for note in measurement.notes:
                print_text(f"note: {measurement.name}: {note}")
        print_places("", f"pictures: {folder}")
    return 0
