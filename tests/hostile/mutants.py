"""Wrong physics on purpose: ``python -m tests.hostile.mutants geometry --number 60``; needs cosmic-ray.

A mutant is the package with one change: another operator, the next number, sine for cosine, a condition turned round.
A mutant that passes all tests of its room survives: the change means nothing, or a test is missing.
The sample is drawn by a fixed seed, a place first and then one change at it. No file is changed: the functions of a
running process are. Constants of modules, defaults, annotations and texts stay as they are.
"""

from __future__ import annotations

import argparse
import difflib
import json
import os
import random
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.operator import Operator
from cosmic_ray.operators.provider import OperatorProvider
from parso.python.tree import Name
from parso.tree import NodeOrLeaf

ROOT = Path(__file__).parents[2]
CHANGES = (
    *(f"ReplaceBinaryOperator_{pair}" for pair in (
        "Add_Sub", "Sub_Add", "Mul_Div", "Div_Mul", "Pow_Mul", "FloorDiv_Mul", "Mod_FloorDiv",
        "BitAnd_BitOr", "BitOr_BitAnd",
    )),
    *(f"ReplaceComparisonOperator_{pair}" for pair in (
        "Lt_GtE", "LtE_Gt", "Gt_LtE", "GtE_Lt", "Eq_NotEq", "NotEq_Eq", "Is_IsNot", "IsNot_Is",
    )),
    *(f"ReplaceUnaryOperator_Delete_{name}" for name in ("USub", "Not", "Invert")),
    "AddNot", "ReplaceAndWithOr", "ReplaceOrWithAnd", "ReplaceTrueWithFalse", "ReplaceFalseWithTrue",
    "ReplaceContinueWithBreak", "ZeroIterationForLoop", "NumberReplacer",
)  # fmt: skip
SWAPPED = (
    ("sin", "cos"), ("arcsin", "arccos"), ("tan", "sin"), ("min", "max"), ("minimum", "maximum"), ("argmin", "argmax"),
    ("floor", "ceil"), ("any", "all"), ("cumsum", "cumprod"), ("sum", "prod"), ("mean", "median"),
    ("real", "imag"), ("zeros", "ones"), ("zeros_like", "ones_like"),
)  # fmt: skip
TEXTS = ("_key_figures", "to_frame")  # functions that only describe
PASSED_OVER = ("annassign", "tfpdef", "decorator", "fstring", "raise_stmt", "import_from", "assert_stmt")


def files(folder: str, names: str) -> tuple[str, ...]:
    return tuple(f"tests/{folder}/test_{name}.py" for name in names.split())


