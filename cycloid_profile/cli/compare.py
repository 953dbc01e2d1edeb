"""``cycloid-profile compare``: measured files minus the prediction of a spec."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cycloid_profile.cli._terminal import Json, OutFolder, output_folder, print_json, print_table, progress
from cycloid_profile.units import SIGNS


def compare(
    spec: Path,
    /,
    *data: Path,
    out: OutFolder = None,
    disc: Annotated[int, Parameter(help="Disc that was scanned, 1 for the first.")] = 1,
    json: Json = False,
) -> int:
    """Compare measured files with the prediction of the spec and its [[effects]], and draw the differences.

    Example: cycloid-profile compare examples/rv40e.toml scan.csv loop.csv

    Parameters
    ----------
    spec
        Spec file (TOML).
    data
        Measured files (CSV).
    """
    from cycloid_profile import plot
    from cycloid_profile.design import as_built_reducer
    from cycloid_profile.errors import MeasurementError
    from cycloid_profile.export.writing import atomic_folder
    from cycloid_profile.measurement import read_measurement
    from cycloid_profile.rig import measurement_residual
    from cycloid_profile.spec import read_spec

    if not data:
        raise MeasurementError("measured files", "none", "were given", "name at least one CSV file after the spec", " ")
    folder = output_folder(out, spec) / "compare"
    with progress() as report:
        wanted = read_spec(spec)
        measured = [read_measurement(file) for file in data]
        report("building the reducer")
        reducer = as_built_reducer(wanted)
        residuals = []
        with atomic_folder(folder) as scratch:
            for number, measurement in enumerate(measured, 1):
                report(f"comparing {measurement.name}")
                found = measurement_residual(reducer, measurement, disc - 1)
                name = f"{number}_{Path(measurement.name).stem}.png"
                plot.save_png(plot.measurement_residual(found, name=wanted.name), scratch / name)
                residuals.append((found, folder / name))
    if json:
        rows = [
            {
                "file": found.measurement.name,
                "kind": found.measurement.kind.name,
                "unit": found.unit,
                "rms": found.rms,
                "noise": found.noise,
                "registration": found.registration,
                "picture": str(picture),
            }
            for found, picture in residuals
        ]
        print_json({"schema": 1, "name": wanted.name, "gap": rows})
    else:
        table = [
            (f.measurement.name, f.measurement.kind.name, f"{f.rms:.4g}", f"{f.noise:.4g}", SIGNS[f.unit])
            for f, _ in residuals
        ]
        print_table(f"{wanted.name}: measured minus predicted", ("file", "kind", "rms", "noise", "unit"), table)
        print(f"\npictures: {folder}")
    return 0
