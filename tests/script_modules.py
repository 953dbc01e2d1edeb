"""Scripts outside the package as modules: examples and generators of pages."""

from __future__ import annotations

import importlib.util
import sys
from functools import cache
from pathlib import Path
from types import ModuleType

ROOT = Path(__file__).parents[1]


@cache
def script(folder: str, name: str) -> ModuleType:
    """``folder/name.py`` as a module; each is imported once."""
    spec = importlib.util.spec_from_file_location(name, ROOT / folder / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


def example(name: str) -> ModuleType:
    """A script of examples/."""
    return script("examples", name)
