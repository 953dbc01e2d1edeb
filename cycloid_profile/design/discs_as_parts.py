"""The discs of a stage as parts: which of them differ, and their records.

The openings of all discs are aligned by the cranks or output pins, while disc j leads by 2πj/n. Its teeth are therefore
turned by −2πj/(n z_c) against its openings (docs/theory.md, Eqs. 19–20): another part than disc 1, unless the openings
repeat with that turn.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.arrays import ComplexArray
from cycloid_profile.design.record import DesignRecord
from cycloid_profile.geometry import Arc, Contour, DiscOutline, Drive
from cycloid_profile.units import DEGREE

_SAME = 1e-6  # mm between equal openings


@dataclass(frozen=True, slots=True)
class DiscPart:
    """A disc with its own drawing: ``discs`` made by it, counted from 1, and its ``outline``.

    ``turn`` of the openings against the teeth, compared with disc 1, anticlockwise [rad].
    """

    discs: tuple[int, ...]
    turn: float
    outline: DiscOutline

    @property
    def number(self) -> int:
        """Number of the first disc that is this part."""
        return self.discs[0]


def turned_openings(drive: Drive, outline: DiscOutline, disc: int) -> tuple[float, tuple[Contour, ...]]:
    """Openings of a disc, counted from 1, in the frame of its teeth: their turn compared with disc 1 [rad], and their
    contours; ``outline`` is that of disc 1."""
    turn = 2.0 * math.pi * (disc - 1) / (drive.discs * drive.trochoid.lobes)
    return turn, tuple(contour.rotated(turn, contour.name) for contour in outline.contours)


def disc_parts(drive: Drive, outline: DiscOutline) -> tuple[DiscPart, ...]:
    """The different discs of a stage; ``outline`` is that of disc 1."""
    parts = [DiscPart((1,), 0.0, outline)]
    positions = drive.trochoid.lobes if outline.profile.identical_lobes else 1
    for j in range(1, drive.discs):
        turn, contours = turned_openings(drive, outline, j + 1)
        same = [k for k, part in enumerate(parts) if _same_openings(contours, part.outline.contours, positions)]
        if same:
            parts[same[0]] = replace(parts[same[0]], discs=(*parts[same[0]].discs, j + 1))
        else:
            parts.append(DiscPart((j + 1,), turn, DiscOutline(outline.profile, contours)))
    return tuple(parts)


def disc_records(record: DesignRecord) -> tuple[DesignRecord, ...]:
    """The record of every different disc, that of disc 1 first."""
    return tuple(
        record if part.number == 1 else replace(record, outline=part.outline, disc=part.number, openings_turn=part.turn)
        for part in disc_parts(record.drive, record.outline)
    )


def place_among_parts(record: DesignRecord) -> tuple[int, int]:
    """Place of a disc among the different ones of its stage, counted from 1, and their number."""
    # disc_parts counts from the openings of disc 1.
    contours = tuple(contour.rotated(-record.openings_turn, contour.name) for contour in record.outline.contours)
    parts = disc_parts(record.drive, DiscOutline(record.profile, contours))
    return [part.number for part in parts].index(record.disc) + 1, len(parts)


def disc_parts_sentence(record: DesignRecord) -> str:
    """Which discs differ, and where their files are; empty for a single disc."""
    if record.drive.discs == 1:
        return ""
    first, *others = disc_parts(record.drive, record.outline)
    if not others:
        return f"Discs 1 to {record.drive.discs} are the same part."
    return " ".join(
        f"Disc {part.number} is another part than disc {first.number}: its openings are turned by "
        f"{part.turn / DEGREE:.4f}° against the teeth; its files have disc_{part.number} in their names."
        for part in others
    )


def _same_openings(some: tuple[Contour, ...], others: tuple[Contour, ...], positions: int) -> bool:
    """Whether two sets of openings are the same in one of the ``positions`` in which the teeth repeat."""
    mine, theirs = _segments(some), _segments(others)
    if mine.shape != theirs.shape:
        return False
    return any(_covered(mine * [np.exp(2j * math.pi * k / positions), 1.0], theirs) for k in range(positions))


def _covered(some: ComplexArray, others: ComplexArray) -> bool:
    distance = np.abs(some[:, np.newaxis] - others[np.newaxis])
    return bool(np.all(np.any(np.all(distance < _SAME, axis=-1), axis=-1)))


def _segments(contours: tuple[Contour, ...]) -> ComplexArray:
    """A point of every segment, the centre of a full circle or the middle of another, and its signed curve radius and
    length; shape (segments, 2) [mm]."""
    rows: list[tuple[complex, complex]] = []
    for contour in contours:
        for segment in contour.segments:
            if not isinstance(segment, Arc):
                rows.append((0.5 * (segment.start + segment.end), complex(0.0, segment.length)))
            elif segment.full_circle:
                rows.append((segment.centre, complex(segment.radius, segment.length)))
            else:
                middle = 0.5 * (segment.from_angle + segment.to_angle)
                point = segment.centre + segment.radius * complex(math.cos(middle), math.sin(middle))
                rows.append((point, complex(math.copysign(segment.radius, segment.sweep), segment.length)))
    return np.array(rows, dtype=np.complex128).reshape(-1, 2)
