"""The grinding program that cancels what a diagnosis named, while the machine repeats its errors (docs/diagnosis.md).

To first order the opposite of every error on the drawing gives the drawing when the error comes again.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.corrected_scans import Outlook, outlooks, residuals
from cycloid_profile.discrepancy.correction_limits import LARGEST, refuse_beyond
from cycloid_profile.discrepancy.departure import Shape, removal_along, round_disc, shape_of
from cycloid_profile.discrepancy.grindable import cautions, grindable, grindable_known
from cycloid_profile.discrepancy.opposite import opposite, repeated
from cycloid_profile.discrepancy.outcome import Diagnosis, NamedEffect
from cycloid_profile.discrepancy.remainder import Remainder, smooth_remainder
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.effect import Effect
from cycloid_profile.errors import GeometryError, MeasurementError
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.modification.deviation import MeasuredDeviation
from cycloid_profile.units import UM

_STEP = 1e-3


@dataclass(frozen=True, eq=False)
class Correction:
    """What to grind instead of the drawing, and what comes of it.

    ``disc`` counted from 0; ``program`` tooth to be ground; ``predicted``, the reducer with the disc that the same
    machine makes of it, and ``residual``, what that departs from the drawing, root mean square [mm]. ``named`` flank
    effects are cancelled, and ``known`` ones that the spec already held; ``left`` tells in a sentence each what
    grinding cannot take away, ``cautions`` what to mind. ``uncertainty`` of the correction from that of the sizes,
    root mean square [mm].
    """

    disc: int
    drawing: ToothProfile
    program: ToothProfile
    predicted: Built
    named: tuple[NamedEffect, ...]
    known: tuple[Effect, ...]
    remainder: Remainder | None
    shape: Shape
    residual: float
    uncertainty: float
    scans: tuple[Outlook, ...]
    left: tuple[str, ...]
    cautions: tuple[str, ...]

    def removal(self, along: FloatArray) -> FloatArray:
        """What the program takes off beyond the drawing at phases along the disc, in their shape [mm]."""
        return removal_along(self.drawing, self.program, along)

    @property
    def nothing(self) -> bool:
        """Whether the program is the drawing."""
        return self.program is self.drawing

    @property
    def rms_expected(self) -> float:
        """What a new scan will read against the drawing: noise, what stays, and what the correction errs [µm]."""
        if not self.scans:
            return self.uncertainty / UM
        # The rows at hand were used for the fit, which flatters them as much as it errs on new ones.
        return math.sqrt(
            float(np.mean([scan.rms_after**2 for scan in self.scans])) + 2.0 * (self.uncertainty / UM) ** 2
        )


def correction(
    diagnosis: Diagnosis,
    disc: int = 0,
    limit: float = LARGEST,
    *,
    wheel_radius: float | None = None,
    with_remainder: bool = False,
    known: Sequence[Effect] = (),
) -> Correction:
    """The program for one disc that cancels the named flank effects and those the spec already held.

    Parameters
    ----------
    diagnosis : what was found
    disc : counted from 0
    limit : largest departure from the drawing that is allowed [mm]
    wheel_radius : radius of the grinding wheel [mm], that of the generating pin if None
    with_remainder : cancel the smooth part of what the named effects leave, too
    known : effects of the spec, to be listed with those that are cancelled

    Raises
    ------
    GeometryError
        If the program would depart further than ``limit``, be too steep, or bend more than wheel or tooth allow.
    MeasurementError
        If there is no such disc.
    """
    if not 0 <= disc < diagnosis.built.discs:
        raise MeasurementError("disc", disc + 1, f"is not one of the {diagnosis.built.discs} discs", "count from 1")
    drawing = diagnosis.built.case.profile
    named, left = grindable(diagnosis.effects, disc)
    listed, also_left = grindable_known(known, disc)
    grown = _apply(diagnosis.built, named)
    smooth = smooth_remainder(residuals(diagnosis, grown, disc), drawing.trochoid.lobes) if with_remainder else None
    try:
        tooth = grown.teeth[disc]
        program = opposite(drawing, tooth if smooth is None else MeasuredDeviation(smooth.curve).apply(tooth))
        again = _apply(diagnosis.built.with_tooth(disc, repeated(drawing, diagnosis.built.teeth[disc], program)), named)
        tooth = again.teeth[disc]
        predicted = again.with_tooth(disc, tooth if smooth is None else MeasuredDeviation(smooth.curve).apply(tooth))
    except GeometryError as error:
        raise GeometryError(
            f"corrected tooth: {error.what}", error.value, error.limit, "set the machine right instead of its program"
        ) from None
    shape = shape_of(drawing, program)
    refuse_beyond(shape, limit, drawing.pin_radius if wheel_radius is None else wheel_radius)
    off = removal_along(drawing, predicted.teeth[disc], round_disc(drawing, program))
    return Correction(
        disc=disc,
        drawing=drawing,
        program=program,
        predicted=predicted,
        named=named,
        known=listed,
        remainder=smooth,
        shape=shape,
        residual=float(np.sqrt(np.mean(off**2))),
        uncertainty=math.hypot(_uncertainty(diagnosis.built, named, disc), smooth.uncertainty if smooth else 0.0),
        scans=tuple(outlooks(diagnosis, drawing, program, disc)),
        left=(*left, *also_left),
        cautions=cautions(named, listed),
    )


def _apply(built: Built, named: Iterable[NamedEffect]) -> Built:
    return reduce(lambda so_far, one: one.effect.apply(so_far), named, built)


def _uncertainty(built: Built, named: Iterable[NamedEffect], disc: int) -> float:
    """Root mean square over the disc of what the sizes may be off [mm]; effects apart."""
    variance = 0.0
    for one in named:
        candidate = one.candidate
        tooth = one.effect.apply(built).teeth[disc]
        along = round_disc(built.teeth[disc], tooth)
        columns = []
        for c in range(candidate.coordinates):
            moved = np.array(one.coordinates, dtype=np.float64)
            moved[c] += _STEP * candidate.width
            effect = candidate.effect(moved)
            assert effect is not None
            columns.append(removal_along(tooth, effect.apply(built).teeth[disc], along) / (_STEP * candidate.width))
        G = np.stack(columns, axis=1)
        n = candidate.coordinates
        variance += float(np.mean(np.sum((G @ one.covariance[:n, :n]) * G, axis=1)))
    return math.sqrt(variance)
