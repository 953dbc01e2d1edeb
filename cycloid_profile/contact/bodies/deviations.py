"""Deviations of single parts from the drawing, input of the equilibrium of the stage (docs/theory.md, Eq. 46).

They are small displacements of pins, teeth, eccentrics and bores. The gaps contain them exactly, the supports
to first order.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.errors import LoadError
from cycloid_profile.geometry import Cranks, Drive, ToothProfile


@dataclass(frozen=True, eq=False, kw_only=True)
class PartDeviations:
    """Deviations of the parts from the drawing; None for parts as drawn.

    ``pin_shift`` of each pin, x + iy in the housing frame, shape (pins,) [mm]; ``pin_oversize`` in radius,
    shape (pins,) [mm]; ``teeth``, the tooth of each disc in place of the load case's.

    For drives with cranks, shape (discs, cranks) [mm]: ``eccentric_shift`` of the eccentric's centre in a
    frame that turns with the crank, real part outwards along the eccentricity; ``bore_shift`` of the crank
    bore's centre in the frame of the carrier, x + iy when the crank angle of disc 1 is 0. ``crank_lead`` is
    how far the planet drives a crank ahead, once per turn of the planet on the carrier: Re[lead·e^{iα}],
    shape (cranks,) [rad]. ``sun_shift``, offset of the sun's centre in a frame that turns with the sun, equal to that
    of the carrier when the crank angle of disc 1 is 0 [mm].
    """

    pin_shift: ComplexArray | None = None
    pin_oversize: FloatArray | None = None
    teeth: tuple[ToothProfile, ...] | None = None
    eccentric_shift: ComplexArray | None = None
    bore_shift: ComplexArray | None = None
    crank_lead: ComplexArray | None = None
    sun_shift: complex = 0j

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray | complex) and not np.all(np.isfinite(value)):
                raise LoadError(field.name, f"{value}", "is not finite", "give every part a number, 0 as drawn")

    def check(self, drive: Drive) -> None:
        """Raise ``LoadError`` unless every array has one value for each part of the drive."""
        cranks = drive.support.count if isinstance(drive.support, Cranks) else 0
        shapes = {
            "pin_shift": (drive.trochoid.pins,),
            "pin_oversize": (drive.trochoid.pins,),
            "eccentric_shift": (drive.discs, cranks),
            "bore_shift": (drive.discs, cranks),
            "crank_lead": (cranks,),
        }
        for name, shape in shapes.items():
            value = getattr(self, name)
            if value is not None and np.shape(value) != shape:
                raise LoadError(
                    name, f"of shape {np.shape(value)}", f"is not of shape {shape}", "give one value a part"
                )
        if self.sun_shift and drive.first_stage is None:
            raise LoadError("sun_shift", self.sun_shift, "is given to a drive without a first stage", "leave it 0")
        if self.teeth is not None and len(self.teeth) != drive.discs:
            raise LoadError("teeth", len(self.teeth), f"is not the {drive.discs} discs", "give one tooth a disc")


NO_DEVIATIONS = PartDeviations()
