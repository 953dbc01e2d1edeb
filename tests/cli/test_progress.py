"""Remaining time of a command: from its counts, and from the last run of the same command."""

from __future__ import annotations

from pathlib import Path

import pytest

from cycloid_profile.cli.output._progress import Steps, command_words, keep_durations, known_durations


class Clock:
    """A clock that is set by hand [s]."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


def test_a_counted_step_shows_the_time_to_its_end() -> None:
    clock = Clock()
    steps = Steps(clock=clock)
    steps.show("10 of 100 reducers")
    assert steps.text() == "10 of 100 reducers"
    clock.now = 20.0
    steps.show("30 of 100 reducers")
    assert steps.text() == "30 of 100 reducers (70 s to go)"
    clock.now = 21.0
    steps.show("drawing")
    assert steps.text() == "drawing (21 s so far)"


def test_a_long_step_keeps_its_time_on_one_line() -> None:
    clock = Clock()
    steps = Steps(clock=clock)
    steps.show("every tolerance halved: backlash, least backlash, lost motion")
    clock.now = 12.0
    assert steps.text(40) == "every tolerance halved: b… (12 s so far)"


def test_a_step_that_states_its_own_time_is_left_as_it_is() -> None:
    clock = Clock()
    steps = Steps(clock=clock)
    clock.now = 10.0
    steps.show("1,000 of 2,000 reducers, 12 s to go")
    assert steps.text() == "1,000 of 2,000 reducers, 12 s to go"


def test_the_same_command_knows_how_long_it_took(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("platformdirs.user_cache_path", lambda _: tmp_path / "cache")
    token = command_words.set(("build", "a.toml"))
    try:
        assert known_durations() == []
        clock = Clock()
        steps = Steps(clock=clock)
        for clock.now, step in ((0.0, "reading"), (1.0, "computing"), (31.0, "drawing 1"), (41.0, "drawing 2")):
            steps.show(step)
        clock.now = 61.0
        keep_durations(steps.finish())
        clock.now = 100.0
        again = Steps(known_durations(), clock)
        again.show("computing")
        assert again.remaining() == pytest.approx(60.0)
        clock.now = 110.0
        assert again.text() == "computing (50 s to go)"
        again.show("drawing 1")
        assert again.text() == "drawing 1 (30 s to go)"
        command_words.set(("build", "b.toml"))
        assert known_durations() == []
        (tmp_path / "cache" / "durations.json").write_text("no JSON", encoding="utf-8")
        assert known_durations() == []
    finally:
        command_words.reset(token)


def test_a_cache_that_cannot_be_written_is_left_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    monkeypatch.setattr("platformdirs.user_cache_path", lambda _: tmp_path / "file")
    token = command_words.set(("build", "a.toml"))
    try:
        keep_durations([(0.0, "computing"), (9.0, "")])
    finally:
        command_words.reset(token)
    assert (tmp_path / "file").read_text(encoding="utf-8") == ""
