"""``cycloid-profile accuracy``: backlash, lost motion, rigidity and transmission error of a spec."""

from __future__ import annotations

from pathlib import Path

from cycloid_profile.cli.options import Json, OutFolder
from cycloid_profile.cli.terminal import output_folder, print_json, print_table, progress


def accuracy(
    spec: Path,
    /,
    *,
    out: OutFolder = None,
    json: Json = False,
) -> int:
    """Predict backlash, lost motion, torsional rigidity and transmission error, and draw them.

    Example: cycloid-profile accuracy examples/rv40e.toml --json

    Parameters
    ----------
    spec
        Spec file (TOML).
    """
    from cycloid_profile.cli.figures import accuracy_rows, as_built_rows, closing_words, stage_rows
    from cycloid_profile.design.record import design_disc
    from cycloid_profile.design.summary import summary
    from cycloid_profile.export.folder import whole_or_nothing
    from cycloid_profile.plot.accuracy import accuracy_plot
    from cycloid_profile.plot.style import save
    from cycloid_profile.report.build import PLOTS
    from cycloid_profile.spec.read import read_spec

    folder = output_folder(out, spec)
    with progress() as tell:
        tell("loading the drive over one mesh cycle")
        record = design_disc(read_spec(spec))
        with whole_or_nothing(folder) as scratch:
            (scratch / PLOTS).mkdir()
            picture, _ = save(accuracy_plot(record), scratch / PLOTS, "accuracy")
    figures = summary(record) | {"picture": str(folder / PLOTS / picture.name)}
    if json:
        print_json(figures)
    else:
        print_table(f"{record.spec.name}: accuracy", ("", "conventional", "compensated"), accuracy_rows(figures))
        print()
        print_table("whole stage, tooth as ground, rated torque", ("", ""), stage_rows(figures))
        if figures["as_built"]:
            print()
            print_table(f"as built, with {', '.join(figures['effects'])}", ("", ""), as_built_rows(figures))
        print(f"\npicture: {figures['picture']}")
    return closing_words(figures)
