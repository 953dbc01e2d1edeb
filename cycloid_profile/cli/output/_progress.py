"""Current step of a command and the time to go: by its own count, or as the same command took before."""

from __future__ import annotations

import hashlib
import json
import re
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from contextvars import ContextVar
from pathlib import Path

from cycloid_profile.cli.output._encoding import said
from cycloid_profile.filesystem import new_file

SHORTEST = 3.0  # s; below, no time is shown
_MOST_COMMANDS = 200  # whose durations are kept
_COUNT = re.compile(r"([\d,]+) of (?:at most )?([\d,]+)")
_TO_GO = "to go"  # in steps that state their remaining time themselves

# Words of the running command: the same words take the same time again.
command_words: ContextVar[tuple[str, ...]] = ContextVar("command_words", default=())


class Steps:
    """The steps of one run. ``before`` holds start [s] and name of each step of an earlier run, and its end."""

    def __init__(self, before: Sequence[tuple[float, str]] = (), clock: Callable[[], float] = time.monotonic) -> None:
        self._before, self._clock = before, clock
        self._begun = self._phase_begun = clock()
        self._first_count = 0
        self.step = ""
        self.record: list[tuple[float, str]] = []

    def show(self, step: str) -> None:
        """Begin a step, or count within the current one."""
        if _name(step) != _name(self.step):
            self._phase_begun, self._first_count = self._clock(), _count(step)[0]
            self.record.append((self._phase_begun - self._begun, _name(step)))
        self.step = step

    def text(self, width: int | None = None) -> str:
        """The current step, cut to ``width``, with the seconds to go as far as they are known and not few."""
        remaining, passed = self.remaining(), self._clock() - self._begun
        time_shown = ""
        if _TO_GO not in self.step and remaining is not None and remaining >= SHORTEST:
            time_shown = f" ({_duration(remaining)} {_TO_GO})"
        elif _TO_GO not in self.step and passed >= SHORTEST:
            time_shown = f" ({_duration(passed)} so far)"
        step, time_shown = said(self.step, sys.stderr), said(time_shown, sys.stderr)
        if width is None:
            return step + time_shown
        from rich.cells import cell_len, set_cell_size

        if cell_len(step) + cell_len(time_shown) <= width:
            return step + time_shown
        return f"{set_cell_size(step, max(width - cell_len(time_shown), 1) - 1)}…" + time_shown

    def remaining(self) -> float | None:
        """Seconds to the end as the same command took before, else to the end of a counted step; None if unknown."""
        now = self._clock() - self._begun
        in_step = self._clock() - self._phase_begun
        starts = [start for start, name in self._before if name == _name(self.step)]
        if starts:
            return max(self._before[-1][0] - starts[0] - in_step, 0.0) if self._before[-1][0] > 0.0 else None
        done, wanted = _count(self.step)
        since = done - self._first_count
        return in_step * (wanted - done) / since if wanted and since > 0 and now > 0.0 else None

    def finish(self) -> list[tuple[float, str]]:
        """Starts and names of all steps, with the end."""
        return [*self.record, (self._clock() - self._begun, "")]


def known_durations() -> list[tuple[float, str]]:
    """Steps of the last run of the same command; empty if there was none."""
    with suppress(OSError, ValueError, TypeError, AttributeError):
        found = json.loads(_file().read_text(encoding="utf-8")).get(_key(), [])
        return [(float(start), str(name)) for start, name in found]
    return []


def keep_durations(steps: Sequence[tuple[float, str]]) -> None:
    """Keep the steps of a run that took its time for the next one; a cache that cannot be written is left alone."""
    if not command_words.get() or steps[-1][0] < SHORTEST:
        return
    with suppress(OSError):
        kept: dict[str, object] = {}
        with suppress(OSError, ValueError):
            kept = dict(json.loads(_file().read_text(encoding="utf-8")))
        kept.pop(_key(), None)
        kept[_key()] = [[round(start, 1), name] for start, name in steps]
        newest = dict(list(kept.items())[-_MOST_COMMANDS:])
        _file().parent.mkdir(parents=True, exist_ok=True)
        with new_file(_file()) as scratch:
            scratch.write_text(json.dumps(newest), encoding="utf-8")


def _file() -> Path:
    from platformdirs import user_cache_path

    return user_cache_path("cycloid-profile") / "durations.json"


def _key() -> str:
    return hashlib.sha256("\0".join(command_words.get()).encode()).hexdigest()[:16]


def _name(step: str) -> str:
    """A step without its numbers."""
    return re.sub(r"[\d.,]+", "#", step)


def _count(step: str) -> tuple[int, int]:
    """Number done and number wanted; 0, 0 where a step does not count."""
    found = _COUNT.search(step)
    return (0, 0) if found is None else (int(found[1].replace(",", "")), int(found[2].replace(",", "")))


def _duration(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90.0 else f"{seconds / 60.0:.0f} min"
