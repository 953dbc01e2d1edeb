"""The plug-in of the examples, loaded for a test and forgotten after it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from cycloid_profile.effects import EFFECTS, Effect, load_plugins

THREE_JAW = Path(__file__).parents[1] / "examples" / "plugins" / "three_jaw.py"
NAME = "three_jaw_clamping"


def forget(*modules: str) -> None:
    """Remove all effects of plug-ins, and their modules."""
    for kind in EFFECTS.of_plugins:
        EFFECTS.remove(kind.name)
        sys.modules.pop(kind.__module__, None)
    for module in modules:
        sys.modules.pop(module, None)


@contextmanager
def three_jaw() -> Iterator[type[Effect]]:
    """The effect of the example."""
    forget("three_jaw")
    load_plugins([str(THREE_JAW)])
    try:
        yield EFFECTS[NAME]
    finally:
        forget()
