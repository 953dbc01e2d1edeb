"""A report read as a browser does: headings, sentences, tables, links and explanations of a page."""

from __future__ import annotations

from dataclasses import dataclass, field
from html.parser import HTMLParser
from itertools import takewhile
from pathlib import Path
from urllib.parse import unquote


@dataclass
class Page(HTMLParser):
    """What a reader finds on an HTML page."""

    links: list[str] = field(default_factory=list)
    explained: dict[str, str] = field(default_factory=dict)
    metas: list[dict[str, str | None]] = field(default_factory=list)
    texts: list[tuple[str, str]] = field(default_factory=list)  # element and text, those of pictures left out
    tables: int = 0
    tables_that_scroll: int = 0

    def __post_init__(self) -> None:
        super().__init__()
        self._open: list[tuple[str, dict[str, str | None]]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = dict(attrs)
        if tag == "meta":
            self.metas.append(found)
            return
        if tag == "a" and found.get("href"):
            self.links.append(unquote(str(found["href"])))
        if tag == "table":
            self.tables += 1
            self.tables_that_scroll += any("wide" in str(one.get("class")) for _, one in self._open)
        self._open.append((tag, found))

    def handle_endtag(self, tag: str) -> None:
        while self._open and self._open.pop()[0] != tag:
            pass

    def handle_data(self, data: str) -> None:
        tags = [tag for tag, _ in self._open]
        if not data.strip() or {"svg", "style"} & set(tags):
            return
        if tags[-1] == "abbr":
            self.explained[data] = str(self._open[-1][1]["title"])
        self.texts.append((tags[-1], data))

    @property
    def text(self) -> str:
        """All text outside of pictures."""
        return " ".join(" ".join(text for _, text in self.texts).split())

    @property
    def verdict(self) -> str:
        """The first strong text below the name of the drive."""
        first = [tag for tag, _ in self.texts].index("h1") + 1
        return "".join(text for _, text in takewhile(lambda one: one[0] in ("strong", "abbr"), self.texts[first:]))


def read_page(path: Path) -> Page:
    """The page in a file."""
    page = Page()
    page.feed(path.read_text(encoding="utf-8"))
    return page
