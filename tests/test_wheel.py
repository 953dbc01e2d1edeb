"""The wheel, built from the source distribution and installed in a clean environment, works outside the source tree."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "cycloid_profile"
MEASURED = ROOT / "examples" / "measured"

pytestmark = pytest.mark.slow


def called(*words: str | Path, folder: Path) -> str:
    """What a command prints in ``folder``, without the source tree on its path; fails with its errors."""
    hidden = ("PYTHONPATH", "VIRTUAL_ENV")
    environment = {name: value for name, value in os.environ.items() if name not in hidden}
    done = subprocess.run(
        list(map(str, words)), cwd=folder, env=environment, capture_output=True, text=True, timeout=600, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("build")
    pytest.importorskip("hatchling")
    folder = tmp_path_factory.mktemp("wheel")
    # From the tree to the source distribution, and from that to the wheel.
    called(sys.executable, "-m", "build", "--no-isolation", "--outdir", folder, ROOT, folder=folder)
    (found,) = folder.glob("*.whl")
    return found


@pytest.fixture(scope="module")
def scripts(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the commands of an environment with the wheel, and the libraries of this one."""
    home = tmp_path_factory.mktemp("clean")
    venv.create(home, with_pip=False)
    folder = home / ("Scripts" if os.name == "nt" else "bin")
    python = folder / "python"
    site = Path(called(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))", folder=home).strip())
    libraries = [path for path in sys.path if Path(path).name in ("site-packages", "dist-packages")]
    (site / "libraries.pth").write_text("\n".join(libraries), encoding="utf-8")
    pip = (sys.executable, "-m", "pip", "--python", python, "install", "-q", "--no-deps", "--no-index")
    called(*pip, "--force-reinstall", wheel, folder=home)
    return folder


def test_the_wheel_holds_every_file_of_the_package(wheel: Path) -> None:
    files = {
        path.relative_to(ROOT).as_posix()
        for path in PACKAGE.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    inside = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    assert inside == files
    assert {Path(name).suffix for name in files} >= {".toml", ".j2", ".pyi", ".typed"}


def test_the_installed_wheel_builds_and_diagnoses(scripts: Path, tmp_path: Path) -> None:
    command = scripts / "cycloid-profile"
    imported = called(
        scripts / "python", "-c", "import cycloid_profile; print(cycloid_profile.__file__)", folder=tmp_path
    )
    assert Path(imported.strip()).is_relative_to(scripts.parent)

    called(command, "catalog", "printed_11", "--out", "mine.toml", folder=tmp_path)
    called(command, "build", "mine.toml", "--out", "built", folder=tmp_path)
    assert {"report.html", "manifest.json", "profile.dxf"} <= {path.name for path in (tmp_path / "built").iterdir()}

    for name in ("rv40e.toml", "scan.csv"):
        shutil.copyfile(MEASURED / name, tmp_path / name)
    found = called(command, "diagnose", "rv40e.toml", "scan.csv", "--out", "found", folder=tmp_path)
    assert "cumulative_pitch_error" in found
    assert (tmp_path / "found" / "report.html").is_file()
