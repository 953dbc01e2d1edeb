"""``cycloid-profile export``: some formats of a spec, without the pictures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from cycloid_profile.cli.options import Json, OutFolder
from cycloid_profile.cli.terminal import output_folder, print_json, print_table, progress, warn
from cycloid_profile.design.summary import shown
from cycloid_profile.spec.export import Format


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
    from cycloid_profile.design.record import design_disc
    from cycloid_profile.export.folder import whole_or_nothing
    from cycloid_profile.export.formats import exporter_for, write_formats
    from cycloid_profile.export.manifest import manifest_entry, untouched_entries, write_manifest
    from cycloid_profile.spec.read import read_spec

    folder = output_folder(out, spec)
    wanted = read_spec(spec)
    formats = tuple(dict.fromkeys(format or wanted.export.formats))
    if list:
        files = [(str(folder / file), name) for name in formats for file in exporter_for(name).filenames]
        return _show(files, wanted.name, json)
    with progress() as tell:
        tell("sharing the load, compensating the tooth")
        record = design_disc(wanted)
        with whole_or_nothing(folder) as scratch:
            written, skipped = write_formats(record, formats, scratch, tell)
            entries = [manifest_entry(file, wanted, scratch) for file in written]
            paths = {entry["path"] for entry in entries}
            others = [entry for entry in untouched_entries(folder) if entry["path"] not in paths]
            write_manifest(wanted.name, [*others, *entries], skipped, scratch)
    if json:
        print_json({"schema": 1, "name": wanted.name, "out": str(folder), "files": entries, "skipped": skipped})
    else:
        print_table("written", ("file", "bytes", "promised [µm]", "measured [µm]"), _rows(entries, folder))
    for reason in (*skipped.values(), *record.failures):
        warn(reason)
    return 1 if skipped or record.failures else 0


def _show(files: Sequence[tuple[str, str]], name: str, as_json: bool) -> int:
    if as_json:
        listed = [{"path": path, "format": format_name} for path, format_name in files]
        print_json({"schema": 1, "name": name, "files": listed})
    else:
        print_table("would be written", ("file", "format"), files)
    return 0


def _rows(entries: Sequence[dict[str, Any]], folder: Path) -> Sequence[tuple[str, ...]]:
    return [
        (str(folder / e["path"]), f"{e['bytes']:,}", shown(e["tolerance_um"]), shown(e["deviation_um"]))
        for e in entries
    ]
