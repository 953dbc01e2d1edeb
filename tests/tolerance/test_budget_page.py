"""docs/budget.md: its tables are those of the code, its example runs.

``python tests/tolerance/test_budget_page.py`` writes the tables into the page.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "budget.md"
NAMES = ("sensitivities", "ranges", "methods", "budget", "remarks", "formulas")
NUMBER = re.compile(r"\d+(?:\.\d+)?")


def tables_of_the_example(page: str) -> tuple[Any, ...]:
    """Run the Python of the page and take its ``tables``."""
    (code,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    names: dict[str, Any] = {}
    exec(compile(code, "docs/budget.md", "exec"), names)
    tables: tuple[Any, ...] = names["tables"]
    return tables


def marks(name: str) -> tuple[str, str]:
    return f"<!-- begin {name} -->\n", f"<!-- end {name} -->"


def between(page: str, name: str) -> str:
    begin, end = marks(name)
    return page.split(begin)[1].split(end)[0].strip()


@pytest.fixture(scope="module")
def page() -> str:
    return PAGE.read_text(encoding="utf-8")


@pytest.mark.slow
def test_tables_are_those_of_the_code(page: str, capsys: pytest.CaptureFixture[str]) -> None:
    tables = tables_of_the_example(page)
    shown = capsys.readouterr().out
    assert all(table.title in shown and table.markdown in shown for table in tables)
    for name, table in zip(NAMES, tables, strict=True):
        printed, found = between(page, name), table.markdown
        assert NUMBER.sub("#", printed) == NUMBER.sub("#", found)
        for number, computed in zip(NUMBER.findall(printed), NUMBER.findall(found), strict=True):
            digits = len(number.partition(".")[2])
            # One unit of the last digit: a sum in another order may round the other way.
            assert float(number) == pytest.approx(float(computed), abs=1.01 * 10.0**-digits if digits else 0.0), name


def test_numbers_of_the_text_are_those_of_the_tables(page: str) -> None:
    budget = between(page, "budget") + between(page, "remarks")
    for number in ("0.784 ± 0.389", "0.784 ± 0.195", "0.0176", "±0.123"):
        assert number in budget


def test_equations_are_numbered_in_order(page: str) -> None:
    assert re.findall(r"\\tag\{(B\d+)\}", page) == [f"B{i}" for i in range(1, 14)]


if __name__ == "__main__":
    text = PAGE.read_text(encoding="utf-8")
    for name, table in zip(NAMES, tables_of_the_example(text), strict=True):
        begin, end = marks(name)
        before, rest = text.split(begin)
        text = before + begin + table.markdown + "\n" + end + rest.split(end, 1)[1]
    PAGE.write_text(text, encoding="utf-8")
