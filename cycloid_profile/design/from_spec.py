"""From the keys of a spec file to drive, tooth, load case, outline and reducer in base units."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from cycloid_profile.compensation import Compensation, LoadSharingSolver, compensate, compensate_by
from cycloid_profile.contact import LoadCase
from cycloid_profile.contact.bodies import (
    AxialRelief,
    DiscCompliance,
    FaceWidth,
    disc_compliance,
    read_disc_compliance,
)
from cycloid_profile.contact.disc import Classical, Equilibrium
from cycloid_profile.contact.laws import LAWS, Material
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.design.crank_rollers import ROLLER_LENGTH_PER_WIDTH, carried_by_rollers, on_rollers
from cycloid_profile.design.supports_of_spec import supports_of
from cycloid_profile.effects import (
    AsBuiltReducer,
    Effect,
    Empirical,
    apply_effects,
    effect_from_table,
    empirical_from_spec,
)
from cycloid_profile.errors import CompensationError, GeometryError, LoadError, SolveError, SpecError
from cycloid_profile.geometry import (
    CentralEccentric,
    Contour,
    Cranks,
    DiscOutline,
    Drive,
    InvoluteStage,
    ToothProfile,
    Trochoid,
    circular_contour,
    keyed_bore,
    ring_of_holes,
    ring_of_windows,
    thinnest_web,
)
from cycloid_profile.modification import Equidistant, FlankRotation, RadialMoving, modify
from cycloid_profile.spec.model import DiscSpec, MaterialSpec, Spec
from cycloid_profile.units import ARCMIN, DEGREE, GPA, NEWTON_METRE, UM

_T = TypeVar("_T")
_E = TypeVar("_E")

_KEYS = {
    "pins": "drive.pins",
    "pin_circle_radius": "drive.pin_circle_radius_mm",
    "pin_radius": "drive.pin_radius_mm",
    "eccentricity": "drive.eccentricity_mm",
    "disc_width": "drive.disc_width_mm",
    "discs": "drive.discs",
    "torque": "load.rated_torque_nm",
    "width_slices": "load.width_slices",
    "bearing_offset": "drive.crank_bearing.offset_mm",
    "windows.outer_radius": "disc.windows.outer_radius_mm",
    "windows.span": "disc.windows.span_deg",
    "windows.corner_radius": "disc.windows.corner_radius_mm",
    "keyway.width": "disc.keyway.width_mm",
    "keyway.corner_radius": "disc.keyway.corner_radius_mm",
    "pin seat: length": "drive.pin_seat.length_mm",
    "pin seat: span": "drive.pin_seat.span_mm",
    "ring: outer_radius": "drive.ring.outer_radius_mm",
    "ring: waves": "drive.ring.waves",
    "pillars": "drive.pillars",
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
_LARGEST_DELTA_UM = 1000.0  # a millimetre is a mistyped unit, not a deformation


def drive_of(spec: Spec) -> Drive:
    """The nominal drive.

    Raises
    ------
    GeometryError
        With the key's name where it cannot exist.
    LoadError, SpecError
        With the key's name where its crank bearings cannot exist.
    """
    d = spec.drive
    holder = d.eccentric if d.cranks is None else d.cranks
    bearing = (holder.bearing_stiffness_n_per_mm, holder.bearing_play_um * UM)
    support = (
        CentralEccentric(*bearing) if d.cranks is None else Cranks(d.cranks.count, d.cranks.circle_radius_mm, *bearing)
    )
    stage = d.first_stage
    first_stage = None if stage is None else InvoluteStage(stage.sun_teeth, stage.planet_teeth, stage.module_mm)
    with _key_names():
        drive = Drive(
            trochoid=Trochoid(d.pins, d.pin_circle_radius_mm, d.eccentricity_mm),
            pin_radius=d.pin_radius_mm,
            disc_width=d.disc_width_mm,
            discs=d.discs,
            support=support,
            first_stage=first_stage,
        )
    if not carried_by_rollers(spec):
        return drive
    outline = disc_outline(spec, drive, drive.theoretical_profile)
    return replace(drive, support=on_rollers(spec, support, outline, _material(spec.materials.disc)))


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
            law=LAWS[spec.load.law],
            # Load share of one disc in the classical scheme.
            disc_share=min(1.0, 1.1 / spec.drive.discs) if spec.load.disc_share is None else spec.load.disc_share,
            disc_bodies=disc_bodies(spec, drive),
            supports=supports_of(spec, drive, rated_torque(spec)),
            width=face_width(spec, drive),
        )


def flank_relief(spec: Spec) -> AxialRelief:
    """Relief of the flanks along the axis.

    Raises ``SpecError`` for an edge relief without a length, or longer than half the face width.
    """
    m = spec.modification
    amounts = (m.crowning_um, m.edge_relief_um, m.edge_relief_length_mm, m.flank_taper_um)
    return _relief(spec, "modification.", *amounts)


def pin_relief(spec: Spec) -> AxialRelief:
    """Relief of the pins along the axis; raises ``SpecError`` as ``flank_relief``."""
    p = spec.drive.pin_relief
    amounts = (p.crowning_um, p.edge_relief_um, p.edge_relief_length_mm, p.taper_um)
    return _relief(spec, "drive.pin_relief.", *amounts)


def _relief(
    spec: Spec, keys: str, crowning_um: float, edge_relief_um: float, edge_length: float, taper_um: float
) -> AxialRelief:
    half = 0.5 * spec.drive.disc_width_mm
    if (edge_relief_um > 0.0) != (edge_length > 0.0):
        raise SpecError(
            f"{keys}edge_relief_um", f"{edge_relief_um:g}", f"does not go with a length of {edge_length:g} mm",
            f"give {keys}edge_relief_um and {keys}edge_relief_length_mm, or neither",
        )  # fmt: skip
    if edge_length > half:
        raise SpecError(
            f"{keys}edge_relief_length_mm", f"{edge_length:g}", f"is longer than half the face width, {half:g} mm",
            "give a shorter one, or a crowning",
        )  # fmt: skip
    return AxialRelief(crowning_um * UM, edge_relief_um * UM, edge_length, taper_um * UM)


def face_width(spec: Spec, drive: Drive) -> FaceWidth | None:
    """Slices over the face width, with the relief of tooth and pins and the tilt of the bearings; None without slices.

    Raises ``SpecError`` or ``LoadError`` with the key's name where a relief, an offset or the slices are impossible.
    """
    bearing, stiffness = spec.drive.crank_bearing, drive.support.bearing_stiffness
    length = bearing.roller_length_mm or ROLLER_LENGTH_PER_WIDTH * drive.disc_width
    given = bearing.tilt_stiffness_nm_per_mrad
    tooth, pin = flank_relief(spec), pin_relief(spec)
    if not spec.load.width_slices:
        return None
    with _key_names():
        return FaceWidth(
            width=drive.disc_width,
            slices=spec.load.width_slices,
            tooth=tooth,
            pin=pin,
            tilt_stiffness=stiffness * length**2 / 12.0 if given is None else given * 1e3 * NEWTON_METRE,
            bearing_offset=bearing.offset_mm,
        )


def disc_bodies(spec: Spec, drive: Drive) -> tuple[DiscCompliance, ...]:
    """Compliance of each disc, nothing for rigid discs.

    Raises
    ------
    LoadError
        If a file cannot be read or does not fit the drive.
    SpecError
        If the disc cannot carry its own loads, or no file is given.
    """
    load = spec.load
    if load.disc_body == "rigid":
        return ()
    if load.disc_body == "file":
        if load.disc_body_file is None:
            raise SpecError("load.disc_body", "file", "needs load.disc_body_file", "give the path of an .npz file")
        count = drive.support.count if isinstance(drive.support, Cranks) else 1
        one = read_disc_compliance(Path(load.disc_body_file), drive.trochoid.lobes, count)
        return (one,) * drive.discs
    material = _material(spec.materials.disc)
    outline = disc_outline(spec, drive, drive.theoretical_profile)
    # The openings of all discs are aligned by the carrier; the eccentrics rotate the teeth relative to them.
    turned = 2.0 * math.pi / (drive.discs * drive.trochoid.lobes)
    try:
        return tuple(
            disc_compliance(outline, material.youngs_modulus, material.poisson_ratio, drive.disc_width, j * turned)
            for j in range(drive.discs)
        )
    except GeometryError:
        thinnest_wall(outline)
        raise


def compensation_of(spec: Spec, case: LoadCase) -> tuple[Compensation | None, str | None]:
    """Deformation compensation of a spec, and the reason for its refusal; either is None.

    Raises ``SpecError`` where the wanted delta_max is outside 0 to 1000 µm.
    """
    wanted = spec.modification.deformation_compensation
    if wanted is False or wanted == 0.0:
        return None, None
    if wanted is not True and not 0.0 < wanted <= _LARGEST_DELTA_UM:
        raise SpecError(
            "modification.deformation_compensation",
            f"{wanted:.6g}",
            f"is outside 0 to {_LARGEST_DELTA_UM:g}",
            "give delta_max as a positive amount in µm",
        )
    try:
        if wanted is True:
            loaded = replace(case, torque=spec.modification.compensation_load_share * case.torque)
            solver = spec.modification.compensation_solver or ("stage" if case.disc_bodies else "equilibrium")
            return compensate(loaded, _SOLVERS[solver]), None
        return compensate_by(case, wanted * UM), None
    except (CompensationError, SolveError) as error:
        return None, str(error)


def effects_of(spec: Spec) -> tuple[Effect | Empirical, ...]:
    """The ``[[effects]]`` of a spec, then its ``[[empirical]]`` ones; raises ``SpecError`` for an impossible table."""
    effects = _built("effects", spec.effects, effect_from_table)
    return (*effects, *_built("empirical", spec.empirical, empirical_from_spec))


def _built(key: str, tables: Iterable[_T], build: Callable[[_T], _E]) -> Iterator[_E]:
    """Effects of tables; errors name the number of the table."""
    for i, table in enumerate(tables, start=1):
        try:
            yield build(table)
        except SpecError as error:
            raise error.renamed(f"{key}[{i}]: {error.what}") from None


def reducer_with_effects(spec: Spec, case: LoadCase) -> AsBuiltReducer:
    """The reducer with the effects of the spec, empirical ones included; raises ``SpecError`` where one is
    impossible.
    """
    try:
        return replace(apply_effects(case, effects_of(spec)), quality=spec.quality)
    except GeometryError as error:
        raise SpecError(f"effects: {error.what}", error.value, error.limit, "take smaller effects") from None


def as_built_reducer(spec: Spec) -> AsBuiltReducer:
    """The reducer of a spec with its effects, its tooth compensated where the spec asks for that.

    Raises
    ------
    GeometryError, LoadError, SpecError
        If the drive, its tooth or an effect cannot exist.
    CompensationError
        If the compensation asked for had to be refused.
    """
    drive = drive_of(spec)
    case = load_case(spec, drive, conventional_profile(spec, drive))
    compensation, refusal = compensation_of(spec, case)
    if refusal is not None:
        raise CompensationError(
            "deformation compensation", "refused", f"({refusal})", "lower it or set it to false", " "
        )
    return reducer_with_effects(spec, case if compensation is None else replace(case, profile=compensation.profile))


def rated_torque(spec: Spec) -> float:
    """Rated output torque [N·mm]; scaled from an RV-40E by size and stiffness where the spec has none."""
    if spec.load.rated_torque_nm is not None:
        return spec.load.rated_torque_nm * NEWTON_METRE
    d, m = spec.drive, spec.materials
    modulus = min(m.disc.youngs_modulus_gpa, m.pin.youngs_modulus_gpa) * GPA
    return _TORQUE_PER_SIZE * d.pin_circle_radius_mm**2 * d.disc_width_mm * d.discs * modulus


def allowable_pressure(spec: Spec) -> float | None:
    """Allowable peak pressure [MPa]; None where the spec gives none and a body is not steel."""
    given = spec.load.allowable_pressure_mpa
    steel = _material(spec.materials.disc).is_steel and _material(spec.materials.pin).is_steel
    return STEEL_FATIGUE_LIMIT if given is None and steel else given


def output_speed(spec: Spec) -> float:
    """Speed of the output [rad/s]."""
    return spec.load.output_speed_rpm * 2.0 * math.pi / 60.0


def disc_outline(spec: Spec, drive: Drive, profile: ToothProfile) -> DiscOutline:
    """Tooth curve with the openings; sizes that the spec leaves out are estimated from the space available.

    Raises ``GeometryError`` with the key's name of an impossible window or keyway.
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
        return DiscOutline(profile, (*_bore(spec.disc, bore), *cranks, *_output_openings(spec)))


