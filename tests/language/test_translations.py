"""Translations: every pair matches, whole texts are found from them, and English stays as it is."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest

from cycloid_profile.effects import EFFECTS, parameters
from cycloid_profile.errors import CycloidError, SpecError
from cycloid_profile.language import error_sentences, languages, translated, use_language
from cycloid_profile.language._translations import Translations
from cycloid_profile.report import TERMS
from cycloid_profile.spec.model import Spec
from cycloid_profile.spec.model.checks._suggestions import fields_of, tables_in
from cycloid_profile.spec.model.checks._validation import meta_in
from tests.language.clauses import PACKAGE, clauses

FILES = sorted((PACKAGE / "language").glob("*/*.toml"))
GLOSSARY = (PACKAGE.parent / "docs" / "glossary.md").read_text(encoding="utf-8")
CHINESE = re.compile(r"[\u4e00-\u9fff]")
PLACE = re.compile(r"\{(\w*)\}")
# A word of prose: no key, path or number with a unit.
WORD = re.compile(r"(?<![\w./='\-\[\"<{])[A-Za-z][a-z]+(?![\w/=.\-\[\"])")
# Words of commands and of file contents, which stay.
KEPT = {"true", "false", "each", "rayleigh", "pip", "install", "apt", "file", "per", "lobe", "bore", "free"}


def pairs() -> Iterator[tuple[str, str]]:
    """English and translation of every pair of every language."""
    for path in FILES:
        for name, table in tomllib.loads(path.read_text(encoding="utf-8")).items():
            if name != "same":
                yield from table.items()


def left_in_english(text: str) -> list[str]:
    """Words of the missing parts of a translated template, its places filled with a number."""
    found = Translations.of("zh")._find(text.replace("{}", "7"))
    return [word for part in found.missing for word in WORD.findall(part) if word not in KEPT]


def test_each_english_text_stands_once() -> None:
    texts = [english for english, _ in pairs()]
    assert [text for text in texts if texts.count(text) > 1] == []


def test_places_are_those_of_the_english_text() -> None:
    wrong = []
    for english, translation in pairs():
        names, used, unnamed = PLACE.findall(english), set(), 0
        for name in PLACE.findall(translation):
            if not name:
                unnamed, position = unnamed + 1, unnamed
            else:
                position = int(name) if name.isdigit() else names.index(name) if name in names else -1
            used.add(position)
        if used != set(range(len(names))):
            wrong.append(english)
    assert wrong == []


def test_every_translation_is_chinese_and_no_sentence_ends_it() -> None:
    same = {"json", "numpy", "sha256", "K1", "rpm"}
    named = [english for english, two in pairs() if not CHINESE.search(two) and not PLACE.search(two)]
    assert set(named) - same <= {english for english, two in pairs() if english == two}
    assert [two for _, two in pairs() if two.endswith("。")] == []


@pytest.mark.parametrize("part", ["limit", "remedy"])
def test_every_clause_of_an_error_is_translated(part: str) -> None:
    known = clauses()[part]
    assert len(known) > 150, "the errors of the package were not found"
    missing = {f"{place}: {text}": words for text, place in known.items() if (words := left_in_english(text))}
    assert missing == {}


def test_every_remedy_of_a_key_is_translated() -> None:
    def remedies(table: type[msgspec.Struct]) -> Iterator[str]:
        for annotation in fields_of(table).values():
            meta = meta_in(annotation)
            if meta is not None and meta.extra:
                yield str(meta.extra["remedy"])
            for inner in tables_in(annotation):
                yield from remedies(inner)

    found = set(remedies(Spec))
    assert len(found) > 50
    assert {text: words for text in found if (words := left_in_english(text))} == {}


def test_every_effect_is_translated() -> None:
    texts = [name.replace("_", " ") for name in EFFECTS]
    for kind in EFFECTS.values():
        first = " ".join(str(kind.__doc__).split("\n\n")[0].split())
        texts += [re.split(r"(?<=\.) (?=[A-Z])", first)[0], kind.remedy, *(one.text for one in parameters(kind))]
    assert {text: words for text in texts if (words := left_in_english(text))} == {}


def test_every_term_and_its_meaning_is_translated() -> None:
    assert {one.name: words for one in TERMS if (words := left_in_english(one.name))} == {}
    assert {one.meaning: words for one in TERMS if (words := left_in_english(one.meaning))} == {}


def glossary_terms() -> dict[str, str]:
    """Term and its Chinese words in docs/glossary.md."""
    found = {}
    for line in GLOSSARY.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 6 and CHINESE.search(cells[4]):
            found[cells[0]] = cells[4].rsplit(", ", 1)[0]
    return found


def test_terms_are_those_of_the_glossary() -> None:
    known = dict(pairs())
    terms = glossary_terms()
    assert len(terms) > 80
    wrong = {
        term: known.get(term)
        for term, words in terms.items()
        if not any(word in known.get(term, "") for word in re.split(r" or | \(", words))
    }
    assert wrong == {}


@pytest.mark.parametrize(
    ("english", "chinese"),
    [
        ("backlash, crank held [′]", "几何回差，曲柄固定 [′]"),
        ("lobe 27, ψ from −120° to 1°, missing material, 0.65 µm on average", None),
        ("All 12 checks passed.", "全部 12 项校核通过。"),
        ("Cumulative pitch error", "齿距累积误差"),
        ("scan.csv: profile scan", "scan.csv：齿廓扫描"),
        ("What it means", "含义"),
        ("2 to 3 of 5, 2 idle at best", "5 个中 2 至 3 个，至少 2 个不受载"),
        ("  whole loop\n", "  完整滞回曲线\n"),
        ("", ""),
        ("0.8159", "0.8159"),
    ],
)
def test_whole_texts_are_found_from_templates(english: str, chinese: str | None) -> None:
    with use_language("zh"):
        found = translated(english)
    assert found == chinese if chinese is not None else not WORD.search(found)


def test_an_error_keeps_name_and_value() -> None:
    error = CycloidError("drive.pins", 2, "is below 3", "give 3 to 1000 pins")
    several = SpecError.of([SpecError("load.a_nm", 1, "is negative", "give a number"), SpecError("x", 2, "differ", "")])
    with use_language("zh"):
        assert error_sentences(error) == ("drive.pins = 2 小于 3：请给出 3 至 1000 个针齿",)
        assert len(error_sentences(several)) == 2
        assert error_sentences(several)[0] == "load.a_nm = 1 为负：请给出一个数"
    assert error_sentences(error) == error.sentences


def test_a_text_without_translation_stays_and_is_noted() -> None:
    with use_language("zh"):
        assert translated("an unheard sentence of its own") == "an unheard sentence of its own"
    assert "an unheard sentence of its own" in Translations.of("zh").missed


def test_the_language_ends_with_its_block() -> None:
    assert languages() == ("en", "zh")
    with use_language("zh"), use_language("en"):
        assert translated("backlash") == "backlash"
    assert translated("backlash") == "backlash"
    with pytest.raises(CycloidError, match="choose en or zh"), use_language("xx"):
        pass


def test_english_loads_no_translations() -> None:
    code = (
        "import sys; from cycloid_profile.cli.main import run; run(['catalog']); "
        "sys.exit('cycloid_profile.language._translations' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, check=False).returncode == 0


def test_pairs_of_every_language_are_files_of_the_package() -> None:
    assert {path.parent.name for path in FILES} == set(languages()) - {"en"}
    assert Path(FILES[0]).is_relative_to(PACKAGE)
