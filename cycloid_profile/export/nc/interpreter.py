"""Strict interpreter of the four dialects: runs a program as its control would, and refuses every unknown word."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cycloid_profile.errors import ExportError
from cycloid_profile.export.curves import Arcs
from cycloid_profile.export.nc._program_flow import Line, klartext_blocks, o_programs, o_words, sections
from cycloid_profile.export.nc.machine import built_in_machine
from cycloid_profile.spec.model import MachineSpec

_COMMENT = re.compile(r"\([^()]*\)|;.*")
_WORD = re.compile(r"([A-Z])([+-]?\d+\.?\d*)\s*")
_MOVES = {0: "rapid", 1: "line", 2: "clockwise", 3: "anticlockwise"}
_SIGN = {"line": 0.0, "clockwise": -1.0, "anticlockwise": 1.0}
_SHARED_G: set[float] = {0, 1, 2, 3, 17, 40, 54, 55, 56, 57, 90, 91, 93, 94}
_G: dict[str, set[float]] = {
    "linuxcnc": _SHARED_G | {21, 41.1, 42.1, 43, 49, 58, 59, 61, 64, 80, 91.1},
    "fanuc": _SHARED_G | {21, 41, 42, 43, 49, 58, 59, 61, 64, 80},
    "siemens": _SHARED_G | {41, 42, 60, 64, 71},
}
_SHARED_M: set[float] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 30}
_M: dict[str, set[float]] = {"linuxcnc": _SHARED_M, "fanuc": _SHARED_M | {50, 60}, "siemens": _SHARED_M | {17}}
_LETTERS = {"linuxcnc": "GMFSTDHXYZCIJ", "fanuc": "GMFSTDHXYZCIJ", "siemens": "GMFSTDXYZCIJ"}
_NAMED = {"siemens": ("DIAMOF",)}
_UNITS_OF_ARC = 4.0  # last decimals by which the radii at both ends of an arc may differ


class Position(NamedTuple):
    """Axes X, Y, Z [mm] and C [°]; not a number before the first word of an axis."""

    x: float
    y: float
    z: float
    c: float

    @property
    def plane(self) -> complex:
        """x + iy [mm]."""
        return complex(self.x, self.y)


class State(NamedTuple):
    """Modal state during a motion: ``spindle`` [1/min], 0 when off; ``side`` of the radius compensation, or "".

    ``diameter`` given with the compensation [mm]; ``feed`` in mm/min, or 1/min with ``inverse``.
    """

    tool: int = 0
    offset: int = 0
    work_offset: int = 0
    spindle: float = 0.0
    coolant: bool = False
    side: str = ""
    diameter: float = 0.0
    feed: float = math.nan
    inverse: bool = False
    threaded: bool = False
    flushing: bool = False


class Motion(NamedTuple):
    """One motion: number of its ``line``, its ``kind``, ends, ``centre`` of an arc [mm], and the modal ``state``."""

    line: int
    kind: str
    start: Position
    end: Position
    centre: complex
    state: State


class Program(NamedTuple):
    """A program that has been run: its motions, the state at its end, and the stops as (motions before, text)."""

    motions: list[Motion]
    state: State
    stops: list[tuple[int, str]]


def interpret(text: str, machine: MachineSpec, name: str = "program") -> Program:
    """Run a program of the machine's control.

    Raises ``ExportError`` with the line for an unknown word, more decimals than the control keeps, an arc without a
    circle, or a missing end.
    """
    lines = list(enumerate(text.splitlines(), start=1))
    run = _Run(machine, name)
    if machine.control == "heidenhain":
        run.each(klartext_blocks(lines, run.refusal), run.klartext)
    else:
        flat = {"linuxcnc": o_words, "fanuc": o_programs, "siemens": sections}[machine.control]
        run.each(flat(lines, run.refusal), run.iso)
    if not run.ended:
        raise run.refusal(len(lines), "M30", "is missing")
    return Program(run.motions, run.state, run.stops)


def control_of(text: str) -> str:
    """Control that a program is written for, from its first line."""
    first = text.split("\n", 2)
    if re.match(r"0 BEGIN PGM", first[0]):
        return "heidenhain"
    if first[0].startswith("%_N_"):
        return "siemens"
    return "fanuc" if len(first) > 1 and re.match(r"O\d+", first[1]) else "linuxcnc"


def read_program(path: Path, machine: MachineSpec | None = None) -> Program:
    """Run the program in a file; without a ``machine`` the built-in one of the control that its first line shows."""
    text = path.read_text(encoding="ascii")
    return interpret(text, machine or built_in_machine(control_of(text)), path.name)


def cutting_runs(motions: list[Motion]) -> list[Arcs]:
    """Motions in the plane between rapid moves as chains, one for each run."""
    runs: list[tuple[list[complex], list[float]]] = []
    for motion in motions:
        if motion.kind == "rapid":
            runs.append(([motion.end.plane], []))
        elif motion.end.plane != motion.start.plane:
            ends, curvature = runs[-1]
            here = motion.start.plane
            curvature.append(0.0 if motion.kind == "line" else _SIGN[motion.kind] / abs(here - motion.centre))
            ends.append(motion.end.plane)
    return [Arcs(np.array(ends), np.array(curvature)) for ends, curvature in runs if curvature]


def read_gcode(path: Path) -> tuple[Arcs, dict[str, int]]:
    """The last run of cutting moves as a chain of arcs, and the number of moves of each kind."""
    motions = read_program(path).motions
    codes = {"G1": "line", "G2": "clockwise", "G3": "anticlockwise"}
    counts = {code: sum(motion.kind == kind for motion in motions) for code, kind in codes.items()}
    return cutting_runs(motions)[-1], counts


@dataclass
class _Run:
    """What changes while a program runs; the interpreter is the only writer of it."""

    machine: MachineSpec
    name: str

    def __post_init__(self) -> None:
        self.here = Position(math.nan, math.nan, math.nan, 0.0)
        self.state = State()
        self.motions: list[Motion] = []
        self.stops: list[tuple[int, str]] = []
        self.code, self.incremental, self.ended = "", False, False
        self.centre = 0j
        self._parsed: dict[int, Callable[[], None]] = {}

    def refusal(self, line: int, word: str, finding: str) -> ExportError:
        """The error of a line."""
        remedy = "correct the blocks of the machine file"
        return ExportError(f"program '{self.name}', line {line}:", f"'{word}'", finding, remedy, " ")

    def each(self, lines: Iterator[Line], read: Callable[[int, str], Callable[[], None]]) -> None:
        """Run lines in order; a line that is repeated is read once."""
        for number, text in lines:
            if self.ended:
                raise self.refusal(number, text, "stands after the end of the program")
            if number not in self._parsed:
                self._parsed[number] = self.wire_or_stop(text) or read(number, text)
            self._parsed[number]()

    def change(self, **words: float | str | bool) -> None:
        """Change the modal state."""
        self.state = self.state._replace(**words)  # type: ignore[arg-type]

    def move(self, number: int, kind: str, end: Position, centre: complex = 0j) -> None:
        """One motion to ``end``."""
        if kind not in ("rapid", "line"):
            unit = 10.0**-self.machine.numbers.decimals
            radii = abs(self.here.plane - centre), abs(end.plane - centre)
            if not abs(radii[0] - radii[1]) <= _UNITS_OF_ARC * unit:
                raise self.refusal(number, kind, f"has radii of {radii[0]:.6f} and {radii[1]:.6f} mm at its ends")
        if kind != "rapid" and math.isnan(self.state.feed):
            raise self.refusal(number, kind, "has no feed")
        self.motions.append(Motion(number, kind, self.here, end, centre, self.state))
        self.here = end

    def wire_or_stop(self, text: str) -> Callable[[], None] | None:
        """Action of the blocks that thread or cut the wire or flush it, and of stops; None for any other."""
        blocks = self.machine.blocks
        plain = text.strip()
        if plain in blocks.thread or plain in blocks.cut_wire:
            return partial(self.change, threaded=plain in blocks.thread)
        if plain in blocks.flush_on or plain in blocks.flush_off:
            # A control may flush by its words for coolant, which grinding programs use as well.
            on = plain in blocks.flush_on
            cools = plain in (blocks.coolant_on if on else blocks.coolant_off)
            return partial(self.change, flushing=on, **({"coolant": on} if cools else {}))
        if re.match(r"(M0|STOP)\b", plain):
            return lambda: self.stops.append((len(self.motions), plain))
        return None

    def iso(self, number: int, text: str) -> Callable[[], None]:
        """Read one line of G code."""
        control = self.machine.control
        code = _COMMENT.sub("", text).strip()
        for word in (*self.machine.blocks.accepted, *_NAMED.get(control, ())):
            code = re.sub(rf"(?<!\S){re.escape(word)}(?!\S)", "", code).strip()
        words = _WORD.findall(code)
        if "".join(letter + value for letter, value in words) != code.replace(" ", ""):
            raise self.refusal(number, text, "is not made of words of this control")
        for letter, value in words:
            known = {"G": _G[control], "M": _M[control]}.get(letter)
            if letter not in _LETTERS[control] or (known is not None and float(value) not in known):
                raise self.refusal(number, letter + value, "is no known word of this control")
            self.check_digits(number, letter, value)
        codes = [float(value) for letter, value in words if letter == "G"]
        extra = [float(value) for letter, value in words if letter == "M"]
        values = {letter: float(value) for letter, value in words if letter not in "GM"}
        return partial(self.run_iso, number, codes, extra, values)

    def check_digits(self, number: int, letter: str, value: str) -> None:
        """Refuse more decimals than the control keeps."""
        numbers = self.machine.numbers
        kept = {"C": numbers.angle_decimals, "F": numbers.feed_decimals}.get(letter, numbers.decimals)
        if letter in "XYZCIJF" and len(value.partition(".")[2]) > kept:
            raise self.refusal(number, letter + value, f"has more than the {kept} decimals that the control keeps")

    def run_iso(self, number: int, codes: list[float], extra: list[float], values: dict[str, float]) -> None:
        """Run one line of G code: settings, spindle and coolant, then its motion."""
        for g in codes:
            self.set_code(g, values)
        if "F" in values:
            self.change(feed=values["F"])
        elif self.state.inverse and {"X", "Y", "C"} & values.keys():
            raise self.refusal(number, "G93", "asks for F in every block")
        if "T" in values:
            self.change(tool=int(values["T"]))
        for letter in "DH":
            if letter in values and self.machine.control != "linuxcnc":
                self.change(offset=int(values[letter]))
        for m in extra:
            self.run_m(m, values.get("S", 0.0))
        if not {"X", "Y", "Z", "C"} & values.keys():
            return
        base = self.here if self.incremental else Position(0.0, 0.0, 0.0, 0.0)
        axes = [
            getattr(base, axis) + values[axis.upper()] if axis.upper() in values else getattr(self.here, axis)
            for axis in Position._fields
        ]
        centre = self.here.plane + complex(values.get("I", 0.0), values.get("J", 0.0))
        self.move(number, self.code, Position(*axes), centre)

    def set_code(self, g: float, values: dict[str, float]) -> None:
        """Change the mode by a G word."""
        if g in _MOVES:
            self.code = _MOVES[int(g)]
        elif g in (90, 91):
            self.incremental = g == 91
        elif g in (93, 94):
            self.change(inverse=g == 93, feed=math.nan)
        elif g in (40, 41, 42, 41.1, 42.1):
            side = {40: "", 41: "left", 42: "right"}[int(g)]
            self.change(side=side, diameter=values.get("D", 0.0) if g in (41.1, 42.1) else 0.0)
        elif g == 43:
            self.change(offset=int(values.get("H", 0)))
        elif 54 <= g <= 59:
            self.change(work_offset=int(g))

    def run_m(self, m: float, speed: float) -> None:
        """Run an M word."""
        if m in (3, 4):
            self.change(spindle=speed)
        elif m == 5:
            self.change(spindle=0.0)
        elif m in (7, 8, 9):
            self.change(coolant=m != 9)
        elif m in (2, 30):
            self.ended = True

    def klartext(self, number: int, text: str) -> Callable[[], None]:
        """Read one block of klartext."""
        code = _COMMENT.sub("", text).strip()
        if code in ("", *self.machine.blocks.accepted):
            return lambda: None
        if match := re.fullmatch(r"TOOL CALL (\d+) Z S([\d.]+)", code):
            # The tool call sets the speed; M3 starts the spindle.
            tool, self._speed = int(match[1]), float(match[2])
            return partial(self.change, tool=tool, offset=tool)
        if match := re.fullmatch(r"CYCL DEF 247 DATUM SETTING ~ Q339=\+(\d+)", code):
            return partial(self.change, work_offset=int(match[1]))
        if match := re.fullmatch(r"M(\d+)", code):
            if float(match[1]) not in _SHARED_M:
                raise self.refusal(number, code, "is no known word of this control")
            return lambda m=float(match[1]): self.run_m(m, getattr(self, "_speed", 0.0))  # type: ignore[misc]
        match = re.fullmatch(r"(L|CC|C)((?: I?[XYZC][+-]\d+\.\d+)+)( DR[+-])?( R[0LR])?( F(?:MAX|[\d.]+))?", code)
        if match is None:
            raise self.refusal(number, code, "is no known block of this control")
        words = dict(re.findall(r"(I?[XYZC])([+-][\d.]+)", match[2]))
        for axis, value in words.items():
            self.check_digits(number, axis[-1], value)
        if match[5] and match[5] != " FMAX":
            self.check_digits(number, "F", match[5][2:])
        at = {axis: float(value) for axis, value in words.items()}
        turn, side, feed = (part.strip() if part else "" for part in match.groups()[2:])
        return partial(self.run_klartext, number, match[1], at, turn, side, feed)

    def run_klartext(self, number: int, head: str, at: dict[str, float], turn: str, side: str, feed: str) -> None:
        """Run one motion of klartext."""
        axes = [
            at.get(name, getattr(self.here, axis) + at.get("I" + name, 0.0))
            for axis, name in zip(Position._fields, "XYZC", strict=True)
        ]
        end = Position(*axes)
        if head == "CC":
            self.centre = end.plane
            return
        if side:
            self.change(side={"R0": "", "RL": "left", "RR": "right"}[side])
        if feed and feed != "FMAX":
            self.change(feed=float(feed[1:]))
        kind = "anticlockwise" if turn == "DR+" else "clockwise" if turn else "rapid" if feed == "FMAX" else "line"
        self.move(number, kind, end, self.centre)
