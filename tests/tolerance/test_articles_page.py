"""docs/articles.md: its tables on both disc bodies are those of the code, and its numbers agree with docs/budget.md.

``python tests/tolerance/test_articles_page.py`` writes the tables into the page.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from cycloid_profile.articles import PlainTable, article_tables, formula_table
from cycloid_profile.catalog import catalog_drive
from cycloid_profile.contact import LoadCase
from cycloid_profile.design.from_spec import conventional_profile, drive_of, load_case

PAGE = Path(__file__).parents[2] / "docs" / "articles.md"
NAMES = ("sensitivities", "deformation", "simulated", "measured", "parameters", "parts")
NUMBER = re.compile(r"\d+(?:\.\d+)?")


def case(body: str) -> LoadCase:
    spec = catalog_drive("rv40e").replace("load.disc_body", body)
    drive = drive_of(spec)
    return load_case(spec, drive, conventional_profile(spec, drive))


def tables() -> tuple[PlainTable, ...]:
    return article_tables(case("rigid"), case("elastic"))


def marks(name: str) -> tuple[str, str]:
    return f"<!-- begin article {name} -->\n", f"<!-- end article {name} -->"


def between(page: str, name: str) -> str:
    begin, end = marks(name)
    return page.split(begin)[1].split(end)[0].strip()


@pytest.mark.slow
def test_tables_on_both_bodies_are_those_of_the_code() -> None:
    page = PAGE.read_text(encoding="utf-8")
    for name, table in zip(NAMES, tables(), strict=True):
        printed, found = between(page, name), table.markdown
        assert NUMBER.sub("#", printed) == NUMBER.sub("#", found)
        for shown, computed in zip(NUMBER.findall(printed), NUMBER.findall(found), strict=True):
            digits = len(shown.partition(".")[2])
            # One unit of the last digit: a sum in another order may round the other way.
            assert float(shown) == pytest.approx(float(computed), abs=1.01 * 10.0**-digits if digits else 0.0), name


def test_columns_are_rigid_elastic_and_published() -> None:
    page = PAGE.read_text(encoding="utf-8")
    for name in NAMES:
        lines = between(page, name).splitlines()
        assert lines[0].endswith("| rigid disc | elastic disc | as published |")
        # Readable in a terminal.
        assert max(map(len, lines)) <= 82
        assert {line.count("|") for line in lines} == {5}


def test_both_pages_quote_one_tolerance_of_the_involute_stage() -> None:
    # Half bands by the printed and the corrected formula [′]; a tolerance is twice as wide.
    printed, corrected = (float(cell) for cell in formula_table(case("rigid").drive).rows[0][1:3])
    page = PAGE.read_text(encoding="utf-8")
    quoted = re.findall(r"printed formula ([\d.]+)′, corrected ([\d.]+)′", page)
    assert len(quoted) == 1
    assert [float(each) for each in quoted[0]] == pytest.approx([2.0 * printed, 2.0 * corrected], rel=2e-3)
    assert "0.53′" not in page


if __name__ == "__main__":
    text = PAGE.read_text(encoding="utf-8")
    for name, table in zip(NAMES, tables(), strict=True):
        begin, end = marks(name)
        before, rest = text.split(begin)
        text = before + begin + table.markdown + "\n" + end + rest.split(end, 1)[1]
    PAGE.write_text(text, encoding="utf-8")
