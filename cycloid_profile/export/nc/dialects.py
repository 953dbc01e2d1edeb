"""NC dialects: one table of block templates per control, and the renderer that fills them for a machine."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from cycloid_profile.export.nc.machine import filled, machine_of
from cycloid_profile.spec.model import ExportSpec, MachineSpec

_LENGTHS = ("x", "y", "z", "i", "j", "cx", "cy", "diameter")
_SIGNED = ("x", "y", "z", "cx", "cy", "c")
_FEEDS = ("feed", "inverse", "mixed")


class Block(NamedTuple):
    """One step of a program: the ``kind`` of template and the ``words`` that fill it; ``feed`` may be absent."""

    kind: str
    words: Mapping[str, float | str] = {}


@dataclass(frozen=True, slots=True)
class NcDialect:
    """Grammar of one control.

    ``templates`` by kind of block; ``order`` of the program's parts; ``plus`` sign before positive numbers;
    ``numbered`` if every line begins with its number; ``inverse_time`` if it knows G93.
    """

    name: str
    templates: Mapping[str, str]
    order: tuple[str, ...] = ("begin", "turn", "main", "end")
    plus: str = ""
    numbered: bool = False
    inverse_time: bool = True


@dataclass(frozen=True, slots=True)
class Post:
    """The dialect and the machine that a program is written for."""

    dialect: NcDialect
    machine: MachineSpec

    @property
    def decimals(self) -> int:
        """Decimals of lengths."""
        return self.machine.numbers.decimals

    @property
    def angle_decimals(self) -> int:
        """Decimals of C."""
        return self.machine.numbers.angle_decimals

    @property
    def rounding(self) -> float:
        """Largest deviation of arcs by rounding: ends and centres move by half a unit in x and in y [mm]."""
        return math.sqrt(2.0) * 10.0**-self.decimals

    def rounded(self, z: complex) -> complex:
        """Position of the machine after a move to ``z``, with the decimals of the program."""
        return complex(round(z.real, self.decimals), round(z.imag, self.decimals))

    def own(self, *names: str, z: float = 0.0) -> list[Block]:
        """Blocks of the machine file by their keys, the height ``z`` [mm] filled in."""
        height = _word("z", z, self)
        lines = [line for name in names for line in filled(getattr(self.machine.blocks, name), self.machine, height)]
        return [Block("own", {"text": line}) for line in lines]


_ISO = {
    "own": "{text}",
    "comment": "({text})",
    "rapid": "G0 X{x} Y{y}",
    "height rapid": "G0 Z{z}",
    "height": "G1 Z{z}{feed}",
    "enter": "G1 X{x} Y{y}{feed}",
    "line": "G1 X{x} Y{y}{feed}",
    "clockwise": "G2 X{x} Y{y} I{i} J{j}{feed}",
    "anticlockwise": "G3 X{x} Y{y} I{i} J{j}{feed}",
    "leave": "G1 X{x} Y{y}{feed}",
    "polar rapid": "G0 X{x} C{c}",
    "polar infeed": "G1 X{x}{feed}",
    "polar step": "G1 X{x} C{c}{inverse}",
    "absolute begins": "G93",
    "absolute ends": "G94",
    "stop": "M0 ({text})",
}

LINUXCNC = NcDialect(
    "linuxcnc",
    _ISO
    | {
        "begin": "%",
        # The program gives the wheel's diameter, so that it depends on no radius in the tool table.
        "enter left": "G41.1 D{diameter}\nG1 X{x} Y{y}{feed}",
        "enter right": "G42.1 D{diameter}\nG1 X{x} Y{y}{feed}",
        "leave compensated": "G40\nG1 X{x} Y{y}{feed}",
        "turn begins": "o100 sub\nG91 G93",
        "turn ends": "G90 G94\no100 endsub",
        "turn": "o100 call",
        "end": "%",
    },
)

FANUC = NcDialect(
    "fanuc",
    _ISO
    | {
        "begin": "%\nO0001",
        "enter left": "G41 G1 X{x} Y{y} D{offset}{feed}",
        "enter right": "G42 G1 X{x} Y{y} D{offset}{feed}",
        "leave compensated": "G40 G1 X{x} Y{y}{feed}",
        "turn begins": "O0100\nG91 G93",
        "turn ends": "G90 G94\nM99",
        "turn": "M98 P0100",
        "end": "%",
    },
    order=("begin", "main", "turn", "end"),
)

SIEMENS = NcDialect(
    "siemens",
    _ISO
    | {
        "begin": "%_N_{program}_MPF\n;$PATH=/_N_MPF_DIR",
        "comment": "; {text}",
        "enter left": "G41 G1 X{x} Y{y} D{offset}{feed}",
        "enter right": "G42 G1 X{x} Y{y} D{offset}{feed}",
        "leave compensated": "G40 G1 X{x} Y{y}{feed}",
        # A section between labels is in the same file; a subprogram needs a separate file.
        "turn begins": "GOTOF MAIN\nTURN_BEGIN:\nG91 G93",
        "turn ends": "G90 G94\nTURN_END:\nMAIN:",
        "turn": "REPEAT TURN_BEGIN TURN_END P=1",
        "stop": "M0 ; {text}",
        "end": "",
    },
)

HEIDENHAIN = NcDialect(
    "heidenhain",
    {
        "own": "{text}",
        "begin": "BEGIN PGM {program} MM",
        "comment": "; {text}",
        "rapid": "L X{x} Y{y} R0 FMAX",
        "height rapid": "L Z{z} R0 FMAX",
        "height": "L Z{z} R0{feed}",
        "enter": "L X{x} Y{y} R0{feed}",
        "enter left": "L X{x} Y{y} RL{feed}",
        "enter right": "L X{x} Y{y} RR{feed}",
        "line": "L X{x} Y{y}{feed}",
        "clockwise": "CC X{cx} Y{cy}\nC X{x} Y{y} DR-{feed}",
        "anticlockwise": "CC X{cx} Y{cy}\nC X{x} Y{y} DR+{feed}",
        "leave": "L X{x} Y{y}{feed}",
        "leave compensated": "L X{x} Y{y} R0{feed}",
        "polar rapid": "L X{x} C{c} R0 FMAX",
        "polar infeed": "L X{x} R0{feed}",
        # No inverse time: F counts along the path of X in mm and C in degrees together.
        "polar step": "L IX{x} IC{c}{mixed}",
        "polar step absolute": "L X{x} C{c}{mixed}",
        "absolute begins": "",
        "absolute ends": "",
        "turn begins": "LBL 1",
        "turn ends": "LBL 0",
        "turn": "CALL LBL 1",
        "stop": "STOP ; {text}",
        "end": "END PGM {program} MM",
    },
    order=("begin", "main", "turn", "end"),
    plus="+",
    numbered=True,
    inverse_time=False,
)

POSTS: Mapping[str, NcDialect] = {post.name: post for post in (LINUXCNC, FANUC, SIEMENS, HEIDENHAIN)}


def post_of(export: ExportSpec) -> Post:
    """Dialect and machine from the ``[export]`` table of a spec."""
    machine = machine_of(export)
    return Post(POSTS[machine.control], machine)


def render(parts: Mapping[str, Iterable[Block]], post: Post) -> str:
    """Text of a program with ``parts`` named as in ``NcDialect.order``; absent parts are skipped."""
    lines: list[str] = []
    common: dict[str, float | str] = {"feed": "", "offset": str(post.machine.tool.offset)}
    for part in post.dialect.order:
        for block in parts.get(part, ()):
            words = {name: _word(name, value, post) for name, value in {**common, **block.words}.items()}
            text = post.dialect.templates[block.kind].format_map(words)
            lines += text.split("\n") if text else []
    return "\n".join(_numbered(lines) if post.dialect.numbered else lines) + "\n"


def _numbered(lines: list[str]) -> list[str]:
    """Lines with their numbers; a line after a tilde continues its block."""
    numbered: list[str] = []
    number, joined = 0, False
    for line in lines:
        numbered.append(line if joined else f"{number} {line}")
        number += not joined
        joined = line.endswith("~")
    return numbered


def _word(name: str, value: float | str, post: Post) -> str:
    if isinstance(value, str):
        return value
    if name in _FEEDS:
        return f" F{feed_word(value, post.machine, inverse=name == 'inverse')}"
    # Adding zero turns −0.0 into 0.0, which would print a sign that depends on rounding.
    decimals = post.angle_decimals if name == "c" else post.decimals
    number = f"{round(value, decimals) + 0.0:.{decimals}f}"
    return post.dialect.plus + number if name in _SIGNED and not number.startswith("-") else number


def feed_word(value: float, machine: MachineSpec, inverse: bool = False) -> str:
    """F within the range of the control, rounded down to its digits so that no limit is exceeded."""
    numbers = machine.numbers
    low, high = numbers.inverse_time_per_min if inverse else numbers.feed_mm_per_min
    unit = 10.0**-numbers.feed_decimals
    # A value that is a whole number of units must not lose one to its binary fraction.
    kept = math.floor(min(max(value, low), high) / unit * (1.0 + 1e-12)) * unit
    text = f"{max(kept, math.ceil(low / unit) * unit):.{numbers.feed_decimals}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text
