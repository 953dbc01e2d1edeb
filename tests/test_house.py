"""The rules of the house in CONTRIBUTING.md, read from the source text: nothing is imported."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "cycloid_profile"
FOLDERS = sorted(path.parent for path in PACKAGE.rglob("__init__.py"))
ROOMS = sorted(folder for folder in FOLDERS if folder.parent == PACKAGE)
MODULES_OF_A_FOLDER = 12
FLOORS_OF_A_ROOM = 8


def name_of(folder: Path) -> str:
    """Dotted name of a folder, for the report of a test."""
    return ".".join(folder.relative_to(ROOT).parts)


def modules(folder: Path) -> list[Path]:
    """Modules of a folder without its ``__init__``."""
    return sorted(path for path in folder.glob("*.py") if path.name != "__init__.py")


@cache
def source(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def imports(path: Path) -> Iterator[tuple[str, str]]:
    """Module and name of every import from the package, but for those that only type checkers see."""
    package = ".".join(path.parent.relative_to(ROOT).parts)
    for node in _running(source(path)):
        if isinstance(node, ast.ImportFrom):
            module = f"{package}.{node.module or ''}".rstrip(".") if node.level == 1 else node.module or ""
            yield from ((module, alias.name) for alias in node.names if module.startswith("cycloid_profile"))
        elif isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names if alias.name.startswith("cycloid_profile"))


def _running(node: ast.AST) -> Iterator[ast.AST]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test):
            continue
        yield child
        yield from _running(child)


def imported_file(module: str, name: str) -> Path | None:
    """File that defines an imported name, looked up through the faces of rooms; None for a whole folder."""
    path = ROOT.joinpath(*module.split("."))
    if not (path / "__init__.py").is_file():
        return path.with_suffix(".py")
    if (path / f"{name}.py").is_file():
        return path / f"{name}.py"
    further = {known: origin for origin, known in imports(face(path))}
    known = name in further and further[name] != module
    return imported_file(further[name], name) if known else None


def face(folder: Path) -> Path:
    """File that lists the public names of a folder: a stub where they are imported when first used."""
    stub = folder / "__init__.pyi"
    return stub if stub.is_file() else folder / "__init__.py"


def re_exported(folder: Path) -> dict[str, Path | None]:
    """Names of a folder's face with the files that define them."""
    return {name: imported_file(module, name) for module, name in imports(face(folder))}


@pytest.mark.parametrize("folder", FOLDERS, ids=name_of)
def test_a_folder_has_a_dozen_modules(folder: Path) -> None:
    if folder != PACKAGE / "diagnosis":  # its search has more steps than a dozen files hold
        assert len(modules(folder)) <= MODULES_OF_A_FOLDER


@pytest.mark.parametrize("folder", FOLDERS, ids=name_of)
def test_a_folder_states_its_purpose_in_one_line(folder: Path) -> None:
    text = ast.get_docstring(source(folder / "__init__.py"))
    assert text, "no docstring"
    assert "\n" not in text.split("\n\n")[0]


@pytest.mark.parametrize("folder", [f for f in FOLDERS if f not in (PACKAGE, PACKAGE / "cli")], ids=name_of)
def test_modules_without_a_public_name_are_private(folder: Path) -> None:
    public = set(re_exported(folder).values())
    assert [path.name for path in modules(folder) if path not in public and not path.stem.startswith("_")] == []


@pytest.mark.parametrize("folder", FOLDERS, ids=name_of)
def test_no_module_is_called_like_a_public_name(folder: Path) -> None:
    # A module that is re-exported itself, such as cp.units, is no other thing of the same name.
    public = {name for module, name in imports(face(folder)) if module != name_of(folder)}
    assert {path.stem for path in modules(folder)} & public == set()


@pytest.mark.parametrize("room", [room for room in ROOMS if room.name != "diagnosis"], ids=name_of)
def test_imports_of_a_room_form_few_floors(room: Path) -> None:
    chain = longest_chain(room)
    assert len(chain) <= FLOORS_OF_A_ROOM, " > ".join(str(path.relative_to(room)) for path in chain)


