"""docs/allocation.md: its example runs, its table is what comes out."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from cycloid_profile.tolerance.allocation import Allocation
from cycloid_profile.tolerance.allocation.result import AllocationStatus

ROOT = Path(__file__).parents[2]
NUMBER = re.compile(r"\d+\.\d+")


@pytest.mark.slow
def test_the_table_is_that_of_the_example(monkeypatch: pytest.MonkeyPatch) -> None:
    page = (ROOT / "docs" / "allocation.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    monkeypatch.chdir(ROOT)
    names: dict[str, Any] = {}
    exec(compile(code, "docs/allocation.md", "exec"), names)
    found: Allocation = names["found"]
    assert found.status is AllocationStatus.CONFIRMED
    assert found.saving_left < 1e-4
    rows = re.search(r"<!-- begin table -->\n(.*?)<!-- end table -->", page, re.DOTALL).group(1).splitlines()[2:]  # type: ignore[union-attr]
    for row, line in zip(rows, found.lines, strict=True):
        label, *numbers, bound = (cell.strip() for cell in row.strip("|").split("|"))
        expected = (line.plus_minus_before, line.plus_minus_after, line.ratio, line.cost_before, line.cost_after)
        assert (label, bound) == (line.label.replace("_", " "), line.bound)
        # The search stops within 1e-5 of its cost, which leaves 0.3 % of a ratio; and one unit of the last digit.
        assert [float(number) for number in numbers] == pytest.approx(expected, rel=0.003, abs=0.01)
    totals = re.search(r"<!-- begin totals -->(.*?)<!-- end totals -->", page).group(1)  # type: ignore[union-attr]
    after = found.yield_after
    expected = (found.cost_before, found.cost_after, 100.0 * found.yield_before.value, 100.0 * after.value,
            100.0 * after.low, 100.0 * after.high, found.cost_per_percent)  # fmt: skip
    assert [float(number) for number in NUMBER.findall(totals)] == pytest.approx(expected, abs=0.06, rel=0.003)
