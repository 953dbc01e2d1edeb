"""Photograph the reports for docs/reports.md: wide and narrow screen, a page of the PDF, a terminal of 80 columns.

``python docs/make_report_pictures.py`` needs the programs ``chromium`` and ``pdftoppm``, and the extra ``pdf``.
"""

from __future__ import annotations

import fcntl
import io
import os
import pty
import shutil
import struct
import subprocess
import sys
import termios
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

ROOT = Path(__file__).parents[1]
PICTURES = ROOT / "docs" / "pictures"
PROGRAM = (sys.executable, "-m", "cycloid_profile")
MEASURED = ("examples/measured/rv40e.toml", "examples/measured/scan.csv")
WIDE, NARROW, COLUMNS = 1280, 390, 80
COLOURS = 64


def photograph(page: str, width: int, height: int, scratch: Path) -> Image.Image:
    """The top of an HTML page on a screen of ``width`` by ``height`` pixels, however narrow."""
    frame = scratch / "frame.html"
    frame.write_text(
        f"<body style='margin:0'><iframe src='{page}' width={width} height={height} style='border:0'></iframe></body>",
        encoding="utf-8",
    )
    shot = scratch / "shot.png"
    window = ("--hide-scrollbars", "--allow-file-access-from-files", f"--window-size={max(width, 600)},{height}")
    call = ["chromium", "--headless=new", "--no-sandbox", "--disable-gpu", *window, f"--screenshot={shot}"]
    subprocess.run([*call, frame.as_uri()], check=True, capture_output=True)
    return Image.open(shot).crop((0, 0, width, height))


def keep(picture: Image.Image, name: str) -> None:
    """Write a picture with few colours."""
    picture.convert("RGB").quantize(COLOURS).save(PICTURES / f"{name}.png", optimize=True)


def printed(*words: str, folder: Path) -> str:
    """What a command prints in ``folder`` on a terminal of 80 columns."""
    leader, follower = pty.openpty()
    fcntl.ioctl(follower, termios.TIOCSWINSZ, struct.pack("HHHH", 100, COLUMNS, 0, 0))
    with subprocess.Popen([*PROGRAM, *words], cwd=folder, stdout=follower, stderr=subprocess.DEVNULL):
        os.close(follower)
        text = b""
        while True:
            try:
                text += os.read(leader, 4096)
            except OSError:  # the command has ended
                break
    os.close(leader)
    return text.decode("utf-8").replace("\r\n", "\n")


def terminal(command: str, scratch: Path) -> Image.Image:
    """A terminal that shows a command and what it prints in the folder ``scratch``."""
    from rich.console import Console
    from rich.terminal_theme import DEFAULT_TERMINAL_THEME
    from rich.text import Text

    text = f"$ cycloid-profile {command}\n{printed(*command.split(), '-q', folder=scratch)}".rstrip()
    console = Console(record=True, width=COLUMNS, file=io.StringIO())
    console.print(Text.from_ansi(text))
    page = scratch / "terminal.svg"
    page.write_text(console.export_svg(title="80 columns", theme=DEFAULT_TERMINAL_THEME), encoding="utf-8")
    return photograph(page.as_uri(), 994, 66 + round(24.4 * (text.count("\n") + 1)), scratch)


def main() -> None:
    """Write the reports into a scratch folder and photograph them."""
    with TemporaryDirectory() as folder:
        scratch = Path(folder)
        for command, files in (("build", ("examples/rv40e.toml",)), ("diagnose", MEASURED)):
            words = (*PROGRAM, command, *files, "--out", str(scratch / command), "-q", "--pdf")
            subprocess.run(words, cwd=ROOT, check=True, capture_output=True)
        diagnosis, design = (scratch / command / "report.html" for command in ("diagnose", "build"))
        keep(photograph(diagnosis.as_uri(), WIDE, 1750, scratch), "report_wide")
        keep(photograph(design.as_uri(), NARROW, 1100, scratch), "report_narrow")
        pdf = ("pdftoppm", "-r", "80", "-f", "1", "-l", "1", "-png", "-singlefile", str(design.with_suffix(".pdf")))
        subprocess.run([*pdf, str(scratch / "page")], check=True)
        keep(Image.open(scratch / "page.png"), "report_pdf")
        for file in MEASURED:
            shutil.copy(ROOT / file, scratch)
        keep(terminal("inspect rv40e.toml scan.csv --out inspected", scratch), "report_terminal")


if __name__ == "__main__":
    main()
