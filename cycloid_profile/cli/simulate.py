"""``cycloid-profile simulate``: the file that a measuring machine or test bench would write."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from cycloid_profile.cli.output._options import (
    AllowLarge,
    Force,
    Json,
    Plugins,
    Quiet,
    protection_of,
    read_with_plugins,
)
from cycloid_profile.cli.output._terminal import print_places, print_tables, printed_as_json, progress

if TYPE_CHECKING:
    from cycloid_profile.export.writing import Protection

Kind = Literal["profile_scan", "hysteresis", "transmission_error", "lost_motion_map"]


def simulate(
    spec: Path,
    /,
    *,
    kind: Annotated[Kind, Parameter(help="What to measure.")],
    out: Annotated[
        Path | None, Parameter(help="File to write, default NAME_KIND.csv; a picture is written next to it.")
    ] = None,
    torque_nm: Annotated[float | None, Parameter(help="Torque [N·m], default that of the kind.")] = None,
    output_angle_deg: Annotated[float, Parameter(help="Angle of the output for a loop [°].", show_default=True)] = 0.0,
    points: Annotated[int | None, Parameter(help="Number of rows, default that of the kind.")] = None,
    disc: Annotated[int, Parameter(help="Disc to scan, 1 for the first.", show_default=True)] = 1,
    noise: Annotated[
        float, Parameter(help="Standard deviation of noise, in the unit of the column (scan: µm).", show_default=True)
    ] = 0.0,
    seed: Annotated[int, Parameter(help="Seed of the noise.", show_default=True)] = 0,
    json: Json = None,
    force: Force = False,
    allow_large: AllowLarge = False,
    plugin: Plugins = (),
    quiet: Quiet = False,
) -> int:
    """Write the readings of a measuring machine or test bench on the reducer with its [[effects]].

    Example: cycloid-profile simulate examples/rv40e.toml --kind hysteresis --out loop.csv

    Parameters
    ----------
    spec
        Spec file (TOML).
    """
    from cycloid_profile.design import as_built_reducer
    from cycloid_profile.measurement import kind_named
    from cycloid_profile.report import key_figure_table, write_measurement
    from cycloid_profile.rig import Settings, key_figures
    from cycloid_profile.rig import simulate as measure
    from cycloid_profile.units import DEGREE, NEWTON_METRE

    protection = protection_of(force, spec, *plugin, json=json)
    file = _output_file(Path(f"{spec.stem}_{kind}.csv") if out is None else out, protection)
    settings = Settings(
        torque=None if torque_nm is None else torque_nm * NEWTON_METRE,
        output_angle=output_angle_deg * DEGREE,
        points=points,
        disc=disc - 1,
        noise=noise,
        seed=seed,
    )
    with progress(quiet, allow_large) as show_step:
        show_step("building the reducer")
        wanted = read_with_plugins(spec, plugin)
        reducer = as_built_reducer(wanted)
        title = kind_named(kind).title
        show_step(f"measuring: {title}")
        measured = measure(reducer, kind, settings)
        figures = key_figures(measured)
        picture = write_measurement(measured, reducer, wanted.name, file, protection)
    written = {"name": wanted.name, "kind": kind, "file": str(file), "picture": str(picture)}
    if not printed_as_json({"schema": 1, **written, "figures": figures}, json, protection):
        print_tables([key_figure_table(f"{wanted.name}: {title}", figures)])
        print_places("", f"written: {file}, picture: {picture}")
    return 0


def _output_file(file: Path, protection: Protection) -> Path:
    """The file to write; raises ``ExportError`` unless it and its picture have two names that may be written."""
    from cycloid_profile.errors import ExportError

    if file.suffix == ".png":
        raise ExportError("--out", f"'{file}'", "is the name of the picture", "end it with .csv", " ")
    for target in (file, file.with_suffix(".png")):
        protection.check(target)
    return file
