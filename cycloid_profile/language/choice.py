"""The chosen language: English unless another is asked for, never that of the machine: scripts read the same."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from cycloid_profile.errors import CycloidError, did_you_mean

if TYPE_CHECKING:
    from cycloid_profile.language._translations import Translations

ENGLISH = "en"
VARIABLE = "CYCLOID_PROFILE_LANGUAGE"  # of the environment
# One of the process, not of a context: the thread that repeats a step shows the language of the command.
_chosen: list[Translations] = []


def languages() -> tuple[str, ...]:
    """Codes of the languages: English, and each folder of translations."""
    return (ENGLISH, *sorted(path.name for path in Path(__file__).parent.iterdir() if any(path.glob("*.toml"))))


def chosen_language() -> str:
    """Code of the chosen language."""
    return _chosen[-1].language if _chosen else ENGLISH


@contextmanager
def use_language(code: str) -> Iterator[None]:
    """Texts leave the package in this language until the block ends; raises ``CycloidError`` for an unknown one."""
    if code not in languages():
        remedy = did_you_mean(code, languages(), f"choose {' or '.join(languages())}")
        raise CycloidError("language", f"'{code}'", "has no translations", remedy, " ")
    before = list(_chosen)
    try:
        _chosen.clear()
        if code != ENGLISH:
            # Loaded when another language is chosen: English costs nothing.
            from cycloid_profile.language._translations import Translations

            _chosen.append(Translations.of(code))
        yield
    finally:
        _chosen[:] = before


def translated(text: str) -> str:
    """The text in the chosen language; in English, or without a translation, as it is."""
    return _chosen[-1].translate(text) if _chosen else text


def error_sentences(error: CycloidError) -> tuple[str, ...]:
    """Sentences of an error in the chosen language."""
    if not _chosen:
        return error.sentences
    faults: tuple[CycloidError, ...] = getattr(error, "faults", ()) or (error,)
    # By its parts: the clauses of a whole sentence would have to be found first.
    return tuple(_chosen[-1].error(one.what, one.joint, str(one.value), one.limit, one.remedy) for one in faults)
