"""docs/spec.md lists every key with its default and limits, as the model has them."""

from __future__ import annotations

from pathlib import Path

from cycloid_profile.spec.io import key_reference

PAGE = Path(__file__).parents[2] / "docs" / "spec.md"


def test_the_page_holds_the_models_own_tables() -> None:
    assert key_reference() in PAGE.read_text(encoding="utf-8")


def test_every_key_has_a_meaning() -> None:
    rows = [line for line in key_reference().splitlines() if line.startswith("| `")]
    assert len(rows) > 30
    assert all(row.split("|")[4].strip() for row in rows)
