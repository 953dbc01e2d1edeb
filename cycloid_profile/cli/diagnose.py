"""``cycloid-profile diagnose``: where measured files and simulation disagree, and which effect is missing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from cycloid_profile.cli.output._options import (
    AllowLarge,
    Columns,
    Force,
    Json,
    OutFolder,
    Pdf,
    Plugins,
    Quiet,
    check_pdf,
    keep_columns,
    output_folder,
    protection_of,
    read_files,
    read_with_plugins,
    require_files,
)
from cycloid_profile.cli.output._terminal import print_places, print_tables, print_text, printed_as_json, progress

if TYPE_CHECKING:
    from cycloid_profile.export.writing import Protection


def diagnose(
    spec: Path,
    /,
    *data: Path,
    out: OutFolder = None,
    json: Json = None,
    disc: Annotated[int | None, Parameter(help="Scanned disc, default from key `specimen`, else 1.")] = None,
    held_out: Annotated[
        tuple[Path, ...], Parameter(help="Measured file for validation only, for example of a second specimen.")
    ] = (),
    columns: Columns = (),
    against: Annotated[
        tuple[Path, ...],
        Parameter(consume_multiple=True, help="Files of the same specimen before: run-in, preload, regrinding."),
    ] = (),
    plan: Annotated[bool, Parameter(help="Print the effect sizes each measurement can detect; needs no data.")] = False,
    pdf: Pdf = False,
    force: Force = False,
    allow_large: AllowLarge = False,
    plugin: Plugins = (),
    quiet: Quiet = False,
) -> int:
    """Compare measured files with the simulation, name the missing effect and print the gap before and after.

    Example: cycloid-profile diagnose examples/rv40e.toml scan.csv te_rated.csv loop.csv --out diagnosis

    Parameters
    ----------
    spec
        Spec file (TOML); it is not changed.
    data
        Measured files (CSV), also of other programs, explained together.
    """
    check_pdf(pdf)
    protection = protection_of(force, spec, *data, *held_out, *against, *plugin, json=json)
    if plan:
        folder = output_folder(out, spec, protection, writes=["diagnosis/plan.png"]) / "diagnosis"
        return _plan_measurements(spec, plugin, folder, protection, quiet, allow_large)
    require_files(data, "measured files")
    from cycloid_profile.design import as_built_reducer
    from cycloid_profile.diagnosis import compare_diagnoses, require_new_rows
    from cycloid_profile.diagnosis import diagnose as diagnose_files
    from cycloid_profile.report import REPORT
    from cycloid_profile.report.diagnosis import write_diagnosis

    wanted = read_with_plugins(spec, plugin)
    folder = output_folder(out, spec, protection, "diagnosis", writes=[REPORT])
    with progress(quiet, allow_large) as show_step:
        measured = read_files([*data, *held_out, *against], columns, wanted, show_step)
        measured, checks, earlier = (
            measured[: len(data)],
            measured[len(data) : len(data) + len(held_out)],
            measured[len(data) + len(held_out) :],
        )
        require_new_rows(earlier, measured)
        show_step("building the reducer")
        reducer = as_built_reducer(wanted)
        discs = None if disc is None else [disc - 1] * len(measured)
        result = diagnose_files(reducer, measured, discs, checks, show_step)
        changes = None
        if earlier:
            show_step("diagnosing the files before")
            known = None if disc is None else [disc - 1] * len(earlier)
            changes = compare_diagnoses(diagnose_files(reducer, earlier, known, (), show_step), result, show_step)
        files = {file.name: file.read_bytes() for file in data}
        written = write_diagnosis(result, wanted.name, spec, files, folder, show_step, changes, protection, pdf)
    keep_columns([*data, *held_out, *against], columns, quiet)
    if not printed_as_json(written.values, json, protection):
        _print_diagnosis(written.values, wanted.name, (*result.notes, *(changes.notes if changes is not None else ())))
        print_places("", f"report: {written.report}")
        if written.spec is not None:
            print_places(f"spec with the effects: {written.spec}")
    return 0


def _print_diagnosis(values: Mapping[str, Any], name: str, notes: Sequence[str]) -> None:
    """Verdict, tables and notes of a diagnosis."""
    from cycloid_profile.report.diagnosis import VERDICTS, change_tables, diagnosis_tables

    print_places(f"{name}: {VERDICTS[values['verdict']]}", "")
    print_tables([*diagnosis_tables(values), *(change_tables(values["against"]) if "against" in values else [])])
    for note in notes:
        print_text(f"note: {note}")


def _plan_measurements(
    spec: Path, plugin: Sequence[str], folder: Path, protection: Protection, quiet: bool, allow_large: bool
) -> int:
    from cycloid_profile.design import as_built_reducer
    from cycloid_profile.diagnosis import detectability
    from cycloid_profile.report.diagnosis import plan_tables, save_plan_plot

    wanted = read_with_plugins(spec, plugin)
    with progress(quiet, allow_large) as show_step:
        rows = detectability(as_built_reducer(wanted), show_step)
        picture = save_plan_plot(rows, wanted.name, folder, protection)
    print_tables(plan_tables(rows, wanted.name))
    print_places("", f"picture: {picture}")
    return 0
