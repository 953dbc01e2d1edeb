"""Interpreters of four NC dialects, written from the controls' manuals; they share no code with the package.

Each runs a program as the control would: subprograms, repeated sections and jumps are followed, modal words kept.
"""

from __future__ import annotations

import math
import re
from typing import NamedTuple

import numpy as np


class Step(NamedTuple):
    """One motion: G code 0 to 3, end, centre of an arc, C [°]; feed word with its meaning; side of compensation.

    Height at both ends, not a number before the first word; speed of the spindle, 0 when off; coolant.
    """

    code: int
    start: complex
    end: complex
    centre: complex
    c_start: float
    c: float
    feed: float
    inverse: bool
    side: str
    z_start: float = math.nan
    z: float = math.nan
    spindle: float = 0.0
    coolant: bool = False


def run(text: str, dialect: str) -> list[Step]:
    """All motions of a program in the order a machine would make them."""
    if dialect == "heidenhain":
        return _klartext(text)
    lines = [re.sub(r"\([^)]*\)|;.*", "", line).strip() for line in text.splitlines()]
    flat = {"linuxcnc": _call_o_words, "fanuc": _call_programs, "siemens": _repeat_sections}[dialect](lines)
    return _iso(flat)


def _call_o_words(lines: list[str]) -> list[str]:
    subs: dict[str, list[str]] = {}
    main: list[str] = []
    into: list[str] | None = None
    for line in lines:
        word = re.fullmatch(r"o(\d+) (sub|endsub|call)", line)
        if word and word[2] == "sub":
            into = subs.setdefault(word[1], [])
        elif word and word[2] == "endsub":
            into = None
        elif word:
            main += subs[word[1]]
        else:
            (main if into is None else into).append(line)
    return main


def _call_programs(lines: list[str]) -> list[str]:
    programs: dict[int, list[str]] = {}
    order: list[int] = []
    for line in lines:
        if re.fullmatch(r"O\d+", line):
            order.append(int(line[1:]))
            programs[order[-1]] = []
        elif order:
            programs[order[-1]].append(line)
    out: list[str] = []
    for line in programs[order[0]]:
        call = re.fullmatch(r"M98 P(\d+)", line)
        if call:
            body = programs[int(call[1])]
            out += body[: body.index("M99")]
        elif line == "M30":
            break
        else:
            out.append(line)
    return out


def _repeat_sections(lines: list[str]) -> list[str]:
    label = {line[:-1]: i for i, line in enumerate(lines) if re.fullmatch(r"[A-Z_]+:", line)}
    out: list[str] = []
    i = 0
    while i < len(lines) and lines[i] != "M30":
        jump = re.fullmatch(r"GOTOF (\w+)", lines[i])
        again = re.fullmatch(r"REPEAT (\w+) (\w+) P=(\d+)", lines[i])
        if jump:
            i = label[jump[1]]
            assert i >= 0
        elif again:
            out += int(again[3]) * lines[label[again[1]] + 1 : label[again[2]]]
        else:
            out.append(lines[i])
        i += 1
    return out


def _iso(lines: list[str]) -> list[Step]:
    steps: list[Step] = []
    here, c, z, feed, code = 0j, 0.0, math.nan, math.nan, 0
    incremental = inverse = coolant = False
    spindle = speed = 0.0
    side = ""
    for line in lines:
        if not line or line[0] in "%:" or line.endswith(":"):
            continue
        words = re.findall(r"([A-Z])(-?\d+\.?\d*)", line)
        codes = [float(n) for letter, n in words if letter == "G"]
        value = {letter: float(n) for letter, n in words if letter != "G"}
        for g in codes:
            if g in (0, 1, 2, 3):
                code = int(g)
            elif g in (90, 91):
                incremental = g == 91
            elif g in (93, 94):
                inverse = g == 93
            elif g == 40:
                side = ""
            elif g in (41, 42, 41.1, 42.1):
                side = "left" if int(g) == 41 else "right"
        feed, speed = value.get("F", feed), value.get("S", speed)
        spindle = {3.0: speed, 4.0: speed, 5.0: 0.0}.get(value.get("M", 0.0), spindle)
        coolant = {8.0: True, 9.0: False}.get(value.get("M", 0.0), coolant)
        if not {"X", "Y", "Z", "C"} & value.keys():
            continue
        to_z = value.get("Z", z)
        base, c_base = (here, c) if incremental else (0j, 0.0)
        there = complex(
            base.real + value["X"] if "X" in value else here.real, base.imag + value["Y"] if "Y" in value else here.imag
        )
        to_c = c_base + value["C"] if "C" in value else c
        assert not inverse or "F" in value, "in inverse time every block needs its feed"
        centre = here + complex(value.get("I", 0.0), value.get("J", 0.0))
        steps.append(Step(code, here, there, centre, c, to_c, feed, inverse, side, z, to_z, spindle, coolant))
        here, c, z = there, to_c, to_z
    return steps


