"""``cycloid-profile export``: some formats of a spec, without the pictures."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from cycloid_profile.cli.output._options import (
    AllowLarge,
    Force,
    Json,
    OutFolder,
    Plugins,
    Quiet,
    SpecFile,
    output_folder,
    protection_of,
    read_with_plugins,
)
from cycloid_profile.cli.output._terminal import hint, print_places, print_tables, printed_as_json, progress, warn
from cycloid_profile.spec.model import Format


def export(
    spec: SpecFile,
    /,
    *,
    format: Annotated[
        tuple[Format, ...],
        Parameter(help="Formats to write, default those of the spec.", consume_multiple=True),
    ] = (),
    out: OutFolder = None,
    list: Annotated[bool, Parameter(help="Print the names of the files without writing them.")] = False,
    json: Json = None,
    force: Force = False,
    allow_large: AllowLarge = False,
    plugin: Plugins = (),
    quiet: Quiet = False,
) -> int:
    """Write the chosen formats, read each file back and print its measured error.

    Example: cycloid-profile export examples/rv40e.toml --format dxf gcode --out exports/rv40e
    """
    from cycloid_profile.design import design_disc, disc_outline, disc_parts, disc_parts_sentence, drive_of
    from cycloid_profile.export import CadProcess, ascii_name_notes, file_names
    from cycloid_profile.export.writing import MANIFEST, notes_of
    from cycloid_profile.report.design import export_package, planned_files_table, written_files_table

    protection = protection_of(force, spec, *plugin, json=json)
    folder = output_folder(out, spec, protection, writes=() if list else [MANIFEST])
    wanted = read_with_plugins(spec, plugin)
    formats = tuple(dict.fromkeys(format or wanted.export.formats))
    if list:
        drive = drive_of(wanted)
        parts = disc_parts(drive, disc_outline(wanted, drive, drive.theoretical_profile))
        discs = [part.number for part in parts]
        files = [(str(folder / file), name) for name in formats for file in file_names(name, discs)]
        listed = [{"path": path, "format": name} for path, name in files]
        if not printed_as_json({"schema": 1, "name": wanted.name, "files": listed}, json, protection):
            print_tables([planned_files_table(formats, folder, discs)])
        return 0
    with progress(quiet, allow_large) as show_step:
        show_step("computing load sharing and compensation")
        with CadProcess(formats) as process:
            record = design_disc(wanted)
            entries, skipped = export_package(record, formats, folder, show_step, protection, process)
    written = {"schema": 1, "name": wanted.name, "out": str(folder), "files": entries, "skipped": skipped}
    if not printed_as_json(written, json, protection):
        print_tables([written_files_table(entries, folder)])
        if sentence := disc_parts_sentence(record):
            print_places("", sentence)
    hint(*ascii_name_notes(wanted, formats), *notes_of(entries), quiet=quiet)
    warn(*skipped.values(), *record.failures)
    return 1 if skipped or record.failures else 0