def longest_chain(room: Path) -> tuple[Path, ...]:
    """Longest chain of imports among the modules of a room and its sub-rooms."""
    inside = [path for folder in FOLDERS if folder.is_relative_to(room) for path in modules(folder)]
    below = {
        path: {
            found
            for module, name in imports(path)
            if (found := imported_file(module, name)) and found in inside and found != path
        }
        for path in inside
    }
    known: dict[Path, tuple[Path, ...]] = {}

    def chain(path: Path, above: tuple[Path, ...]) -> tuple[Path, ...]:
        assert path not in above, f"modules import each other: {[str(p.relative_to(room)) for p in (*above, path)]}"
        if path not in known:
            known[path] = (path, *max((chain(p, (*above, path)) for p in sorted(below[path])), key=len, default=()))
        return known[path]

    return max((chain(path, ()) for path in inside), key=len, default=())


def code_of_pages() -> Iterator[tuple[str, str]]:
    """Name and Python of the examples, the README and the pages."""
    for path in sorted((ROOT / "examples").glob("*.py")):
        yield path.name, path.read_text(encoding="utf-8")
    for page in (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))):
        for block in re.findall(r"```(?:python|pycon)\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
            yield str(page.relative_to(ROOT)), block


# Words with many meanings, of which a reader has to guess one, and what says it plainly.
VAGUE = {
    "told": "reported, printed, given",
    "tell": "show, report, distinguish",
    "tells": "shows, reports, distinguishes",
    "alike": "equal, identical",
    "anew": "again",
    "beside": "next to, given, compared with",
    "laid": "placed, registered",
    "at hand": "given, available",
}
WRITTEN = [
    path
    for folder in ("cycloid_profile", "docs", "examples", "tests")
    for path in sorted((ROOT / folder).rglob("*"))
    if path.suffix in {".md", ".py", ".pyi", ".toml"} and path.name not in {"renamed.md", "test_house.py"}
]
# A key of the JSON output, a note of a recording with its translation and test, and names in the diagnosis.
KNOWN = {
    ("cycloid_profile/correction/json_output.py", "alike"),
    ("cycloid_profile/report/diagnosis/tables.py", "alike"),
    ("cycloid_profile/diagnosis/data/recording.py", "tell"),
    ("cycloid_profile/language/zh/results.toml", "tell"),
    ("tests/diagnosis/test_dense_scans.py", "tell"),
    ("cycloid_profile/diagnosis/data/noise.py", "beside"),
    ("cycloid_profile/diagnosis/model/exact_model.py", "anew"),
    ("cycloid_profile/diagnosis/change/_joint_model.py", "anew"),
}


def test_words_have_one_meaning() -> None:
    vague = re.compile(rf"\b(?:{'|'.join(VAGUE)})\b", re.IGNORECASE)
    found = {
        (str(path.relative_to(ROOT)), word.lower())
        for path in (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *WRITTEN)
        for word in vague.findall(path.read_text(encoding="utf-8").replace("_", " "))
    }
    assert {(file, word, VAGUE[word]) for file, word in found - KNOWN} == set()


def test_readers_import_rooms_and_nothing_deeper() -> None:
    deep = re.compile(r"^\s*(?:>>> )?(?:from|import) (cycloid_profile\.\w+\.[\w.]+)", re.MULTILINE)
    found = {(name, match) for name, code in code_of_pages() for match in deep.findall(code)}
    assert found == set()


def test_values_with_arrays_compare_by_identity_or_without_them() -> None:
    def asks_arrays(node: ast.ClassDef) -> bool:
        decorators = [ast.unparse(decorator) for decorator in node.decorator_list]
        fields = [ast.unparse(statement) for statement in node.body if isinstance(statement, ast.AnnAssign)]
        return (
            any("dataclass" in decorator and "eq=False" not in decorator for decorator in decorators)
            and not any(isinstance(part, ast.FunctionDef) and part.name == "__eq__" for part in node.body)
            and any(re.search(r": .*(Array|Matrix)\b", f) and "compare=False" not in f for f in fields)
        )

    # Two arrays compare element by element, which is neither true nor false.
    found = [
        f"{path.relative_to(PACKAGE)}: {node.name}"
        for path in sorted(PACKAGE.rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef) and asks_arrays(node)
    ]
    assert found == []
