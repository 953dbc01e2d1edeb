"""What a block looks like on each control: one table of templates a dialect, and the renderer that fills them in.

A program is a list of ``Block``s, the same for all controls. Numbers come as floats and are printed with the
decimals of their letter; a template may hold several lines, or none where a control needs no such block.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

from cycloid_profile.spec.export import ExportSpec

_PLACES = ("x", "y", "i", "j", "cx", "cy", "diameter", "c")
_SIGNED = ("x", "y", "cx", "cy", "c")


class Block(NamedTuple):
    """One step of a program: which template, and the words that go into it."""

    kind: str
    words: Mapping[str, float | str] = {}


@dataclass(frozen=True, slots=True)
class Post:
    """The dialect of one control: ``templates`` by kind of block, ``plus`` before positive numbers,
    ``numbered`` where every line begins with its number. ``order`` is where main program and subprogram stand.
    ``decimals`` of lengths.
    """

    name: str
    templates: Mapping[str, str]
    order: tuple[str, ...] = ("begin", "turn", "main", "end")
    plus: str = ""
    numbered: bool = False
    decimals: int = 5

    @property
    def angle_decimals(self) -> int:
        """Of C, which turns a circle of some 60 mm: one more makes it as fine as a length there."""
        return self.decimals + 1

    @property
    def rounding(self) -> float:
        """What rounding adds to the deviation of arcs: ends and centres move by half a unit in x and in y [mm]."""
        return math.sqrt(2.0) * 10.0**-self.decimals

    def stands(self, z: complex) -> complex:
        """Where the machine stands when it is told to go to ``z``."""
        return complex(round(z.real, self.decimals), round(z.imag, self.decimals))


_ISO = {
    "comment": "({text})",
    "rapid": "G0 X{x} Y{y}",
    "enter": "G1 X{x} Y{y}",
    "line": "G1 X{x} Y{y}",
    "clockwise": "G2 X{x} Y{y} I{i} J{j}",
    "anticlockwise": "G3 X{x} Y{y} I{i} J{j}",
    "leave": "G1 X{x} Y{y}",
    "feed": "F{f}",
    "polar rapid": "G0 X{x} C{c}",
    "polar retract": "G0 X{x}",
    "polar infeed": "G1 X{x} F{f}",
    "polar step": "G1 X{x} C{c} F{inverse}",
    "stop": "M0 ({text})",
    "thread": "M0 (THREAD THE WIRE)",
    "cut wire": "M0 (CUT THE WIRE)",
    "finish": "M30",
}

LINUXCNC = Post(
    "linuxcnc",
    _ISO
    | {
        "begin": "%",
        "contour": "G17 G21 G40 G90 G91.1 G94",
        # Exact path: without it the control may round the corners between steps.
        "polar": "G17 G21 G40 G61 G90 G94",
        # The control is told the wheel itself, as a diameter, so that it depends on no table.
        "enter left": "G41.1 D{diameter}\nG1 X{x} Y{y}",
        "enter right": "G42.1 D{diameter}\nG1 X{x} Y{y}",
        "leave compensated": "G40\nG1 X{x} Y{y}",
        "turn begins": "o100 sub\nG91 G93",
        "turn ends": "G90 G94\no100 endsub",
        "turn": "o100 call",
        "end": "%",
    },
)

FANUC = Post(
    "fanuc",
    _ISO
    | {
        "begin": "%\nO0001",
        "contour": "G17 G21 G40 G49 G80 G90 G94",
        "polar": "G21 G40 G90 G94",
        "enter left": "G41 G1 X{x} Y{y} D1",
        "enter right": "G42 G1 X{x} Y{y} D1",
        "leave compensated": "G40 G1 X{x} Y{y}",
        "turn begins": "O0100\nG91 G93",
        "turn ends": "G90 G94\nM99",
        "turn": "M98 P0100",
        "thread": "M60 (THREAD THE WIRE)",
        "cut wire": "M50 (CUT THE WIRE)",
        "end": "%",
    },
    order=("begin", "main", "turn", "end"),
)

SIEMENS = Post(
    "siemens",
    _ISO
    | {
        "begin": "%_N_{program}_MPF\n;$PATH=/_N_MPF_DIR",
        "comment": "; {text}",
        "contour": "G17 G71 G40 G90 G94",
        "polar": "G71 G40 G90 G94 DIAMOF",
        "enter left": "G41 G1 X{x} Y{y}",
        "enter right": "G42 G1 X{x} Y{y}",
        "leave compensated": "G40 G1 X{x} Y{y}",
        # A section between labels stands in the same file; a subprogram would be a file of its own.
        "turn begins": "GOTOF MAIN\nTURN_BEGIN:\nG91 G93",
        "turn ends": "G90 G94\nTURN_END:\nMAIN:",
        "turn": "REPEAT TURN_BEGIN TURN_END P=1",
        "stop": "M0 ; {text}",
        "thread": "M0 ; THREAD THE WIRE",
        "cut wire": "M0 ; CUT THE WIRE",
        "end": "",
    },
)

HEIDENHAIN = Post(
    "heidenhain",
    {
        "begin": "BEGIN PGM {program} MM",
        "comment": "; {text}",
        "contour": "",
        "polar": "",
        "rapid": "L X{x} Y{y} R0 FMAX",
        "feed": "FN 0: Q1 = +{f}",
        "enter": "L X{x} Y{y} R0 FQ1",
        "enter left": "L X{x} Y{y} RL FQ1",
        "enter right": "L X{x} Y{y} RR FQ1",
        "line": "L X{x} Y{y}",
        "clockwise": "CC X{cx} Y{cy}\nC X{x} Y{y} DR-",
        "anticlockwise": "CC X{cx} Y{cy}\nC X{x} Y{y} DR+",
        "leave": "L X{x} Y{y}",
        "leave compensated": "L X{x} Y{y} R0",
        "polar rapid": "L X{x} C{c} R0 FMAX",
        "polar retract": "L X{x} R0 FMAX",
        "polar infeed": "L X{x} R0 F{f}",
        # No inverse time: F counts along the path of X in mm and C in degrees together.
        "polar step": "L IX{x} IC{c} F{mixed}",
        "turn begins": "LBL 1",
        "turn ends": "LBL 0",
        "turn": "CALL LBL 1",
        "stop": "STOP ; {text}",
        "thread": "STOP ; THREAD THE WIRE",
        "cut wire": "STOP ; CUT THE WIRE",
        "finish": "M30",
        "end": "END PGM {program} MM",
    },
    order=("begin", "main", "turn", "end"),
    plus="+",
    numbered=True,
)

POSTS: Mapping[str, Post] = {post.name: post for post in (LINUXCNC, FANUC, SIEMENS, HEIDENHAIN)}


def post_of(export: ExportSpec) -> Post:
    """The dialect that a spec asks for, with its decimals."""
    return replace(POSTS[export.nc_dialect], decimals=export.nc_decimals)


def render(parts: Mapping[str, Iterable[Block]], post: Post) -> str:
    """Text of a program whose ``parts`` are named as in ``Post.order``; a part that is absent is left out."""
    lines: list[str] = []
    for part in post.order:
        for block in parts.get(part, ()):
            filled = post.templates[block.kind].format_map({k: _word(k, v, post) for k, v in block.words.items()})
            lines += filled.split("\n") if filled else []
    if post.numbered:
        lines = [f"{number} {line}" for number, line in enumerate(lines)]
    return "\n".join(lines) + "\n"


def _word(letter: str, value: float | str, post: Post) -> str:
    if isinstance(value, str):
        return value
    if letter in _PLACES:
        # Adding zero turns −0.0 into 0.0, which would print a sign that depends on rounding.
        places = post.angle_decimals if letter == "c" else post.decimals
        number = f"{round(value, places) + 0.0:.{places}f}"
        return post.plus + number if letter in _SIGNED and not number.startswith("-") else number
    # Feeds: those computed block by block need six digits, and none an exponent.
    short = f"{value:.{9 if letter == 'f' else 6}g}"
    return short if "e" not in short else f"{value:.6f}".rstrip("0").rstrip(".")
