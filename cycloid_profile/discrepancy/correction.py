"""The grinding program that cancels what a diagnosis named, while the machine repeats its errors (docs/diagnosis.md).

To first order the opposite of every error on the drawing gives the drawing when the error comes again. The set-up
(wheel, infeed, eccentricity) is mirrored about the drawing, every removal is taken the other way.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.diagnosis import Diagnosis, NamedEffect
from cycloid_profile.discrepancy.laid import Laid
from cycloid_profile.discrepancy.recording import Recording
from cycloid_profile.discrepancy.remainder import Remainder, Residual, smooth_remainder
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.effect import Effect, Place
from cycloid_profile.effects.pattern import removal_between
from cycloid_profile.effects.registry import EFFECTS
from cycloid_profile.errors import GeometryError, MeasurementError
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.geometry.removal import NormalRemoval, RemovalJet
from cycloid_profile.geometry.trochoid import Trochoid
from cycloid_profile.modification.deviation import MeasuredDeviation
from cycloid_profile.units import UM

LARGEST = 10.0 * UM
# Steeper than this against the drawing, path and wheel no longer touch where they should.
STEEPEST = 0.03  # mm of removal per mm of path
_POINTS_PER_LOBE = 721
_MOST_POINTS = 8001
_POINTS_PER_SPACING = 2
_STEP = 1e-3
_ROUNDS = 12
_PULL = 2.0  # standard deviations

_CAUTIONS = {
    "grinding_chatter": "a wave is cancelled only where it comes again in the same place: keep speed and clamping",
    "flank_wear": "wear is not made by the grinding machine: the correction suits regrinding, and wear will come again",
    "thermal_growth": "the correction suits discs ground at the same temperature",
    "single_tooth_error": "a slip or a hit need not come again: scan another disc before grinding by this program",
}


@dataclass(frozen=True, slots=True)
class Opposite:
    """A removal the other way round: what ``of`` takes off is left on."""

    of: NormalRemoval

    @property
    def whole_disc(self) -> bool:
        """See ``NormalRemoval``."""
        return self.of.whole_disc

    @property
    def spacing(self) -> float | None:
        """See ``NormalRemoval``."""
        return self.of.spacing

    @property
    def corners(self) -> tuple[float, ...]:
        """See ``NormalRemoval``."""
        return self.of.corners

    def jet(self, phase: FloatArray, side: FloatArray, trochoid: Trochoid) -> RemovalJet:
        """See ``NormalRemoval.jet``."""
        value, first, second = self.of.jet(phase, side, trochoid)
        return RemovalJet(-value, -first, -second)


@dataclass(frozen=True, eq=False)
class Shape:
    """How a program departs from the drawing.

    ``largest`` departure and the part of it that leaves material on (``added``) [mm]; ``steepest`` [mm/mm];
    ``bending``, largest change of curvature [1/mm]; ``concave``, least concave radius of the program [mm], or inf.
    """

    largest: float
    added: float
    steepest: float
    bending: float
    concave: float


@dataclass(frozen=True, eq=False)
class Outlook:
    """A scan before the correction and as it is expected after it, both beside the drawing; arrays over its rows.

    ``along`` the disc, phase + 2π·lobe [rad]; ``before`` and ``after``, removal with the registration taken off [µm];
    ``noise`` [µm]; ``turn``, angle of lobe 1 in the coordinates of the file [rad].
    """

    name: str
    along: FloatArray
    before: FloatArray
    after: FloatArray
    noise: float
    turn: float

    @property
    def rms_before(self) -> float:
        """Root mean square [µm]."""
        return _rms(self.before)

    @property
    def rms_after(self) -> float:
        """Root mean square [µm]."""
        return _rms(self.after)


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
    named, left = _sorted(diagnosis.effects, disc)
    grown = _apply(diagnosis.built, named)
    smooth = smooth_remainder(_residuals(diagnosis, grown, disc), drawing.trochoid.lobes) if with_remainder else None
    try:
        tooth = grown.teeth[disc]
        program = opposite(drawing, tooth if smooth is None else MeasuredDeviation(smooth.curve).apply(tooth))
        again = _apply(
            diagnosis.built.with_tooth(disc, _repeated(drawing, diagnosis.built.teeth[disc], program)), named
        )
        tooth = again.teeth[disc]
        predicted = again.with_tooth(disc, tooth if smooth is None else MeasuredDeviation(smooth.curve).apply(tooth))
    except GeometryError as error:
        raise GeometryError(
            f"corrected tooth: {error.what}", error.value, error.limit, "set the machine right instead of its program"
        ) from None
    shape = shape_of(drawing, program)
    _check(shape, limit, drawing.pin_radius if wheel_radius is None else wheel_radius)
    listed = tuple(one for one in known if one.place is Place.FLANK and _of_disc(one, disc))
    names = [one.candidate.name for one in named] + [one.name for one in listed]
    return Correction(
        disc=disc,
        drawing=drawing,
        program=program,
        predicted=predicted,
        named=named,
        known=listed,
        remainder=smooth,
        shape=shape,
        residual=_rms(removal_along(drawing, predicted.teeth[disc], _grid(drawing, program))),
        uncertainty=math.hypot(_uncertainty(diagnosis.built, named, disc), smooth.uncertainty if smooth else 0.0),
        scans=tuple(_outlooks(diagnosis, drawing, program, disc)),
        left=(*left, *(_not_ground(one.name) for one in known if one.place is not Place.FLANK)),
        cautions=(*dict.fromkeys(_CAUTIONS[name] for name in names if name in _CAUTIONS), *_alike(named)),
    )


def opposite(drawing: ToothProfile, tooth: ToothProfile) -> ToothProfile:
    """The drawing with the opposite of all that ``tooth`` departs from it; the drawing itself where nothing does.

    Raises
    ------
    GeometryError
        If that tooth cannot exist.
    """
    if tooth is drawing:
        return drawing
    count = len(drawing.removals)
    trochoid = replace(
        drawing.trochoid,
        pin_circle_radius=2.0 * drawing.trochoid.pin_circle_radius - tooth.trochoid.pin_circle_radius,
        eccentricity=2.0 * drawing.trochoid.eccentricity - tooth.trochoid.eccentricity,
    )
    turned = tuple(_turned(removal) for removal in tooth.removals[count:])
    return ToothProfile(trochoid, 2.0 * drawing.pin_radius - tooth.pin_radius, (*drawing.removals, *turned))


def removal_along(before: ToothProfile, after: ToothProfile, along: FloatArray) -> FloatArray:
    """What ``after`` lacks at phases along the disc, in their shape [mm]."""
    lobe = np.round(along / (2.0 * math.pi))
    return removal_between(before, after, along - 2.0 * math.pi * lobe, lobe)


def shape_of(drawing: ToothProfile, program: ToothProfile) -> Shape:
    """How far, how steeply and how sharply the program departs from the drawing, on a grid fine enough for both."""
    along = _grid(drawing, program)
    h = removal_along(drawing, program, along)
    old, new = drawing.at(along), program.at(along)
    # Lobe by lobe, so that a corner is no slope; the arc is that of the drawing.
    slope = np.diff(h) / np.maximum(np.abs(np.diff(old.position)), 1e-12)
    concave = float(np.max(new.curvature))
    return Shape(
        largest=float(np.max(np.abs(h))),
        added=float(np.max(-h, initial=0.0)),
        steepest=float(np.max(np.abs(slope))),
        bending=float(np.max(np.abs(new.curvature - old.curvature))),
        concave=1.0 / concave if concave > 0.0 else math.inf,
    )


def _check(shape: Shape, limit: float, wheel_radius: float) -> None:
    if not shape.largest <= limit:
        raise GeometryError(
            "largest correction",
            f"{shape.largest / UM:.2f} µm",
            f"is more than the limit of {limit / UM:g} µm",
            "set the machine right first, or raise --limit-um",
        )
    if not shape.steepest <= STEEPEST:
        raise GeometryError(
            "slope of the correction",
            f"{shape.steepest / UM:.1f} µm/mm",
            f"is more than {STEEPEST / UM:g} µm/mm",
            "no wheel follows that: take the short waves off at their source",
        )
    if not shape.concave >= wheel_radius:
        raise GeometryError(
            "least concave radius of the corrected tooth",
            f"{shape.concave:.4f} mm",
            f"is below the wheel radius {wheel_radius:.4f} mm",
            "take a smaller wheel and tell its radius with --wheel-radius-mm, or set the machine right",
        )


def _turned(removal: NormalRemoval) -> NormalRemoval:
    return removal.of if isinstance(removal, Opposite) else Opposite(removal)


def _repeated(drawing: ToothProfile, built: ToothProfile, program: ToothProfile) -> ToothProfile:
    """The program with what the spec already held against the drawing: the machine does it again."""
    if built is drawing:
        return program
    trochoid = replace(
        program.trochoid,
        pin_circle_radius=program.trochoid.pin_circle_radius
        + (built.trochoid.pin_circle_radius - drawing.trochoid.pin_circle_radius),
        eccentricity=program.trochoid.eccentricity + (built.trochoid.eccentricity - drawing.trochoid.eccentricity),
    )
    radius = program.pin_radius + (built.pin_radius - drawing.pin_radius)
    return ToothProfile(trochoid, radius, (*program.removals, *built.removals[len(drawing.removals) :]))


def _sorted(effects: Iterable[NamedEffect], disc: int) -> tuple[tuple[NamedEffect, ...], tuple[str, ...]]:
    """Those to cancel, and a sentence on each of the others."""
    named, left = [], []
    for one in effects:
        doubts = [name for name in one.group if EFFECTS[name].place is not Place.FLANK]
        if one.candidate.kind.place is not Place.FLANK:
            left.append(_not_ground(one.candidate.name))
        elif not _of_disc(one.effect, disc):
            left.append(f"{one.candidate.name} is on another disc: scan and correct that one")
        elif doubts:
            by = f": measure {one.separate_by}" if one.separate_by else ""
            left.append(f"{one.candidate.name} may as well be {' or '.join(doubts)} and is not ground away{by}")
        else:
            named.append(one)
    return tuple(named), tuple(left)


def _alike(named: Iterable[NamedEffect]) -> list[str]:
    return [
        f"{one.candidate.name} may as well be {' or '.join(one.group[1:])}: "
        "the scan does not tell them apart, and the correction suits both"
        for one in named
        if len(one.group) > 1
    ]


def _not_ground(name: str) -> str:
    return f"{name} is no error of the flank ({EFFECTS[name].place.value}): grinding the disc does not take it away"


def _of_disc(effect: Effect, disc: int) -> bool:
    return getattr(effect, "disc", None) in (None, disc + 1)


def _apply(built: Built, named: Iterable[NamedEffect]) -> Built:
    return reduce(lambda so_far, one: one.effect.apply(so_far), named, built)


def _scanned(diagnosis: Diagnosis, disc: int) -> list[Recording]:
    recordings = [gap.recording for gap in diagnosis.gaps]
    return [r for r in recordings if r.kind == "profile_scan" and r.disc == disc]


def _residuals(diagnosis: Diagnosis, grown: Built, disc: int) -> list[Residual]:
    """What each scan leaves once the effects to be cancelled are taken into account."""
    found = []
    for recording in _scanned(diagnosis, disc):
        laid = Laid(recording, grown)
        along = laid.phase + 2.0 * math.pi * laid.lobe
        left = _settled(laid.residual, _registration(laid), recording.noise.sigma)
        found.append(Residual(along, left * UM, recording.noise.sigma * UM, recording.noise.rho))
    return found


def _outlooks(diagnosis: Diagnosis, drawing: ToothProfile, program: ToothProfile, disc: int) -> list[Outlook]:
    found = []
    bare = diagnosis.built.with_tooth(disc, drawing)
    for recording in _scanned(diagnosis, disc):
        laid = Laid(recording, bare)
        change = removal_between(drawing, program, laid.phase, laid.lobe) / UM
        sigma = recording.noise.sigma
        free = _registration(laid)
        before, after = (_settled(r, free, sigma) for r in (laid.residual, laid.residual + change))
        along = laid.phase + 2.0 * math.pi * laid.lobe
        found.append(Outlook(recording.name, along, before, after, sigma, laid.placed.turn))
    return found


def _registration(laid: Laid) -> FloatArray:
    """What the datum leaves open: the angle, and the origin where it is free. The bore is what the disc turns about."""
    free = laid.recording.measurement.keys.get("datum", "bore") == "free"
    return laid.nuisance if free else laid.nuisance[:, :1]


def _settled(residual: FloatArray, nuisance: FloatArray, sigma: float) -> FloatArray:
    """The residual with what no measurement can know fitted against its prior [µm].

    Rows far off pull no harder than those at a few standard deviations (Huber): one bad lobe does not move the disc.
    """
    left = residual
    for _ in range(_ROUNDS):
        weighted = nuisance.T / (sigma**2 * np.maximum(1.0, np.abs(left) / (_PULL * sigma)))
        gram = np.eye(nuisance.shape[1]) + weighted @ nuisance
        left = residual - nuisance @ np.linalg.solve(gram, weighted @ residual)
    return left


def _uncertainty(built: Built, named: Iterable[NamedEffect], disc: int) -> float:
    """Root mean square over the disc of what the sizes may be off [mm]; effects apart."""
    variance = 0.0
    for one in named:
        candidate = one.candidate
        tooth = one.effect.apply(built).teeth[disc]
        along = _grid(built.teeth[disc], tooth)
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


def _grid(*teeth: ToothProfile) -> FloatArray:
    """Phases round the whole disc, fine enough for the shortest wave of any of the teeth [rad]."""
    spacing = [one.spacing for tooth in teeth for one in tooth.removals if one.spacing is not None]
    wanted = _POINTS_PER_LOBE
    if spacing:
        wanted = max(wanted, math.ceil(_POINTS_PER_SPACING * 2.0 * math.pi / min(spacing)))
    lobes = teeth[0].trochoid.lobes
    count = lobes * min(wanted, _MOST_POINTS)
    # Half a step off the roots and tips, so that no point falls on a corner.
    return np.linspace(0.5, count - 0.5, count) * (2.0 * math.pi * lobes / count)


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
