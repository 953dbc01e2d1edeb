"""Texts of the errors that the package raises, read from its source: f-strings as templates with {} in their places."""

from __future__ import annotations

import ast
import builtins
from collections.abc import Iterator
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parents[2] / "cycloid_profile"
PARTS = ("what", "value", "limit", "remedy", "joint")
FOREIGN = {name for name in dir(builtins) if name.endswith("Error")} | {"PinRadiusError", "UndefinedError"}


@cache
def clauses() -> dict[str, dict[str, str]]:
    """Every ``limit`` and every ``remedy`` of an error, each with a place where it is raised."""
    found: dict[str, dict[str, str]] = {"limit": {}, "remedy": {}}
    trees = {path: ast.parse(path.read_text(encoding="utf-8")) for path in sorted(PACKAGE.rglob("*.py"))}
    helpers = {name: parts for tree in trees.values() for name, parts in _helpers(tree)}
    for path, tree in trees.items():
        assigned = _assigned(tree)
        for call in ast.walk(tree):
            if isinstance(call, ast.Call) and (parts := _parts(call, helpers)):
                given = dict(zip(parts, call.args, strict=False)) | {one.arg: one.value for one in call.keywords}
                for part in found.keys() & given.keys():
                    for text in filter(None, _texts(given[part], assigned)):
                        found[part].setdefault(" ".join(text.split()), f"{path.relative_to(PACKAGE)}:{call.lineno}")
    return found


def _helpers(tree: ast.Module) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Functions and classes that take a limit and a remedy, with the names of what they take."""
    for node in ast.walk(tree):
        names: list[str] = []
        if isinstance(node, ast.FunctionDef):
            names = [one.arg for one in node.args.args if one.arg not in ("self", "cls")]
        elif isinstance(node, ast.ClassDef):
            names = [str(one.target.id) for one in node.body if _is_field(one)]  # type: ignore[attr-defined]
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and {"limit", "remedy"} & set(names):
            yield node.name, tuple(names)


def _is_field(node: ast.stmt) -> bool:
    return isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)


def _parts(call: ast.Call, helpers: dict[str, tuple[str, ...]]) -> tuple[str, ...]:
    """What the arguments of a call are, if it makes an error."""
    name = getattr(call.func, "id", getattr(call.func, "attr", ""))
    if name.endswith("Error") and name not in FOREIGN and len(call.args) + len(call.keywords) >= 4:
        return PARTS
    return helpers.get(name, ())


def _assigned(tree: ast.Module) -> dict[str, list[ast.expr]]:
    """Values of each name of a module."""
    found: dict[str, list[ast.expr]] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign):
            for target in node.targets:
                if isinstance(target, ast.Name):
                    found.setdefault(target.id, []).append(node.value)
                elif isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                    pairs = zip(target.elts, node.value.elts, strict=True)
                    for one, value in pairs:
                        if isinstance(one, ast.Name):
                            found.setdefault(one.id, []).append(value)
    return found


def _texts(node: ast.expr, assigned: dict[str, list[ast.expr]]) -> Iterator[str]:
    match node:
        case ast.Constant(value=str(text)):
            yield text
        case ast.JoinedStr():
            yield "".join(str(one.value) if isinstance(one, ast.Constant) else "{}" for one in node.values)
        case ast.IfExp():
            yield from _texts(node.body, assigned)
            yield from _texts(node.orelse, assigned)
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            yield from (a + b for a in _texts(left, assigned) for b in _texts(right, assigned))
        case ast.BoolOp():
            for value in node.values:
                yield from _texts(value, assigned)
        case ast.Call(func=ast.Name(id="did_you_mean"), args=[*_, otherwise]):
            yield "did you mean {}?"
            yield from _texts(otherwise, assigned)
        case ast.Name(id=name):
            for value in assigned.get(name, ()):
                if not isinstance(value, ast.Name):
                    yield from _texts(value, assigned)
