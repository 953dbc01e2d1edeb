"""Write docs/reference/, the map of the house in CONTRIBUTING.md and the list of rooms in docs/index.md.

Names and one-line descriptions come from the source text; nothing is imported. Run it after any change of a public
name or of its first docstring line: ``python docs/make_reference.py``. ``tests/test_docs.py`` checks that it was run.
"""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import takewhile
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "cycloid_profile"
BASE_MODULES = ("resources", "compiled", "filesystem", "units", "arrays", "errors")
LONGEST_VALUE = 60


@dataclass(frozen=True)
class PublicName:
    """One re-exported name: ``call`` with its parameters, and the first line of its docstring."""

    call: str
    text: str


@cache
def source(path: Path) -> ast.Module:
    """Syntax tree of a source file."""
    return ast.parse(path.read_text(encoding="utf-8"))


def file_of(module: str) -> Path:
    """Source file of a dotted module name."""
    path = ROOT.joinpath(*module.split("."))
    package = path / "__init__.py"
    return package if package.is_file() else path.with_suffix(".py")


def first_line(node: ast.Module | ast.ClassDef | ast.FunctionDef) -> str:
    """First paragraph of a docstring on one line, without its final stop."""
    paragraph = (ast.get_docstring(node) or "").split("\n\n")[0]
    return " ".join(paragraph.split()).removesuffix(".")


def re_exports(path: Path) -> dict[str, str]:
    """Public names of an ``__init__`` file and the module each is imported from, in alphabetical order.

    Names that are imported when first used are listed in a stub next to the file. Sub-rooms have their own tables.
    """
    package = ".".join(path.parent.relative_to(ROOT).parts)
    stub = path.with_suffix(".pyi")
    path = stub if stub.is_file() else path
    found = {}
    for node in source(path).body:
        if isinstance(node, ast.ImportFrom) and node.module:
            module = f"{package}.{node.module}" if node.level else node.module
            found.update({alias.asname or alias.name: module for alias in node.names})
    return dict(sorted(found.items(), key=lambda item: (item[0].lower(), item[0])))


def origin(name: str, module: str) -> Path:
    """Source file that defines ``name``."""
    path = file_of(module)
    further = re_exports(path) if path.name == "__init__.py" else {}
    return origin(name, further[name]) if name in further else path


def describe(name: str, module: str) -> PublicName:
    """Find ``name`` where it is defined and describe it."""
    path = origin(name, module)
    body = source(path).body
    for position, node in enumerate(body):
        if isinstance(node, ast.FunctionDef) and node.name == name:
            return PublicName(f"{name}({', '.join(parameters(node))})", first_line(node))
        if isinstance(node, ast.ClassDef) and node.name == name:
            return PublicName(name, first_line(node))
        if name in assigned(node):
            return PublicName(name, constant_text(node, body[position + 1 :], path))
    return PublicName(name, "")


def parameters(node: ast.FunctionDef) -> list[str]:
    """Parameter names as they are called; an optional one ends in ``=…``."""
    arguments = node.args
    positional = [*arguments.posonlyargs, *arguments.args]
    optional = len(positional) - len(arguments.defaults)
    names = [a.arg + ("=…" if i >= optional else "") for i, a in enumerate(positional)]
    names += [f"*{arguments.vararg.arg}"] if arguments.vararg else ["*"] if arguments.kwonlyargs else []
    names += [
        a.arg + ("" if d is None else "=…") for a, d in zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True)
    ]
    return names


def assigned(node: ast.stmt) -> set[str]:
    """Names that an assignment at module level binds."""
    targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
    return {leaf.id for target in targets for leaf in ast.walk(target) if isinstance(leaf, ast.Name)}


def constant_text(node: ast.stmt, following: list[ast.stmt], path: Path) -> str:
    """Text of a constant: the string below it, else the comment on its line or above it."""
    below = following[0] if following else None
    if isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant) and isinstance(below.value.value, str):
        return " ".join(below.value.value.split("\n\n")[0].split()).removesuffix(".")
    lines = path.read_text(encoding="utf-8").splitlines()
    if found := re.search(r"\s# (?!type:|noqa|fmt:)(.+)$", lines[node.lineno - 1]):
        return found[1].strip().removesuffix(".")
    above = list(takewhile(re.compile(r"# (?!fmt:)").match, reversed(lines[: node.lineno - 1])))
    return " ".join(line[2:] for line in reversed(above)).removesuffix(".") or value_text(node)


def value_text(node: ast.stmt) -> str:
    """Value of a constant if it is short, else its type."""
    value = node.value if isinstance(node, ast.Assign | ast.AnnAssign) else None
    text = " ".join(ast.unparse(value).split()) if value else ""
    if value and len(text) <= LONGEST_VALUE and not isinstance(value, ast.DictComp):
        return f"`{text}`"
    if isinstance(node, ast.AnnAssign):
        return f"`{ast.unparse(node.annotation)}`"
    return "Type" if text.startswith(("Literal", "Union")) else "Constant"


