"""Random damage to every file that the package reads: ``python -m tests.hostile.fuzz --minutes 10``.

A reader may return a value or raise an error of the package; everything else is a find, and so is a file that takes
longer than ``SLOW``. The smallest file of each find is kept in ``tests/hostile/seeds``, NAME of the reader first; the
default tests read those again.
"""

from __future__ import annotations

import argparse
import hashlib
import io
import re
import tempfile
import time
import traceback
import warnings
import zipfile
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import seed as seeded
from hypothesis import strategies as st

from cycloid_profile.contact.bodies import read_disc_compliance
from cycloid_profile.design.from_spec import drive_of
from cycloid_profile.errors import CycloidError
from cycloid_profile.export.nc.machine import MACHINES, machine_text, read_machine
from cycloid_profile.export.writing.manifest import read_manifest
from cycloid_profile.measurement import read_measurement
from cycloid_profile.measurement.foreign import remembered
from cycloid_profile.spec import read_spec
from cycloid_profile.tolerance.study.store import Store

ROOT = Path(__file__).parents[2]
SEEDS = Path(__file__).with_name("seeds")
SLOW = 10.0  # s for one file of a few kB
_HEADER = ["x_mm", "y_mm"]
_VALUE = re.compile(rb"[=:,;\t] ?")
_TOKENS = (
    b"nan", b"inf", b"-1", b"0", b"1e308", b"1e-320", b"9" * 5000, b'""', b"[]", b"{}", b"[" * 2000, b"\x00", b"\xff",
    b"\xef\xbb\xbf", b"\n", b"\r", b"\t", b";", b",", b"=", b"#", b'"', b"# kind: ", b"# noise_um: nan\n", b"unit",
    b"true", b"1979-05-27", "µ°′″−".encode(), "µ°".encode("cp1252"), "俯".encode("gb18030"), b"1,5", b"1.000.000,5",
    b"]]", b"[[", b"inch", b"../../x", b"\x1b[31m", b"<!DOCTYPE x [<!ENTITY a 'b'>]>", b"&a;", b"PK\x03\x04",
)  # fmt: skip


class Parts:
    """What a store of samples asks of its study."""

    samples, chunk, chunks, fingerprint = 8, 8, 1, "0" * 64

    def span(self, _: int) -> tuple[int, int]:
        return 0, 8


def _read_spec(file: Path) -> None:
    drive_of(read_spec(file))


def _read_store(file: Path) -> None:
    store = Store(file.parent, Parts(), ("backlash_arcmin",))  # type: ignore[arg-type]
    (file.parent / "study.json").write_bytes(_study())
    file.replace(file.parent / "part-00000.parquet")
    if not store.missing():
        list(store.tables())


def _read_study(file: Path) -> None:
    file.replace(file.parent / "study.json")
    Store(file.parent, Parts(), ("backlash_arcmin",)).missing()  # type: ignore[arg-type]


def _named(name: str, read: Callable[[Path], object]) -> Callable[[Path], None]:
    def moved(file: Path) -> None:
        file.replace(file.parent / name)
        read(file.parent)

    return moved


READERS: dict[str, Callable[[Path], object]] = {
    "spec": _read_spec,
    "measured": read_measurement,
    "machine": read_machine,
    "disc": lambda file: read_disc_compliance(file, 3, 1),
    "mapping": _named(".mapping.toml", lambda folder: remembered(folder, _HEADER)),
    "samples": _read_store,
    "study": _read_study,
    "manifest": _named("manifest.json", read_manifest),
}


@cache
def _study() -> bytes:
    return (
        b'{"schema": 1, "fingerprint": "' + b"0" * 64 + b'", "columns": ["backlash_arcmin"], "chunk": 8}\n'
    )  # equal to the header of ``Parts``


@cache
def bases() -> dict[str, list[bytes]]:
    """Good files of each reader, which are then damaged."""
    foreign = (ROOT / "tests" / "measurement" / "foreign" / "files").iterdir()
    own = sorted((ROOT / "examples" / "measured").rglob("*.csv"))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        np.savez(folder / "a.npz", format="", key="k", lobes=3, per_lobe=4, matrix=np.eye(14), own=np.ones(12))
        Store(folder, Parts(), ("backlash_arcmin",)).put(0, np.ones((8, 1)))  # type: ignore[arg-type]
        disc, part = (folder / "a.npz").read_bytes(), (folder / "part-00000.parquet").read_bytes()
    mapping = (
        "# Columns of measured files by their header, as --columns writes them; reused for the next file of that "
        'header.\n[[mapping]]\nheader = ["x_mm", "y_mm"]\ncolumns = "x=1,y=-2,unit=mm,datum=free"\n'
    )
    found = {
        "spec": [one.read_bytes() for one in sorted((ROOT / "examples").glob("*.toml"))],
        "measured": [one.read_bytes()[:6000] if one.suffix == ".csv" else one.read_bytes()
                     for one in [*sorted(foreign), *own]],
        "machine": [machine_text(name).encode() for name in MACHINES],
        "disc": [disc],
        "mapping": [mapping.encode()],
        "samples": [part],
        "study": [_study()],
        "manifest": [(ROOT / "exports" / "rv40e" / "manifest.json").read_bytes()[:4000]],
    }  # fmt: skip
    for seed in sorted(SEEDS.iterdir()) if SEEDS.is_dir() else []:
        found[seed.name.split("-")[0]].append(seed.read_bytes())
    return found


