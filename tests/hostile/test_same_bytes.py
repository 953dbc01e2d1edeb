"""The same spec gives the same bytes, wherever and by whomever it is built, given ``SOURCE_DATE_EPOCH``."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PLACES = {
    "plain": {"TZ": "UTC", "LANG": "C.UTF-8", "PYTHONHASHSEED": "0", "USER": "anna", "LOGNAME": "anna"},
    "Zürich lab": {
        "TZ": "Pacific/Kiritimati", "LANG": "de_DE.ISO-8859-1", "LC_ALL": "de_DE.ISO-8859-1", "PYTHONHASHSEED": "4711",
        "USER": "böb", "LOGNAME": "böb", "COLUMNS": "31", "HOSTNAME": "elsewhere",
    },
}  # fmt: skip


def built(place: Path, changed: dict[str, str], mask: int) -> dict[str, bytes]:
    """Files of a package that is built in the folder ``place`` with a home of its own."""
    home = place / "home"
    home.mkdir(parents=True)
    text = (ROOT / "examples" / "rv40e.toml").read_text(encoding="utf-8")
    (place / "my drive.toml").write_text(text, encoding="utf-8")
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("LC_", "XDG_", "MPL"))}
    done = subprocess.run(
        [sys.executable, "-m", "cycloid_profile", "build", "my drive.toml", "--out", "out"],
        cwd=place, capture_output=True, text=True, errors="replace", timeout=500, check=False, umask=mask,
        env={**environment, **changed, "HOME": str(home), "PYTHONPATH": str(ROOT), "SOURCE_DATE_EPOCH": "1700000000"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    out = place / "out"
    return {str(path.relative_to(out)): path.read_bytes() for path in out.rglob("*") if path.is_file()}


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="umask and locales of POSIX")
def test_two_places_build_the_same_bytes(tmp_path: Path):
    one, other = (
        built(tmp_path / name, changed, mask)
        for (name, changed), mask in zip(PLACES.items(), (0o022, 0o077), strict=True)
    )
    assert one.keys() == other.keys()
    assert len(one) > 20
    assert not [name for name in one if one[name] != other[name]]
    assert not [name for name, data in one.items() if b"home" in data and str(tmp_path).encode() in data]
