"""Pairs of English texts and translations, and how the translation of a whole text is found from them.

A text is looked up as it is, then by templates such as "{} of {} pins loaded", whose parts are translated in turn,
then by its sentences, and last at its commas and colons. Of several ways the one that leaves least English wins.
"""

from __future__ import annotations

import itertools
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from functools import cache, cached_property
from pathlib import Path
from typing import NamedTuple

CLAUSES = "clauses"  # table of ends of error sentences, after the name and value at fault
SAME = "same"  # list of words that stay
_WORD = re.compile(r"[A-Za-z]{2,}")
_PLACE = re.compile(r"\{(\w*)\}")
_NUMBER = r"[-+−–±≤≥]{0,2} ?\d[\d.,]*(?:e[-+]?\d+)?"
_SENTENCES = re.compile(r"(?<=[a-z)\]%′″°\d][.!?]) (?=[\"“]?[A-Z]|[±χ])")
# Where nothing else is found, a text is cut at the first of these.
_JOINTS = {
    ": ": "：", "; ": "；", ", ": "，", " and ": " 和 ", " or ": " 或 ", " · ": " · ", " – ": " – ",
    " → ": " → ", " / ": " / ",
}  # fmt: skip
_BRACKETS = re.compile(r"(?P<before>.*?)(?P<open> ?[\[(])(?P<inner>[^\[\]()]+)(?P<close>[\])])(?P<after>.*)", re.DOTALL)


class Found(NamedTuple):
    """A translated text, and the parts of it that have no translation."""

    text: str
    missing: tuple[str, ...] = ()

    @property
    def letters(self) -> int:
        """Letters of English words that are left."""
        return sum(len(word) for part in self.missing for word in _WORD.findall(part))


class Template:
    """An English template with places in braces, and its translation.

    ``{}`` takes any text, ``{n}`` or ``{n1}`` a number, ``{s}`` or ``{s1}`` a name that stays; the translation names
    them by position or by name.
    """

    def __init__(self, english: str, translation: str) -> None:
        self.translation = translation
        self.names: list[str] = []
        pattern, at = "", 0
        for place in _PLACE.finditer(english):
            pattern += _literal(english[at : place.start()], first=at == 0)
            self.names.append(place[1])
            pattern += f"({_NUMBER})" if place[1].startswith("n") else "(.+?)"
            at = place.end()
        self.pattern = re.compile(pattern + _literal(english[at:], first=at == 0), re.DOTALL)
        literal = _PLACE.sub("\0", english)
        self.length = len(literal)
        self.word = max(_whole_words(literal), key=len, default="")

    def parts(self, text: str) -> tuple[str, ...] | None:
        """What stands in the places; None for a text of another form."""
        match = self.pattern.fullmatch(text)
        return None if match is None else match.groups()

    def filled(self, parts: Iterable[str]) -> str:
        """The translation with these parts."""
        values = list(parts)
        named = {name: value for name, value in zip(self.names, values, strict=True) if name}
        return self.translation.format(*values, **named)


