"""Switch on pin seats, pin bending, ring and carrier pillars of an RV-40E, and list what each adds to the rotation."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np

import cycloid_profile as cp
from cycloid_profile.units import ARCMIN, UM

SPEC = cp.catalog_drive("rv40e")
SEAT = {"drive.pin_seat.contact": True}
BENDING = {**SEAT, "drive.pin_seat.bending": True}
RING = {"drive.ring.elastic": True}
PILLARS = {"drive.pillars.elastic": True}
ALL = {**BENDING, **RING, **PILLARS}


def at(estimate: str) -> dict[str, str | bool]:
    """All supports, sizes that the spec leaves out at one end of their range."""
    return {**ALL, **{f"drive.{table}.estimate": estimate for table in ("pin_seat", "ring", "pillars")}}


SWITCHES: dict[str, dict[str, str | bool]] = {
    "rigid supports": {},
    "seat contact": {**SEAT},
    "and pin bending": {**BENDING},
    "ring": {**RING},
    "pillars": {**PILLARS},
    "all, stiff end": at("stiff"),
    "all, likely": {**ALL},
    "all, soft end": at("soft"),
}


@cache
def case(name: str) -> cp.LoadCase:
    """Rated load on the tooth before compensation."""
    spec = SPEC.replace(SWITCHES[name])
    drive = cp.design.drive_of(spec)
    return cp.design.load_case(spec, drive, cp.design.conventional_profile(spec, drive))


@cache
def loaded(name: str) -> cp.LoadSharing:
    """The stage at rated torque over the cycle in which its load repeats."""
    return cp.StageEquilibrium().solve(case(name))


def table() -> str:
    """One row for each set of supports and the published figures; below, the shares of the parts in the rotation."""
    head = ("lost motion [′]", "rigidity [N·m/′]", "δmax [µm]", "transmission error [″]")
    rows = [f"{'':<18}" + "".join(f"{each:>{len(each) + 2}}" for each in head)]
    for name in SWITCHES:
        figures = cp.accuracy(case(name)).figures()
        values = (
            f"{figures['lost_motion_arcmin']:.3f}", f"{figures['torsional_rigidity_nm_per_arcmin']:.1f}",
            f"{loaded(name).delta_max / UM:.2f}", f"{figures['transmission_error_arcsec']:.2f}",
        )  # fmt: skip
        rows.append(f"{name:<18}" + "".join(f"{each:>{len(of) + 2}}" for each, of in zip(values, head, strict=True)))
    published = ("< 1", "72 to 108", "4.06", "")
    rows.append(
        f"{'published':<18}" + "".join(f"{each:>{len(of) + 2}}" for each, of in zip(published, head, strict=True))
    )
    return "\n".join(row.rstrip() for row in [*rows, "", *shares()])


def shares() -> list[str]:
    """Rotation of the output at rated torque by part, mean over the poses [′]."""
    names = list(loaded("all, likely").rotation_by_part)
    rows = [f"{'[′]':<18}{'all':>8}" + "".join(f"{name:>{len(name) + 2}}" for name in names)]
    for name in SWITCHES:
        parts = loaded(name).rotation_by_part
        mean = {part: float(np.mean(each)) / ARCMIN for part, each in parts.items()}
        cells = (f"{mean[part]:.3f}" if part in mean else "" for part in names)
        rows.append(
            f"{name:<18}{sum(mean.values()):>8.3f}"
            + "".join(f"{cell:>{len(part) + 2}}" for cell, part in zip(cells, names, strict=True))
        )
    return rows


def visualize(folder: Path) -> tuple[Path, Path]:
    """Shares of the parts in the rotation at rated torque, as PNG and SVG."""
    ax = cp.plot.rotation_by_part({name: loaded(name) for name in SWITCHES})
    return cp.plot.save(ax.figure, folder, "elastic_supports")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables and draw the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/elastic_supports"), help="folder for the picture")
    folder = parser.parse_args(arguments).out
    folder.mkdir(parents=True, exist_ok=True)
    print(table())
    print(*visualize(folder), sep="\n")


if __name__ == "__main__":
    main()
