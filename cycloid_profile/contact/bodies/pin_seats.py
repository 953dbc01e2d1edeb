"""Pins in the half-round grooves of their ring: a beam on the elastic contact of its seat (docs/theory.md, Eqs. 86–88).

A pin is one body for all discs: it moves as a whole, tilts and bends under the forces of every disc on it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray
from cycloid_profile.contact.laws import Material
from cycloid_profile.errors import LoadError

_ELEMENT = 0.25  # of the pin radius, length of a beam element; half of it moves the compliance by less than 1e-4
_SHEAR = 0.9  # share of a round section that carries shear, Timoshenko


@dataclass(frozen=True, slots=True)
class PinSeats:
    """Seats of the pins; ``contact`` and ``bending`` say which of the two give way.

    ``places`` of the discs along the pin, from its middle, and their ``width`` [mm]; ``pin_radius`` and ``length`` of a
    pin [mm]; ``span`` without a seat, of the whole middle or under each disc, and ``overhang`` at both ends [mm];
    ``clearance`` of the groove in radius and ``depth`` of the ring behind it [mm]; ``line_load``, force per length
    of the seat at which its contact is linearised [N/mm].

    Raises
    ------
    LoadError
        If a size is impossible, a disc reaches beyond the pin, or no seat is left.
    """

    pin_radius: float
    length: float
    places: tuple[float, ...]
    width: float
    pin: Material
    housing: Material
    clearance: float
    depth: float
    line_load: float
    span: float = 0.0
    overhang: float = 0.0
    contact: bool = True
    bending: bool = True

    def __post_init__(self) -> None:
        for name in ("pin_radius", "length", "width", "depth", "line_load"):
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) > 0.0):
                raise LoadError(f"pin seat: {name}", getattr(self, name), "is not above zero", "give a positive size")
        for name in ("clearance", "span", "overhang"):
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) >= 0.0):
                raise LoadError(
                    f"pin seat: {name}", getattr(self, name), "is negative or not finite", "give 0 for none"
                )
        if max(abs(place) for place in self.places) + 0.5 * self.width > 0.5 * self.length * (1.0 + 1e-9):
            raise LoadError("pin seat: length", f"{self.length} mm", "is shorter than the discs", "give a longer pin")
        ends = self._breakpoints()
        if not np.any(self._seated(0.5 * (ends[1:] + ends[:-1]))):
            raise LoadError("pin seat: span", f"{self.span} mm", "leaves no seat", "make span and overhang shorter")

    @property
    def half_width(self) -> float:
        """Half-width of the contact in the groove: h² = 4 q R C_E/π, 1/R = 1/r − 1/(r + c), at most r (Eq. 86) [mm]."""
        r, c = self.pin_radius, self.clearance
        if c == 0.0:
            return r
        C_E = self.pin.compliance + self.housing.compliance
        return min(math.sqrt(4.0 * self.line_load * r * (r + c) / c * C_E / math.pi), r)

    @property
    def seat_compliance(self) -> float:
        """Recession of the pin per force on a unit length of the groove, Eq. 86 [mm²/N]; 0 for a rigid contact."""
        if not self.contact:
            return 0.0
        h = self.half_width
        both = ((self.pin, self.pin_radius), (self.housing, max(self.depth, h)))
        return sum(
            body.compliance / math.pi * (math.log(4.0 * t**2 / h**2) - body.poisson_ratio / (1.0 - body.poisson_ratio))
            for body, t in both
        )

    def compliance(self) -> FloatArray:
        """Mean recession under each disc by a unit force of each disc, shape (discs, discs) [mm/N] (Eqs. 87, 88)."""
        return _compliance(self)

    def _solved(self) -> FloatArray:
        if not (self.contact or self.bending):
            return np.zeros((len(self.places),) * 2)
        node = self._nodes()
        middle = 0.5 * (node[1:] + node[:-1])
        seated = self._seated(middle)
        stiffness = self._bending_stiffness(node)
        if self.contact:
            stiffness = stiffness + self._foundation(node, seated)
        load = np.stack([self._even_load(node, place) for place in self.places], axis=1)
        if not self.bending:
            # Shift and tilt of a stiff pin.
            rigid = np.zeros((2 * node.size, 2))
            rigid[::2, 0], rigid[::2, 1], rigid[1::2, 1] = 1.0, node, 1.0
            stiffness, load = rigid.T @ stiffness @ rigid, rigid.T @ load
        elif not self.contact:
            held = np.zeros(node.size, dtype=np.bool_)
            held[:-1] |= seated
            held[1:] |= seated
            free = np.repeat(~held, 2)
            stiffness, load = stiffness[np.ix_(free, free)], load[free]
        if not load.size:
            return np.zeros((len(self.places),) * 2)
        found: FloatArray = load.T @ np.linalg.solve(stiffness, load)
        return 0.5 * (found + found.T)

    def _breakpoints(self) -> FloatArray:
        """Ends of pin, discs and seats, ascending [mm]."""
        half = 0.5 * self.length
        ends = [-half, half, self.overhang - half, half - self.overhang]
        for middle in (*self.places, 0.0):
            ends += [middle + 0.5 * sign * size for sign in (-1.0, 1.0) for size in (self.width, self.span)]
        inside: FloatArray = np.unique(np.round([end for end in ends if -half <= end <= half], 9))
        return inside

    def _nodes(self) -> FloatArray:
        ends = self._breakpoints()
        parts = [
            np.linspace(a, b, max(1, math.ceil((b - a) / (_ELEMENT * self.pin_radius))), endpoint=False)
            for a, b in pairwise(ends)
        ]
        return np.concatenate([*parts, ends[-1:]])

    def _seated(self, z: FloatArray) -> BoolArray:
        """Whether the pin lies in its groove at ``z``: outside the span, which is one where those of the discs meet."""
        seated = np.abs(z) < 0.5 * self.length - self.overhang
        pitch = np.min(np.diff(np.sort(self.places)), initial=math.inf)
        spans = self.places if self.span <= pitch else (0.0,)
        for middle in spans:
            seated &= np.abs(z - middle) > 0.5 * self.span
        return np.asarray(seated)

    def _bending_stiffness(self, node: FloatArray) -> FloatArray:
        """Timoshenko's beam elements: deflection and slope of each node (Eq. 88)."""
        E, nu, r = self.pin.youngs_modulus, self.pin.poisson_ratio, self.pin_radius
        EI, shear = E * math.pi * r**4 / 4.0, _SHEAR * E / (2.0 * (1.0 + nu)) * math.pi * r**2
        found = np.zeros((2 * node.size,) * 2)
        for i, L in enumerate(np.diff(node)):
            phi = 12.0 * EI / (shear * L**2)
            some = np.array([
                [12.0, 6.0 * L, -12.0, 6.0 * L],
                [6.0 * L, (4.0 + phi) * L**2, -6.0 * L, (2.0 - phi) * L**2],
                [-12.0, -6.0 * L, 12.0, -6.0 * L],
                [6.0 * L, (2.0 - phi) * L**2, -6.0 * L, (4.0 + phi) * L**2],
            ])  # fmt: skip
            found[2 * i : 2 * i + 4, 2 * i : 2 * i + 4] += EI / (L**3 * (1.0 + phi)) * some
        return found

    def _foundation(self, node: FloatArray, seated: BoolArray) -> FloatArray:
        """Stiffness of the seats, 1/``seat_compliance`` per length, by cubic shapes of the deflection (Eq. 87)."""
        found = np.zeros((2 * node.size,) * 2)
        for i in np.flatnonzero(seated):
            L = node[i + 1] - node[i]
            some = np.array([
                [156.0, 22.0 * L, 54.0, -13.0 * L],
                [22.0 * L, 4.0 * L**2, 13.0 * L, -3.0 * L**2],
                [54.0, 13.0 * L, 156.0, -22.0 * L],
                [-13.0 * L, -3.0 * L**2, -22.0 * L, 4.0 * L**2],
            ])  # fmt: skip
            found[2 * i : 2 * i + 4, 2 * i : 2 * i + 4] += L / 420.0 / self.seat_compliance * some
        return found

    def _even_load(self, node: FloatArray, place: float) -> FloatArray:
        """A unit force spread evenly over one disc, equally the mean deflection there, shape (unknowns,)."""
        found = np.zeros(2 * node.size)
        for i, (a, b) in enumerate(pairwise(node)):
            if abs(0.5 * (a + b) - place) < 0.5 * self.width:
                L = b - a
                found[2 * i : 2 * i + 4] += L / self.width * np.array([0.5, L / 12.0, 0.5, -L / 12.0])
        return found


@lru_cache(maxsize=64)
def _compliance(seats: PinSeats) -> FloatArray:
    return seats._solved()