class Translations:
    """Translations into one language; ``missed`` collects the parts without one."""

    def __init__(
        self, language: str, pairs: Mapping[str, str], clauses: Mapping[str, str], same: Iterable[str]
    ) -> None:
        self.language = language
        self.pairs, self.clauses = dict(pairs), dict(clauses)
        self.missed: dict[str, None] = {}
        whole = {**self.clauses, **self.pairs}
        self._same = frozenset(same)
        self._exact = {_key(one): _bare(two) for one, two in whole.items()}
        # As it is written first: "Parameters" of a help page are options, "parameters" of an effect are sizes.
        self._exact |= {_bare(one): _bare(two) for one, two in whole.items()} | {word: word for word in same}
        self._known: dict[str, Found] = {}

    @classmethod
    @cache
    def of(cls, language: str) -> Translations:
        """Translations of the files of a language."""
        pairs, clauses, same = dict[str, str](), dict[str, str](), list[str]()
        for path in sorted((Path(__file__).parent / language).glob("*.toml")):
            tables = tomllib.loads(path.read_text(encoding="utf-8"))
            same += tables.pop(SAME, [])
            clauses |= tables.pop(CLAUSES, {})
            for table in tables.values():
                pairs |= table
        return cls(language, pairs, clauses, same)

    def translate(self, text: str) -> str:
        """The translation of a text; parts without one stay English and are noted in ``missed``."""
        inner = text.strip()
        if not inner:
            return text
        found = self._find(inner)
        self.missed.update(dict.fromkeys(found.missing))
        start = text.index(inner)
        return text[:start] + found.text + text[start + len(inner) :]

    def error(self, what: str, joint: str, value: str, limit: str, remedy: str) -> str:
        """The sentence of an error; name and value stay next to each other."""
        subject = f"{self.translate(what)}{joint}{value if _is_name(value) else self.translate(value)}"
        return f"{subject} {self.translate(limit)}：{self.translate(remedy)}"

    @cached_property
    def _templates(self) -> dict[str, list[Template]]:
        """Templates by their longest word, and by "" those without a word; the most definite first."""
        behind = {f"{{}} {english}": f"{{0}} {_numbered(two, 1)}" for english, two in self.clauses.items()}
        found: dict[str, list[Template]] = {}
        for english, translation in {**behind, **self.clauses, **self.pairs}.items():
            if _PLACE.search(english):
                template = Template(_bare(english), _numbered(_bare(translation), 0))
                found.setdefault(template.word, []).append(template)
        for templates in found.values():
            templates.sort(key=lambda one: -one.length)
        return found

    def _find(self, text: str) -> Found:
        known = self._known.get(text)
        if known is None:
            # A text within itself, as by a template that takes all, stays as it is.
            self._known[text] = Found(text, (text,))
            known = self._known[text] = self._best(text)
        return known

    def _best(self, text: str) -> Found:
        if self._same.issuperset(_WORD.findall(text)):
            return Found(text)
        best = Found(text, (text,))
        for found in self._ways(text):
            if found.letters < best.letters:
                best = found
            if not best.letters:
                break
        return best

    def _ways(self, text: str) -> Iterator[Found]:
        """Translations of a text, the most definite first."""
        flat = text
        if "\n" in text:
            # The lines of a label stay lines; those of a paragraph are none.
            yield _joined(map(self._find_padded, text.split("\n")), "\n")
            flat = " ".join(text.split())
        bare, end = (flat[:-1], "。") if flat.endswith(".") and not flat.endswith("..") else (flat, "")
        exact = self._exact.get(bare) or self._exact.get(_key(bare))
        if exact is not None:
            # A name that stays keeps its letters: the unit Nm is not nm.
            yield Found((bare if exact in self._same else exact) + end)
            return
        candidates = [one for word in set(_whole_words(bare)) for one in self._templates.get(word, ())]
        for template in sorted(candidates, key=lambda one: -one.length):
            yield from self._filled(template, bare, end)
        sentences = _SENTENCES.split(flat)
        if len(sentences) > 1:
            yield _joined(map(self._find, sentences), "")
        for template in self._templates.get("", ()):
            yield from self._filled(template, bare, end)
        yield from self._cut(bare, end)

    def _filled(self, template: Template, text: str, end: str) -> Iterator[Found]:
        parts = template.parts(text)
        if parts is not None and text not in parts:
            found = [
                self._find_padded(one) if place[:1] != "s" else Found(one)
                for one, place in zip(parts, template.names, strict=True)
            ]
            yield Found(
                template.filled(one.text for one in found) + end, tuple(m for one in found for m in one.missing)
            )

    def _cut(self, text: str, end: str) -> Iterator[Found]:
        """The parts of a text before and after a joint, and in brackets."""
        if (match := _BRACKETS.fullmatch(text)) is not None:
            before, inner, after = (self._find_padded(match[name]) for name in ("before", "inner", "after"))
            whole = before.text + match["open"] + inner.text + match["close"] + after.text
            yield Found(whole + end, (*before.missing, *inner.missing, *after.missing))
        for joint, sign in _JOINTS.items():
            if joint in text:
                yield _joined((self._find_padded(part) for part in text.split(joint)), sign, end)
                first, rest = text.split(joint, 1)
                yield _joined((self._find_padded(first), self._find_padded(rest)), sign, end)

    def _find_padded(self, text: str) -> Found:
        inner = text.strip()
        if not inner:
            return Found(text)
        found = self._find(inner)
        start = text.index(inner)
        return Found(text[:start] + found.text + text[start + len(inner) :], found.missing)


def _joined(parts: Iterable[Found], sign: str, end: str = "") -> Found:
    found = list(parts)
    return Found(sign.join(one.text for one in found) + end, tuple(m for one in found for m in one.missing))


def _literal(text: str, first: bool) -> str:
    """Pattern of the fixed words of a template; the first letter of a sentence may be large."""
    if first and text[:1].isalpha():
        return f"[{text[0].lower()}{text[0].upper()}]{re.escape(text[1:])}"
    return re.escape(text)


def _whole_words(text: str) -> list[str]:
    """Words that are whole, in small letters: none that continues in a place of a template."""
    return [word.lower() for word in re.findall(r"(?<![\w\0])[A-Za-z]{2,}(?![\w\0])", text)]


def _numbered(translation: str, first: int) -> str:
    """A translation whose unnamed places carry numbers from ``first`` on; given numbers move by as much."""
    following = itertools.count(first)

    def numbered(place: re.Match[str]) -> str:
        name = place[1] or str(next(following))
        return f"{{{int(name) + first if place[1].isdigit() else name}}}"

    return _PLACE.sub(numbered, translation)


def _bare(text: str) -> str:
    """A text without its full stop, which its place decides."""
    return text[:-1] if text.endswith(("。", ".")) and not text.endswith("..") else text


def _key(text: str) -> str:
    bare = _bare(text)
    return bare[:1].lower() + bare[1:]


def _is_name(value: str) -> bool:
    return " " not in value
