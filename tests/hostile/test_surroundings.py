"""A command gives the same answer in surroundings of every kind: home, locale, display, encoding, names of folders."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SURROUNDINGS = {
    "no display": {"DISPLAY": "", "WAYLAND_DISPLAY": "", "MPLBACKEND": ""},
    "a display that is none": {"DISPLAY": ":999", "QT_QPA_PLATFORM": "xcb"},
    "decimal comma": {"LC_ALL": "de_DE.UTF-8", "LC_NUMERIC": "de_DE.UTF-8", "LANG": "de_DE.UTF-8"},
    "no UTF-8": {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
    "pipe of cp1252": {"PYTHONIOENCODING": "cp1252"},
    "home that cannot be made": {"HOME": "/dev/null/home", "XDG_CACHE_HOME": "/proc/x", "XDG_STATE_HOME": "/proc/x"},
    "no home": {"HOME": "", "XDG_CACHE_HOME": "", "XDG_STATE_HOME": ""},
    "no variables": dict.fromkeys(("LANG", "LC_ALL", "USER", "LOGNAME", "TMPDIR", "TERM", "TZ"), ""),
}
FOLDERS = ("a b", "Prüfstand № 1", "俯仰", "'quoted' $(x)", "-dash", "x" * 200)

pytestmark = pytest.mark.skipif(os.name != "posix", reason="surroundings of POSIX")


def scan(place: Path, changed: dict[str, str]) -> bytes:
    """The scan that ``simulate`` writes in the folder ``place``; its picture is there, too."""
    place.mkdir(parents=True)
    text = (ROOT / "examples" / "rv40e.toml").read_text(encoding="utf-8")
    rigid = text.replace("[load]\n", '[load]\ndisc_body = "rigid"\n')
    (place / "drive µ.toml").write_text(rigid, encoding="utf-8")
    words = ["simulate", "drive µ.toml", "--kind=profile_scan", "--points=400", "--out=scan 1.csv"]
    done = subprocess.run(
        [sys.executable, "-m", "cycloid_profile", *words], cwd=place, capture_output=True, timeout=300, check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT), **changed},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert b"Traceback" not in done.stderr
    assert (place / "scan 1.png").stat().st_size > 1000
    return (place / "scan 1.csv").read_bytes()


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return scan(tmp_path_factory.mktemp("plain") / "plain", {})


@pytest.mark.slow
@pytest.mark.parametrize("name", SURROUNDINGS)
def test_surroundings_change_no_byte(name: str, expected: bytes, tmp_path: Path):
    assert scan(tmp_path / "here", SURROUNDINGS[name]) == expected


@pytest.mark.slow
@pytest.mark.parametrize("folder", FOLDERS)
def test_names_of_folders_change_no_byte(folder: str, expected: bytes, tmp_path: Path):
    assert scan(tmp_path / folder, {}) == expected
