"""From the keys of a spec file to geometry and loads in base units."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager

from cycloid_profile.compensation.fixed_point import LoadSharingSolver
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.classical import Classical
from cycloid_profile.contact.equilibrium import Equilibrium
from cycloid_profile.contact.hertz import STEEL, Material
from cycloid_profile.contact.laws import LAWS
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.effect import Effect
from cycloid_profile.effects.registry import build, effect
from cycloid_profile.errors import GeometryError, LoadError, SpecError
from cycloid_profile.geometry.contour import Arc, Contour, circle
from cycloid_profile.geometry.drive import CentralEccentric, Cranks, Drive, InvoluteStage
from cycloid_profile.geometry.openings import keyed_bore, ring_of_holes, ring_of_windows
from cycloid_profile.geometry.outline import DiscOutline, least_web
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.geometry.trochoid import Trochoid
from cycloid_profile.modification.setup import Equidistant, FlankRotation, RadialMoving, modify
from cycloid_profile.spec.disc import DiscSpec
from cycloid_profile.spec.materials import MaterialSpec
from cycloid_profile.spec.model import Spec
from cycloid_profile.units import ARCMIN, DEGREE, GPA, NEWTON_METRE, UM

_KEYS = {
    "pins": "drive.pins",
    "pin_circle_radius": "drive.pin_circle_radius_mm",
    "pin_radius": "drive.pin_radius_mm",
    "eccentricity": "drive.eccentricity_mm",
    "disc_width": "drive.disc_width_mm",
    "discs": "drive.discs",
    "torque": "load.rated_torque_nm",
    "windows.outer_radius": "disc.windows.outer_radius_mm",
    "windows.span": "disc.windows.span_deg",
    "windows.corner_radius": "disc.windows.corner_radius_mm",
    "keyway.width": "disc.keyway.width_mm",
    "keyway.corner_radius": "disc.keyway.corner_radius_mm",
}

_SOLVERS: dict[str, LoadSharingSolver] = {
    "equilibrium": Equilibrium(),
    "classical": Classical(),
    "stage": StageEquilibrium(),
}
# ISO 281:2007, Annex B: fatigue limit of bearing steel, contact stress 1500 MPa.
STEEL_FATIGUE_LIMIT = 1500.0
# Rated torque of an RV-40E per pin circle² × width × discs × modulus: a first guess where none is given.
_TORQUE_PER_SIZE = 412e3 / (64.0**2 * 11.5 * 2 * 206e3)


def drive_of(spec: Spec) -> Drive:
    """The nominal drive. Raises ``GeometryError`` with the key's name where it cannot exist."""
    d = spec.drive
    support: Cranks | CentralEccentric = CentralEccentric(
        d.eccentric.bearing_stiffness_n_per_mm, d.eccentric.bearing_play_um * UM
    )
    if d.cranks is not None:
        support = Cranks(
            d.cranks.count,
            d.cranks.circle_radius_mm,
            d.cranks.bearing_stiffness_n_per_mm,
            d.cranks.bearing_play_um * UM,
        )
    stage = d.first_stage
    first_stage = None if stage is None else InvoluteStage(stage.sun_teeth, stage.planet_teeth, stage.module_mm)
    with _key_names():
        return Drive(
            trochoid=Trochoid(d.pins, d.pin_circle_radius_mm, d.eccentricity_mm),
            pin_radius=d.pin_radius_mm,
            disc_width=d.disc_width_mm,
            discs=d.discs,
            support=support,
            first_stage=first_stage,
        )


def conventional_profile(spec: Spec, drive: Drive) -> ToothProfile:
    """The tooth with the modifications of the set-up, before deformation compensation."""
    m = spec.modification
    try:
        return modify(
            drive.theoretical_profile,
            Equidistant(m.equidistant_um * UM),
            RadialMoving(m.radial_moving_um * UM),
            FlankRotation(m.rotation_arcmin * ARCMIN),
        )
    except GeometryError as error:
        amounts = f"equidistant_um = {m.equidistant_um:g}, radial_moving_um = {m.radial_moving_um:g}"
        raise SpecError(
            f"modification ({amounts}): {error.what}", error.value, error.limit, "take smaller modification amounts"
        ) from None


def load_case(spec: Spec, drive: Drive, profile: ToothProfile) -> LoadCase:
    """The rated load on ``profile``."""
    with _key_names():
        return LoadCase(
            drive=drive,
            profile=profile,
            torque=rated_torque(spec),
            disc_material=_material(spec.materials.disc),
            pin_material=_material(spec.materials.pin),
            law=LAWS[spec.load.contact_law],
            disc_share=_disc_share(spec),
        )


def built_of(spec: Spec, case: LoadCase) -> Built:
    """The reducer of the spec with its ``[[effects]]``; raises ``SpecError`` where one cannot be."""
    made: list[Effect] = []
    for i, table in enumerate(spec.effects):
        try:
            made.append(effect(table))
        except SpecError as error:
            raise error.renamed(f"effects[{i + 1}]: {error.what}") from None
    try:
        return build(case, made)
    except GeometryError as error:
        raise SpecError(f"effects: {error.what}", error.value, error.limit, "take smaller effects") from None


