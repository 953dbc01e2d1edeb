"""Files that once broke a reader are read or refused in one sentence."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest

from cycloid_profile.errors import CycloidError, ResourceError
from cycloid_profile.resources import LIMITS, Limit
from tests.hostile import fuzz


@pytest.mark.parametrize("seed", sorted(fuzz.SEEDS.iterdir()), ids=lambda path: path.name)
def test_a_file_that_broke_a_reader_is_read_or_refused(seed: Path):
    assert fuzz.find_in(seed.name.split("-")[0], seed.read_bytes()) is None


@pytest.mark.parametrize("reader", fuzz.READERS)
def test_undamaged_files_are_no_finds(reader: str):
    for data in fuzz.bases()[reader][:3]:
        assert fuzz.find_in(reader, data) is None


@pytest.mark.parametrize("reader", ["spec", "machine", "disc", "measured"])
@pytest.mark.parametrize("place", ["/dev/zero", "."])
def test_devices_and_folders_are_refused(reader: str, place: str):
    with pytest.raises(CycloidError, match=r"is a device|is no plain file|cannot be read"):
        fuzz.READERS[reader](Path(place))


def test_an_archive_that_unpacks_to_more_than_the_memory_is_refused_unread(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setitem(LIMITS, "memory", Limit(4e6, "a thousandth"))
    file = tmp_path / "bomb.npz"
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("matrix.npy", "w") as member:
        member.write(bytes(10**7))
    assert file.stat().st_size < 2e4
    for reader in ("disc", "measured"):
        with pytest.raises(ResourceError, match=r"needs about .* GB of memory .*--allow-large"):
            fuzz.READERS[reader](file)


def test_an_error_of_another_kind_is_a_find(monkeypatch: pytest.MonkeyPatch):
    def broken(_: Path) -> None:
        raise ZeroDivisionError

    monkeypatch.setitem(fuzz.READERS, "spec", broken)
    assert fuzz.find_in("spec", b"x") == "ZeroDivisionError in elsewhere"
