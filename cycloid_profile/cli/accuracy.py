"""``cycloid-profile accuracy``: backlash, lost motion, rigidity and transmission error of a spec."""

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


def accuracy(spec: SpecFile, /, *, out: OutFolder = None, json: Json = False, plugin: Plugins = ()) -> int:
    """Predict and draw backlash, lost motion, torsional rigidity and transmission error.

    Example: cycloid-profile accuracy examples/rv40e.toml --json
    """
    from cycloid_profile.design import design_disc, summary
    from cycloid_profile.report.design import save_accuracy_plot, terminal_tables, warnings

    with progress() as show_step:
        show_step("loading the drive over one mesh cycle")
        record = design_disc(read_with_plugins(spec, plugin))
        picture = save_accuracy_plot(record, output_folder(out, spec))
    figures = summary(record) | {"picture": str(picture)}
    if json:
        print_json(figures)
    else:
        print_tables(terminal_tables(figures))
        print(f"\npicture: {picture}")
    warn(*warnings(figures))
    return 1 if record.failures else 0