# The tests that must notice a change in a folder of the package: those of the longest path that fits.
TESTS = {
    "geometry": ("tests/geometry", "tests/modification"),
    "modification": (
        "tests/modification", *files("compensation", "even_load"), *files("contact", "measured_deviation_gaps"),
    ),
    "compensation": ("tests/compensation",),
    "contact": files(
        "contact", "running pin_strength disc_equilibrium stage_numbers results_described bearing_life batch"
    ),
    "contact/mesh": files(
        "contact", "meshing_poses rv40e_backlash_numbers backlash exact_gaps measured_deviation_gaps"
    ),
    "contact/laws": files("contact", "line_contact_numbers linear_compliance pin_strength own_law contact_laws"),
    "contact/bodies": files(
        "contact", "support_kinematics running stage_numbers face_width supports elastic_disc roller_bearing"
    ),
    "contact/disc": files(
        "contact", "classical_scheme_numbers classical_scheme disc_equilibrium compiled_balance elastic_disc face_width"
    ),
    "contact/stage": files(
        "contact",
        "stage_numbers stage tangent stage_near stage_near_compiled stage_balance face_width supports "
        "linear_compliance",
    ),
    "effects": files(
        "effects",
        "removals effect_tables pins_on_springs first_order shape_families short_waves loops_of_real_reducers "
        "first_stage_and_forms effects_on_the_rig empirical plugins",
    ),
    "diagnosis/data": files(
        "diagnosis", "drift repeats gross_errors dense_scans noise bad_files likelihood hypotheses"
    ),
    "diagnosis/model": files(
        "diagnosis",
        "not_yet_proposed priors lobe_index exact_detectability other_locations unscanned_waves separable "
        "chatter_spectrum controls blind_cases likelihood detection hypotheses",
    ),
    "diagnosis/search": files(
        "diagnosis", "moves lobe_index other_locations unscanned_waves chatter_spectrum blind_cases seam"
    ),
    "diagnosis/verdict": files(
        "diagnosis", "explanations remainder nearest_effects result_description other_locations blind_cases change"
    ),
}  # fmt: skip
# Those of the compiled functions in a folder, which run uncompiled and some hundred times as long.
KERNEL_TESTS = {
    "contact/laws": files("contact", "line_contact_numbers contact_laws own_law disc_equilibrium compiled_balance"),
    "contact/bodies": (
        *files("contact", "roller_bearing face_width elastic_disc"),
        "--deselect=tests/contact/test_elastic_disc.py::test_forces_balance_and_deform_as_they_say[compiled]",
    ),
    "contact/disc": files("contact", "disc_equilibrium compiled_balance"),
    "contact/stage": (
        *files("contact", "stage_numbers stage tangent stage_balance face_width elastic_disc"),
        "tests/contact/test_stage_near_compiled.py::test_a_few_poses_settle_at_once_and_with_exact_gaps",
        "--deselect=tests/contact/test_elastic_disc.py::test_forces_balance_and_deform_as_they_say[compiled]",
    ),
}
ROOMS = ("geometry", "modification", "compensation", "contact", "effects", "diagnosis")
PACKAGE = ROOT / "cycloid_profile"


def tests_of(path: Path, kernel: bool) -> tuple[str, ...] | None:
    """Tests of a source file; None of one outside the rooms."""
    tests = KERNEL_TESTS if kernel else TESTS
    folders = [folder for folder in tests if (PACKAGE / folder) in path.parents]
    return tests[max(folders, key=len)] if folders else None


class SwapFunction(Operator):
    """Another function of the same arguments, such as sine for cosine."""

    other = {a: b for pair in SWAPPED for a, b in (pair, pair[::-1])} | {"abs": "float"}

    def mutation_positions(self, node: NodeOrLeaf) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
        if isinstance(node, Name) and node.value in self.other and not node.is_definition():
            yield node.start_pos, node.end_pos

    def mutate(self, node: Name, index: int) -> Name:  # noqa: ARG002
        node.value = self.other[node.value]
        return node

    @classmethod
    def examples(cls) -> tuple[()]:
        return ()


@dataclass(frozen=True)
class Mutant:
    path: Path
    line: int
    change: str
    text: str

    def __str__(self) -> str:
        old, new = ([*text.splitlines(), ""] for text in ((ROOT / self.path).read_text(), self.text))
        parts = [
            line
            for line in difflib.unified_diff(old, new, n=0, lineterm="")
            if not line.startswith(("---", "+++", "@@"))
        ]
        return f"{self.path}:{self.line} {self.change}\n  " + "\n  ".join(parts)


def operators() -> dict[str, Operator]:
    provider = OperatorProvider()
    return {"SwapFunction": SwapFunction(), **{name: provider[name]() for name in CHANGES}}


def means_something(node: NodeOrLeaf) -> bool:
    """Whether a node computes in the body of a function: no constant, default, annotation or text of a message."""
    inside = False
    while node.parent is not None:
        if node.parent.type == "funcdef" and node is node.parent.children[-1]:
            inside = True
        if node.parent.type in PASSED_OVER:
            return False
        if node.parent.type == "funcdef" and node is node.parent.annotation:
            return False
        if node.parent.type == "funcdef" and node.parent.name.value in TEXTS:
            return False
        node = node.parent
    return inside


