"""Grinding program that cancels the named effects if the machine repeats its errors (docs/diagnosis.md).

To first order, the negated errors on the nominal tooth give the nominal tooth when the errors recur (Eq. 56).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np

from cycloid_profile._display import Described
from cycloid_profile.arrays import FloatArray
from cycloid_profile.correction._correctable_effects import cautions, correctable, correctable_known
from cycloid_profile.correction._deviation import (
    DeviationFigures,
    deviation_from_nominal,
    phases_round_disc,
    removal_along,
)
from cycloid_profile.correction._limits import LARGEST, check_limits
from cycloid_profile.correction._profile import correction_profile, with_machine_errors
from cycloid_profile.correction.expected_scans import ExpectedScan, expected_scans, scan_residuals
from cycloid_profile.diagnosis import Diagnosis, NamedEffect, Remainder, smooth_remainder
from cycloid_profile.effects import AsBuiltReducer, Effect, Empirical
from cycloid_profile.errors import GeometryError, MeasurementError
from cycloid_profile.geometry import ToothProfile
from cycloid_profile.modification import MeasuredDeviation
from cycloid_profile.units import UM

_STEP = 1e-3  # of the width of a coordinate: a step of a linear propagation


@dataclass(frozen=True, eq=False, repr=False)
class Correction(Described):
    """Corrected grinding program of one disc and its expected result.

    ``disc``: counted from 0. ``program``: tooth to grind. ``predicted``: reducer with the disc that the same machine
    then produces; ``residual``: its deviation from the drawing, root mean square [mm]. ``named``: flank effects
    cancelled, from the diagnosis; ``known``: those of the spec. ``not_ground_away``: one sentence for each effect that
    grinding does not correct. ``cautions``:
    conditions of validity. ``uncertainty``: root mean square error of the correction, from that of the sizes [mm].
    """

    disc: int
    drawing: ToothProfile
    program: ToothProfile
    predicted: AsBuiltReducer
    named: tuple[NamedEffect, ...]
    known: tuple[Effect | Empirical, ...]
    remainder: Remainder | None
    shape: DeviationFigures
    residual: float
    uncertainty: float
    scans: tuple[ExpectedScan, ...]
    not_ground_away: tuple[str, ...]
    cautions: tuple[str, ...]

    def removal(self, along: FloatArray) -> FloatArray:
        """Additional removal of the program relative to the drawing, at phases along the disc, in their shape [mm]."""
        return removal_along(self.drawing, self.program, along)

    @property
    def is_unchanged(self) -> bool:
        """Whether the program equals the drawing."""
        return self.program is self.drawing

    @property
    def rms_expected(self) -> float:
        """Expected root mean square of a new scan against the drawing: noise, uncorrected effects, correction error
        [µm].
        """
        if not self.scans:
            return self.uncertainty / UM
        # In-sample residuals are too small by the variance that new data add.
        return math.sqrt(
            float(np.mean([scan.rms_after**2 for scan in self.scans])) + 2.0 * (self.uncertainty / UM) ** 2
        )

    def _key_figures(self) -> Mapping[str, str]:
        cancelled = [*(one.candidate.name for one in self.named), *(one.name for one in self.known)]
        scans = {
            f"gap of {scan.name}": f"{scan.rms_before:.4g} to {scan.rms_after:.4g} µm rms, noise {scan.noise:.4g} µm"
            for scan in self.scans
        }
        return {
            "disc": str(self.disc + 1),
            "cancelled": ", ".join(cancelled) or "nothing",
            "largest deviation": f"{self.shape.largest / UM:.3g} µm from the drawing",
            "expected scan": f"{self.rms_expected:.3g} µm rms",
            **scans,
        }


def correction(
    diagnosis: Diagnosis,
    disc: int = 0,
    limit: float = LARGEST,
    *,
    wheel_radius: float | None = None,
    with_remainder: bool = False,
    known: Sequence[Effect | Empirical] = (),
) -> Correction:
    """Program for one disc that cancels the named flank effects and those of the spec.

    Parameters
    ----------
    diagnosis : result of ``diagnose``
    disc : counted from 0
    limit : largest permitted deviation from the drawing [mm]
    wheel_radius : radius of the grinding wheel [mm]; that of the generating pin if None
    with_remainder : also cancel the smooth part of the unexplained residual
    known : effects of the spec, listed with those that are cancelled

    Raises
    ------
    GeometryError
        If the program exceeds ``limit``, is too steep, or has a concave radius below the limit of wheel or tooth.
    MeasurementError
        If the disc does not exist.
    """
    if not 0 <= disc < diagnosis.reducer.discs:
        raise MeasurementError("disc", disc + 1, f"is not one of the {diagnosis.reducer.discs} discs", "count from 1")
    drawing = diagnosis.reducer.case.profile
    named, not_ground_away = correctable(diagnosis.effects, disc)
    listed, also_left = correctable_known(known, disc)
    with_effects = _apply(diagnosis.reducer, named)
    smooth = (
        smooth_remainder(scan_residuals(diagnosis, with_effects, disc), drawing.trochoid.lobes)
        if with_remainder
        else None
    )
    try:
        tooth = with_effects.teeth[disc]
        program = correction_profile(drawing, tooth if smooth is None else MeasuredDeviation(smooth.curve).apply(tooth))
        again = _apply(
            diagnosis.reducer.with_tooth(disc, with_machine_errors(drawing, diagnosis.reducer.teeth[disc], program)),
            named,
        )
        tooth = again.teeth[disc]
        predicted = again.with_tooth(disc, tooth if smooth is None else MeasuredDeviation(smooth.curve).apply(tooth))
    except GeometryError as error:
        raise GeometryError(
            f"corrected tooth: {error.what}", error.value, error.limit, "correct the machine instead of its program"
        ) from None
    shape = deviation_from_nominal(drawing, program)
    check_limits(shape, limit, drawing.pin_radius if wheel_radius is None else wheel_radius)
    off = removal_along(drawing, predicted.teeth[disc], phases_round_disc(drawing, program))
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
        uncertainty=math.hypot(_uncertainty(diagnosis.reducer, named, disc), smooth.uncertainty if smooth else 0.0),
        scans=tuple(expected_scans(diagnosis, drawing, program, disc)),
        not_ground_away=(*not_ground_away, *also_left),
        cautions=cautions(named, listed),
    )


def _apply(reducer: AsBuiltReducer, named: Iterable[NamedEffect]) -> AsBuiltReducer:
    return reduce(lambda so_far, one: one.effect.apply(so_far), named, reducer)


def _uncertainty(reducer: AsBuiltReducer, named: Iterable[NamedEffect], disc: int) -> float:
    """Root mean square over the disc of the error from the uncertainty of the sizes [mm]; effects are independent."""
    variance = 0.0
    for one in named:
        candidate = one.candidate
        tooth = one.effect.apply(reducer).teeth[disc]
        along = phases_round_disc(reducer.teeth[disc], tooth)
        columns = []
        for c in range(candidate.coordinates):
            moved = np.array(one.coordinates, dtype=np.float64)
            moved[c] += _STEP * candidate.width
            effect = candidate.effect(moved)
            assert effect is not None
            columns.append(removal_along(tooth, effect.apply(reducer).teeth[disc], along) / (_STEP * candidate.width))
        G = np.stack(columns, axis=1)
        n = candidate.coordinates
        variance += float(np.mean(np.sum((G @ one.covariance[:n, :n]) * G, axis=1)))
    return math.sqrt(variance)
