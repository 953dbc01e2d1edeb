"""docs/spec.md lists every key with its default and limits, and every material, as the model has them."""

from __future__ import annotations

from pathlib import Path

from cycloid_profile.spec.io import key_reference
from cycloid_profile.spec.model import MachineSpec, material_table

PAGE = Path(__file__).parents[2] / "docs" / "spec.md"


def test_the_page_holds_the_models_own_tables() -> None:
    assert key_reference() in PAGE.read_text(encoding="utf-8")


def test_the_page_of_machines_holds_the_keys_of_a_machine_file() -> None:
    assert key_reference(MachineSpec) in PAGE.with_name("machines.md").read_text(encoding="utf-8")


def test_the_page_holds_the_table_of_materials() -> None:
    assert material_table() in PAGE.read_text(encoding="utf-8")


def test_every_key_has_a_meaning() -> None:
    rows = [line for line in key_reference().splitlines() if line.startswith("| `")]
    assert len(rows) > 30
    assert all(row.split("|")[4].strip() for row in rows)
