"""Smallest visible sizes held against the exact model: equations about no effect do not know what a size does.

Plays close under load and pins leave contact: what shows at the size that would be seen may be a tenth of what a little
of it promises.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cycloid_profile.discrepancy.candidates import Candidate
from cycloid_profile.discrepancy.laid import Laid
from cycloid_profile.discrepancy.normal import Whitened
from cycloid_profile.errors import CycloidError

NEARLY = 0.8  # of what is needed: as near as the linear size may be
_ROUNDS, _LEAST, _MOST = 12, 1.1, 2.0  # of the search, and how many times larger it tries


def exact_size(laid: Sequence[Laid], candidate: Candidate, size: float, needed: float, enough: float = NEARLY) -> float:
    """The first size from ``size`` on that shows ``enough`` of what is ``needed``, a noncentrality, in recordings
    ``laid`` on a reducer; infinite where no workshop makes as much. In the unit of the coordinate, as ``size``.

    Of an amount of either sign the larger of the two, if both show at all.
    """
    signs = (1.0,) if candidate.one_sided or candidate.angle is not None else (1.0, -1.0)
    sizes = [_from(laid, candidate, size, sign, needed, enough) for sign in signs]
    return max((one for one in sizes if one < math.inf), default=math.inf)


def _from(laid: Sequence[Laid], candidate: Candidate, size: float, sign: float, needed: float, enough: float) -> float:
    for _ in range(_ROUNDS):
        if size > candidate.implausible:
            break
        squares = shown(laid, candidate, sign * size)
        if squares >= enough * needed:
            return size
        size *= float(np.clip(math.sqrt(needed / max(squares, 1e-9)), _LEAST, _MOST))
    return math.inf


def shown(laid: Sequence[Laid], candidate: Candidate, size: float) -> float:
    """What an effect of ``size`` changes, in squares of the noise, what no measurement knows marginalised; infinite
    where the reducer binds with it.
    """
    effect = candidate.effect([size, 0.0])
    assert effect is not None
    total = 0.0
    try:
        for before in laid:
            after = Laid(before.recording, effect.apply(before.built), before.probes)
            block = Whitened(before)
            z = block.white(np.nan_to_num(after.residual - before.residual))
            total += float(block.product(z, z))
    except CycloidError:
        return math.inf
    return total
