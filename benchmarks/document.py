"""Tables in pages of docs, docs/benchmarks.md if not said otherwise, each between two marks that name it."""

from __future__ import annotations

import os
import platform
import re
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path

PAGE = Path(__file__).parents[1] / "docs" / "benchmarks.md"


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A Markdown table."""
    head = list(head)
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def machine(libraries: Iterable[str] = ("numpy", "scipy")) -> str:
    """What the figures were measured on, in one line."""
    versions = ", ".join(f"{name} {version(name)}" for name in libraries)
    return f"Measured on: {_processor()}, {os.cpu_count()} cores; Python {platform.python_version()}, {versions}."


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    named = re.search(r"^model name\s*:\s*(.+)$", info.read_text(), re.MULTILINE) if info.exists() else None
    return named[1] if named else platform.processor() or platform.machine()


def put(name: str, text: str, path: Path = PAGE) -> None:
    """Print the text and write it between the marks of ``name``."""
    print(text)
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    page = path.read_text(encoding="utf-8")
    before, rest = page.split(begin)
    after = rest.split(end)[1]
    path.write_text(f"{before}{begin}\n{text}\n{end}{after}", encoding="utf-8")
