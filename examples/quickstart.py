"""Design the disc of an RV-40E, see what compensation does to its backlash, write its files."""

from pathlib import Path
from tempfile import mkdtemp

from cycloid_profile import build_package, catalog_drive, design_disc
from cycloid_profile.plot.comparison import profile_comparison
from cycloid_profile.plot.style import save
from cycloid_profile.units import ARCMIN

record = design_disc(catalog_drive("rv40e"))  # or read_spec("my_drive.toml")
before = record.conventional_accuracy.backlash.worst / ARCMIN
after = record.compensated_accuracy.backlash.worst / ARCMIN


def visualize(folder: Path) -> tuple[Path, Path]:
    """Draw the tooth against theory into ``folder``, as PNG and SVG."""
    return save(profile_comparison(record), folder, "profile")


if __name__ == "__main__":
    print(f"backlash {before:.3f}′ → {after:.3f}′")
    folder = Path(mkdtemp())
    build_package(record, folder / "rv40e")  # DXF, STEP, points, G-code, pictures, report
    print(*visualize(folder), sep="\n")
