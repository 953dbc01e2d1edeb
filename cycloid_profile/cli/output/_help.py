"""The help of commands and options in the chosen language."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from cyclopts.help import DefaultFormatter, InlineText
from rich.text import Text

from cycloid_profile.cli.output._encoding import said

if TYPE_CHECKING:
    from cyclopts.help import HelpEntry, HelpPanel
    from rich.console import Console, ConsoleOptions


class TranslatedHelp(DefaultFormatter):
    """Help pages whose usage, titles and descriptions are in the chosen language."""

    def __call__(self, console: Console, options: ConsoleOptions, panel: HelpPanel) -> None:
        entries = [_translated_entry(entry) for entry in panel.entries]
        super().__call__(console, options, panel.copy(title=said(str(panel.title)), entries=entries))

    def render_usage(self, console: Console, options: ConsoleOptions, usage: Any) -> None:  # noqa: ARG002
        """The usage line."""
        text = str(usage).strip()
        console.print(Text(said(text if text.startswith("Usage:") else f"Usage: {text}") + "\n"))

    def render_description(self, console: Console, options: ConsoleOptions, description: Any) -> None:  # noqa: ARG002
        """The paragraphs of a description."""
        if text := _plain(description):
            console.print(Text(translated_paragraphs(text) + "\n"))


def translated_paragraphs(text: str) -> str:
    """A text of several paragraphs in the chosen language."""
    return "\n\n".join(said(" ".join(paragraph.split())) for paragraph in text.strip().split("\n\n"))


def _translated_entry(entry: HelpEntry) -> HelpEntry:
    """An entry with its description; the library would add what may be given in English."""
    words = " ".join([said(_plain(entry.description)), *_notes(entry)])
    return entry.copy(description=InlineText(Text(words)), choices=None, default=None, required=False)


def _notes(entry: HelpEntry) -> Iterator[str]:
    if entry.choices:
        yield f"[{said('choices')}: {', '.join(entry.choices)}]"
    if entry.default is not None:
        yield f"[{said('default')}: {entry.default}]"
    if entry.required:
        yield f"[{said('required')}]"


def _plain(description: Any) -> str:
    return str(getattr(description, "primary_renderable", description) or "").strip()
