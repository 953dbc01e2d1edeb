"""``cycloid-profile build``: from a spec file to every file, picture and number."""

from __future__ import annotations

from pathlib import Path

from cycloid_profile.cli.options import Json, OutFolder
from cycloid_profile.cli.terminal import output_folder, print_json, print_table, progress, warn


def build(
    spec: Path,
    /,
    *,
    out: OutFolder = None,
    json: Json = False,
) -> int:
    """Compute the tooth, compensate it, and write all files, pictures and the report.

    Example: cycloid-profile build examples/rv40e.toml --out exports/rv40e

    Parameters
    ----------
    spec
        Spec file (TOML).
    """
    from cycloid_profile.cli.figures import accuracy_rows, as_built_rows, closing_words, load_rows, stage_rows
    from cycloid_profile.design.record import design_disc
    from cycloid_profile.design.summary import summary
    from cycloid_profile.export.formats import exporter_for
    from cycloid_profile.report.build import REPORT, build_package
    from cycloid_profile.spec.read import read_spec

    folder = output_folder(out, spec)
    with progress() as tell:
        tell("reading the spec")
        wanted = read_spec(spec)
        tell("sharing the load, compensating the tooth")
        record = design_disc(wanted)
        skipped = build_package(record, folder, tell)
    figures = summary(record) | {"out": str(folder), "skipped": skipped}
    for name, reason in skipped.items():
        warn(f"{', '.join(exporter_for(name).filenames)} not written: {reason}")
    if json:
        print_json(figures)
    else:
        print_table(f"{record.spec.name}: accuracy", ("", "conventional", "compensated"), accuracy_rows(figures))
        print()
        print_table("load on the conventional tooth", ("", "classical", "equilibrium"), load_rows(figures))
        print()
        print_table("whole stage, tooth as ground, rated torque", ("", ""), stage_rows(figures))
        if figures["as_built"]:
            print()
            print_table(f"as built, with {', '.join(figures['effects'])}", ("", ""), as_built_rows(figures))
        print(f"\nwritten to {folder}; open {folder / REPORT}")
    return closing_words(figures)
