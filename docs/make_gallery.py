"""Draw the picture of every script of examples/ and list them in docs/gallery.md.

``python docs/make_gallery.py [NAME …]`` draws the named examples, by default all of them, and rewrites the page.
``tests/test_docs.py`` checks that the page lists every example with its own first sentence.
"""

from __future__ import annotations

import argparse
import ast
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).parents[1]
PICTURES = ROOT / "docs" / "pictures"
HEAD = """# Gallery

One picture for each script of [examples/](../examples). Every script imports `cycloid_profile as cp`, prints its
results and draws them. Run one with `python examples/NAME.py --out FOLDER`. `docs/make_gallery.py` writes this page.
"""


def examples() -> list[Path]:
    """The example scripts, simplest first."""
    return sorted((ROOT / "examples").glob("*.py"), key=lambda path: (path.stem != "quickstart", path.stem))


def first_sentence(script: Path) -> str:
    """First paragraph of a script's docstring."""
    text = ast.get_docstring(ast.parse(script.read_text(encoding="utf-8"))) or ""
    return " ".join(text.split("\n\n")[0].split())


def page() -> str:
    """The text of docs/gallery.md."""
    parts = [HEAD]
    for script in examples():
        parts.append(
            f"## {script.stem}\n\n{first_sentence(script)} [Source](../examples/{script.name})\n\n"
            f"![{script.stem}](pictures/example_{script.stem}.png)\n"
        )
    return "\n".join(parts)


def draw(script: Path) -> None:
    """Run a script and keep its picture."""
    with TemporaryDirectory() as folder:
        subprocess.run([sys.executable, str(script), "--out", folder], cwd=ROOT, check=True)
        shutil.copyfile(Path(folder) / f"{script.stem}.png", PICTURES / f"example_{script.stem}.png")


def main() -> None:
    """Draw the examples named on the command line and write the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("names", nargs="*", help="examples to draw, such as quickstart; default all")
    names = parser.parse_args().names
    for script in examples():
        if not names or script.stem in names:
            draw(script)
    (ROOT / "docs" / "gallery.md").write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
