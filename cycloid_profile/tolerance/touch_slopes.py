"""How the crank-locked backlash answers to a small change of any part (docs/tolerance.md, Eq. 61).

Each flank is closed by the contact that touches first. The gap there is zero, so that its change over its arm is the
change of the turn, exactly.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.backlash import closing_turn, first_touch
from cycloid_profile.contact.gap import Gaps
from cycloid_profile.contact.meshing import Meshing, mesh
from cycloid_profile.contact.support import support_model
from cycloid_profile.effects.built import Built
from cycloid_profile.errors import SolveError
from cycloid_profile.tolerance.patterns import GapPlace, UnitChange, gap_change, misfit_change
from cycloid_profile.tolerance.slopes import Slope, Smooth, Weighted, least

# Rounding of a touch is some 1e-15 rad; contacts of two discs that mirror each other meet within it.
_TIE = 1e-12  # rad


@dataclass(frozen=True)
class TouchSlopes:
    """Backlash at each pose, ``values`` shape (poses,) [rad], and its slope by the coordinates of the changes."""

    values: FloatArray
    slopes: tuple[Slope, ...]


def touch_slopes(built: Built, changes: list[UnitChange], crank_angle: FloatArray) -> TouchSlopes:
    """Exact first touches of a reducer as built, discs where the misfits of their bearings put them, and their slopes.

    Raises ``SolveError`` where a disc finds no first touch.
    """
    drive = built.case.drive
    meshing = mesh(drive.trochoid, crank_angle, drive.discs)
    rest = _Rest(built, meshing)
    moved = rest.motion(support_model(drive, meshing.crank_angle, built.parts).misfit)
    shift, turn = moved[..., 0] + 1j * moved[..., 1], moved[..., 2]
    placed = replace(meshing, pin_centre=meshing.pin_in_lobe(shift, turn, built.pin_shift))
    flanks = []
    for direction in (1.0, -1.0):
        rotation, found = _touched(built, placed, direction)
        # The touch turns by itself; its normals are seen from a disc that was turned by its misfits before.
        normal = found.normal * np.exp(1j * turn)[..., np.newaxis]
        place = GapPlace(found.foot, meshing.lobe, normal, meshing.crank_angle)
        arm = direction * found.lever
        closing = direction * rotation[..., np.newaxis] + closing_turn(built.case.profile, found.gap, arm)
        opened = np.zeros((len(changes), *closing.shape))
        for number, change in enumerate(changes):
            gap, misfit = gap_change(change, place), misfit_change(change, meshing.crank_angle)
            opened[number] = 0.0 if gap is None else gap
            if misfit is not None:
                own = rest.motion(misfit)[:, :, np.newaxis]
                opened[number] -= normal.real * own[..., 0] + normal.imag * own[..., 1] + found.lever * own[..., 2]
        flanks.append(_first(closing, opened, arm))
    (forward, to), (backward, back) = flanks
    return TouchSlopes(forward + backward, tuple(Weighted(both) for both in zip(to, back, strict=True)))


def _touched(built: Built, meshing: Meshing, direction: float) -> tuple[FloatArray, Gaps]:
    radius = built.case.drive.pin_radius + built.pin_oversize
    touches = [first_touch(tooth, radius, meshing.disc(j), direction) for j, tooth in enumerate(built.teeth)]
    if not all(np.all(touch.settled) for touch in touches):
        raise SolveError("first touch", "not found", "at some pose", "take smaller effects", " ")
    return np.concatenate([t.rotation for t in touches], axis=1), Gaps.of_discs([t.gaps for t in touches])


def _first(closing: FloatArray, opened: FloatArray, arm: FloatArray) -> tuple[FloatArray, list[Slope]]:
    """Least closing turn at each pose [rad] with its slope."""
    turn = closing.reshape(len(closing), -1)
    by_unit = opened.reshape(len(opened), *turn.shape)
    slopes = []
    for p, (row, reach) in enumerate(zip(turn, arm.reshape(turn.shape), strict=True)):
        first = np.flatnonzero(row <= np.min(row) + _TIE)
        slopes.append(least(row[first], [Smooth(by_unit[:, p, i] / reach[i]) for i in first], _TIE))
    return np.min(turn, axis=1), slopes


class _Rest:
    """Where discs come to lie by the misfits of their bearings, no load on any pin."""

    def __init__(self, built: Built, meshing: Meshing) -> None:
        model = support_model(built.case.drive, meshing.crank_angle)
        stretch = model.spring_stretch.reshape(len(meshing.phase), built.discs, -1, model.arm.size)
        self._answers = [
            # A disc on a central eccentric turns with the carrier: its bearing has no misfit to follow.
            -np.linalg.pinv(stretch[:, j][:, :, own]) if np.all(own > 0) else np.zeros((1, 3, 2))
            for j, own in enumerate(model.disc_unknowns)
        ]

    def motion(self, misfit: FloatArray) -> FloatArray:
        """(x, y, θ) of each disc, shape (poses, discs, 3) [mm, mm, rad], by misfits of shape (poses, bearings, 2)."""
        fits = misfit.reshape(len(misfit), len(self._answers), -1, 1)
        return np.stack([(answer @ fits[:, j])[..., 0] for j, answer in enumerate(self._answers)], axis=1)
