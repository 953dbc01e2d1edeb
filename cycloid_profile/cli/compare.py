"""``cycloid-profile compare``: measured files beside the prediction of a spec."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cycloid_profile.cli.options import Json, OutFolder
from cycloid_profile.cli.terminal import output_folder, print_json, print_table, progress
from cycloid_profile.units import SIGNS


def compare(
    spec: Path,
    /,
    *data: Path,
    out: OutFolder = None,
    disc: Annotated[int, Parameter(help="Disc that was scanned, 1 for the first.")] = 1,
    json: Json = False,
) -> int:
    """Lay measured files beside what the spec with its [[effects]] predicts, and draw the gaps.

    Example: cycloid-profile compare examples/rv40e.toml scan.csv loop.csv

    Parameters
    ----------
    spec
        Spec file (TOML).
    data
        Measured files (CSV).
    """
    from cycloid_profile.design.ground import built_reducer
    from cycloid_profile.errors import MeasurementError
    from cycloid_profile.export.folder import whole_or_nothing
    from cycloid_profile.measurement.files import read_measurement
    from cycloid_profile.plot.measured import gap_plot
    from cycloid_profile.plot.style import save_png
    from cycloid_profile.rig.gap import gap
    from cycloid_profile.spec.read import read_spec

    if not data:
        raise MeasurementError("measured files", "none", "were given", "name at least one CSV file after the spec", " ")
    folder = output_folder(out, spec) / "compare"
    with progress() as tell:
        wanted = read_spec(spec)
        measured = [read_measurement(file) for file in data]
        tell("building the reducer")
        built = built_reducer(wanted)
        gaps = []
        with whole_or_nothing(folder) as scratch:
            for number, measurement in enumerate(measured, 1):
                tell(f"comparing {measurement.name}")
                found = gap(built, measurement, disc - 1)
                name = f"{number}_{Path(measurement.name).stem}.png"
                save_png(gap_plot(found, wanted.name), scratch / name)
                gaps.append((found, folder / name))
    if json:
        rows = [
            {
                "file": found.measurement.name,
                "kind": found.measurement.kind,
                "unit": found.unit,
                "rms": found.rms,
                "noise": found.noise,
                "registration": found.removed,
                "picture": str(picture),
            }
            for found, picture in gaps
        ]
        print_json({"schema": 1, "name": wanted.name, "gap": rows})
    else:
        table = [
            (f.measurement.name, f.measurement.kind, f"{f.rms:.4g}", f"{f.noise:.4g}", SIGNS[f.unit]) for f, _ in gaps
        ]
        print_table(f"{wanted.name}: measured minus predicted", ("file", "kind", "rms", "noise", "unit"), table)
        print(f"\npictures: {folder}")
    return 0
