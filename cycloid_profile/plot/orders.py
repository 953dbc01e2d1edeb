"""Orders per turn of the output: where they show, and what they are called."""

from __future__ import annotations

_MESH_HARMONICS = (1, 2, 3)


def order_label(order: int, lobes: int, pins: int, poses: int) -> str:
    """An order as 39·k, 40·k or of the mesh, whose harmonics ``poses`` rows a turn may fold back several times."""
    mesh = {k: lobes * pins * k for k in _MESH_HARMONICS}
    for k, true in mesh.items():
        if order == true:
            return f"{order} = {_harmonic(k)}"
    names = [f"{number}·{order // number}" for number in (lobes, pins) if order % number == 0]
    # Of several harmonics that fold to one order the lowest is the strongest.
    names += [f"{_harmonic(k)}, folded" for k, true in mesh.items() if order == folded_order(true, poses)][:1]
    return f"{order} = {' or '.join(names)}" if names else str(order)


def folded_order(order: int, poses: int) -> int:
    """Where an order shows with ``poses`` rows a turn."""
    return abs((order + poses // 2) % poses - poses // 2)


def _harmonic(k: int) -> str:
    return "mesh" if k == 1 else f"{k}·mesh"
