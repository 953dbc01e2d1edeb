"""Every table of the two articles with three columns of results: rigid disc, elastic disc, as published."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.articles.backlash_sensitivities import sensitivities
from cycloid_profile.articles.finite_difference import POSES, DifferenceSetup
from cycloid_profile.articles.formulas import InvolutePair
from cycloid_profile.articles.lost_motion_budget import (
    Budget,
    BudgetPart,
    PartErrors,
    budget_of_bands,
    parameter_bands,
    printed_errors,
)
from cycloid_profile.articles.tables import ABSENT, PlainTable, disc_name
from cycloid_profile.catalog import PublishedPart, lost_motion_article
from cycloid_profile.compensation import compensate_by
from cycloid_profile.contact import LoadCase, first_order_backlash
from cycloid_profile.contact.disc import Classical, Equilibrium
from cycloid_profile.contact.mesh import backlash, input_locked_factor
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.effects import apply_effects, as_drawn, effect_from_table
from cycloid_profile.geometry import Drive, ToothProfile
from cycloid_profile.modification import Equidistant, RadialMoving, modify
from cycloid_profile.rig import LoopFigures, evaluate_loop, hysteresis_loop
from cycloid_profile.units import ARCMIN, DEGREE, NEWTON_METRE, UM

# [TP]: pair of amounts [mm], deformation [mm], and measured backlash before compensation.
PRINTED_PAIR = (0.5, -0.275)
PRINTED_DELTA_MAX = 4.06 * UM
PRINTED_BACKLASH = 1.30 * ARCMIN
# Shafts, carrier, main bearings and housing: what the catalogue's rigidity lacks (docs/articles.md) [N·m/′].
SERIES_STIFFNESS = 134.0


@dataclass(frozen=True)
class Prototype:
    """One tooth of [TP] on one kind of disc: rated load on it, its backlash and its hysteresis loop.

    ``soft`` is the loop with ``SERIES_STIFFNESS`` in series.
    """

    case: LoadCase
    loop: LoopFigures
    soft: LoopFigures

    @property
    def crank_held(self) -> float:
        """Worst backlash of a mesh cycle, crank held [rad]."""
        return backlash(self.case.drive, self.case.profile).worst


def conventional_tooth(drive: Drive, scale: float) -> ToothProfile:
    """The tooth of ``drive`` with ``scale`` times the printed pair; 0 for the theoretical tooth."""
    equidistant, radial_moving = (scale * amount for amount in PRINTED_PAIR)
    return modify(drive.theoretical_profile, Equidistant(equidistant), RadialMoving(radial_moving))


def fitted_scale(drive: Drive) -> float:
    """Scale of the printed pair at which the rigid backlash is the measured 1.30′."""
    return PRINTED_BACKLASH / first_order_backlash(drive, *PRINTED_PAIR)


def prototype(case: LoadCase, profile: ToothProfile) -> Prototype:
    """Put ``profile`` into the reducer of ``case`` and measure its loops."""
    ground = replace(case, profile=profile)
    series = effect_from_table({"name": "series_compliance", "stiffness_nm_per_arcmin": SERIES_STIFFNESS})
    loops = (hysteresis_loop(reducer) for reducer in (as_drawn(ground), apply_effects(ground, [series])))
    return Prototype(ground, *(evaluate_loop(loop.torque, loop.angle) for loop in loops))


def article_tables(
    rigid: LoadCase, elastic: LoadCase, errors: PartErrors | None = None, poses: int = POSES
) -> tuple[PlainTable, ...]:
    """Six tables: [TP] sensitivities, deformation, prototypes simulated and measured; [LM] parameters and parts.

    ``rigid`` and ``elastic`` are one reducer with both disc bodies; ``errors`` are those of [LM] unless given.
    """
    cases = {disc_name(case): case for case in (rigid, elastic)}
    given = printed_errors() if errors is None else errors
    setups = {name: DifferenceSetup(case, poses=poses) for name, case in cases.items()}
    bands = {name: parameter_bands(setup, given) for name, setup in setups.items()}
    budgets = [budget_of_bands(setups[name], given, bands[name]) for name in cases]
    return (
        _sensitivities(setups),
        _deformation(cases),
        *_prototypes(cases),
        _parameters(cases, bands, given),
        _parts(cases, budgets),
    )


def _table(title: str, first: str, cases: Mapping[str, object], rows: list[tuple[str, ...]]) -> PlainTable:
    return PlainTable(title, (first, *cases, "as published"), tuple(rows))


def _sensitivities(setups: Mapping[str, DifferenceSetup]) -> PlainTable:
    columns = [sensitivities(setup.case, setup) for setup in setups.values()]
    rows = [
        (
            f"{each[0].factor.number} {each[0].name}",
            *(ABSENT if row.geometry is None else _shown(row.geometry.mean / ARCMIN, 2) for row in each),
            f"{each[0].printed / ARCMIN:.4f}",
        )
        for each in zip(*columns, strict=True)
    ]
    return _table("[TP] sensitivity of the backlash [′/mm]", "factor", setups, rows)


def _deformation(cases: Mapping[str, LoadCase]) -> PlainTable:
    drive = next(iter(cases.values())).drive
    scales = {"as printed": 1.0, "at a tenth": 0.1, "fitted to 1.30′": fitted_scale(drive)}
    published = f"{PRINTED_DELTA_MAX / UM:.2f}"
    rows = []
    for reading, scale in scales.items():
        ground = [replace(case, profile=conventional_tooth(drive, scale)) for case in cases.values()]
        # The published scheme knows contacts alone.
        classical = (ABSENT if case.disc_bodies else f"{Classical().solve(case).delta_max / UM:.3f}" for case in ground)
        rows.append((f"published scheme, pair {reading}", *classical, published))
        for name, solver in (("one disc", Equilibrium()), ("whole stage", StageEquilibrium())):
            found = (f"{float(np.mean(solver.solve(case).deformation)) / UM:.3f}" for case in ground)
            rows.append((f"{name}, pair {reading}", *found, published))
    return _table("[TP] deformation δmax [µm]", "load sharing", cases, rows)


def _prototypes(cases: Mapping[str, LoadCase]) -> tuple[PlainTable, PlainTable]:
    drive = next(iter(cases.values())).drive

    def pair(scale: float) -> tuple[list[Prototype], list[Prototype]]:
        tooth = conventional_tooth(drive, scale)
        added = [compensate_by(replace(case, profile=tooth), PRINTED_DELTA_MAX).profile for case in cases.values()]
        return (
            [prototype(case, tooth) for case in cases.values()],
            [prototype(case, one) for case, one in zip(cases.values(), added, strict=True)],
        )

    tenth, fitted = pair(0.1), pair(fitted_scale(drive))
    theoretical = [prototype(case, drive.theoretical_profile) for case in cases.values()]

    def row(
        name: str, found: list[Prototype], of: Callable[[Prototype], float], digits: int, printed: str
    ) -> tuple[str, ...]:
        return (name, *(_shown(of(one), digits) for one in found), printed)

    def held(one: Prototype) -> float:
        return one.crank_held * input_locked_factor(drive) / ARCMIN

    def lost(one: Prototype) -> float:
        return one.loop.lost_motion / ARCMIN

    def loss(one: Prototype) -> float:
        return one.loop.hysteresis_loss / ARCMIN

    def rigidity(one: Prototype) -> float:
        return one.loop.torsional_rigidity * ARCMIN / NEWTON_METRE

    def soft(one: Prototype) -> float:
        return one.soft.torsional_rigidity * ARCMIN / NEWTON_METRE

    simulated = [
        row("unmodified: backlash, input held", theoretical, held, 3, "~0"),
        row("unmodified: lost motion ±3 %", theoretical, lost, 3, "~0"),
    ]
    measured = []
    for reading, (before, after) in {"a tenth": tenth, "fitted": fitted}.items():
        simulated += [
            row(f"conventional, {reading}: backlash", before, held, 3, "0.88 (0.54 to 1.22)"),
            row(f"compensated, {reading}: backlash", after, held, 3, "0.56 (0.14 to 0.98)"),
            row(f"conventional, {reading}: lost motion", before, lost, 3, ABSENT),
            row(f"compensated, {reading}: lost motion", after, lost, 3, ABSENT),
        ]
        measured += [
            row(f"conventional, {reading}: backlash [′]", before, loss, 3, "1.30"),
            row(f"compensated, {reading}: backlash [′]", after, loss, 3, "0.66"),
            row(f"conventional, {reading}: stiffness [N·m/′]", before, rigidity, 1, "72"),
            row(f"compensated, {reading}: stiffness", after, rigidity, 1, "95"),
            row(f"conventional, {reading}: {SERIES_STIFFNESS:g} in series", before, soft, 1, "72"),
            row(f"compensated, {reading}: {SERIES_STIFFNESS:g} in series", after, soft, 1, "95"),
        ]
    # Printed without a definition.
    none = (ABSENT,) * len(cases)
    measured += [("conventional: clearance [′]", *none, "0.660"), ("compensated: clearance [′]", *none, "0.313")]
    return (
        _table("[TP] simulated backlash [′]", "prototype", cases, simulated),
        _table("[TP] measured: loop at zero torque, stiffness 50 to 100 %", "prototype", cases, measured),
    )


def _parameters(
    cases: Mapping[str, LoadCase], bands: Mapping[str, Mapping[str, float | None]], errors: PartErrors
) -> PlainTable:
    names = {
        "normal_length_um": "E_s, tooth thickness",
        "centre_distance_um": "Δa, centre distance",
        "gear_runout_um": "ΔF_r, radial runout",
        "pin_um": "Δr, pins",
        "disc_um": "Δρ, discs",
        "bearing_um": "Δ, bearings",
    }
    # E_s has two limits; its half band is that of their distance.
    upper, lower = errors.normal_length_upper_um, errors.normal_length_lower_um
    sizes = {name: getattr(errors, name, 0.5 * abs(upper - lower)) for name in names}
    rows = [
        (
            label,
            *(
                ABSENT if (band := found[name]) is None else f"±{_shown(abs(band) / ARCMIN, 4)}"
                for found in bands.values()
            ),
            f"±{1e-3 * sizes[name]:g} mm",
        )
        for name, label in names.items()
    ]
    article = lost_motion_article()
    pair = [None if case.drive.first_stage is None else InvolutePair(case.drive.first_stage) for case in cases.values()]
    rows += [
        (
            "d_1, sun",
            *(ABSENT if one is None else f"{2.0 * one.sun_radius:g} mm" for one in pair),
            f"{article.sun_diameter_mm:g} mm",
        ),
        (
            "α, pressure angle",
            *(ABSENT if one is None else f"{one.pressure_angle / DEGREE:g}°" for one in pair),
            f"{article.pressure_angle_deg:g}°",
        ),
        ("i, ratio", *(f"{case.drive.reduction_ratio:g}" for case in cases.values()), f"{article.ratio:g}"),
    ]
    return _table("[LM] parameters: lost motion at the output that each makes [′]", "parameter", bands, rows)


def _parts(cases: Mapping[str, LoadCase], budgets: list[Budget]) -> PlainTable:
    article = lost_motion_article()

    def row(name: str, found: list[BudgetPart | None], printed: PublishedPart) -> tuple[str, ...]:
        shown = (
            ABSENT if one is None else f"{_shown(one.mean / ARCMIN, 3)} ± {_shown(one.half_band / ARCMIN, 3)}"
            for one in found
        )
        return (name, *shown, f"{printed.mean_arcmin:g} ± {printed.tolerance_arcmin:g}")

    rows = [
        row("involute stage, at the sun", [one.involute for one in budgets], article.involute),
        row("cycloid stage", [one.cycloid for one in budgets], article.cycloid),
        row("eccentric bearing", [one.bearing for one in budgets], article.bearing),
        row("total", [one.total for one in budgets], article.total),
    ]
    rows[-1] = (*rows[-1][:-1], f"{article.total.low_arcmin:g} to {article.total.high_arcmin:g}")
    return _table("[LM] parts of the lost motion [′], mean ± half band", "part", cases, rows)


def _shown(value: float, digits: int) -> str:
    """A number with a true minus, and no minus before a zero."""
    shown = f"{value:.{digits}f}"
    return shown.lstrip("-") if float(shown) == 0.0 else shown.replace("-", "−")
