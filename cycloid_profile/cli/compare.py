"""``cycloid-profile compare``: measured files minus the prediction of a spec."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cycloid_profile.cli._terminal import (
    Json,
    OutFolder,
    Plugins,
    output_folder,
    print_json,
    print_tables,
    progress,
    read_with_plugins,
    require_files,
)


def compare(
    spec: Path,
    /,
    *data: Path,
    out: OutFolder = None,
    disc: Annotated[int, Parameter(help="Disc that was scanned, 1 for the first.")] = 1,
    json: Json = False,
    plugin: Plugins = (),
) -> int:
    """Compare measured files with the prediction of the spec and its [[effects]], and draw the differences.

    Example: cycloid-profile compare examples/rv40e.toml scan.csv loop.csv

    Parameters
    ----------
    spec
        Spec file (TOML).
    data
        Measured files (CSV).
    """
    from cycloid_profile.design import as_built_reducer
    from cycloid_profile.measurement import read_measurement
    from cycloid_profile.report import comparison_table, comparison_to_json, write_comparison

    require_files(data, "measured files")
    folder = output_folder(out, spec) / "compare"
    with progress() as show_step:
        wanted = read_with_plugins(spec, plugin)
        measured = [read_measurement(file) for file in data]
        show_step("building the reducer")
        compared = write_comparison(as_built_reducer(wanted), wanted.name, measured, folder, disc - 1, show_step)
    if json:
        print_json(comparison_to_json(wanted.name, compared))
    else:
        print_tables([comparison_table(wanted.name, compared)])
        print(f"\npictures: {folder}")
    return 0