def _bore(disc: DiscSpec, radius: float) -> tuple[Contour, ...]:
    key = disc.keyway
    if radius <= 0.0:
        return ()
    if key is None:
        return (circular_contour("bore", 0j, radius),)
    first_at = key.first_at_deg * DEGREE
    return (keyed_bore("bore", radius, key.count, key.width_mm, key.depth_mm, key.corner_radius_mm, first_at),)


def output_sizes(spec: Spec) -> tuple[float, float] | None:
    """Radii of an output hole and of the roller or pin in it [mm]: hole = roller + eccentricity + clearance.

    The spec gives one of them, or both. None without output holes. Raises ``SpecError`` where neither is given, or
    the hole leaves no room for a pin.
    """
    holes, a = spec.disc.output_holes, spec.drive.eccentricity_mm
    if holes is None:
        return None
    between = a + holes.clearance_um * UM
    if holes.radius_mm is None:
        if holes.roller_radius_mm is None:
            remedy = "give disc.output_holes.radius_mm or roller_radius_mm"
            raise SpecError("disc.output_holes", "without radius_mm", "has no roller_radius_mm either", remedy, " ")
        return holes.roller_radius_mm + between, holes.roller_radius_mm
    roller = holes.radius_mm - between if holes.roller_radius_mm is None else holes.roller_radius_mm
    if roller <= 0.0:
        limit = f"is not above eccentricity and clearance, {between:.4g} mm"
        raise SpecError("disc.output_holes.radius_mm", f"{holes.radius_mm:g}", limit, "make the holes larger")
    return holes.radius_mm, roller


