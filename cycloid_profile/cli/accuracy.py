"""``cycloid-profile accuracy``: backlash, lost motion, rigidity and transmission error of a spec."""

from __future__ import annotations

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
from cycloid_profile.cli.output._terminal import print_places, print_tables, printed_as_json, progress, warn


def accuracy(
    spec: SpecFile,
    /,
    *,
    out: OutFolder = None,
    json: Json = None,
    force: Force = False,
    allow_large: AllowLarge = False,
    plugin: Plugins = (),
    quiet: Quiet = False,
) -> int:
    """Predict and draw backlash, lost motion, torsional rigidity and transmission error.

    Example: cycloid-profile accuracy examples/rv40e.toml --out exports/rv40e
    """
    from cycloid_profile.design import design_disc, summary
    from cycloid_profile.report.design import save_accuracy_plot, terminal_tables, warnings

    protection = protection_of(force, spec, *plugin, json=json)
    folder = output_folder(out, spec, protection, writes=["plots/accuracy.png"])
    with progress(quiet, allow_large) as show_step:
        show_step("loading the drive over one mesh cycle")
        record = design_disc(read_with_plugins(spec, plugin))
        picture = save_accuracy_plot(record, folder, protection)
    figures = summary(record) | {"picture": str(picture)}
    if not printed_as_json(figures, json, protection):
        print_tables(terminal_tables(figures))
        print_places("", f"picture: {picture}")
    warn(*warnings(figures))
    return 1 if record.failures else 0
