"""Write contour, polar and wire programs for four controls, run each with its strict interpreter, and draw the paths.

A machine file changes what is built in: here the Fanuc machine gets its own tool and a roughing pass of 50 µm.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from matplotlib.figure import Figure

import cycloid_profile as cp

HERE = Path(__file__).parent
WHEEL_RADIUS, TOLERANCE = 2.5, 1.0  # mm, µm
MY_MACHINE = """control = "fanuc"
name = "Grinder 7"
[tool]
number = 12
[passes]
stock_um = 100.0
infeed_um = 50.0
spark_out_turns = 1
"""
PROGRAMS = ("grinding.nc", "grinding_polar.nc", "wire_edm.nc")

record = cp.design.design_disc(cp.read_spec(HERE / "rv40e.toml"))
ran: dict[str, dict[str, cp.export.Program]] = {}
with TemporaryDirectory() as place:
    own = Path(place) / "my.toml"
    own.write_text(MY_MACHINE, encoding="utf-8")
    for control in cp.export.MACHINES:
        spec = record.spec.replace(
            {
                "export.nc_dialect": control,
                "export.machine": str(own) if control == "fanuc" else None,
                "export.wheel_compensation": "G41",
                "export.wheel_radius_mm": WHEEL_RADIUS,
                "export.chord_tolerance_um": TOLERANCE,
            }
        )
        machine = cp.export.machine_of(spec.export)
        cp.export.write_formats(replace(record, spec=spec), ("gcode", "gcode-polar", "gcode-wire"), Path(place))
        ran[control] = {name: cp.export.read_program(Path(place) / name, machine) for name in PROGRAMS}


def table() -> str:
    """Motions of every program, the largest F, and the tool it called."""
    lines = ["control       program              motions   largest F   tool"]
    for control, programs in ran.items():
        for name, program in programs.items():
            most = max(motion.state.feed for motion in program.motions if motion.kind != "rapid")
            lines.append(f"{control:12s}  {name:18s} {len(program.motions):9d} {most:11.1f} {program.state.tool:6d}")
    return "\n".join(lines)


def visualize(folder: Path) -> tuple[Path, Path]:
    """Plan and height of the contour and polar programs and plan of the wire program, a row a control."""
    figure = Figure(figsize=(17.0, 15.5), layout="constrained")
    axes = figure.subplots(len(ran), 6, width_ratios=(3, 2, 3, 2, 3, 1))
    for row, (control, programs) in zip(axes, ran.items(), strict=True):
        blank = cp.export.blank_of(record, [0.02])
        for pair, (name, program) in zip((row[:2], row[2:4], row[4:]), programs.items(), strict=True):
            cp.plot.nc_program(program, blank, ax=pair)
            pair[0].set_title(f"{control}, {name}")
    return cp.plot.save(figure, folder, "nc_programs")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table and draw the paths."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--out", type=Path, default=Path("out/nc_programs"), help="folder for the picture")
    folder = parser.parse_args(arguments).out
    folder.mkdir(parents=True, exist_ok=True)
    print(table())
    print(*visualize(folder), sep="\n")


if __name__ == "__main__":
    main()