def _klartext(text: str) -> list[Step]:
    # A block goes on in the next line after a tilde.
    numbered = [line.split(" ", 1) for line in re.sub(r"~\n *", "", text).splitlines()]
    assert [int(number) for number, _ in numbered] == list(range(len(numbered)))
    lines = [re.sub(r";.*", "", line).strip() for _, line in numbered]
    assert re.fullmatch(r"BEGIN PGM \w+ MM", lines[0])
    assert lines[-1] == lines[0].replace("BEGIN", "END")
    flat: list[str] = []
    for line in lines[1 : lines.index("M30")]:
        call = re.fullmatch(r"CALL LBL (\d+)", line)
        if call:
            begin = lines.index(f"LBL {call[1]}")
            flat += lines[begin + 1 : lines.index("LBL 0", begin)]
        else:
            flat.append(line)
    steps: list[Step] = []
    here, c, z, feed, centre, side = 0j, 0.0, math.nan, math.nan, 0j, ""
    spindle, speed, coolant = 0.0, 0.0, False
    for line in flat:
        tool = re.fullmatch(r"TOOL CALL 1 Z S(\d+)", line)
        speed = float(tool[1]) if tool else speed
        spindle = {"M3": speed, "M5": 0.0}.get(line, spindle)
        coolant = {"M8": True, "M9": False}.get(line, coolant)
        head = line.split(" ")[0]
        if head not in ("L", "C", "CC"):
            continue
        place = {axis: float(v) for axis, v in re.findall(r"(?<![A-Z])(I?[XYZC])([+-]\d+\.\d+)", line)}
        x, y = place.get("X", here.real + place.get("IX", 0.0)), place.get("Y", here.imag + place.get("IY", 0.0))
        if head == "CC":
            centre = complex(x, y)
            continue
        to_c = place.get("C", c + place.get("IC", 0.0))
        rapid = "FMAX" in line
        word = re.search(r" F([\d.]+)", line)
        feed = float(word[1]) if word else feed
        comp = re.search(r" R([0LR])\b", line)
        if comp:
            side = {"0": "", "L": "left", "R": "right"}[comp[1]]
        code = 0 if rapid else 1 if head == "L" else 3 if "DR+" in line else 2
        to_z = place.get("Z", z)
        steps.append(Step(code, here, complex(x, y), centre, c, to_c, feed, False, side, z, to_z, spindle, coolant))
        here, c, z = complex(x, y), to_c, to_z
    return steps


def along(step: Step, share: np.ndarray) -> np.ndarray:
    """Points on a motion in the plane at shares of its length, complex; an arc by the angle about its centre."""
    if step.code in (0, 1):
        return step.start + share * (step.end - step.start)
    a0, a1 = (math.atan2((z - step.centre).imag, (z - step.centre).real) for z in (step.start, step.end))
    turn = (a1 - a0) % (2.0 * math.pi) if step.code == 3 else -((a0 - a1) % (2.0 * math.pi))
    r0, r1 = abs(step.start - step.centre), abs(step.end - step.centre)
    return step.centre + (r0 + (r1 - r0) * share) * np.exp(1j * (a0 + turn * share))


def seconds(step: Step, dialect: str) -> float:
    """How long a motion in C and X takes [s]."""
    if step.inverse:
        return 60.0 / step.feed
    path = (
        abs(step.end - step.start)
        if dialect != "heidenhain"
        else math.hypot(abs(step.end - step.start), step.c - step.c_start)
    )
    return 60.0 * path / step.feed
