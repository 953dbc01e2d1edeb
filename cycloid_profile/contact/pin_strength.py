"""Shear and bending of the pins under the load of the discs.

Docs: docs/theory.md, Eqs. 66–67.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.contact.result import LoadSharing
from cycloid_profile.errors import LoadError


@dataclass(frozen=True, slots=True)
class PinStress:
    """Stresses of the most loaded pin [MPa]: ``shear`` on the neutral axis, ``bending`` at the surface.

    ``force`` of all discs on that pin [N]. The shear is a bound from above; seats count as rigid in bending.
    """

    force: float
    shear: float
    bending: float

    @property
    def equivalent_shear(self) -> float:
        """√3·``shear``, von Mises [MPa]; the bending stress vanishes on the neutral axis."""
        return math.sqrt(3.0) * self.shear


def pin_stress(sharing: LoadSharing, span: float = 0.0, overhang: float = 0.0) -> PinStress:
    """Stresses of the most loaded pin over all poses.

    A pin that lies in its groove under the disc does not bend. Its shear is bounded by the whole force of the discs in
    one section, next to a disc or between two (Eq. 66). A pin bends where it is free of its seat (Eq. 67).

    Parameters
    ----------
    span : length that the pin bridges between two seats, simply supported [mm]
    overhang : length of the pin beyond the end of its seat, held at that end [mm]

    Raises
    ------
    LoadError
        If a length is negative or not finite.
    """
    for name, value in (("span", span), ("overhang", overhang)):
        if not (math.isfinite(value) and value >= 0.0):
            raise LoadError(name, f"{value} mm", "is negative or not finite", "give 0 for a pin in a whole groove")
    drive = sharing.case.drive
    # Two opposite discs load opposite halves of the ring; of three discs, two may load one pin.
    force = float(np.max(np.sum(sharing.force, axis=1)))
    r, b = drive.pin_radius, drive.disc_width
    on_span, on_overhang = min(span, b), min(overhang, b)
    bridged = force * on_span / b * (2.0 * span - on_span) / 8.0
    hanging = force * on_overhang / b * (overhang - 0.5 * on_overhang)
    bending = 4.0 * max(bridged, hanging) / (math.pi * r**3)
    return PinStress(force, 4.0 * force / (3.0 * math.pi * r**2), bending)
