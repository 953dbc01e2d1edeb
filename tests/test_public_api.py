"""Public names: every room and every name listed can be used, and nothing heavy is imported for it."""

from __future__ import annotations

import ast
import importlib
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import cycloid_profile as cp

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "cycloid_profile"
ROOMS = sorted(path.parent for path in PACKAGE.rglob("__init__.py") if path.parent != PACKAGE)
FLAT = (
    "read_spec",
    "design_disc",
    "build_package",
    "Trochoid",
    "ToothProfile",
    "Drive",
    "LoadCase",
    "StageEquilibrium",
)


def exported(path: Path) -> list[str]:
    """Names that an ``__init__`` re-exports."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return [
        alias.asname for node in tree.body if isinstance(node, ast.ImportFrom) for alias in node.names if alias.asname
    ]


def test_every_listed_name_can_be_used() -> None:
    assert set(FLAT) < set(cp.__all__)
    assert set(exported(PACKAGE / "__init__.pyi")) | {"__version__"} == set(cp.__all__)
    for name in cp.__all__:
        assert getattr(cp, name) is not None


@pytest.mark.parametrize("room", ROOMS, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_every_room_says_what_it_is_for_and_re_exports_only(room: Path) -> None:
    text = (room / "__init__.py").read_text(encoding="utf-8")
    tree = ast.parse(text)
    purpose = ast.get_docstring(tree)
    assert purpose is not None
    assert "\n" not in purpose
    stub = room / "__init__.pyi"
    if stub.exists():
        assert "attach_stub(__name__, __file__)" in text
    else:
        assert all(isinstance(node, ast.ImportFrom | ast.Expr) for node in tree.body)
    module = importlib.import_module(".".join(room.relative_to(ROOT).parts))
    for name in exported(stub if stub.exists() else room / "__init__.py"):
        assert getattr(module, name) is not None


def test_import_is_light() -> None:
    code = (
        "import sys, cycloid_profile\n"
        "heavy = {'numpy', 'scipy', 'numba', 'OCP', 'build123d', 'lib3mf', 'ezdxf', 'matplotlib', 'shapely'}\n"
        "heavy |= {'jinja2', 'rich'}\n"
        "assert not heavy & set(sys.modules), heavy & set(sys.modules)\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT)


def test_a_misspelt_name_gets_the_nearest_one() -> None:
    with pytest.raises(AttributeError, match="did you mean read_spec"):
        _ = cp.reed_spec  # type: ignore[attr-defined]


def test_version_is_that_of_the_project_file() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert cp.__version__ == project["version"]
