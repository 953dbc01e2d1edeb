"""Signals that ask a process to stop, put off while a step must not be cut in two."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

STOPPING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))


@contextmanager
def signals_deferred() -> Iterator[None]:
    """A block that Ctrl-C and requests to end do not interrupt: they take effect at its end.

    Only the main thread receives signals; in others this does nothing.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    received: list[int] = []

    def note(number: int, _: FrameType | None) -> None:
        received.append(number)

    # A signal that is ignored, as under nohup, stays ignored; None is a handler that Python did not set.
    before = {one: signal.getsignal(one) for one in STOPPING}
    kept = {one: handler for one, handler in before.items() if handler not in (signal.SIG_IGN, None)}
    try:
        for one in kept:
            signal.signal(one, note)
        yield
    finally:
        for one, handler in kept.items():
            signal.signal(one, handler)
        if received:
            signal.raise_signal(received[0])