def _output_openings(spec: Spec) -> tuple[Contour, ...]:
    disc, sizes = spec.disc, output_sizes(spec)
    holes, windows = disc.output_holes, disc.windows
    found: tuple[Contour, ...] = ()
    if holes is not None and sizes is not None:
        found = ring_of_holes("output hole", holes.count, holes.circle_radius_mm, sizes[0])
    if windows is not None:
        first_at = 180.0 / windows.count if windows.first_at_deg is None else windows.first_at_deg
        radii = (windows.inner_radius_mm, windows.outer_radius_mm)
        span = windows.span_deg * DEGREE
        found += ring_of_windows("window", windows.count, radii, span, windows.corner_radius_mm, first_at * DEGREE)
    return found


def thinnest_wall(outline: DiscOutline) -> tuple[float, str]:
    """The thinnest wall [mm] and its place. Raises ``SpecError`` if holes cut into each other or the teeth."""
    wall, place = thinnest_web(outline)
    if wall <= 0.0:
        raise SpecError(
            f"disc: wall between {place}", f"{wall:.3f} mm", "is not above zero", "make the holes smaller or move them"
        )
    return wall, place


def _material(material: MaterialSpec) -> Material:
    return Material(material.youngs_modulus_gpa * GPA, material.poisson_ratio)


@contextmanager
def _key_names() -> Iterator[None]:
    """Name geometry errors by the key of the spec file."""
    try:
        yield
    except (GeometryError, LoadError) as error:
        raise error.renamed(_KEYS.get(error.what, error.what)) from None