def places_of(room: str) -> list[list[tuple[Path, int, str, int]]]:
    """All places of a folder, each with its changes: path, line, name of the operator, occurrence."""
    places: dict[tuple[Path, tuple[int, int]], list[tuple[Path, int, str, int]]] = {}
    for path in sorted((PACKAGE / room).rglob("*.py")):
        if path.name == "__init__.py" or tests_of(path, False) is None:
            continue
        tree = get_ast(path.read_text())
        for name, operator in operators().items():
            found = ((node, start) for node in ast_nodes(tree) for start, _ in operator.mutation_positions(node))
            for occurrence, (node, start) in enumerate(found):
                if means_something(node):
                    places.setdefault((path, start), []).append((path.relative_to(ROOT), start[0], name, occurrence))
    return [places[key] for key in sorted(places)]


def sample(room: str, number: int, seed: int) -> tuple[list[Mutant], int]:
    """Mutants of a room drawn by a seed, and the number of its places."""
    places, random_ = places_of(room), random.Random(seed)
    random_.shuffle(places)  # a larger number adds mutants to those of a smaller one
    drawn = []
    for place in places[:number]:
        path, line, name, occurrence = random_.choice(place)
        text = mutate_code((ROOT / path).read_text(), operators()[name], occurrence)
        drawn.append(Mutant(path, line, name, text))
    return drawn, len(places)


class Runs:
    """Tests of rooms, each collected in a process of its own that runs them for any number of mutants."""

    def __init__(self, python: str) -> None:
        self.python = python

    @cache  # noqa: B019
    def process(self, tests: tuple[str, ...], kernel: bool) -> subprocess.Popen[str]:
        """Kernels run uncompiled: a changed one would not reach the compiled callers of the cache."""
        places = {"PYTHONPATH": str(ROOT), "NUMBA_DISABLE_JIT": str(int(kernel))}
        words = [self.python, "-m", "tests.hostile.mutant_runs", *tests]
        pipe = subprocess.PIPE
        return subprocess.Popen(words, cwd=ROOT, env=os.environ | places, stdin=pipe, stdout=pipe, text=True)

    @staticmethod
    def status(process: subprocess.Popen[str], *texts: str) -> int:
        print(json.dumps(texts), file=process.stdin, flush=True)
        for line in process.stdout:
            if line.startswith("status "):
                return int(line.split()[1])
        raise SystemExit("the tests cannot be collected, or fail without a mutant")

    def answer(self, mutant: Mutant) -> str:
        kernel, path = "\nfrom cycloid_profile.compiled import" in mutant.text, ROOT / mutant.path
        process = self.process(tests_of(path, kernel), kernel)
        status = self.status(process, str(path), path.read_text(), mutant.text)
        return {0: "survived", 8: "untouched", -signal.SIGXCPU: "without end"}.get(status, "killed")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "rooms", nargs="*", metavar="ROOM", help="folder of the package, such as contact/mesh; without any, all six"
    )
    parser.add_argument("--number", type=int, default=60, help="mutants of each room")
    parser.add_argument("--seed", type=int, default=2026)
    parser.add_argument("--skip", type=int, default=0, help="mutants at the start of the sample that were tried before")
    parser.add_argument("--python", default=sys.executable, help="interpreter of the tests, if not this one")
    options = parser.parse_args()
    runs = Runs(options.python)
    for title in options.rooms or ROOMS:
        drawn, places = sample(title, options.number, options.seed)
        counts: Counter[str] = Counter()
        for mutant in drawn[options.skip :]:
            answer = runs.answer(mutant)
            counts[answer] += 1
            print(f"{answer}: {mutant}", flush=True)
        print(f"{title}: {dict(counts)} in a sample of {places} places", flush=True)


if __name__ == "__main__":
    main()
