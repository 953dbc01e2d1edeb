"""``cycloid-profile build``: from a spec file to every file, picture and number."""

from __future__ import annotations

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


def build(spec: SpecFile, /, *, out: OutFolder = None, json: Json = False, plugin: Plugins = ()) -> int:
    """Compute the tooth, compensate it, and write all files, pictures and the report.

    Example: cycloid-profile build examples/rv40e.toml --out exports/rv40e
    """
    from cycloid_profile.design import design_disc, summary
    from cycloid_profile.export import exporter_for
    from cycloid_profile.report.design import REPORT, build_package, terminal_tables, warnings

    folder = output_folder(out, spec)
    with progress() as show_step:
        show_step("reading the spec")
        wanted = read_with_plugins(spec, plugin)
        show_step("computing load sharing and compensation")
        record = design_disc(wanted)
        skipped = build_package(record, folder, show_step)
    figures = summary(record) | {"out": str(folder), "skipped": skipped}
    warn(*(f"{', '.join(exporter_for(name).filenames)} not written: {reason}" for name, reason in skipped.items()))
    if json:
        print_json(figures)
    else:
        print_tables(terminal_tables(figures, loads=True))
        print(f"\nwritten to {folder}; open {folder / REPORT}")
    warn(*warnings(figures))
    return 1 if record.failures else 0