@st.composite
def damaged(draw: st.DrawFn, reader: str) -> bytes:
    """A good file with a few pieces removed, doubled, exchanged or replaced, inside the members of an archive, too."""
    data = draw(st.sampled_from(bases()[reader]))
    members = _members(data)
    return _damaged_archive(draw, members) if members and draw(st.booleans()) else _damaged_bytes(draw, data)


@cache
def _members(data: bytes) -> dict[str, bytes]:
    """Members of an archive by name; none of a file that is no archive, or a damaged one."""
    with suppress(Exception), zipfile.ZipFile(io.BytesIO(data)) as archive:
        return {one.filename: archive.read(one) for one in archive.infolist()}
    return {}


def _damaged_bytes(draw: st.DrawFn, data: bytes) -> bytes:
    for _ in range(draw(st.integers(1, 6))):
        # Half of the places are where a value begins.
        values = [one.end() for one in _VALUE.finditer(data)] if draw(st.booleans()) else []
        at = draw(st.sampled_from(values) if values else st.integers(0, len(data)))
        end = min(len(data), at + draw(st.sampled_from((0, 0, 1, 1, 2, 4, 8, 40, 400, 10**6))))
        piece = draw(
            st.one_of(
                st.sampled_from(_TOKENS), st.binary(max_size=8), st.just(data[at:end] * 2), st.just(b""),
                st.integers(-(2**63), 2**64).map(lambda n: str(n).encode()), st.floats().map(lambda x: str(x).encode()),
            )
        )  # fmt: skip
        data = data[:at] + piece + data[end:]
    return data


def _damaged_archive(draw: st.DrawFn, good: dict[str, bytes]) -> bytes:
    """One member damaged before it is packed again, so that checksums are right."""
    name = draw(st.sampled_from(sorted(good)))
    members = good | {name: _damaged_bytes(draw, good[name])}
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for member, content in members.items():
            archive.writestr(member, content)
    return packed.getvalue()


def find_in(reader: str, data: bytes) -> str | None:
    """What is wrong with the answer of a reader to ``data``: None where it returns or refuses in one sentence."""
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        file = Path(folder) / "file.csv"
        file.write_bytes(data)
        try:
            READERS[reader](file)
        except CycloidError as error:
            if "\n" in str(error):
                return f"{type(error).__name__} of two lines"
        except Exception as error:
            own = [one for one in traceback.extract_tb(error.__traceback__) if "cycloid_profile" in one.filename]
            place = f"{Path(own[-1].filename).name}:{own[-1].name}" if own else "elsewhere"
            return f"{type(error).__name__} in {place}"
    return f"slow: over {SLOW:.0f} s" if time.monotonic() - began > SLOW else None


def fuzz(reader: str, seconds: float, number: int) -> tuple[int, dict[str, bytes]]:
    """Number of files read in ``seconds``, and the smallest file of each find."""
    count, finds = 0, dict[str, bytes]()
    until = time.monotonic() + seconds

    @seeded(number)
    @settings(
        max_examples=10**6,
        database=None,
        deadline=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(damaged(reader))
    def each(data: bytes) -> None:
        nonlocal count
        if time.monotonic() > until:
            raise TimeoutError
        count += 1
        what = find_in(reader, data)
        if what is not None and len(data) < len(finds.get(what, data + b"\0")):
            finds[what] = data

    with suppress(TimeoutError):
        each()
    return count, finds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--reader", choices=READERS, nargs="*", default=list(READERS))
    arguments = parser.parse_args()
    shares = Counter(dict.fromkeys(arguments.reader, 1.0))
    shares.update({name: 2.0 for name in ("measured", "spec") if name in shares})
    total = 0
    for reader, share in shares.items():
        seconds = 60.0 * arguments.minutes * share / sum(shares.values())
        count, finds = fuzz(reader, seconds, arguments.seed)
        total += count
        print(f"{reader:10} {count:7} files in {seconds:4.0f} s, {len(finds)} finds", flush=True)
        for what, data in finds.items():
            SEEDS.mkdir(exist_ok=True)
            name = f"{reader}-{hashlib.sha256(data).hexdigest()[:12]}"
            (SEEDS / name).write_bytes(data)
            print(f"    {what}: tests/hostile/seeds/{name}, {len(data)} bytes")
    print(f"{total} files")


if __name__ == "__main__":
    main()
