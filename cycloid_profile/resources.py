"""What a computation needs, the limits above which it is refused, and the permission to exceed them.

A need is estimated from the input before the work begins. Needs above a tenth of a limit are stated.
"""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass, field
from typing import BinaryIO

from cycloid_profile.errors import ResourceError


@dataclass(frozen=True, slots=True)
class Limit:
    """The ``most`` of a resource that is taken without permission, and why that much."""

    most: float
    reason: str


# Half and double of these limits refuse and admit other inputs; no result depends on them.
LIMITS = {
    "memory": Limit(4e9, "half the memory of an ordinary computer [bytes]"),
    "disk": Limit(10e9, "free on most disks, and copied in minutes [bytes]"),
    "time": Limit(8.0 * 3600.0, "a night of one core [s]"),
}
_STATED_SHARE = 0.1
ALLOW = "--allow-large"


@dataclass(frozen=True, slots=True)
class Need:
    """What an input makes necessary: ``memory`` and ``disk`` [bytes], ``time`` of one core [s], all estimates.

    ``what`` and ``value`` name the input; ``remedy`` makes the need smaller.
    """

    what: str
    value: object
    remedy: str
    memory: float = 0.0
    disk: float = 0.0
    time: float = 0.0
    joint: str = " = "

    def require(self) -> None:
        """State the need if it is much; raises ``ResourceError`` if it exceeds a limit and that is not allowed."""
        session = _session.get()
        shares = {name: getattr(self, name) / limit.most for name, limit in LIMITS.items()}
        much = [name for name, share in shares.items() if share > _STATED_SHARE]
        over = [name for name in much if shares[name] > 1.0]
        if over and not session.allow_large:
            needs = " and ".join(f"{self._amount(name)} (limit {_text(name, LIMITS[name].most)})" for name in over)
            raise ResourceError(
                self.what, self.value, f"needs about {needs}", f"{self.remedy}, or add {ALLOW}", self.joint
            )
        if much:
            session.state(f"{self.what}{self.joint}{self.value} needs about {' and '.join(map(self._amount, much))}")

    def _amount(self, name: str) -> str:
        return f"{_text(name, getattr(self, name))}{'' if name == 'time' else f' of {name}'}"


@dataclass(frozen=True, slots=True)
class _Session:
    allow_large: bool = False
    say: Callable[[str], None] = lambda _: None
    stated: set[str] = field(default_factory=set)

    def state(self, sentence: str) -> None:
        """Say a sentence once: a search predicts the same files many times."""
        if sentence not in self.stated:
            self.stated.add(sentence)
            self.say(sentence)


_session: ContextVar[_Session] = ContextVar("cycloid_profile.resources", default=_Session())  # noqa: B039 - frozen


@contextmanager
def resource_limits(allow_large: bool = False, say: Callable[[str], None] = lambda _: None) -> Iterator[None]:
    """Within this context needs are stated by ``say``, and those above the limits are met if ``allow_large``."""
    before = _session.set(_Session(allow_large, say))
    try:
        yield
    finally:
        _session.reset(before)


def is_large_allowed() -> bool:
    """Whether needs above the limits are met here."""
    return _session.get().allow_large


def unpacked_need(archive: BinaryIO, what: str, value: str, memory_per_byte: float) -> Need:
    """What a ZIP archive needs once it is unpacked: a few bytes can unpack to any number. No archive needs nothing."""
    size = 0
    with suppress(zipfile.BadZipFile, ValueError, NotImplementedError, OSError), zipfile.ZipFile(archive) as opened:
        size = sum(one.file_size for one in opened.infolist())
    archive.seek(0)
    unpacked = f"{value} unpacked to {size / 1e6:,.0f} MB"
    return Need(what, unpacked, "keep less in it", memory=memory_per_byte * size, joint=" ")


def _text(name: str, amount: float) -> str:
    if name != "time":
        return f"{amount / 1e9:,.2g} GB" if amount < 1e11 else f"{amount / 1e9:,.0f} GB"
    return f"{amount / 60.0:,.0f} min of one core" if amount < 2.0 * 3600.0 else f"{amount / 3600.0:,.0f} h of one core"
