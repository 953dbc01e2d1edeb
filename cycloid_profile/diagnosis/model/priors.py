"""Prior widths of the sizes of effects, from size, material, load and manufacturing quality of the reducer.

Lengths follow the standard tolerances of ISO 286-1, angles are such lengths over a radius. Compliances are shares of
what the stage itself gives under its load, and friction is a share of the rated torque. ``PRIORS`` is the one table;
docs/diagnosis.md, "Priors", has its reasons and the widths of two reducers.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple, Protocol

import numpy as np

from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.effects import (
    AsBuiltReducer,
    CarrierBoreError,
    CommonPlanetRunout,
    CoulombFriction,
    CrankBearingClearance,
    CrankBearingCompliance,
    CrankEccentricityError,
    CrankHoleError,
    CrankPhaseError,
    CumulativePitchError,
    DiscOval,
    DiscRunout,
    Effect,
    ElastoslideFriction,
    EncoderEccentricity,
    EquidistantError,
    FlankWear,
    GeneratingEccentricityError,
    GrindingChatter,
    InputRunout,
    LoadProportionalFriction,
    MissingDeformationCompensation,
    NonlinearSeriesCompliance,
    Parameter,
    PinCircleRadiusError,
    PinPositionError,
    PinRadiusError,
    PinRingCumulativePitch,
    PinRingOval,
    PinRingRunout,
    PinRingThreeLobed,
    PinSupportCompliance,
    PlanetRunout,
    RadialMovingError,
    RingMountingOvality,
    SeriesCompliance,
    SinglePinError,
    SingleToothError,
    StribeckFriction,
    SunRunout,
    ThermalGrowth,
    ToothFormError,
    ViscoelasticCreep,
    WheelWearDrift,
)
from cycloid_profile.errors import LoadError
from cycloid_profile.geometry import Cranks, Drive
from cycloid_profile.spec.model import FLANK_GRADES, HOLE_GRADES, STIFFEST_PLASTIC, ByQuality, Quality, quality_of
from cycloid_profile.units import ARCMIN, ARCSEC, NEWTON_METRE, UM, unit_of

_POSES = 4  # the mean stiffness of an RV-40E at 4 poses is that at 24 within 0.1 %
_WIDTH_OF_TOLERANCE = 2.0  # of an effect that is not in the table
_BASE_UNITS = {
    "": 1.0,
    "k": 1.0,
    "um": UM,
    "arcmin": ARCMIN,
    "arcsec": ARCSEC,
    "nm": NEWTON_METRE,
    "um_per_kn": UM / 1e3,
    "nm_per_arcmin": NEWTON_METRE / ARCMIN,
}


def standard_tolerance(grade: int, dimension: float) -> float:
    """Width of the tolerance zone of an ISO ``grade`` IT at a ``dimension`` [mm], both [mm].

    10^((IT − 1)/5) i with i = 0.45 D^(1/3) + 0.001 D [µm], ISO 286-1:2010, 4.1; IT6 to IT18 of its Table 1 within the
    rounding and the steps of D. Below IT6 the series is continued; to 180 mm the standard is up to 40 % wider there.
    A prior is smooth in size; ``spec.model.standard_zone`` has the values that the standard prints.
    """
    unit = 0.45 * dimension ** (1.0 / 3.0) + 0.001 * dimension
    return float(10.0 ** ((grade - 1) / 5.0) * unit * UM)


class PriorRule(Protocol):
    """How the width of an effect follows from the drive."""

    def width(self, priors: Priors) -> float:
        """Standard deviation of the size in base units."""
        ...


@dataclass(frozen=True, slots=True)
class WithinGrade:
    """Length within a grade: half the tolerance zone at a dimension of the drive [mm], or of this over a radius [rad].

    ``on_pins``: pins of a harder material than a plastic disc are bought, and at least of machined quality.
    """

    dimension: Callable[[Drive], float]
    grades: ByQuality
    radius: Callable[[Drive], float] | None = None
    on_pins: bool = False

    def width(self, priors: Priors) -> float:
        drive = priors.reducer.case.drive
        grade = int(self.grades.of(priors.pin_quality if self.on_pins else priors.quality))
        half = 0.5 * standard_tolerance(grade, self.dimension(drive))
        return half if self.radius is None else half / self.radius(drive)


@dataclass(frozen=True, slots=True)
class ShareOf:
    """Share of a scale that the load gives: a torque, a compliance, a twist or a deflection, in its base unit."""

    scale: Callable[[AsBuiltReducer], float]
    shares: ByQuality

    def width(self, priors: Priors) -> float:
        return self.shares.of(priors.quality) * self.scale(priors.reducer)


@dataclass(frozen=True, slots=True)
class OwnScale:
    """Width that does not depend on the size of the drive: a temperature, a sensor, a coefficient; in base units."""

    widths: ByQuality

    def width(self, priors: Priors) -> float:
        return self.widths.of(priors.quality)


class StageScales(NamedTuple):
    """What the nominal stage gives under rated torque, mean of a mesh cycle.

    ``compliance`` of the output [rad/(N·mm)], ``contact`` compliance of the hardest pressed pin [mm/N], ``deformation``
    δmax that a compensation of the flanks removes [mm].
    """

    compliance: float
    contact: float
    deformation: float


@lru_cache(maxsize=16)
def stage_scales(reducer: AsBuiltReducer) -> StageScales:
    """Deflections of the stage as drawn; raises ``LoadError`` if it cannot carry the rated torque."""
    case = reducer.case
    solved = StageEquilibrium(poses=_POSES).solve(case)
    if not solved.converged:
        torque = f"{case.torque / NEWTON_METRE:g} N·m"
        raise LoadError("rated torque", torque, f"has no equilibrium ({solved.status.value})", "lower the torque")
    hardest = float(np.max(solved.pin_stiffness[solved.loaded]))
    return StageScales(1.0 / float(np.mean(solved.torsional_stiffness)), 1.0 / hardest, solved.delta_max)


def _pin_circle(drive: Drive) -> float:
    return 2.0 * drive.trochoid.pin_circle_radius


def _pin(drive: Drive) -> float:
    return 2.0 * drive.pin_radius


def _eccentricity(drive: Drive) -> float:
    return drive.trochoid.eccentricity


def _crank_circle(drive: Drive) -> float:
    """Crank circle; half the pin circle where one eccentric in the middle takes its place."""
    return 2.0 * drive.support.circle_radius if isinstance(drive.support, Cranks) else drive.trochoid.pin_circle_radius


def _planet(drive: Drive) -> float:
    # Without a first stage the effect does not exist, whatever its width.
    return _crank_circle(drive) if drive.first_stage is None else 2.0 * drive.first_stage.planet_radius


def _sun(drive: Drive) -> float:
    return _planet(drive) if drive.first_stage is None else _planet(drive) * drive.first_stage.tooth_ratio


def _torque(reducer: AsBuiltReducer) -> float:
    return abs(reducer.case.torque)


def _stage_compliance(reducer: AsBuiltReducer) -> float:
    return stage_scales(reducer).compliance


def _stage_twist(reducer: AsBuiltReducer) -> float:
    return _stage_compliance(reducer) * _torque(reducer)


def _stage_deformation(reducer: AsBuiltReducer) -> float:
    return stage_scales(reducer).deformation


def _contact_compliance(reducer: AsBuiltReducer) -> float:
    return stage_scales(reducer).contact


def _bearing_compliance(reducer: AsBuiltReducer) -> float:
    """Compliance of each bearing that alone would twist the stage as much as all its parts do [mm/N].

    A compliance c of n bearings a disc at the radius r twists N discs by c/(n N r²), as far as they carry the moment
    alone; the radial force adds two fifths of it on an RV-40E. The central eccentric acts at the radius e z_c of the
    disc's rolling circle.
    """
    drive = reducer.case.drive
    held, path = drive.support, drive.trochoid
    per_disc = held.count * held.circle_radius**2 if isinstance(held, Cranks) else (path.eccentricity * path.lobes) ** 2
    return _stage_compliance(reducer) * drive.discs * per_disc


# Grades that grinding, milling or turning, and printing hold; see docs/diagnosis.md, "Priors", for each reason.
_FLANK = WithinGrade(_pin_circle, FLANK_GRADES)
_WITHIN_ONE_PASS = WithinGrade(_pin_circle, ByQuality(3, 6, 11))
_WAVINESS = WithinGrade(_pin_circle, ByQuality(1, 4, 10))
_RING = WithinGrade(_pin_circle, ByQuality(5, 8, 12))
_PIN = WithinGrade(_pin, ByQuality(5, 6, 12), on_pins=True)
_CRANK = WithinGrade(_crank_circle, HOLE_GRADES)
_GEARS = ByQuality(8, 9, 12)
_SERIES = ByQuality(5.0, 5.0, 20.0)
_CREEP = ByQuality(1.2, 1.2, 5.0)  # a quarter: plastics lose that share of their short-time modulus within minutes
_FRICTION = ShareOf(_torque, ByQuality(0.03, 0.05, 0.15))

PRIORS: dict[type[Effect], PriorRule] = {
    EquidistantError: _FLANK,
    RadialMovingError: _FLANK,
    DiscRunout: _FLANK,
    DiscOval: _FLANK,
    CumulativePitchError: _FLANK,
    ToothFormError: _FLANK,
    FlankWear: _FLANK,
    GeneratingEccentricityError: _WITHIN_ONE_PASS,
    WheelWearDrift: _WITHIN_ONE_PASS,
    SingleToothError: _WITHIN_ONE_PASS,
    GrindingChatter: _WAVINESS,
    MissingDeformationCompensation: ShareOf(_stage_deformation, ByQuality(1.0, 1.0, 1.0)),
    ThermalGrowth: OwnScale(ByQuality(6.0, 6.0, 40.0)),
    PinCircleRadiusError: _RING,
    PinRingRunout: _RING,
    PinRingOval: _RING,
    PinRingThreeLobed: _RING,
    RingMountingOvality: _RING,
    PinRingCumulativePitch: _RING,
    PinPositionError: _RING,
    PinRadiusError: _PIN,
    SinglePinError: _PIN,
    CrankEccentricityError: _CRANK,
    CrankHoleError: _CRANK,
    CarrierBoreError: _CRANK,
    CrankBearingClearance: WithinGrade(_crank_circle, ByQuality(4, 6, 12)),
    CrankPhaseError: WithinGrade(_crank_circle, ByQuality(4, 6, 11), radius=_eccentricity),
    PlanetRunout: WithinGrade(_planet, _GEARS),
    CommonPlanetRunout: WithinGrade(_planet, _GEARS),
    SunRunout: WithinGrade(_sun, _GEARS),
    SeriesCompliance: ShareOf(_stage_compliance, _SERIES),
    NonlinearSeriesCompliance: ShareOf(_stage_twist, _SERIES),
    ViscoelasticCreep: ShareOf(_stage_twist, _CREEP),
    CrankBearingCompliance: ShareOf(_bearing_compliance, ByQuality(0.5, 0.5, 3.0)),
    PinSupportCompliance: ShareOf(_contact_compliance, ByQuality(1.0, 1.0, 3.0)),
    CoulombFriction: _FRICTION,
    ElastoslideFriction: _FRICTION,
    StribeckFriction: _FRICTION,
    LoadProportionalFriction: OwnScale(ByQuality(0.06, 0.06, 0.12)),
    EncoderEccentricity: OwnScale(ByQuality(10.0 * ARCSEC, 10.0 * ARCSEC, 6.0 * ARCMIN)),
    InputRunout: OwnScale(ByQuality(2.0 * ARCMIN, 2.0 * ARCMIN, 20.0 * ARCMIN)),
}


@dataclass(frozen=True, slots=True)
class Priors:
    """Prior widths of one ``reducer``, made in one ``quality``; ``pin_quality`` of its pins."""

    reducer: AsBuiltReducer
    quality: Quality
    pin_quality: Quality

    def width(self, kind: type[Effect], size: Parameter, reciprocal: bool) -> float:
        """Standard deviation of the size of an effect about zero, in the unit of ``size``, or its ``reciprocal``.

        An effect that is not in ``PRIORS`` has twice its manufacturing tolerance. Raises ``LoadError`` where the width
        of a compliance is asked for and the stage cannot carry its rated torque.
        """
        rule = PRIORS.get(kind)
        if rule is None:
            tolerance = float(size.tolerance or 0.0)
            return _WIDTH_OF_TOLERANCE * (1.0 / tolerance if reciprocal else tolerance)
        unit = _BASE_UNITS[unit_of(size.name)]
        return rule.width(self) * (unit if reciprocal else 1.0 / unit)

    def size_error(self, kind: type[Effect]) -> float:
        """Standard deviation of what the model itself errs in the size of an effect, in prior widths.

        A pin on a spring gives as contact and disc do, and their compliance is known to a share only.
        """
        if kind is not PinSupportCompliance:
            return 0.0
        share = math.hypot(tuned.CONTACT_LAW, body_error(self.reducer))
        return share * _contact_compliance(self.reducer) / PRIORS[kind].width(self)


def body_error(reducer: AsBuiltReducer) -> float:
    """Standard deviation of what the bodies of the discs give, in shares of the approach of their contacts."""
    return tuned.BODY_OF_ELASTIC_DISC if reducer.case.disc_bodies else tuned.BODY_OF_RIGID_DISC


def priors_of(reducer: AsBuiltReducer) -> Priors:
    """Prior widths for a reducer, its quality from the material of the disc where the spec gives none."""
    case = reducer.case
    quality = quality_of(reducer.quality, case.disc_material.youngs_modulus)
    bought = quality == "printed" and case.pin_material.youngs_modulus >= STIFFEST_PLASTIC
    return Priors(reducer, quality, "machined" if bought else quality)
