"""A whole drive from its ratio: proposed sizes, each with its rule, as a commented spec file."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from cycloid_profile.design.from_spec import rated_torque
from cycloid_profile.errors import SpecError
from cycloid_profile.geometry import Trochoid, undercut_limit
from cycloid_profile.spec import SCHEMA_FILE, Spec, parse_spec
from cycloid_profile.spec.model import NamedMaterial, named_material
from cycloid_profile.units import NEWTON_METRE, UM

_HANDBOOK = "handbook"
HEADER = (
    "Proposed by 'cycloid-profile new': change what you know better. In brackets the source of each rule;",
    "handbook: Mechanical Design Handbook (机械设计手册), cycloid pin-wheel drives. Docs: docs/spec.md#proposals",
)
_COMMENT_WIDTH = 110  # characters
# Most lobes of each class, with the middle of the handbook's range of K1.
_SHORT_WIDTH_RATIO = ((12, 0.485), (24, 0.61), (60, 0.775), (999, 0.825))
# Pins below this number, with the middle of the handbook's range of K2, pitch of the pins over their diameter.
_PIN_SPACING = ((12, 3.35), (24, 2.4), (36, 1.625), (1001, 1.5))
_CLOSEST_PINS = 1.2  # K2 that a given diameter must leave
_UNDERCUT_MARGIN = 1.15  # undercut limit over radius of the generating pin
_SMALLEST_RATIO_K1 = 0.15
_WALL = 0.05  # of the housing's diameter
_DOWELS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0)
_HOUSING = 60.0  # mm
_LEAST_PIN = 2.0  # mm, where the housing is proposed as well
_CLEARANCE_UM = {"printed": 100.0, "machined": 20.0, "ground": 2.0}
_OUTPUT_PINS = ((100.0, 6), (200.0, 8), (300.0, 10), (math.inf, 12))  # below this diameter of the pin circle [mm]
_TOOTH_RATIO = (1.0, 6.0)  # planet over sun: three planets next to each other
_USUAL_TOOTH_RATIO, _USUAL_RATIOS = 3.0, (19, 29, 39, 49, 59)

RULES = {
    "ratio": ("lobes of the disc = turns of the eccentric per turn of the output, housing fixed", "kinematics"),
    "total_ratio": ("1 + pins · planet teeth / sun teeth, nearest teeth; lobes that make z2/z1 near 3", "RV-40E"),
    "outer_diameter": (f"{_HOUSING:g} mm, more where the pins would be thinner than {_LEAST_PIN:g} mm", "assumed"),
    "pin_circle": ("housing less a wall of 1/20 of its diameter outside the pins", "assumed"),
    "pin_diameter": ("K2 = pitch / diameter in the middle of its range, at least 1.5; next thinner dowel of ISO 8734",
                     _HANDBOOK),
    "eccentricity": ("K1 = eccentricity · pins / pin circle radius in the middle of its range, lower where the tooth "
                     "would be undercut or an output pin thinner than the eccentricity", f"{_HANDBOOK}; pin assumed"),
    "width": ("a tenth of the diameter of the pin circle", f"{_HANDBOOK}, 0.05 to 0.1"),
    "discs": ("two, opposite each other, balance the eccentric", "usual"),
    "bore": ("0.4 of the pin circle, for the bearing on the eccentric", _HANDBOOK),
    "holes": ("6 below a pin circle of 100 mm, 8 below 200, 10 below 300, else 12; midway between bore and root; "
              "0.7 of the room between them", f"{_HANDBOOK}; size assumed"),
    "torque": ("torque of an RV-40E, scaled by size and Young's modulus", "catalogue"),
    "clearance": ("printed 100 µm, machined 20 µm, ground 1/10000 of the pin circle radius and at least 2 µm; at most "
                  "1/10 of the eccentricity", "catalogue drives; machined assumed"),
    "bearing": ("seat of a plastic disc, 20 kN/mm", "catalogue drive printed_11"),
    "cranks": ("three at 0.56 of the pin circle; module from the distance of sun and planet", "RV-40E"),
    "chords": ("2 µm for a printed disc", "catalogue drive printed_11"),
}  # fmt: skip


@dataclass(frozen=True)
class DriveRequest:
    """What a user knows of a drive, None for what is to be proposed; lengths [mm], torque [N·m].

    ``ratio`` counts the lobes of the cycloid stage, ``total_ratio`` includes a first stage, both with the housing
    fixed; ``outer_diameter`` is that of the housing.
    """

    ratio: int | None = None
    total_ratio: float | None = None
    pin_diameter: float | None = None
    outer_diameter: float | None = None
    material: str | None = None
    torque_nm: float | None = None


@dataclass(frozen=True)
class ProposedKey:
    """One line of the proposed spec: table, key, value, and the reason as a comment."""

    table: str
    key: str
    value: Any
    reason: str


@dataclass(frozen=True)
class Proposal:
    """Every key of the proposed drive, in the order of the file; ``advice`` where a given value is unwise."""

    keys: tuple[ProposedKey, ...]
    advice: tuple[str, ...] = ()

    @property
    def spec(self) -> Spec:
        """The proposed drive."""
        return parse_spec(self.text)

    @property
    def text(self) -> str:
        """The spec file, the reason above each key."""
        import tomli_w

        lines, table = [f"#:schema {SCHEMA_FILE}", *(f"# {line}" for line in HEADER)], ""
        for one in self.keys:
            if one.table != table:
                lines += ["", f"[{one.table}]"]
                table = one.table
            lines += textwrap.wrap(one.reason, _COMMENT_WIDTH, initial_indent="# ", subsequent_indent="# ")
            lines.append(tomli_w.dumps({one.key: one.value}).strip())
        return "\n".join(lines) + "\n"


@dataclass(frozen=True)
class _Sizes:
    """Ring and tooth [mm]."""

    lobes: int
    outer_diameter: float
    pin_circle_radius: float
    pin_diameter: float
    eccentricity: float

    @property
    def trochoid(self) -> Trochoid:
        return Trochoid(self.lobes + 1, self.pin_circle_radius, self.eccentricity)

    @property
    def root_radius(self) -> float:
        return self.pin_circle_radius - 0.5 * self.pin_diameter - self.eccentricity

    @property
    def bore_radius(self) -> float:
        return _rounded_down(0.4 * self.pin_circle_radius)

    @property
    def holes(self) -> int:
        return next(number for below, number in _OUTPUT_PINS if 2.0 * self.pin_circle_radius < below)

    @property
    def hole_circle(self) -> float:
        return 0.5 * (self.bore_radius + self.root_radius)


def propose(request: DriveRequest) -> Proposal:
    """Propose what a request leaves open.

    Raises ``SpecError`` where no ratio is given, or a given value is impossible or does not fit the others.
    """
    for name in ("total_ratio", "pin_diameter", "outer_diameter", "torque_nm"):
        value = getattr(request, name)
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise SpecError(_option(name), f"{value:g}", "is not above zero", "give a positive number")
    lobes = _lobes(request)
    material = named_material(request.material or "PLA")
    sizes = _with_eccentricity(_ring(lobes, request), request.total_ratio is None)
    drive = (*_head(request, lobes, material), *_drive(request, sizes, material))
    usual = float(f"{rated_torque(Proposal(drive).spec) / NEWTON_METRE:.2g}")
    torque = usual if request.torque_nm is None else request.torque_nm
    reason = _rule("torque") if request.torque_nm is None else f"given; usual are {usual:g} N·m: {_rule('torque')}"
    load = ProposedKey("load", "rated_torque_nm", torque, reason)
    return Proposal((*drive, load, *_rest(request, sizes, material)), _overload(torque, usual, sizes.outer_diameter))


def _overload(torque: float, usual: float, outer_diameter: float) -> tuple[str, ...]:
    """Advice on a torque above the usual one [N·m], which grows with the cube of the size."""
    if torque <= usual:
        return ()
    larger = outer_diameter * (torque / usual) ** (1.0 / 3.0)
    return (
        f"--torque = {torque:g} N·m is {torque / usual:.1f} times the usual {usual:g} N·m of this size and material: "
        f"check the pressure of the teeth, or give --outer-diameter {math.ceil(larger)}",
    )


def rule_table() -> str:
    """Markdown table of the rules."""
    head = ["| proposed | rule | source |", "|---|---|---|"]
    rows = [f"| {name.replace('_', ' ')} | {rule} | {source} |" for name, (rule, source) in RULES.items()]
    return "\n".join([*head, *rows, ""])


def _option(name: str) -> str:
    return f"--{name.removesuffix('_nm').replace('_', '-')}"


def _lobes(request: DriveRequest) -> int:
    if request.ratio is not None:
        if not 3 <= request.ratio <= 300:
            raise SpecError("--ratio", request.ratio, "is outside 3 to 300", "give the lobes of the cycloid stage")
        return request.ratio
    if request.total_ratio is None:
        raise SpecError("--ratio", "is not given", "and nothing else gives it", "give --ratio or --total-ratio", " ")
    wanted = request.total_ratio - 1.0
    return min(_USUAL_RATIOS, key=lambda lobes: abs(wanted / (lobes + 1) - _USUAL_TOOTH_RATIO))


def _ring(lobes: int, request: DriveRequest) -> _Sizes:
    """Housing, pin circle and pins; the eccentricity is still open."""
    pitch = 2.0 * math.sin(math.pi / (lobes + 1))  # of the pins, over the pin circle radius
    spacing = next(value for below, value in _PIN_SPACING if lobes + 1 < below)
    share = 0.5 - _WALL  # of the housing's diameter, to the outside of the pins
    outer, pin = request.outer_diameter, request.pin_diameter
    if outer is None:
        wanted = pin or _LEAST_PIN
        needed = (wanted * spacing / pitch + 0.5 * wanted) / share
        outer = math.ceil(needed) if pin is not None else max(_HOUSING, 10.0 * math.ceil(needed / 10.0))
    if pin is None:
        pin = _dowel(share * outer / (0.5 + spacing / pitch))
    radius = share * outer - 0.5 * pin
    if radius * pitch < _CLOSEST_PINS * pin:
        thickest = share * outer / (0.5 + _CLOSEST_PINS / pitch)
        raise SpecError(
            "--pin-diameter", f"{pin:g} mm", f"leaves no wall between {lobes + 1} pins in a housing of {outer:g} mm",
            f"give at most {_rounded_down(thickest):g} mm, a larger --outer-diameter or a smaller ratio",
        )  # fmt: skip
    return _Sizes(lobes, outer, _rounded_down(radius), pin, 0.0)


def _with_eccentricity(ring: _Sizes, has_output_pins: bool) -> _Sizes:
    # A hole of 1.5 times the eccentricity lets an output pin as thick as the eccentricity through.
    wanted = next(value for most, value in _SHORT_WIDTH_RATIO if ring.lobes <= most)
    while wanted > _SMALLEST_RATIO_K1:
        sizes = replace(ring, eccentricity=_rounded_down(wanted * ring.pin_circle_radius / (ring.lobes + 1)))
        sound = undercut_limit(sizes.trochoid) >= _UNDERCUT_MARGIN * 0.5 * sizes.pin_diameter
        if sound and (not has_output_pins or _hole(sizes) >= 1.5 * sizes.eccentricity):
            return sizes
        wanted *= 0.97
    limit = "undercuts the tooth, or leaves no room for output pins, at every eccentricity"
    raise SpecError("--pin-diameter", f"{ring.pin_diameter:g} mm", limit, "give thinner pins")


def _head(request: DriveRequest, lobes: int, material: NamedMaterial) -> Iterator[ProposedKey]:
    ratio = f"{lobes}:1" if request.total_ratio is None else f"{request.total_ratio:g}:1"
    yield ProposedKey("", "name", f"{material.name} {ratio}", "")
    yield ProposedKey("", "quality", material.quality, f"as {material.name} is usually made")


def _drive(request: DriveRequest, sizes: _Sizes, material: NamedMaterial) -> Iterator[ProposedKey]:
    housing = _reason(request.outer_diameter, "outer_diameter")
    yield ProposedKey("drive", "ratio", sizes.lobes, _reason(request.ratio, "ratio"))
    circle = f"{_rule('pin_circle')}; housing {sizes.outer_diameter:g} mm: {housing}"
    yield ProposedKey("drive", "pin_circle_radius_mm", sizes.pin_circle_radius, circle)
    pin = _reason(request.pin_diameter, "pin_diameter")
    yield ProposedKey("drive", "pin_diameter_mm", sizes.pin_diameter, pin)
    k1 = f"K1 = {sizes.trochoid.short_width_ratio:.3f}: {_rule('eccentricity')}"
    yield ProposedKey("drive", "eccentricity_mm", sizes.eccentricity, k1)
    yield ProposedKey("drive", "disc_width_mm", _rounded_down(0.2 * sizes.pin_circle_radius), _rule("width"))
    yield ProposedKey("drive", "discs", 2, _rule("discs"))
    if request.total_ratio is not None:
        yield from _first_stage(request.total_ratio, sizes)
    elif material.quality == "printed":
        yield ProposedKey("drive.eccentric", "bearing_stiffness_n_per_mm", 2.0e4, _rule("bearing"))
    constants = f"{material.youngs_modulus_gpa:g} GPa, Poisson's ratio {material.poisson_ratio:g}: {material.source}"
    yield ProposedKey("materials.disc", "material", material.name, constants)
    yield ProposedKey("materials.pin", "material", "steel", "dowel pins")


def _first_stage(total_ratio: float, sizes: _Sizes) -> Iterator[ProposedKey]:
    low, high = _TOOTH_RATIO
    wanted, pins = (total_ratio - 1.0) / (sizes.lobes + 1), sizes.lobes + 1
    if not low <= wanted <= high:
        raise SpecError(
            "--total-ratio", f"{total_ratio:g}", f"needs a first stage of z2/z1 = {wanted:.3g}, outside {low:g} to "
            f"{high:g}", f"give {1 + low * pins:g} to {1 + high * pins:g} for a ratio of {sizes.lobes}, or another one",
        )  # fmt: skip
    sun = min(range(12, 31), key=lambda teeth: abs(round(wanted * teeth) / teeth - wanted))
    planet = round(wanted * sun)
    circle = _rounded_down(0.56 * sizes.pin_circle_radius)
    reached = 1.0 + pins * planet / sun
    yield ProposedKey("drive.cranks", "count", 3, _rule("cranks"))
    yield ProposedKey("drive.cranks", "circle_radius_mm", circle, _rule("cranks"))
    reason = f"total ratio {reached:.6g}: {_rule('total_ratio')}"
    yield ProposedKey("drive.first_stage", "sun_teeth", sun, reason)
    yield ProposedKey("drive.first_stage", "planet_teeth", planet, "")
    yield ProposedKey("drive.first_stage", "module_mm", 2.0 * circle / (sun + planet), _rule("cranks"))


def _rest(request: DriveRequest, sizes: _Sizes, material: NamedMaterial) -> Iterator[ProposedKey]:
    clearance = _CLEARANCE_UM[material.quality]
    if material.quality == "ground":
        clearance = max(clearance, 1e-4 * sizes.pin_circle_radius / UM)
    clearance = _rounded_down(min(clearance, 0.1 * sizes.eccentricity / UM))
    yield ProposedKey("modification", "equidistant_um", clearance, _rule("clearance"))
    if request.total_ratio is None:
        yield from _openings(sizes)
    if material.quality == "printed":
        yield ProposedKey("export", "chord_tolerance_um", 2.0, _rule("chords"))
    yield ProposedKey("source", "reference", "proposed by 'cycloid-profile new', nothing measured or published", "")


def _openings(sizes: _Sizes) -> Iterator[ProposedKey]:
    hole = _rounded_down(_hole(sizes))
    yield ProposedKey("disc", "bore_radius_mm", sizes.bore_radius, _rule("bore"))
    yield ProposedKey("disc.output_holes", "count", sizes.holes, _rule("holes"))
    yield ProposedKey("disc.output_holes", "circle_radius_mm", _rounded_down(sizes.hole_circle), "")
    pin = f"output pins of {2.0 * (hole - sizes.eccentricity):.4g} mm: diameter of the hole less twice the eccentricity"
    yield ProposedKey("disc.output_holes", "radius_mm", hole, pin)


def _hole(sizes: _Sizes) -> float:
    """Radius of an output hole, 0.7 of the room between bore, root and the next hole [mm]."""
    room = min(0.5 * (sizes.root_radius - sizes.bore_radius), sizes.hole_circle * math.sin(math.pi / sizes.holes))
    return 0.7 * room


def _rule(name: str) -> str:
    rule, source = RULES[name]
    return f"{rule} [{source}]"


def _reason(given: float | None, name: str) -> str:
    return "given" if given is not None else _rule(name)


def _dowel(most: float) -> float:
    """The thickest dowel pin that is not above ``most``; below the thinnest, a round number [mm]."""
    return max((size for size in _DOWELS if size <= most), default=_rounded_down(most))


def _rounded_down(size: float) -> float:
    """A size at the next lower round number: three digits, or steps of 0.5 from 20, of 0.05 from 0.5 on."""
    digits: float = 10.0 ** (math.floor(math.log10(size)) - 2)
    step = 0.5 if size >= 20.0 else 0.05 if size >= 0.5 else digits
    return round(math.floor(size / step + 1e-9) * step, 9)