def rated_torque(spec: Spec) -> float:
    """Rated output torque [N·mm]; scaled from an RV-40E by size and stiffness where the spec has none."""
    if spec.load.rated_torque_nm is not None:
        return spec.load.rated_torque_nm * NEWTON_METRE
    d, m = spec.drive, spec.materials
    modulus = min(m.disc.youngs_modulus_gpa, m.pin.youngs_modulus_gpa) * GPA
    return _TORQUE_PER_SIZE * d.pin_circle_radius_mm**2 * d.disc_width_mm * d.discs * modulus


def _disc_share(spec: Spec) -> float:
    """The share of the published schemes: a tenth more than an even one, all of it for a single disc."""
    return min(1.0, 1.1 / spec.drive.discs) if spec.load.disc_share is None else spec.load.disc_share


def allowable_pressure(spec: Spec) -> float | None:
    """Allowable peak pressure [MPa]; None where the spec gives none and a body is no steel."""
    given = spec.load.allowable_pressure_mpa
    bodies = (_material(spec.materials.disc), _material(spec.materials.pin))
    steel = all(body.youngs_modulus > 0.9 * STEEL.youngs_modulus for body in bodies)
    return STEEL_FATIGUE_LIMIT if given is None and steel else given


def output_speed(spec: Spec) -> float:
    """Speed of the output [rad/s]."""
    return spec.load.output_speed_rpm * 2.0 * math.pi / 60.0


def compensation_solver(spec: Spec) -> LoadSharingSolver:
    """The solver that finds the deformation to compensate."""
    return _SOLVERS[spec.modification.compensation_solver]


def disc_outline(spec: Spec, drive: Drive, profile: ToothProfile) -> DiscOutline:
    """Tooth curve with the openings; sizes that the spec leaves out are estimated from the room there is.

    Raises ``GeometryError`` with the key's name where a window or keyway cannot be.
    """
    bare = DiscOutline(profile)
    cranks: tuple[Contour, ...] = ()
    if isinstance(drive.support, Cranks):
        circle_radius = drive.support.circle_radius
        crank_hole = spec.disc.crank_hole_radius_mm or 0.55 * max(bare.root_radius - circle_radius, 0.0)
        bore = spec.disc.bore_radius_mm or 0.7 * max(circle_radius - crank_hole, 0.0)
        if crank_hole > 0.0:
            cranks = ring_of_holes("crank hole", drive.support.count, circle_radius, crank_hole)
    else:
        bore = spec.disc.bore_radius_mm or 0.3 * bare.root_radius
    with _key_names():
        return DiscOutline(profile, (*_bore(spec.disc, bore), *cranks, *_output_openings(spec.disc)))


def _bore(disc: DiscSpec, radius: float) -> tuple[Contour, ...]:
    key = disc.keyway
    if radius <= 0.0:
        return ()
    if key is None:
        return (circle("bore", 0j, radius),)
    first_at = key.first_at_deg * DEGREE
    return (keyed_bore("bore", radius, key.count, key.width_mm, key.depth_mm, key.corner_radius_mm, first_at),)


def _output_openings(disc: DiscSpec) -> tuple[Contour, ...]:
    holes, windows = disc.output_holes, disc.windows
    found: tuple[Contour, ...] = ()
    if holes is not None:
        found = ring_of_holes("output hole", holes.count, holes.circle_radius_mm, holes.radius_mm)
    if windows is not None:
        first_at = 180.0 / windows.count if windows.first_at_deg is None else windows.first_at_deg
        radii = (windows.inner_radius_mm, windows.outer_radius_mm)
        span = windows.span_deg * DEGREE
        found += ring_of_windows("window", windows.count, radii, span, windows.corner_radius_mm, first_at * DEGREE)
    return found


def bearing_radius(outline: DiscOutline) -> float:
    """Radius of the hole a crank bearing sits in: a crank hole, or the bore of a central eccentric [mm]."""
    held = [hole.radius for hole in outline.holes if hole.name.startswith("crank hole")]
    for contour in outline.contours:
        if contour.name == "bore":
            held += [arc.radius for arc in contour.segments if isinstance(arc, Arc) and arc.centre == 0j]
    return held[0] if held else 0.0


def thinnest_wall(outline: DiscOutline) -> tuple[float, str]:
    """The thinnest wall [mm] and its place. Raises ``SpecError`` if holes cut into each other or the teeth."""
    wall, place = least_web(outline)
    if wall <= 0.0:
        raise SpecError(
            f"disc: wall between {place}",
            f"{wall:.3f} mm",
            "is not above zero",
            "make the holes smaller or move them",
        )
    return wall, place


def _material(material: MaterialSpec) -> Material:
    return Material(material.youngs_modulus_gpa * GPA, material.poisson_ratio)


@contextmanager
def _key_names() -> Iterator[None]:
    """Tell geometry errors by the key of the spec file."""
    try:
        yield
    except (GeometryError, LoadError) as error:
        raise error.renamed(_KEYS.get(error.what, error.what)) from None
