"""Elastic supports of a spec: sizes that it leaves out are estimated from those of the drive, with a range."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from cycloid_profile.contact import Pillars, PinSeats, RingBody, Supports
from cycloid_profile.contact.laws import Material
from cycloid_profile.geometry import Cranks, Drive
from cycloid_profile.spec.model import Spec
from cycloid_profile.spec.model.drive import PillarsSpec, RingSpec
from cycloid_profile.units import GPA, UM

# Axial clearance between the discs, and outside them, of their width: that of the assembly in STEP.
_CLEARANCE = 0.1


class Range(NamedTuple):
    """A size over another one, or a choice: stiffest, likely and softest."""

    stiff: float
    likely: float
    soft: float


# Proportions of an RV reducer, assumed and not measured (docs/supports.md).
GROOVE_CLEARANCE_PER_PIN_RADIUS = Range(0.0, 0.002, 0.006)
# The body with its flange and the frame around it as one ring; softest: the body alone.
RING_RADIUS_PER_PIN_CIRCLE = Range(1.45, 1.45, 1.25)
RING_WIDTH_PER_PIN_LENGTH = Range(1.2, 1.2, 1.2)
# Stiffest: one face on a rigid frame, so that the wall shears over half its width.
RING_ON_RIGID_FRAME = Range(True, False, False)
PILLAR_RADIUS_PER_CRANK_CIRCLE = Range(0.30, 0.25, 0.20)
# A bolted joint keeps the angle of a pillar; softest: it does not.
PILLAR_HINGED = Range(False, False, True)


def supports_of(spec: Spec, drive: Drive, torque: float) -> Supports:
    """Elastic supports that the spec switches on; its rated ``torque`` [N·mm] linearises the contact of the seats.

    Raises
    ------
    LoadError
        If sizes are impossible, or pillars are given to a drive without cranks.
    """
    d = spec.drive
    pillars = None if d.pillars is None or not d.pillars.elastic else _pillars(d.pillars, drive)
    body = _ring(spec, drive)
    return Supports(_seats(spec, drive, torque, body), None if d.ring is None or not d.ring.elastic else body, pillars)


def _seats(spec: Spec, drive: Drive, torque: float, ring: RingBody) -> PinSeats | None:
    """Seats in a ``ring``; None for rigid ones."""
    given, trochoid, pin = spec.drive.pin_seat, drive.trochoid, spec.materials.pin
    if given is None or not (given.contact or given.bending):
        return None
    estimate = getattr(GROOVE_CLEARANCE_PER_PIN_RADIUS, given.estimate) * drive.pin_radius
    # Largest force without clearance: 4 T/(K1 z_c r_p) of one disc.
    per_disc = abs(torque) / drive.discs
    force = 4.0 * per_disc / (trochoid.short_width_ratio * trochoid.lobes * trochoid.pin_circle_radius)
    pitch = (1.0 + _CLEARANCE) * drive.disc_width
    return PinSeats(
        pin_radius=drive.pin_radius,
        length=_pin_length(spec, drive),
        places=tuple(pitch * (j - 0.5 * (drive.discs - 1)) for j in range(drive.discs)),
        width=drive.disc_width,
        pin=Material(pin.youngs_modulus_gpa * GPA, pin.poisson_ratio),
        housing=ring.material,
        clearance=estimate if given.groove_clearance_um is None else given.groove_clearance_um * UM,
        depth=ring.outer_radius - ring.inner_radius,
        line_load=force / drive.disc_width,
        span=given.span_mm,
        overhang=given.overhang_mm,
        contact=given.contact,
        bending=given.bending,
    )


def _pin_length(spec: Spec, drive: Drive) -> float:
    """Length of a pin: that of all discs with the clearance between them unless given [mm]."""
    given = None if spec.drive.pin_seat is None else spec.drive.pin_seat.length_mm
    return given or drive.disc_width * (drive.discs + _CLEARANCE * (drive.discs - 1))


def _ring(spec: Spec, drive: Drive) -> RingBody:
    given = spec.drive.ring or RingSpec()
    circle = drive.trochoid.pin_circle_radius
    floor = circle + drive.pin_radius
    width = given.width_mm or getattr(RING_WIDTH_PER_PIN_LENGTH, given.estimate) * _pin_length(spec, drive)
    # Thick pins on a small circle: at least a wall of half their radius.
    outer = max(getattr(RING_RADIUS_PER_PIN_CIRCLE, given.estimate) * circle, floor + 0.5 * drive.pin_radius)
    body = RingBody(
        pin_circle_radius=circle,
        inner_radius=floor,
        outer_radius=given.outer_radius_mm or outer,
        width=width,
        material=Material(given.youngs_modulus_gpa * GPA, given.poisson_ratio),
        waves=min(given.waves, drive.trochoid.pins // 2),
        mounting=given.mounting_stiffness_n_per_mm2,
    )
    if body.mounting is None and getattr(RING_ON_RIGID_FRAME, given.estimate):
        shear_modulus = 0.5 * body.material.youngs_modulus / (1.0 + body.material.poisson_ratio)
        return replace(body, mounting=2.0 * shear_modulus * (body.outer_radius - floor) / width)
    return body


def _pillars(given: PillarsSpec, drive: Drive) -> Pillars:
    cranks = drive.support if isinstance(drive.support, Cranks) else None
    circle = cranks.circle_radius if cranks else 0.5 * drive.trochoid.pin_circle_radius
    stack = drive.disc_width * (drive.discs + _CLEARANCE * (drive.discs + 1))
    return Pillars(
        count=given.count or (cranks.count if cranks else 3),
        circle_radius=given.circle_radius_mm or circle,
        radius=given.radius_mm or getattr(PILLAR_RADIUS_PER_CRANK_CIRCLE, given.estimate) * circle,
        length=given.length_mm or stack,
        material=Material(given.youngs_modulus_gpa * GPA, given.poisson_ratio),
        hinged=bool(getattr(PILLAR_HINGED, given.estimate)),
        far_share=given.far_share,
    )
