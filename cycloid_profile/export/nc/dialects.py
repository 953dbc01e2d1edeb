"""NC dialects: one table of block templates per control, the renderer that fills them, and the reader."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.export.curves import Arcs
from cycloid_profile.spec.model import ExportSpec

_POSITIONS = ("x", "y", "i", "j", "cx", "cy", "diameter", "c")
_SIGNED = ("x", "y", "cx", "cy", "c")
_WORD = re.compile(r"([A-Z]+)([+-]?\d+\.?\d*)")
_COMMENT = re.compile(r"\(.*?\)|;.*")
_CODES = {0: "rapid", 1: "line", 2: "clockwise", 3: "anticlockwise"}
_SIGN = {"line": 0.0, "clockwise": -1.0, "anticlockwise": 1.0}


class Block(NamedTuple):
    """One step of a program: the ``kind`` of template and the ``words`` that fill it."""

    kind: str
    words: Mapping[str, float | str] = {}


@dataclass(frozen=True, slots=True)
class NcDialect:
    """NC dialect of one machine control.

    ``templates`` by kind of block; ``order`` of the program's parts; ``plus`` sign before positive numbers;
    ``numbered`` if every line begins with its number; ``decimals`` of lengths.
    """

    name: str
    templates: Mapping[str, str]
    order: tuple[str, ...] = ("begin", "turn", "main", "end")
    plus: str = ""
    numbered: bool = False
    decimals: int = 5

    @property
    def angle_decimals(self) -> int:
        """Decimals of C: one more than for lengths gives the same resolution at a radius of about 60 mm."""
        return self.decimals + 1

    @property
    def rounding(self) -> float:
        """Largest deviation of arcs by rounding: ends and centres move by half a unit in x and in y [mm]."""
        return math.sqrt(2.0) * 10.0**-self.decimals

    def rounded(self, z: complex) -> complex:
        """Position of the machine after a move to ``z``, with the decimals of the program."""
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

LINUXCNC = NcDialect(
    "linuxcnc",
    _ISO
    | {
        "begin": "%",
        "contour": "G17 G21 G40 G90 G91.1 G94",
        # Exact path: without it the control may round the corners between steps.
        "polar": "G17 G21 G40 G61 G90 G94",
        # The program gives the wheel's diameter, so that it depends on no tool table.
        "enter left": "G41.1 D{diameter}\nG1 X{x} Y{y}",
        "enter right": "G42.1 D{diameter}\nG1 X{x} Y{y}",
        "leave compensated": "G40\nG1 X{x} Y{y}",
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

SIEMENS = NcDialect(
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
        # A section between labels is in the same file; a subprogram needs a separate file.
        "turn begins": "GOTOF MAIN\nTURN_BEGIN:\nG91 G93",
        "turn ends": "G90 G94\nTURN_END:\nMAIN:",
        "turn": "REPEAT TURN_BEGIN TURN_END P=1",
        "stop": "M0 ; {text}",
        "thread": "M0 ; THREAD THE WIRE",
        "cut wire": "M0 ; CUT THE WIRE",
        "end": "",
    },
)

HEIDENHAIN = NcDialect(
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

POSTS: Mapping[str, NcDialect] = {post.name: post for post in (LINUXCNC, FANUC, SIEMENS, HEIDENHAIN)}


def dialect_of(export: ExportSpec) -> NcDialect:
    """Dialect and number of decimals from the ``[export]`` table of a spec."""
    return replace(POSTS[export.nc_dialect], decimals=export.nc_decimals)


def render(parts: Mapping[str, Iterable[Block]], post: NcDialect) -> str:
    """Text of a program with ``parts`` named as in ``NcDialect.order``; absent parts are skipped."""
    lines: list[str] = []
    for part in post.order:
        for block in parts.get(part, ()):
            filled = post.templates[block.kind].format_map({k: _word(k, v, post) for k, v in block.words.items()})
            lines += filled.split("\n") if filled else []
    if post.numbered:
        lines = [f"{number} {line}" for number, line in enumerate(lines)]
    return "\n".join(lines) + "\n"


def _word(letter: str, value: float | str, post: NcDialect) -> str:
    if isinstance(value, str):
        return value
    if letter in _POSITIONS:
        # Adding zero turns −0.0 into 0.0, which would print a sign that depends on rounding.
        decimals = post.angle_decimals if letter == "c" else post.decimals
        number = f"{round(value, decimals) + 0.0:.{decimals}f}"
        return post.plus + number if letter in _SIGNED and not number.startswith("-") else number
    # Feeds computed for each block need six digits, and no exponent.
    short = f"{value:.{9 if letter == 'f' else 6}g}"
    return short if "e" not in short else f"{value:.6f}".rstrip("0").rstrip(".")


class Move(NamedTuple):
    """A move in the plane: its ``kind``, its ``end`` [mm], and the ``centre`` of an arc [mm]."""

    kind: str
    end: complex
    centre: complex = 0j


def read_moves(path: Path) -> list[Move]:
    """All moves in the plane of a contour program, in any dialect."""
    moves: list[Move] = []
    here = centre = 0j
    for line in path.read_text(encoding="ascii").splitlines():
        code = _COMMENT.sub("", line)
        klartext = re.match(r"\d+ (L|CC|C) (.*)", code)
        words = {letter: float(number) for letter, number in _WORD.findall(klartext[2] if klartext else code)}
        if "X" not in words and "Y" not in words:
            continue
        there = complex(words.get("X", here.real), words.get("Y", here.imag))
        if klartext is None:
            # A block may carry a compensation as well: its last G is the move.
            kind = _CODES[int(float(re.findall(r"G(\d+)", code)[-1]))]
            moves.append(Move(kind, there, here + complex(words.get("I", 0.0), words.get("J", 0.0))))
        elif klartext[1] == "CC":
            centre = there
            continue
        elif klartext[1] == "L":
            moves.append(Move("rapid" if "FMAX" in code else "line", there))
        else:
            moves.append(Move("anticlockwise" if "DR+" in code else "clockwise", there, centre))
        here = there
    return moves


def cutting_runs(moves: list[Move]) -> list[Arcs]:
    """The cutting moves as chains, one for each run between rapid moves."""
    runs: list[tuple[list[complex], list[float]]] = []
    here = 0j
    for move in moves:
        if move.kind == "rapid":
            runs.append(([move.end], []))
        else:
            ends, curvature = runs[-1]
            curvature.append(0.0 if move.kind == "line" else _SIGN[move.kind] / abs(here - move.centre))
            ends.append(move.end)
        here = move.end
    return [Arcs(np.array(ends), np.array(curvature)) for ends, curvature in runs if curvature]


def read_gcode(path: Path) -> tuple[Arcs, dict[str, int]]:
    """The first run of cutting moves as a chain of arcs, and the number of moves of each kind."""
    moves = read_moves(path)
    codes = {"G1": "line", "G2": "clockwise", "G3": "anticlockwise"}
    return cutting_runs(moves)[0], {code: sum(move.kind == kind for move in moves) for code, kind in codes.items()}


def read_revolution(path: Path) -> tuple[FloatArray, FloatArray]:
    """X [mm] and C [°] at the start and after every step of one revolution of C, shape (n + 1,), in any dialect.

    The first values are those of the last infeed of the polar program; its incremental steps follow.
    """
    text = _COMMENT.sub("", path.read_text(encoding="ascii"))
    number = r"([+-]?\d+\.\d+)"
    steps = re.findall(rf"(?:G1 X|L IX){number} I?C{number} F", text)
    (c0,) = re.findall(rf"(?:G0|L) X[+-]?\d+\.\d+ C{number}", text)
    x0 = re.findall(rf"(?:G1|L) X{number} (?:R0 )?F\d", text)[-1]
    dx, dc = np.array(steps, dtype=np.float64).T
    return float(x0) + np.concatenate([[0.0], np.cumsum(dx)]), float(c0) + np.concatenate([[0.0], np.cumsum(dc)])
