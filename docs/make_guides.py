"""Run the commands of docs/guides/ in order and write their output and pictures into the pages.

A page holds three kinds of blocks, each under a comment:

- ``<!-- append FILE -->`` above a ``toml`` block: the block is appended to a file;
- ``<!-- keep 1-4, 9 -->`` above a ``console`` block: its command is run, and those lines of its output are shown
  (``keep nothing`` shows none, ``last`` is the last line);
- ``<!-- picture FILE -->`` above an image: the picture is copied to where the image is.

``python docs/make_guides.py [GUIDE …]`` rewrites the pages; ``tests/test_docs.py`` runs them and compares (slow).
"""

from __future__ import annotations

import argparse
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).parents[1]
GUIDES = ROOT / "docs" / "guides"
BLOCK = re.compile(r"<!-- (append|keep|picture) (.+?) -->\n(?:```(\w+)\n(.*?)```|!\[.*?\]\((.*?)\))", re.DOTALL)
PROGRAMS = {
    "cycloid-profile": ["-c", "from cycloid_profile.cli.main import main; main()"],
    "python": [],
}


def kept_lines(output: str, kept: str) -> str:
    """The lines of ``output`` that ``kept`` asks for, counted from 1, with ``…`` for each gap."""
    lines = [line.rstrip() for line in output.rstrip().splitlines()]
    shown: list[str] = []
    last = 0
    for part in kept.split(","):
        first, _, end = part.strip().replace("last", str(len(lines))).partition("-")
        first_line, end_line = int(first), min(int(end or first), len(lines))
        shown += [*(["…"] if first_line > last + 1 else []), *lines[first_line - 1 : end_line]]
        last = end_line
    return "\n".join(shown + (["…"] if last < len(lines) else []))


def run_command(line: str, folder: Path) -> str:
    """Standard output of a command of a page, run in ``folder``; raises ``CalledProcessError`` where it fails."""
    program, *arguments = shlex.split(line)
    paths = (str(ROOT), os.environ.get("PYTHONPATH", ""))
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(path for path in paths if path), "COLUMNS": "110"}
    command = [sys.executable, *PROGRAMS[program], *arguments]
    return subprocess.run(
        command, cwd=folder, env=environment, check=True, stdout=subprocess.PIPE, encoding="utf-8"
    ).stdout


def remade(page: str, folder: Path, picture: Callable[[Path, str], None]) -> str:
    """The text of a page with its commands run in ``folder``; ``picture`` takes a file and the target of its image."""

    def block(found: re.Match[str]) -> str:
        verb, argument, _, text, target = found.groups()
        if verb == "append":
            with (folder / argument).open("a", encoding="utf-8") as file:
                file.write("\n" + text)
        elif verb == "picture":
            picture(folder / argument, target)
        else:
            command = text.removeprefix("$ ").splitlines()[0]
            printed = run_command(command, folder)
            shown = "" if argument == "nothing" else kept_lines(printed, argument)
            output = f"$ {command}\n" + (f"{shown}\n" if shown else "")
            return f"<!-- keep {argument} -->\n```console\n{output}```"
        return found[0]

    return BLOCK.sub(block, page)


def prepared(folder: Path) -> Path:
    """The folder with the example specs in it, as in a checkout."""
    (folder / "examples").symlink_to(ROOT / "examples")
    return folder


def main() -> None:
    """Rewrite the guides named on the command line, all of them by default."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("guides", nargs="*", help="names of guides, such as print; default all")
    names = parser.parse_args().guides or sorted(path.stem for path in GUIDES.glob("*.md"))
    for name in names:
        page = GUIDES / f"{name}.md"
        with TemporaryDirectory() as folder:
            text = remade(
                page.read_text(encoding="utf-8"),
                prepared(Path(folder)),
                lambda file, target: shutil.copyfile(file, GUIDES / target),
            )
        page.write_text(text, encoding="utf-8")
        print(page.relative_to(ROOT))


if __name__ == "__main__":
    main()
