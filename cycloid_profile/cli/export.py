"""``cycloid-profile export``: some formats of a spec, without the pictures."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from cycloid_profile.cli._terminal import (
    Json,
    OutFolder,
    Plugins,
    SpecFile,
    output_folder,
    print_json,
    print_tables,
    progress,
    read_with_plugins,
    warn,
)
from cycloid_profile.spec.model import Format


def export(
    spec: SpecFile,
    /,
    *,
    format: Annotated[
        tuple[Format, ...],
        Parameter(
            help="Formats to write, default those of the spec.", consume_multiple=True, negative=(), show_default=False
        ),
    ] = (),
    out: OutFolder = None,
    list: Annotated[bool, Parameter(negative=(), help="Print the names of the files without writing them.")] = False,
    json: Json = False,
    plugin: Plugins = (),
) -> int:
    """Write the chosen formats, read each file back and print its measured error.

    Example: cycloid-profile export examples/rv40e.toml --format dxf --format gcode
    """
    from cycloid_profile.design import design_disc
    from cycloid_profile.export import exporter_for
    from cycloid_profile.report.design import export_package, planned_files_table, written_files_table

    folder = output_folder(out, spec)
    wanted = read_with_plugins(spec, plugin)
    formats = tuple(dict.fromkeys(format or wanted.export.formats))
    if list:
        if json:
            files = [(str(folder / file), name) for name in formats for file in exporter_for(name).filenames]
            listed = [{"path": path, "format": name} for path, name in files]
            print_json({"schema": 1, "name": wanted.name, "files": listed})
        else:
            print_tables([planned_files_table(formats, folder)])
        return 0
    with progress() as show_step:
        show_step("computing load sharing and compensation")
        record = design_disc(wanted)
        entries, skipped = export_package(record, formats, folder, show_step)
    if json:
        print_json({"schema": 1, "name": wanted.name, "out": str(folder), "files": entries, "skipped": skipped})
    else:
        print_tables([written_files_table(entries, folder)])
    warn(*skipped.values(), *record.failures)
    return 1 if skipped or record.failures else 0
