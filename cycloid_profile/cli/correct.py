"""``cycloid-profile correct``: the grinding path that cancels the errors found in scans of a disc."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cycloid_profile.cli._terminal import (
    Json,
    Plugins,
    output_folder,
    print_json,
    print_tables,
    progress,
    read_with_plugins,
    require_files,
    warn,
)


def correct(
    spec: Path,
    /,
    *scans: Path,
    out: Annotated[
        Path | None, Parameter(help="Output folder, default exports/NAME/correct, NAME of the spec file.")
    ] = None,
    disc: Annotated[int | None, Parameter(help="Scanned disc, default from key `specimen`, else 1.")] = None,
    limit_um: Annotated[float, Parameter(help="Largest allowed deviation from the nominal tooth [µm].")] = 10.0,
    wheel_radius_mm: Annotated[
        float | None, Parameter(help="Radius of the grinding wheel [mm], default that of the generating pin.")
    ] = None,
    remainder: Annotated[
        bool, Parameter(negative=(), help="Cancel a smooth remainder, too: fitted to the scan, not explained.")
    ] = False,
    json: Json = False,
    plugin: Plugins = (),
) -> int:
    """Write the grinding path that cancels the errors found in scans of a disc, and the expected scan.

    Example: cycloid-profile correct examples/rv40e.toml scan.csv --limit-um 5

    Parameters
    ----------
    spec
        Spec file (TOML); the flank errors of this disc in its [[effects]] are cancelled, too.
    scans
        Profile scans of one disc (CSV).
    """
    from cycloid_profile.measurement import read_measurement
    from cycloid_profile.report.diagnosis import correct_scans, correction_sentences, correction_tables

    require_files(scans, "profile scans")
    folder = output_folder(out, spec, "correct")
    with progress() as show_step:
        values, reason, status = correct_scans(
            read_with_plugins(spec, plugin),
            [read_measurement(file) for file in scans],
            folder,
            disc=None if disc is None else disc - 1,
            limit_um=limit_um,
            wheel_radius=wheel_radius_mm,
            remainder=remainder,
            progress=show_step,
        )
    if json:
        print_json(values)
    if status and reason is not None:
        warn(reason)
    elif not json and reason is not None:
        print(f"{values['name']}: {reason}")
    elif not json:
        print_tables(correction_tables(values))
        print("", *correction_sentences(values), f"\nwritten: {folder}", sep="\n")
    return status
