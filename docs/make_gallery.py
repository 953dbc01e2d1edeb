"""Draw the picture of every script of examples/ and list them in docs/gallery.md.

``python docs/make_gallery.py [NAME …]`` draws the named examples, by default all of them, and rewrites the page.
The name ``drawing`` prints the workshop drawing of docs/exports.md, with the fields that the page gives.
``tests/test_docs.py`` checks that the page lists every example with its own first sentence.
"""

from __future__ import annotations

import argparse
import ast
import re
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


def print_sheet() -> None:
    """Print the drawing of the RV-40E as ezdxf's drawing add-on shows the DXF, lines in their widths."""
    import ezdxf
    from ezdxf.addons.drawing import config, matplotlib
    from PIL import Image

    fields = re.search(r"```toml\n(\[export\.drawing\].*?)```", (ROOT / "docs" / "exports.md").read_text("utf-8"), re.S)
    spec = (ROOT / "examples" / "rv40e.toml").read_text("utf-8") + "\n" + (fields[1] if fields else "")
    with TemporaryDirectory() as folder:
        (Path(folder) / "rv40e.toml").write_text(spec, "utf-8")
        command = [sys.executable, "-m", "cycloid_profile", "export", "rv40e.toml", "--format", "drawing", "--out", "."]
        subprocess.run(command, cwd=folder, check=True)
        layout = ezdxf.readfile(Path(folder) / "drawing.dxf").modelspace()
    # Widths of layers [mm] in points.
    widths = config.Configuration(lineweight_scaling=72.0 / 25.4, min_lineweight=0.01)
    white, size = "#ffffff", (420.0 / 25.4, 297.0 / 25.4)
    picture = PICTURES / "drawing.png"
    matplotlib.qsave(layout, picture, bg=white, fg="#000000", dpi=110, config=widths, size_inches=size)
    # Eight greys are enough, and a third of the size.
    Image.open(picture).convert("L").quantize(8).save(picture, optimize=True)


def main() -> None:
    """Draw the examples named on the command line and write the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("names", nargs="*", help="examples to draw, such as quickstart; default all")
    names = parser.parse_args().names
    for script in examples():
        if not names or script.stem in names:
            draw(script)
    if not names or "drawing" in names:
        print_sheet()
    (ROOT / "docs" / "gallery.md").write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
