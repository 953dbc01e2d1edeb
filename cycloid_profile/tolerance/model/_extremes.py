"""Largest and least backlash over a whole turn, compiled by numba; imported inside functions only.

Backlash at a pose is the least closing turn of the forward flank plus that of the backward flank. Its largest value
over a turn lies mostly at a kink, where another pin becomes the first, so that a parabola through poses misses it. The
closing turn of one pin is smooth: it is interpolated pin by pin, and the least is taken afterwards.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cycloid_profile.arrays import BoolArray, FloatArray, IntArray
from cycloid_profile.compiled import contracted, inner, kernel

_ABREAST = 128  # reducers side by side
_ROUNDING = 1e-9  # rad, less than 1e-5′
_FAR = 1e3  # rad; closing turn of a pin out of reach
_PARTS = 4  # of an interval between two poses; halved or doubled, the largest backlash of an RV-40E moves by 2e-5′


@kernel
def turn_extremes(  # pragma: no cover - compiled, out of the sight of the coverage tool
    begin: IntArray,
    column: IntArray,
    weight: FloatArray,
    base: FloatArray,
    pin: IntArray,
    row_of: IntArray,
    arm: FloatArray,
    x: FloatArray,
    extremes: FloatArray,
) -> None:
    """Fill ``extremes``, shape (reducers, 2), with largest and least sum of both flanks over a turn [rad].

    ``base`` and ``pin`` shape (poses, 2, slots): closing turn as drawn and number of the pin, -1 for an empty slot;
    ``row_of`` each pin, shape (poses, 2, pins), and its ``arm``, -1 and 0 where out of reach; the rest as in
    ``least_turns``, with the rows in the order of ``base``. Poses are evenly spaced and close the turn.
    """
    # Seven digits of a closing turn are 1e-10 rad, and half the memory takes less time.
    short_column, short_weight, short_base = column.astype(np.int32), weight.astype(np.float32), base.astype(np.float32)
    rows = _Rows(begin, short_column, short_weight, short_base.ravel(), row_of, arm)
    some = np.empty((x.shape[1], _ABREAST), np.float32)
    least = np.empty((len(base), 2, _ABREAST), np.float32)
    first = np.empty((len(base), 2, _ABREAST), np.int32)
    total, known = np.empty(len(base)), np.empty(len(base), np.bool_)
    turns = np.empty((len(base), 2, arm.shape[2]))
    for start in range(0, len(x), _ABREAST):
        count = min(_ABREAST, len(x) - start)
        for s in range(_ABREAST):
            for c in range(x.shape[1]):
                some[c, s] = x[start + min(s, count - 1), c]
        _all_poses(begin, short_column, short_weight, short_base, pin, some, least, first)
        for s in range(count):
            for p in range(len(base)):
                total[p] = least[p, 0, s] + least[p, 1, s]
            known[:] = False
            _refined(rows, x[start + s], total, first[..., s], turns, known, extremes[start + s])


@contracted
def _all_poses(  # pragma: no cover
    begin: IntArray,
    column: IntArray,
    weight: FloatArray,
    base: FloatArray,
    pin: IntArray,
    some: FloatArray,
    least: FloatArray,
    first: IntArray,
) -> None:
    """Fill ``least`` and ``first``, shape (poses, 2, reducers), with the least closing turns and their pins; to seven
    digits, which choose poses.
    """
    own = np.empty(_ABREAST, np.float32)
    least[:], first[:] = np.inf, 0
    for pose in range(len(base)):
        for f in range(2):
            lowest, which = least[pose, f], first[pose, f]
            for k in range(base.shape[2]):
                number = np.int32(pin[pose, f, k])
                if number < 0:
                    continue
                row = (pose * 2 + f) * base.shape[2] + k
                own[:] = base[pose, f, k]
                entry, end = begin[row], begin[row + 1]
                # Six at once: a third of the time of one by one, which reads and writes the sums more often.
                while entry + 6 <= end:
                    a, b, c = weight[entry], weight[entry + 1], weight[entry + 2]
                    d, e, g = weight[entry + 3], weight[entry + 4], weight[entry + 5]
                    xa, xb = some[np.uint64(column[entry])], some[np.uint64(column[entry + 1])]
                    xc, xd = some[np.uint64(column[entry + 2])], some[np.uint64(column[entry + 3])]
                    xe, xg = some[np.uint64(column[entry + 4])], some[np.uint64(column[entry + 5])]
                    for s in range(_ABREAST):
                        own[s] += ((a * xa[s] + b * xb[s]) + (c * xc[s] + d * xd[s])) + (e * xe[s] + g * xg[s])
                    entry += 6
                while entry < end:
                    a, xa = weight[entry], some[np.uint64(column[entry])]
                    for s in range(_ABREAST):
                        own[s] += a * xa[s]
                    entry += 1
                for s in range(_ABREAST):
                    sooner = own[s] < lowest[s]
                    lowest[s] = own[s] if sooner else lowest[s]
                    which[s] = number if sooner else which[s]


class _Rows(NamedTuple):
    """Closing turns of all pins at all poses, linear in the coordinates; as in ``turn_extremes``."""

    begin: IntArray
    column: NDArray[np.int32]
    weight: NDArray[np.float32]
    base: NDArray[np.float32]
    row_of: IntArray
    arm: FloatArray


@inner
def _turn(rows: _Rows, x: FloatArray, pose: int, f: int, pin: int) -> float:  # pragma: no cover
    """Closing turn of a pin."""
    row = rows.row_of[pose, f, pin]
    if row < 0:
        return _FAR
    turn: float = rows.base[row]
    # Without a sign an index needs no look at numbers counted from the end.
    for entry in range(np.uint64(rows.begin[row]), np.uint64(rows.begin[row + 1])):
        turn += rows.weight[entry] * x[np.uint64(rows.column[entry])]
    return turn


@inner
def _refined(  # pragma: no cover
    rows: _Rows,
    x: FloatArray,
    total: FloatArray,
    first: IntArray,
    turns: FloatArray,
    known: BoolArray,
    ends: FloatArray,
) -> None:
    """Fill ``ends`` with the extremes of one reducer whose backlash at the poses is ``total``, by the pins ``first``.

    The least value is smooth: the lowest vertex of the parabolas through three poses. For the largest one intervals are
    searched in the order of what they promise, until none promises more than was found: the tip of a tent as steep as
    the steepest of three intervals, on a second look that by straight lines of its pins. ``turns`` keeps the closing
    turns of all pins, shape (poses, 2, pins), at poses that are ``known``.
    """
    poses, pins = len(total), rows.arm.shape[2]
    promised, place = np.empty(poses), np.empty(poses, np.int64)
    ends[0], ends[1] = -np.inf, np.inf
    before, here, there = total[-2], total[-1], total[0]
    for a in range(poses):
        ends[0], ends[1] = max(ends[0], there), min(ends[1], _vertex(before, here, there))
        before, here, there = here, there, total[(a + 1) % poses]
    # The values at the poses themselves are rounded to seven digits.
    ends[0] -= _ROUNDING
    count = 0
    for a in range(poses):
        before, here, there, after = total[a - 1], total[a], total[(a + 1) % poses], total[(a + 2) % poses]
        steepest = max(abs(here - before), abs(there - here), abs(after - there))
        promise = 0.5 * (here + there + steepest)
        if promise > ends[0]:
            promised[count], place[count] = promise, a
            count += 1
    promised = promised[:count]
    turn, levers = np.empty((4, 2, pins)), np.empty((4, 2, pins))
    near, value = np.empty(pins, np.int64), np.empty((2, _PARTS + 1))
    found = np.zeros((2, _PARTS + 1), np.int64)
    looked = np.zeros(count, np.bool_)
    for _ in range(2 * count):
        best = int(np.argmax(promised))
        if not promised[best] > ends[0]:
            break
        a = place[best]
        if not looked[best]:
            looked[best] = True
            promised[best] = min(promised[best], _straight_tip(rows, x, first, a, (a + 1) % poses))
            continue
        promised[best] = -np.inf
        for step in range(4):
            pose = (a + step - 1) % poses
            if not known[pose]:
                _turns(rows, x, pose, turns[pose])
                known[pose] = True
            for f in range(2):
                for pin in range(pins):
                    turn[step, f, pin], levers[step, f, pin] = turns[pose, f, pin], rows.arm[pose, f, pin]
        for f in range(2):
            _within(turn, levers, f, near, value[f], found[f])
        ends[0] = max(ends[0], _search(turn, levers, value, found))


@inner
def _turns(rows: _Rows, x: FloatArray, pose: int, turn: FloatArray) -> None:  # pragma: no cover
    """Fill ``turn``, shape (2, pins), with those of all pins at a pose."""
    for f in range(2):
        for pin in range(turn.shape[1]):
            turn[f, pin] = _turn(rows, x, pose, f, pin)


@inner
def _straight_tip(rows: _Rows, x: FloatArray, first: IntArray, a: int, b: int) -> float:  # pragma: no cover
    """Largest sum between two poses by straight lines of the pins that touch first there, if no other pin touches."""
    ia, ib, ja, jb = first[a, 0], first[b, 0], first[a, 1], first[b, 1]
    tip: float = _tent(
        _turn(rows, x, a, 0, ia), _turn(rows, x, b, 0, ia), _turn(rows, x, a, 0, ib), _turn(rows, x, b, 0, ib),
        _turn(rows, x, a, 1, ja), _turn(rows, x, b, 1, ja), _turn(rows, x, a, 1, jb), _turn(rows, x, b, 1, jb),
    )  # fmt: skip
    return tip


@inner
def _vertex(before: float, here: float, after: float) -> float:  # pragma: no cover
    """Least of the parabola through three poses, the middle one where it bends down."""
    bend = before - 2.0 * here + after
    if not bend > 0.0 or abs(after - before) > 2.0 * bend:
        return here
    vertex: float = here - (after - before) ** 2 / (8.0 * bend)
    return vertex


@inner
def _second(  # pragma: no cover
    turn: FloatArray, f: int, pin: int
) -> float:
    """Smaller of the second differences of a pin at poses 1 and 2; 0 next to the end of its reach."""
    a, b, c, d = turn[0, f, pin], turn[1, f, pin], turn[2, f, pin], turn[3, f, pin]
    if b >= _FAR or c >= _FAR:
        return 0.0
    # Next to the end of the reach a turn bends to infinity, but does not touch.
    second: float = min(abs(a - 2.0 * b + c), abs(b - 2.0 * c + d))
    return second if second < 0.5 * _FAR else 0.0


@inner
def _tent(  # pragma: no cover
    fa: float, fab: float, fba: float, fb: float, ga: float, gab: float, gba: float, gb: float
) -> float:
    """Largest sum over an interval of two minima of two straight lines each: ``fa`` to ``fab`` and ``fba`` to ``fb``
    forwards, the same for g backwards; the first line is the lower one at the beginning, the second at the end.
    """
    highest = max(fa + ga, fb + gb)
    for low, rise in ((fba - fa, fab - fb), (gba - ga, gab - gb)):
        if low + rise > 0.0:
            u = low / (low + rise)
            forward = min(fa + u * (fab - fa), fba + u * (fb - fba))
            backward = min(ga + u * (gab - ga), gba + u * (gb - gba))
            highest = max(highest, forward + backward)
    return highest


@inner
def _interpolated(  # pragma: no cover
    turn: FloatArray, arm: FloatArray, f: int, pin: int, u: float
) -> float:
    """Closing turn of a pin between poses 1 (u = 0) and 2 (u = 1), by cubics through four poses.

    Of the turn times its arm and of the arm: both stay smooth where the arm vanishes.
    """
    lb, lc = arm[1, f, pin], arm[2, f, pin]
    if lb == 0.0 or lc == 0.0:
        return _FAR
    la, ld = arm[0, f, pin], arm[3, f, pin]
    b, c = lb * turn[1, f, pin], lc * turn[2, f, pin]
    a, d = la * turn[0, f, pin], ld * turn[3, f, pin]
    if la == 0.0 and ld == 0.0:
        a, la, d, ld = 2.0 * b - c, 2.0 * lb - lc, 2.0 * c - b, 2.0 * lc - lb
    elif la == 0.0:
        a, la = 3.0 * (b - c) + d, 3.0 * (lb - lc) + ld
    elif ld == 0.0:
        d, ld = 3.0 * (c - b) + a, 3.0 * (lc - lb) + la
    turned: float = _cubic(a, b, c, d, u) / _cubic(la, lb, lc, ld, u)
    return turned


@inner
def _cubic(a: float, b: float, c: float, d: float, u: float) -> float:  # pragma: no cover
    """Cubic through a, b, c, d at u = -1, 0, 1, 2."""
    v = 1.0 - u
    value: float = v * b + u * c - u * v * ((2.0 - u) * (a - 2.0 * b + c) + (1.0 + u) * (b - 2.0 * c + d)) / 6.0
    return value


@inner
def _within(  # pragma: no cover
    turn: FloatArray, arm: FloatArray, f: int, near: IntArray,
    value: FloatArray, found: IntArray,
) -> None:  # fmt: skip
    """Fill ``value`` and ``found`` with the least closing turn and its pin at ``_PARTS`` + 1 places of an interval."""
    highest = 0.0
    at = np.inf
    for pin in range(turn.shape[2]):
        both = max(turn[1, f, pin], turn[2, f, pin])
        if both < at:
            at = both
    # Pins above this bound at both ends touch nowhere in between, unless they bend more than the first one.
    count = 0
    for pin in range(turn.shape[2]):
        least = min(turn[1, f, pin], turn[2, f, pin])
        if least < _FAR and least <= at + 0.25 * _second(turn, f, pin):
            near[count] = pin
            count += 1
    for i in range(_PARTS + 1):
        u = i / _PARTS
        highest = np.inf
        for k in range(count):
            here = _interpolated(turn, arm, f, near[k], u)
            if here < highest:
                highest, found[i] = here, near[k]
        value[i] = highest


@inner
def _search(  # pragma: no cover
    turn: FloatArray, arm: FloatArray, value: FloatArray, found: IntArray
) -> float:
    """Largest sum of both flanks in an interval; kinks at the crossing of two pins."""
    highest: float = -np.inf
    for i in range(_PARTS):
        total, later = value[0, i] + value[1, i], value[0, i + 1] + value[1, i + 1]
        highest = max(highest, total, later)
        ia, ib, ja, jb = found[0, i], found[0, i + 1], found[1, i], found[1, i + 1]
        if ia == ib and ja == jb:
            continue
        u, w = i / _PARTS, (i + 1) / _PARTS
        kink = _tent(
            value[0, i], _interpolated(turn, arm, 0, ia, w),
            _interpolated(turn, arm, 0, ib, u), value[0, i + 1],
            value[1, i], _interpolated(turn, arm, 1, ja, w),
            _interpolated(turn, arm, 1, jb, u), value[1, i + 1],
        )  # fmt: skip
        highest = max(highest, kink)
    return highest
