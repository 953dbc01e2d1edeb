"""Point files of any layout: number, range, start, sense, coordinates, columns or a line template."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path
from string import Formatter

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.errors import ExportError
from cycloid_profile.export.curves import ProfileSource, chord_points, deviation
from cycloid_profile.export.writing import WrittenFile
from cycloid_profile.geometry import ToothPoints, ToothProfile
from cycloid_profile.spec.model import PointsSpec
from cycloid_profile.units import DEGREE

_FINE = 4000  # steps of a lobe by which arc length is measured
_NUMBER = r"([-+]?\d+\.?\d*(?:[eE][-+]?\d+)?)"


def write_points(source: ProfileSource, settings: PointsSpec, folder: Path) -> WrittenFile:
    """Write the point file of ``[export.points]``, read it back and measure the points.

    Raises ``ExportError`` for settings that contradict each other, or a template with unknown names.
    """
    points = chosen_points(source, settings)
    values = _values(points, settings)
    path = folder / settings.file
    if settings.template is not None:
        lines = template_lines(settings.template, values, "export.points.template")
        back = _of_template(settings.template, lines)
    else:
        names = ("x", "y", "z") if settings.coordinates == "cartesian" else ("r", "angle", "z")
        rows = [settings.separator.join(f"{v + 0.0:.{settings.decimals}f}" for v in row) for row in
                zip(*(np.round(values[name], settings.decimals).tolist() for name in names), strict=True)]  # fmt: skip
        lines = [settings.separator.join(names), *rows] if settings.header else rows
        back = np.array([row.split(settings.separator) for row in rows], dtype=np.float64)[:, :2]
    path.write_text("\n".join(lines) + "\n", encoding="ascii", newline="\n")
    count = {"points": len(points.phase)}
    if back is None:
        return WrittenFile(path.name, "csv", None, None, None, count)
    polar = settings.coordinates == "polar" if settings.template is None else "{x" not in settings.template
    xy = back[:, 0] * np.exp(1j * back[:, 1] * DEGREE) if polar else back[:, 0] + 1j * back[:, 1]
    decimals = _decimals(settings)
    radius = float(np.max(np.abs(points.position)))
    rounding = 0.5 * 10.0**-decimals * (1.0 + DEGREE * radius if polar else math.sqrt(2.0))
    return WrittenFile(path.name, "csv", rounding + 1e-9, deviation(source.profile, xy), "own reader", count)


def chosen_points(source: ProfileSource, settings: PointsSpec) -> ToothPoints:
    """Points of the tooth in the order of the file.

    Raises ``ExportError`` if a total and a number per lobe are given.
    """
    profile = source.profile
    lobes, period = profile.trochoid.lobes, profile.trochoid.phase_period
    if settings.total is not None and settings.per_lobe is not None:
        raise ExportError(
            "export.points.total", settings.total, "is given with per_lobe", "give one of total and per_lobe"
        )
    gap = settings.range == "gap"
    begin, end = (-math.pi, math.pi) if gap else (0.0, period)
    if settings.start == "tip" and not gap:
        begin, end = begin + math.pi, end + math.pi
    count = settings.total
    if settings.per_lobe is not None:
        count = settings.per_lobe * (1 if gap else lobes)
    if count is None:
        phase = _by_chords(source, begin, end)
    else:
        # A gap has a point on both tips, a disc its first point once.
        phase = equal_arcs(profile, begin, end, count if gap else count + 1)
    if not gap and not settings.closed:
        phase = phase[:-1]
    if settings.sense == "anticlockwise":
        phase = phase[::-1] if gap or settings.closed else np.roll(phase[::-1], 1)
    return _at(profile, phase)


def equal_arcs(profile: ToothProfile, begin: float, end: float, count: int) -> FloatArray:
    """``count`` phases from ``begin`` to ``end`` at equal arcs of the tooth, shape (count,) [rad]."""
    steps = max(2, math.ceil((end - begin) / (2.0 * math.pi) * _FINE))
    fine = np.linspace(begin, end, steps + 1)
    length = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(_at(profile, fine).position)))])
    found = np.interp(np.linspace(0.0, length[-1], count), length, fine)
    found[0], found[-1] = begin, end
    return found


def _by_chords(source: ProfileSource, begin: float, end: float) -> FloatArray:
    """Phases between ``begin`` and ``end``, both included, whose chords keep the tolerance of the spec [rad]."""
    period = source.profile.trochoid.phase_period
    phase = chord_points(source.profile, source.spec.export.chord_tolerance).phase
    every = np.concatenate([phase - period, phase, phase + period])
    inside = every[(every > begin + 1e-9) & (every < end - 1e-9)]
    return np.concatenate([[begin], inside, [end]])


def _at(profile: ToothProfile, phase: FloatArray) -> ToothPoints:
    """Points at phases along the disc, which may be outside one period."""
    return profile.at(np.mod(phase, profile.trochoid.phase_period))


def _values(points: ToothPoints, settings: PointsSpec) -> dict[str, FloatArray]:
    z = points.position
    return {
        "n": np.arange(1.0, z.size + 1.0),
        "x": z.real,
        "y": z.imag,
        "z": np.full(z.shape, settings.z_mm),
        "r": np.abs(z),
        "angle": np.angle(z) / DEGREE,
        "nx": points.normal.real,
        "ny": points.normal.imag,
    }


def template_lines(template: str, values: Mapping[str, FloatArray], what: str) -> list[str]:
    """One line a point from a template; ``n`` is a whole number. Raises ``ExportError`` for a name it does not know."""
    try:
        names = [name for _, name, _, _ in Formatter().parse(template) if name is not None]
        unknown = [name for name in names if name not in values]
        if unknown or not names:
            raise KeyError(unknown[0] if unknown else "no name")
        columns = {name: values[name].tolist() for name in set(names)}
        if "n" in columns:
            columns["n"] = [int(number) for number in columns["n"]]
        rows = (dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True))
        # Adding zero leaves no negative zero.
        return [template.format_map({k: v + 0 for k, v in row.items()}) for row in rows]
    except (KeyError, ValueError, IndexError) as error:
        limit = f"cannot be filled in ({str(error).strip(chr(39))})"
        raise ExportError(what, f"'{template}'", limit, f"use {', '.join(values)} with formats such as :.4f") from None


def _of_template(template: str, lines: list[str]) -> FloatArray | None:
    """The two plane coordinates in lines of a template, shape (points, 2); None where it does not hold both."""
    pattern = ""
    names: list[str] = []
    joined = False
    for text, name, _, _ in Formatter().parse(template):
        joined |= bool(names) and not text and name is not None
        pattern += re.escape(text)
        if name is not None:
            names.append(name)
            pattern += " *" + _NUMBER
    wanted = next((pair for pair in (("x", "y"), ("r", "angle")) if set(pair) <= set(names)), None)
    if wanted is None:
        return None
    at = [names.index(name) for name in wanted]
    found = [re.fullmatch(pattern, line) for line in lines]
    if joined or not all(found):
        raise ExportError(
            "export.points.template",
            f"'{template}'",
            "cannot be read back",
            "separate the numbers by letters or blanks",
        )
    return np.array([[match.groups()[k] for k in at] for match in found if match], dtype=np.float64)


def _decimals(settings: PointsSpec) -> int:
    """Fewest decimals of a plane coordinate in the file; formats without a precision have six."""
    if settings.template is None:
        return settings.decimals
    wanted = [
        form or "" for _, name, form, _ in Formatter().parse(settings.template) if name in ("x", "y", "r", "angle")
    ]
    precisions = [re.search(r"\.(\d+)", form) for form in wanted]
    return min(int(match[1]) if match else 6 for match in precisions)