@cache
def rooms() -> tuple[str, ...]:
    """Rooms from the top to the bottom, in the order of the import contract."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"][
        "contracts"
    ]
    (layers,) = (contract["layers"] for contract in contracts if contract["type"] == "layers")
    names = [part.strip().removeprefix("cycloid_profile.") for layer in layers for part in layer.split(":")]
    return tuple(name for name in names if name not in BASE_MODULES)


def sub_rooms(room: str) -> list[str]:
    """Folders of a room that hold modules, as dotted names below the package."""
    folders = (path.parent for path in (PACKAGE / room).rglob("__init__.py"))
    names = (".".join(folder.relative_to(PACKAGE).parts) for folder in folders)
    return sorted(name for name in names if name != room and first_line(source(face(name))))


def face(room: str) -> Path:
    """The ``__init__`` file of a room or sub-room."""
    return PACKAGE.joinpath(*room.split(".")) / "__init__.py"


def name_table(names: dict[str, str]) -> str:
    """Markdown table of public names."""
    described = [describe(name, module) for name, module in names.items()]
    rows = [f"| `{one.call}` | {one.text.replace('|', chr(92) + '|') or '–'} |" for one in described]
    return "\n".join(["| name | description |", "|---|---|", *rows])


def sections(room: str) -> Iterator[str]:
    """Sections of a room's page: its own names, then the further ones of each sub-room."""
    yield f"# `cp.{room}`"
    yield first_line(source(face(room))) + "."
    own = re_exports(face(room))
    if own:
        yield name_table(own)
    for sub in sub_rooms(room):
        yield f"## `cp.{sub}`"
        yield first_line(source(face(sub))) + "."
        names = re_exports(face(sub))
        shared = [
            name for name, module in names.items() if name in own and origin(name, own[name]) == origin(name, module)
        ]
        if shared:
            yield f"Listed above: {', '.join(f'`{name}`' for name in shared)}."
        if further := {name: module for name, module in names.items() if name not in shared}:
            yield name_table(further)


def top_page() -> str:
    """Page of the names at the top of the package."""
    head = "The names of a whole design at the top of the package, with `import cycloid_profile as cp`."
    return "\n\n".join(["# `cp`", head, name_table(re_exports(PACKAGE / "__init__.py"))]) + "\n"


def house_map() -> str:
    """Rooms, sub-rooms and base modules with their one-line purpose."""
    lines = []
    for room in rooms():
        lines.append((room, first_line(source(face(room)))))
        lines += [("  " + sub.removeprefix(f"{room}."), first_line(source(face(sub)))) for sub in sub_rooms(room)]
    lines += [(name, first_line(source(PACKAGE / f"{name}.py"))) for name in BASE_MODULES]
    width = max(len(name) for name, _ in lines) + 2
    return "\n".join(["```text", *(f"{name:<{width}}{text}" for name, text in lines), "```"])


def room_list() -> str:
    """Links to the reference pages."""
    top = "- [`cp`](reference/cp.md): the names of a whole design"
    texts = ((room, first_line(source(face(room)))) for room in reversed(rooms()) if re_exports_anywhere(room))
    return "\n".join([top, *(f"- [`cp.{room}`](reference/{room}.md): {text}" for room, text in texts)])


def re_exports_anywhere(room: str) -> bool:
    """Whether a room or one of its sub-rooms has public names."""
    return any(re_exports(face(name)) for name in (room, *sub_rooms(room)))


def between(page: Path, part: str, text: str) -> str:
    """The page with the part between the markers of ``part`` replaced by ``text``."""
    begin, end = (f"<!-- {edge} {part}: docs/make_reference.py -->" for edge in ("begin", "end"))
    before, rest = page.read_text(encoding="utf-8").split(begin)
    return f"{before}{begin}\n{text}\n{end}{rest.split(end)[1]}"


def pages() -> dict[Path, str]:
    """Every generated page with its text."""
    folder = ROOT / "docs" / "reference"
    made = {folder / f"{room}.md": "\n\n".join(sections(room)) + "\n" for room in rooms() if re_exports_anywhere(room)}
    made[folder / "cp.md"] = top_page()
    for page, part, text in (
        (ROOT / "CONTRIBUTING.md", "house", house_map()),
        (ROOT / "docs" / "index.md", "rooms", room_list()),
    ):
        made[page] = between(page, part, text)
    return made


def main() -> None:
    """Write all pages and delete those of rooms that are gone."""
    made = pages()
    for page in (ROOT / "docs" / "reference").glob("*.md"):
        if page not in made:
            page.unlink()
    for page, text in made.items():
        page.parent.mkdir(exist_ok=True)
        page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
