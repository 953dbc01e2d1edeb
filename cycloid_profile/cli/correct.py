"""``cycloid-profile correct``: the disc that cancels the errors found in scans, in every format of a design."""

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
    require_files,
)
from cycloid_profile.cli.output._terminal import (
    hint,
    print_places,
    print_tables,
    print_text,
    printed_as_json,
    progress,
    warn,
)
from cycloid_profile.spec.model import Format


def correct(
    spec: Path,
    /,
    *scans: Path,
    out: Annotated[
        Path | None, Parameter(help="Output folder, default exports/NAME/correct, NAME of the spec file.")
    ] = None,
    disc: Annotated[int | None, Parameter(help="Scanned disc, default from key `specimen`, else 1.")] = None,
    limit_um: Annotated[
        float, Parameter(help="Largest allowed deviation from the nominal tooth [µm].", show_default=True)
    ] = 10.0,
    wheel_radius_mm: Annotated[
        float | None, Parameter(help="Radius of the grinding wheel [mm], default that of the generating pin.")
    ] = None,
    remainder: Annotated[
        bool, Parameter(help="Cancel a smooth remainder, too: fitted to the scan, not explained.")
    ] = False,
    format: Annotated[
        tuple[Format, ...],
        Parameter(help="Formats of the corrected disc, as in export.", show_default=" ".join, consume_multiple=True),
    ] = ("csv", "gcode"),
    columns: Columns = (),
    json: Json = None,
    pdf: Pdf = False,
    force: Force = False,
    allow_large: AllowLarge = False,
    plugin: Plugins = (),
    quiet: Quiet = False,
) -> int:
    """Write the disc that cancels the errors found in scans of it, and the expected scan.

    Example: cycloid-profile correct examples/rv40e.toml scan.csv --limit-um 5 --out correction --format csv gcode step

    Parameters
    ----------
    spec
        Spec file (TOML); the flank errors of this disc in its [[effects]] are cancelled, too.
    scans
        Profile scans of one disc (CSV), also of other programs.
    """
    from cycloid_profile.export import ascii_name_notes
    from cycloid_profile.report.diagnosis import CORRECTION_PAGE, correct_scans, correction_sentences, correction_tables

    check_pdf(pdf)
    require_files(scans, "profile scans")
    protection = protection_of(force, spec, *scans, *plugin, json=json)
    folder = output_folder(out, spec, protection, "correct", writes=[CORRECTION_PAGE])
    with progress(quiet, allow_large) as show_step:
        wanted = read_with_plugins(spec, plugin)
        values, reason, status = correct_scans(
            wanted,
            read_files(scans, columns, wanted, warn),
            folder,
            disc=None if disc is None else disc - 1,
            limit_um=limit_um,
            wheel_radius=wheel_radius_mm,
            remainder=remainder,
            formats=tuple(dict.fromkeys(format)),
            progress=show_step,
            protection=protection,
            pdf=pdf,
        )
    keep_columns(scans, columns, quiet)
    printed = printed_as_json(values, json, protection)
    if status and reason is not None:
        warn(reason)
    elif not printed and reason is not None:
        print_places(f"{values['name']}: {reason}")
    elif not printed:
        print_tables(correction_tables(values))
        print_text("", *correction_sentences(values), "", f"written: {folder}")
    if values["files"]:
        hint(*ascii_name_notes(wanted, format), quiet=quiet)
    warn(*(f"{name} is not written: {reason}" for name, reason in values["skipped"].items()))
    return status or int(not values["skipped"].keys().isdisjoint(format))
