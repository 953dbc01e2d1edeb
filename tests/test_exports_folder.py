"""Regression: ``exports/rv40e`` is what ``build examples/rv40e.toml`` writes, byte for byte.

Our own output, pinned so that no number changes unnoticed. Bytes are promised for the pinned library
versions on x86-64 Linux (with and without AVX-512); elsewhere a last digit or a font outline may differ.
"""

from __future__ import annotations

import importlib.metadata
import platform
import re
from pathlib import Path

import pytest

from cycloid_profile.cli.main import run

ROOT = Path(__file__).parents[1]
COMMITTED = ROOT / "exports" / "rv40e"
LIBRARIES = (
    "numpy", "scipy", "shapely", "ezdxf", "build123d", "cadquery-ocp-novtk", "matplotlib", "pillow", "jinja2",
)  # fmt: skip


def other_versions() -> list[str]:
    """Libraries whose installed version is not the pinned one."""
    pins = dict(re.findall(r"^([\w-]+)==(\S+)$", (ROOT / "constraints.txt").read_text(encoding="utf-8"), re.MULTILINE))
    pins = {name.lower(): version for name, version in pins.items()}
    found = {}
    for name in LIBRARIES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "missing"
    return [f"{name} {found[name]} (pinned {pins[name]})" for name in LIBRARIES if found[name] != pins[name]]


def test_the_committed_set_is_small_and_complete() -> None:
    files = [path for path in COMMITTED.rglob("*") if path.is_file()]
    assert sum(path.stat().st_size for path in files) < 6_000_000
    assert {"profile.csv", "profile.dxf", "disc.step", "grinding.nc", "cmm_nominal.csv", "report.html"} <= {
        path.name for path in files
    }


@pytest.mark.slow
def test_build_gives_the_committed_bytes(tmp_path: Path) -> None:
    if (platform.system(), platform.machine()) != ("Linux", "x86_64"):
        pytest.skip("bytes are promised on x86-64 Linux only")
    if different := other_versions():
        pytest.skip("bytes are promised for the pinned versions: " + ", ".join(different))
    assert run(["build", str(ROOT / "examples" / "rv40e.toml"), "--out", str(tmp_path / "rv40e")]) == 0
    reducer = {path.relative_to(tmp_path / "rv40e") for path in (tmp_path / "rv40e").rglob("*") if path.is_file()}
    committed = {path.relative_to(COMMITTED) for path in COMMITTED.rglob("*") if path.is_file()}
    assert reducer == committed
    changed = [
        str(name)
        for name in sorted(reducer)
        if (tmp_path / "rv40e" / name).read_bytes() != (COMMITTED / name).read_bytes()
    ]
    assert not changed, f"run 'cycloid-profile build examples/rv40e.toml' and read the difference: {changed}"
