"""Reads contour and polar programs of all four dialects back, block by block, to check what was written."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.export.biarc import Arcs

_WORD = re.compile(r"([A-Z]+)([+-]?\d+\.?\d*)")
_COMMENT = re.compile(r"\(.*?\)|;.*")
_CODES = {0: "rapid", 1: "line", 2: "clockwise", 3: "anticlockwise"}
_BEND = {"line": 0.0, "clockwise": -1.0, "anticlockwise": 1.0}


class Move(NamedTuple):
    """A block that moves in the plane: what kind, and where it ends [mm]; ``centre`` of an arc."""

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
            # A block may carry a compensation as well: what moves is its last G.
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
    """The cutting moves as chains, one for every stretch between rapid moves."""
    runs: list[tuple[list[complex], list[float]]] = []
    here = 0j
    for move in moves:
        if move.kind == "rapid":
            runs.append(([move.end], []))
        else:
            ends, bend = runs[-1]
            bend.append(0.0 if move.kind == "line" else _BEND[move.kind] / abs(here - move.centre))
            ends.append(move.end)
        here = move.end
    return [Arcs(np.array(ends), np.array(bend)) for ends, bend in runs if bend]


def read_gcode(path: Path) -> tuple[Arcs, dict[str, int]]:
    """The first stretch of cutting moves as a chain of arcs, and how many of each kind."""
    moves = read_moves(path)
    codes = {"G1": "line", "G2": "clockwise", "G3": "anticlockwise"}
    return cutting_runs(moves)[0], {code: sum(move.kind == kind for move in moves) for code, kind in codes.items()}


@dataclass(frozen=True, slots=True)
class Turn:
    """One turn of a polar program: ``x`` [mm] and ``c`` [°] after every step, from where the wheel stands at first."""

    x: FloatArray
    c: FloatArray


def read_turn(path: Path) -> Turn:
    """The turn of a polar program, in any dialect: the last infeed, and the incremental steps from there."""
    text = _COMMENT.sub("", path.read_text(encoding="ascii"))
    number = r"([+-]?\d+\.\d+)"
    steps = re.findall(rf"(?:G1 X|L IX){number} I?C{number} F", text)
    (c0,) = re.findall(rf"(?:G0|L) X[+-]?\d+\.\d+ C{number}", text)
    x0 = re.findall(rf"(?:G1|L) X{number} (?:R0 )?F\d", text)[-1]
    dx, dc = np.array(steps, dtype=np.float64).T
    return Turn(float(x0) + np.concatenate([[0.0], np.cumsum(dx)]), float(c0) + np.concatenate([[0.0], np.cumsum(dc)]))
