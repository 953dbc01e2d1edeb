"""Names of the orders of a curve over one turn of the output (docs/rig.md, "Transmission error")."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from cycloid_profile.geometry import Drive

_MESH_HARMONICS = (1, 2, 3)
_LARGEST_MULTIPLE = 12  # a higher one is chance where the order has another name
_MULTIPLES = (1, 2)  # of lobes and pins: two identical discs cancel the odd ones
_NONE: Mapping[int, str] = MappingProxyType({})


def order_label(order: int, lobes: int, pins: int, poses: int, single: Mapping[int, str] = _NONE) -> str:
    """An order as 39·k, 40·k, of the mesh or by its ``single`` name; ``poses`` rows a turn may fold the harmonics of
    the mesh back several times.
    """
    mesh = {k: lobes * pins * k for k in _MESH_HARMONICS}
    for k, true in mesh.items():
        if order == true:
            return f"{order} = {_harmonic(k)}"
    multiples = [(number, order // number) for number in (lobes, pins) if order % number == 0]
    names = [f"{number}·{k}" for number, k in multiples if k <= _LARGEST_MULTIPLE]
    names += [single[order]] if order in single else []
    # Of several harmonics that fold to one order the lowest is the strongest.
    names += [f"{_harmonic(k)}, folded" for k, true in mesh.items() if order == folded_order(true, poses)][:1]
    names = names or [f"{number}·{k}" for number, k in multiples]
    return f"{order} = {' or '.join(names)}" if names else str(order)


def folded_order(order: int, poses: int) -> int:
    """Order at which ``poses`` rows a turn alias an ``order``."""
    return abs((order + poses // 2) % poses - poses // 2)


def single_orders(drive: Drive) -> dict[int, str]:
    """Names of the orders of the encoder, the input and the sun, where they are whole."""
    found = {1: "encoder"}
    if drive.first_stage is not None:
        planets_per_sun = 1.0 / drive.first_stage.tooth_ratio
        for name, order in (("input", drive.reduction_ratio), ("sun", drive.trochoid.pins * (1.0 + planets_per_sun))):
            if abs(order - round(order)) < 1e-9:
                found[round(order)] = name
    return found


def expected_orders(drive: Drive, poses: int) -> list[int]:
    """Orders at which single errors of a drive show in ``poses`` rows of a turn, increasing."""
    lobes, pins = drive.trochoid.lobes, drive.trochoid.pins
    orders = {number * k for number in (lobes, pins) for k in _MULTIPLES} | set(single_orders(drive))
    shown = {order for order in orders if order < poses / 2} | {folded_order(lobes * pins, poses)}
    return sorted(shown - {0})


def _harmonic(k: int) -> str:
    return "mesh" if k == 1 else f"{k}·mesh"
