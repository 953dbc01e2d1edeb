"""A command gives the same answer in surroundings of every kind: home, locale, display, encoding, names of folders."""

from __future__ import annotations

import os
import shutil
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
    # Folders of the kernel take no file, whoever asks.
    "home that is read-only": {"HOME": "/sys", "XDG_CACHE_HOME": "/sys/cache", "XDG_STATE_HOME": "/sys/state"},
    "home that cannot be made": {"HOME": "/dev/null/home", "XDG_CACHE_HOME": "/proc/x", "XDG_STATE_HOME": "/proc/x"},
    "no home": {"HOME": "", "XDG_CACHE_HOME": "", "XDG_STATE_HOME": ""},
    "no variables": dict.fromkeys(("LANG", "LC_ALL", "USER", "LOGNAME", "TMPDIR", "TERM", "TZ"), ""),
}
# Every format of which a library writes the numbers.
FORMATS = ("csv", "dxf", "drawing", "step", "3mf", "stl", "gcode", "cmm", "dmis", "qif", "vdafs")
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


@pytest.mark.slow
def test_a_process_with_decimal_commas_writes_the_same_files(tmp_path: Path):
    # A window system sets the locale of the whole process, and with it the decimal mark of every library in C.
    if shutil.which("localedef") is None:
        pytest.skip("no localedef to make the locale with")
    locales = tmp_path / "locales"
    locales.mkdir()
    words = ["localedef", "-i", "de_DE", "-f", "UTF-8", str(locales / "de_DE.UTF-8")]
    if subprocess.run(words, capture_output=True, check=False).returncode > 1:
        pytest.skip("no sources of locales")
    (tmp_path / "sitecustomize.py").write_text(
        "import locale\nlocale.setlocale(locale.LC_ALL, '')\nassert locale.localeconv()['decimal_point'] == ','\n",
        encoding="utf-8",
    )
    comma = {"LOCPATH": str(locales), "LC_ALL": "de_DE.UTF-8", "PYTHONPATH": f"{tmp_path}:{ROOT}"}
    text = (ROOT / "examples" / "rv40e.toml").read_text(encoding="utf-8")
    spec = tmp_path / "drive.toml"
    spec.write_text(text.replace("[load]\n", '[load]\ndisc_body = "rigid"\n'), encoding="utf-8")
    found = []
    for name, changed in (("plain", {}), ("comma", comma)):
        words = ["export", str(spec), "--out", str(tmp_path / name), *(f"--format={one}" for one in FORMATS)]
        done = subprocess.run(
            [sys.executable, "-m", "cycloid_profile", *words], capture_output=True, timeout=600, check=False,
            env={**os.environ, "PYTHONPATH": str(ROOT), "SOURCE_DATE_EPOCH": "1700000000", **changed},
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        found.append({path.name: path.read_bytes() for path in (tmp_path / name).iterdir()})
    assert found[0] == found[1]


@pytest.mark.slow
def test_a_package_and_a_home_that_cannot_be_written_compile_again_and_say_so(tmp_path: Path):
    # As in a container whose file system is read-only. A file in the place of a folder stops every user, root as well.
    package = tmp_path / "cycloid_profile"
    shutil.copytree(ROOT / "cycloid_profile", package, ignore=shutil.ignore_patterns("__pycache__"))
    for folder in {file.parent for file in package.rglob("*.py")}:
        (folder / "__pycache__").write_text("", encoding="utf-8")
    kernels = sorted(
        ".".join(file.relative_to(tmp_path).with_suffix("").parts)
        for file in package.rglob("*.py")
        if "from cycloid_profile.compiled import" in file.read_text(encoding="utf-8") and file.name.startswith("_")
    )
    words = [sys.executable, "-B", "-c", f"import {', '.join(kernels)}"]
    nowhere = {"HOME": "/dev/null/home", "XDG_CACHE_HOME": "/dev/null/cache", "NUMBA_CACHE_DIR": ""}
    done = subprocess.run(
        words, cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False,
        env={**os.environ, "PYTHONPATH": str(tmp_path), **nowhere},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    (sentence,) = done.stderr.splitlines()
    assert "set NUMBA_CACHE_DIR" in sentence
