"""``cycloid-profile diagnose``: where measured files and simulation disagree, and which effect is missing."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cycloid_profile.cli._terminal import (
    OutFolder,
    Plugins,
    output_folder,
    print_json,
    print_tables,
    progress,
    read_with_plugins,
    require_files,
)


def diagnose(
    spec: Path,
    /,
    *data: Path,
    out: OutFolder = None,
    json: Annotated[
        Path | None,
        Parameter(allow_leading_hyphen=True, help="File for the result as one JSON object; - prints it, no tables."),
    ] = None,
    disc: Annotated[int | None, Parameter(help="Scanned disc, default from key `specimen`, else 1.")] = None,
    held_out: Annotated[
        tuple[Path, ...], Parameter(help="Measured file for validation only, for example of a second specimen.")
    ] = (),
    plan: Annotated[
        bool, Parameter(negative=(), help="Print the effect sizes each measurement can detect; needs no data.")
    ] = False,
    plugin: Plugins = (),
) -> int:
    """Compare measured files with the simulation, name the missing effect and print the gap before and after.

    Example: cycloid-profile diagnose examples/rv40e.toml scan.csv te_rated.csv loop.csv

    Parameters
    ----------
    spec
        Spec file (TOML); it is not changed.
    data
        Measured files (CSV), explained together.
    """
    if plan:
        return _plan_measurements(spec, plugin, output_folder(out, spec) / "diagnosis")
    require_files(data, "measured files")
    from cycloid_profile.design import as_built_reducer
    from cycloid_profile.diagnosis import diagnose as diagnose_files
    from cycloid_profile.diagnosis import diagnosis_to_json as diagnosis_json
    from cycloid_profile.measurement import read_measurement
    from cycloid_profile.report.diagnosis import VERDICTS, diagnosis_tables, write_diagnosis, write_json

    wanted = read_with_plugins(spec, plugin)
    folder = output_folder(out, spec, "diagnosis")
    with progress() as show_step:
        measured = [read_measurement(file) for file in data]
        checks = [read_measurement(file) for file in held_out]
        show_step("building the reducer")
        reducer = as_built_reducer(wanted)
        discs = None if disc is None else [disc - 1] * len(measured)
        result = diagnose_files(reducer, measured, discs, checks, show_step)
        files = {file.name: file.read_bytes() for file in data}
        written = write_diagnosis(result, wanted.name, spec, files, folder, show_step)
    values = diagnosis_json(result, wanted.name)
    if json is not None and str(json) == "-":
        print_json(values)
        return 0
    if json is not None:
        write_json(json, values)
    print(f"{wanted.name}: {VERDICTS[result.verdict]}\n")
    print_tables(diagnosis_tables(values))
    for note in result.notes:
        print(f"note: {note}")
    print(f"\nreport: {written.report}")
    if written.spec is not None:
        print(f"spec with the effects: {written.spec}")
    return 0


def _plan_measurements(spec: Path, plugin: Sequence[str], folder: Path) -> int:
    from cycloid_profile.design import as_built_reducer
    from cycloid_profile.diagnosis import detectability
    from cycloid_profile.report.diagnosis import plan_tables, save_plan_plot

    wanted = read_with_plugins(spec, plugin)
    with progress() as show_step:
        rows = detectability(as_built_reducer(wanted), show_step)
        picture = save_plan_plot(rows, wanted.name, folder)
    print_tables(plan_tables(rows, wanted.name))
    print(f"\npicture: {picture}")
    return 0
