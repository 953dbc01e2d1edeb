"""Design the disc of an RV-40E, compare its backlash before and after compensation, and write its files."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import cycloid_profile as cp

record = cp.design_disc(cp.catalog_drive("rv40e"))  # or cp.read_spec("my_drive.toml")
before = record.conventional_accuracy.backlash.worst / cp.units.ARCMIN
after = record.compensated_accuracy.backlash.worst / cp.units.ARCMIN


def visualize(folder: Path) -> tuple[Path, Path]:
    """Draw the modified and the compensated tooth against the theoretical one, as PNG and SVG."""
    return cp.plot.save(cp.plot.profile_comparison(record), folder, "quickstart")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the backlash, write all files of the design and draw the tooth."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/quickstart"), help="folder for the files")
    folder = parser.parse_args(arguments).out
    print(f"backlash {before:.3f}′ → {after:.3f}′")
    cp.build_package(record, folder / "rv40e")  # DXF, STEP, points, NC program, pictures, report
    print(*visualize(folder), sep="\n")


if __name__ == "__main__":
    main()
