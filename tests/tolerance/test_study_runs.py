"""Studies that are run: the same numbers whatever computes them, and after any break."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from cycloid_profile.effects import effect_from_table as effect
from cycloid_profile.errors import ToleranceError
from cycloid_profile.tolerance.model import QuantityModel
from cycloid_profile.tolerance.study import Draws, ParallelQuantities, Sobol, Store, Study, Threads, run
from cycloid_profile.tolerance.study.store import open_store

TABLES = (
    {"name": "single_pin_error", "each": "pin", "amount_um": {}, "batch_share": 0.3},
    {"name": "pin_position_error", "each": "pin", "amplitude_um": {}},
)


@pytest.fixture(scope="module")
def study(small, scattered) -> Study:
    return Study(small, Draws(scattered(*TABLES)), ("backlash_arcmin",), 290, chunk=64)


@pytest.fixture(scope="module")
def whole(study, tmp_path_factory) -> dict[str, bytes]:
    """Files of a run that nothing interrupts."""
    folder = tmp_path_factory.mktemp("whole")
    run(study, folder, Threads(1))
    return contents(folder)


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def values(store: Store) -> np.ndarray:
    return np.concatenate(list(store.tables()))


@dataclass
class Breaking:
    """Threads that fail after some chunks, and count what they were asked for."""

    after: int
    asked: list[int]

    def results(self, study: Study, numbers: Sequence[int]) -> Iterator[tuple[int, np.ndarray]]:
        for done, (number, answers) in enumerate(Threads(1).results(study, numbers)):
            if done == self.after:
                raise KeyboardInterrupt
            self.asked.append(number)
            yield number, answers


def test_all_reducers_are_there_in_order(study, whole, tmp_path):
    store = run(study, tmp_path, Threads(1))
    assert sorted(whole) == [*(f"part-{k:05d}.parquet" for k in range(5)), "study.json"]
    assert store.missing() == []
    wanted = np.concatenate([study.values(k) for k in range(study.chunks)])
    assert wanted.shape == (290, len(store.names))
    np.testing.assert_array_equal(values(store), wanted)
    for name, column in zip(store.names, wanted.T, strict=True):
        np.testing.assert_array_equal(np.concatenate(list(store.columns(name))), column)


def test_files_say_what_they_hold(study, tmp_path):
    import pyarrow.parquet as pq

    store = run(study, tmp_path, Threads(1))
    tables = [pq.read_table(path) for path in sorted(tmp_path.glob("part-*.parquet"))]
    assert {tuple(table.column_names) for table in tables} == {("reducer", *store.names)}
    np.testing.assert_array_equal(np.concatenate([table["reducer"].to_numpy() for table in tables]), np.arange(290))
    listed = json.loads((tmp_path / "study.json").read_text())
    assert listed["columns"] == list(store.names)
    assert listed["fingerprint"] == study.fingerprint


@pytest.mark.parametrize("count", [2, 3])
def test_threads_make_no_difference(study, whole, tmp_path, count):
    run(study, tmp_path, Threads(count))
    assert contents(tmp_path) == whole


@pytest.mark.parametrize("reducers", [1, 2, 7])
def test_side_by_side_gives_the_same_answers(study, reducers):
    quantity_model = study.quantity_model
    x = study.coordinates(0)[:reducers]
    both = ParallelQuantities(quantity_model)
    assert both.names == quantity_model.names
    assert np.array_equal(both.of(x), quantity_model.of(x))


@pytest.mark.parametrize("after", [0, 1, 3])
def test_a_run_that_broke_off_goes_on_where_it_was(study, whole, tmp_path, after):
    first = Breaking(after, [])
    with pytest.raises(KeyboardInterrupt):
        run(study, tmp_path, first)
    assert len(open_store(tmp_path, study).missing()) == 5 - after
    said: list[str] = []
    second = Breaking(99, [])
    run(study, tmp_path, second, said.append)
    assert sorted(first.asked + second.asked) == list(range(5))
    assert contents(tmp_path) == whole
    assert any("chunks are there" in line for line in said) == (after > 0)
    assert said[-1].startswith("290 of 290 reducers")


def test_nothing_is_computed_twice(study, tmp_path):
    run(study, tmp_path, Threads(1))
    before = {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()}
    again = Breaking(0, [])
    run(study, tmp_path, again)
    assert again.asked == []
    assert {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()} == before


def test_half_a_file_is_never_read(study, whole, tmp_path):
    run(study, tmp_path, Threads(1))
    part = tmp_path / "part-00002.parquet"
    # As a break in the middle of writing leaves it, and as a full disk or a lost copy does.
    (tmp_path / ".part-00003.parquet.0123abcd.partial").write_bytes(part.read_bytes()[:50])
    part.write_bytes(part.read_bytes()[:-30])
    (tmp_path / "part-00001.parquet").write_bytes(b"")
    (tmp_path / "part-00004.parquet").unlink()
    assert open_store(tmp_path, study).missing() == [1, 2, 4]
    again = Breaking(99, [])
    run(study, tmp_path, again)
    assert sorted(again.asked) == [1, 2, 4]
    assert contents(tmp_path) == whole


def test_one_flipped_bit_is_computed_again(study, whole, tmp_path):
    run(study, tmp_path, Threads(1))
    part = tmp_path / "part-00002.parquet"
    raw = bytearray(part.read_bytes())
    raw[len(raw) // 3] ^= 1
    part.write_bytes(raw)
    assert open_store(tmp_path, study).missing() == [2]
    run(study, tmp_path, Threads(1))
    assert contents(tmp_path) == whole


def test_numbers_that_were_changed_or_moved_are_computed_again(study, whole, tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    run(study, tmp_path, Threads(1))
    first, second, third = (tmp_path / f"part-0000{number}.parquet" for number in range(3))
    table = pq.read_table(first)
    columns = [table.column(0), *(pa.array(2.0 * column.to_numpy()) for column in table.columns[1:])]
    # A whole file with other numbers, the file of another chunk, and that of a study with another seed.
    pq.write_table(pa.table(columns, schema=table.schema), first)
    second.write_bytes(whole["part-00004.parquet"])
    run(other_studies(study)["seed"], tmp_path / "other", Threads(1))
    third.write_bytes((tmp_path / "other" / third.name).read_bytes())
    store = Store(tmp_path, study, study.quantity_model.names)
    assert store.missing() == [0, 1, 2]
    with pytest.raises(ToleranceError, match=r"part-00000\.parquet' was changed while the study ran \(the checksum"):
        list(store.columns(store.names[0]))


def test_one_process_computes_in_a_folder(study, whole, tmp_path):
    class Rival(Breaking):
        def results(self, study: Study, numbers: Sequence[int]) -> Iterator[tuple[int, np.ndarray]]:
            yield from super().results(study, numbers[:2])
            with pytest.raises(ToleranceError, match="are being computed by another process: wait for it"):
                run(study, tmp_path, Threads(1))
            yield from super().results(study, numbers[2:])

    run(study, tmp_path, Rival(99, []))
    assert contents(tmp_path) == whole
    run(study, tmp_path, Threads(1))


def test_another_study_is_cleared_only_after_the_first_result(study, tmp_path):
    class Unreachable:
        def results(self, *_):
            raise ToleranceError("scheduler", "'tcp://nobody'", "cannot be reached", "start one", " ")

    run(other_studies(study)["seed"], tmp_path, Threads(1))
    before = contents(tmp_path)
    with pytest.raises(ToleranceError, match="cannot be reached"):
        run(study, tmp_path, Unreachable())
    assert contents(tmp_path) == before


@pytest.mark.parametrize("count", [0, -1, 10**9])
def test_impossible_numbers_of_threads_are_refused(count):
    with pytest.raises(ToleranceError, match="is no number from 1 to 1024"):
        Threads(count)


def test_a_longer_study_keeps_the_chunks_that_were_full(study, tmp_path):
    run(study, tmp_path, Threads(1))
    longer = replace(study, samples=400)
    again = Breaking(99, [])
    store = run(longer, tmp_path, again)
    # The fifth chunk was cut off at 34 of its 64 reducers.
    assert sorted(again.asked) == [4, 5, 6]
    fresh = np.concatenate([longer.values(k) for k in range(longer.chunks)])
    np.testing.assert_array_equal(values(store), fresh)
    # And a shorter one is its beginning.
    np.testing.assert_array_equal(values(run(study, tmp_path, Threads(1))), fresh[:290])


def other_studies(study: Study) -> dict[str, Study]:
    reducer, draws = study.reducer, study.draws
    case = reducer.case
    return {
        "seed": replace(study, draws=replace(draws, seed=2)),
        "sequence": replace(study, draws=replace(draws, sequence=Sobol())),
        "batch": replace(study, draws=replace(draws, batch_size=50)),
        "width": replace(study, draws=replace(draws, tolerances=draws.tolerances.scaled([1.0, 1.1]))),
        "chunk": replace(study, chunk=128),
        "torque": replace(study, reducer=replace(reducer, case=replace(case, torque=2.1e4))),
        "tooth": replace(study, reducer=effect({"name": "disc_runout", "amplitude_um": 1.0}).apply(reducer)),
        "pins": replace(study, reducer=effect({"name": "pin_radius_error", "amount_um": 1.0}).apply(reducer)),
        "bores": replace(study, reducer=effect({"name": "crank_hole_error", "amplitude_um": 1.0}).apply(reducer)),
    }


def test_a_study_of_anything_else_has_another_name(study):
    others = [one.fingerprint for one in other_studies(study).values()]
    assert len({study.fingerprint, *others}) == 1 + len(others)
    assert replace(study).fingerprint == study.fingerprint


def test_files_of_another_study_are_cleared(study, whole, tmp_path):
    run(other_studies(study)["seed"], tmp_path, Threads(1))
    (tmp_path / "report.html").write_text("not ours")
    assert contents(tmp_path)["part-00000.parquet"] != whole["part-00000.parquet"]
    assert len(open_store(tmp_path, study).missing()) == 5
    assert not list(tmp_path.glob("part-*"))
    run(study, tmp_path, Threads(1))
    assert contents(tmp_path).pop("report.html") == b"not ours"
    assert {name: text for name, text in contents(tmp_path).items() if name != "report.html"} == whole


@pytest.mark.parametrize("text", ["", "{", "[1]", '{"schema": 0}'])
def test_a_study_file_that_says_nothing_is_no_reason_to_trust_the_parts(study, whole, tmp_path, text):
    run(study, tmp_path, Threads(1))
    (tmp_path / "study.json").write_text(text)
    assert len(open_store(tmp_path, study).missing()) == 5
    run(study, tmp_path, Threads(1))
    assert contents(tmp_path) == whole


def test_a_place_that_cannot_be_written_is_one_sentence(study, tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(ToleranceError) as caught:
        run(study, tmp_path / "file", Threads(1))
    assert str(tmp_path / "file") in str(caught.value)
    assert "--out" in caught.value.remedy
    assert "\n" not in str(caught.value)
    store = open_store(tmp_path / "good", study)
    (tmp_path / "good" / "part-00000.parquet").mkdir()
    with pytest.raises(ToleranceError, match="cannot be written"):
        store.put(0, np.zeros((64, len(store.names))))


def test_a_chunk_that_fails_ends_the_run_and_its_threads(study, tmp_path, monkeypatch):
    import threading

    def values(self: Study, number: int) -> np.ndarray:
        if number == 3:
            raise ZeroDivisionError
        return np.zeros((self.span(number)[1], len(self.quantity_model.names)))

    monkeypatch.setattr(Study, "values", values)
    before = threading.active_count()
    with pytest.raises(ZeroDivisionError):
        run(study, tmp_path, Threads(2))
    assert threading.active_count() == before


@pytest.mark.parametrize("known", [True, False], ids=["affinity known", "affinity not known"])
def test_as_many_threads_as_were_asked_for(study, monkeypatch, known):
    import concurrent.futures
    import os

    asked: list[int] = []

    class Pool(concurrent.futures.ThreadPoolExecutor):
        def __init__(self, count: int) -> None:
            asked.append(count)
            super().__init__(count)

    monkeypatch.setattr("cycloid_profile.tolerance.study.workers.ThreadPoolExecutor", Pool)
    if known:
        monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 3, 5}, raising=False)
    else:
        monkeypatch.delattr(os, "sched_getaffinity", raising=False)
        monkeypatch.setattr(os, "cpu_count", lambda: 4)
    for count in (1, 2, None):
        assert len(list(Threads(count).results(study, [0, 1]))) == 2
    assert asked == [1, 2, 3 if known else 4]


def test_half_the_width_is_half_the_scatter_of_the_same_reducers(study):
    half = study.with_tolerances(study.tolerances.scaled([0.5, 0.5]))
    np.testing.assert_allclose(half.coordinates(1), 0.5 * study.coordinates(1))
    assert half.fingerprint != study.fingerprint


@pytest.mark.parametrize("wanted", [("backlash_arcmin",), ("lost_motion_arcmin", "transmission_error_arcsec")])
@pytest.mark.parametrize("parts", [2, 3, 7])
def test_cuts_between_reducers_make_no_difference(study, wanted, parts):
    # The number of cores decides where the ranking of tolerances cuts.
    model = QuantityModel(study.reducer, study.changes, wanted)
    x = study.coordinates(0)[:29]
    cut = np.concatenate([model.of(some) for some in np.array_split(x, parts)])
    np.testing.assert_array_equal(cut, model.of(x))
