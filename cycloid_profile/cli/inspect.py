"""``cycloid-profile inspect``: pitch, runout and profile of a measured disc against its tolerances."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cycloid_profile.cli.output._options import (
    AllowLarge,
    Columns,
    Force,
    Json,
    Pdf,
    Plugins,
    Quiet,
    check_pdf,
    keep_columns,
    output_folder,
    protection_of,
    read_files,
    read_with_plugins,
)
from cycloid_profile.cli.output._terminal import print_places, print_tables, print_text, printed_as_json, progress


def inspect(
    spec: Path,
    scan: Path,
    /,
    *,
    out: Annotated[
        Path | None, Parameter(help="Output folder, default exports/NAME/inspect, NAME of the spec file.")
    ] = None,
    columns: Columns = (),
    json: Json = None,
    pdf: Pdf = False,
    force: Force = False,
    allow_large: AllowLarge = False,
    plugin: Plugins = (),
    quiet: Quiet = False,
) -> int:
    """Evaluate a profile scan: f_p, F_p, F_r and the profile band of every flank; status 1 if a check fails.

    Example: cycloid-profile inspect examples/rv40e.toml scan.csv --out inspection

    Parameters
    ----------
    spec
        Spec file (TOML); tolerances of `[export.inspection]` or `[export.drawing]`, else by its `quality`.
    scan
        Profile scan of the whole disc (CSV), also of another program.
    """
    from cycloid_profile.design import design_disc
    from cycloid_profile.report import INSPECTION_PAGE, inspection_table, inspection_to_json, write_inspection

    check_pdf(pdf)
    protection = protection_of(force, spec, scan, *plugin, json=json)
    folder = output_folder(out, spec, protection, "inspect", writes=[INSPECTION_PAGE])
    with progress(quiet, allow_large) as show_step:
        wanted = read_with_plugins(spec, plugin)
        (measured,) = read_files([scan], columns, wanted, show_step)
        show_step("computing the nominal tooth")
        record = design_disc(wanted)
        show_step(f"evaluating {measured.name}")
        result = write_inspection(record, measured, folder, protection, pdf)
    keep_columns([scan], columns, quiet)
    if not printed_as_json(inspection_to_json(wanted.name, result), json, protection):
        print_tables([inspection_table(wanted.name, result)])
        for note in result.scan.notes:
            print_text(f"note: {measured.name}: {note}")
        print_places("", f"written: {folder}")
    return 0 if result.passed else 1
