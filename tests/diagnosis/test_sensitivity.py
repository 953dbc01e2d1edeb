"""The script that halves and doubles each tuned number."""

from __future__ import annotations

from cycloid_profile.diagnosis import _tuned as tuned
from tests.diagnosis.sensitivity import Reply, recorded, scaled, table, tuned_names


def test_a_number_is_scaled_while_questions_are_asked_and_each_reading_recorded():
    before = tuned.OPEN
    with recorded("OPEN", 2.0) as read:
        during = tuned.OPEN
    assert read == {"OPEN"}
    assert (tuned.OPEN, during) == (before, 2.0 * before)
    with recorded("", 1.0) as read:
        assert tuned.BEAM + tuned.EXCHANGES > 0
    assert read == {"BEAM", "EXCHANGES"}


def test_every_tuned_number_changes():
    for name in tuned_names():
        value = getattr(tuned, name)
        assert scaled(value, 0.5) != value
        assert scaled(value, 2.0) != value
    assert scaled(3, 0.5) == 2
    assert scaled({"a": 0.0, "b": 3.0}, 2.0) == {"a": 0.0, "b": 6.0}


def test_the_table_counts_answers_that_a_number_changes():
    known = [
        Reply(1, "", 1.0, "right", ("BEAM", "OPEN")),
        Reply(2, "", 1.0, "right", ("OPEN",)),
        Reply(1, "BEAM", 0.5, "misnamed", ("BEAM", "OPEN")),
        Reply(1, "BEAM", 2.0, "right", ("BEAM", "OPEN")),
        Reply(1, "OPEN", 0.5, "unknown", ("OPEN",)),
    ]
    assert table(known, ["BEAM", "OPEN"]).splitlines()[2:] == [
        "| `BEAM` | 6 | 1 of 2 | 1 | 2 | 2 | 1, 0, 0 |",
        "| `OPEN` | 12 | 2 of 2 | 1 | 2 | 2 | 0, 0, 0 |",
    ]
