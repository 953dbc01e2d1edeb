"""Which effects of a set are named: those that few others could replace."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from cycloid_profile.diagnosis.verdict._alternatives import clear_effects, group_note


def effect(names: int, by: str = "") -> SimpleNamespace:
    return SimpleNamespace(group=tuple(f"effect_{i}" for i in range(names)), separate_by=by)


@pytest.mark.parametrize(
    ("sizes", "named"), [((1, 5), [0, 1]), ((2, 6), [0]), ((13, 1, 2), [1, 2]), ((9, 7), [1]), ((12,), [0])]
)
def test_a_further_effect_that_more_than_five_could_replace_is_not_named(sizes, named):
    assert clear_effects([effect(size) for size in sizes]) == named


def test_the_note_says_how_many_could_and_what_to_measure():
    note = group_note(effect(13, "profile_scan"))
    assert "13 effects" in note
    assert note.endswith("measure profile_scan")
    assert "effect_5" not in note
