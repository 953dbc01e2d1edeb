"""``cycloid-profile export``: some formats of a spec, without the pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cycloid_profile.cli.options import Json, OutFolder
from cycloid_profile.cli.terminal import default_folder, print_json, print_table, progress, warn
from cycloid_profile.spec.model import Format


def export(
    spec: Path,
    /,
    *,
    format: Annotated[
        tuple[Format, ...],
        Parameter(
            help="Formats to write, default those of the spec.", consume_multiple=True, negative=(), show_default=False
        ),
    ] = (),
    out: OutFolder = None,
    list: Annotated[bool, Parameter(negative=(), help="Show what would be written, write nothing.")] = False,
    json: Json = False,
) -> int:
    """Write the chosen formats, read each back and print its measured error.

    Example: cycloid-profile export examples/rv40e.toml --format dxf --format gcode

    Parameters
    ----------
    spec
        Spec file (TOML).
    """
    from cycloid_profile.cli.figures import shown
    from cycloid_profile.design.record import design_disc
    from cycloid_profile.export.package import exporter_for, manifest_entry, whole_or_nothing
    from cycloid_profile.report.build import write_formats
    from cycloid_profile.spec.read import read_spec

    folder = out if out is not None else default_folder(spec)
    wanted = read_spec(spec)
    formats = format or wanted.export.formats
    if list:
        files = [{"path": str(folder / exporter_for(name).filename), "format": name} for name in formats]
        if json:
            print_json({"schema": 1, "name": wanted.name, "files": files})
        else:
            print_table("would be written", ("file", "format"), [(f["path"], f["format"]) for f in files])
        return 0
    with progress() as tell:
        tell("sharing the load, compensating the tooth")
        record = design_disc(wanted)
        with whole_or_nothing(folder) as scratch:
            written, skipped = write_formats(record, formats, scratch, tell)
            entries = [manifest_entry(file, scratch) for file in written]
    if json:
        print_json({"schema": 1, "name": wanted.name, "out": str(folder), "files": entries, "skipped": skipped})
    else:
        rows = [
            (str(folder / e["path"]), f"{e['bytes']:,}", shown(e["tolerance_um"]), shown(e["deviation_um"]))
            for e in entries
        ]
        print_table("written", ("file", "bytes", "promised [µm]", "measured [µm]"), rows)
    for reason in (*skipped.values(), *record.failures):
        warn(reason)
    if skipped:
        return 2
    return 1 if record.failures else 0
