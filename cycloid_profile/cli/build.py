"""``cycloid-profile build``: from a spec file to every file, picture and number."""

from __future__ import annotations

from cycloid_profile.cli.output._options import (
    AllowLarge,
    Force,
    Json,
    OutFolder,
    Pdf,
    Plugins,
    Quiet,
    SpecFile,
    check_pdf,
    output_folder,
    protection_of,
    read_with_plugins,
)
from cycloid_profile.cli.output._terminal import hint, print_places, print_tables, printed_as_json, progress, warn


def build(
    spec: SpecFile,
    /,
    *,
    out: OutFolder = None,
    json: Json = None,
    pdf: Pdf = False,
    force: Force = False,
    allow_large: AllowLarge = False,
    plugin: Plugins = (),
    quiet: Quiet = False,
) -> int:
    """Compute the tooth, compensate it, and write all files, pictures and the report.

    Example: cycloid-profile build examples/rv40e.toml --out exports/rv40e
    """
    from cycloid_profile.design import design_disc, summary
    from cycloid_profile.export import CadProcess, ascii_name_notes, exporter_for
    from cycloid_profile.export.writing import MANIFEST, notes_of
    from cycloid_profile.report.design import REPORT, build_package, terminal_tables, warnings

    check_pdf(pdf)
    protection = protection_of(force, spec, *plugin, json=json)
    folder = output_folder(out, spec, protection, writes=[MANIFEST, REPORT])
    with progress(quiet, allow_large) as show_step:
        show_step("reading the spec")
        wanted = read_with_plugins(spec, plugin)
        show_step("computing load sharing and compensation")
        with CadProcess(wanted.export.formats) as process:
            record = design_disc(wanted)
            entries, skipped = build_package(record, folder, show_step, protection, process, pdf)
    figures = summary(record) | {"out": str(folder), "skipped": skipped}
    warn(*(f"{', '.join(exporter_for(name).filenames)} not written: {reason}" for name, reason in skipped.items()))
    hint(*ascii_name_notes(wanted, wanted.export.formats), *notes_of(entries), quiet=quiet)
    if not printed_as_json(figures, json, protection):
        print_tables(terminal_tables(figures, loads=True))
        if figures["disc_parts"]:
            print_places("", figures["disc_parts"])
        print_places("", f"written to {folder}; open {folder / REPORT}")
    warn(*warnings(figures))
    return 1 if record.failures else 0
