"""Tables that compare the published budgets with those of a drive, as text for terminal, report and documentation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from cycloid_profile.articles.backlash_sensitivities import BacklashSensitivity, sensitivities, weights
from cycloid_profile.articles.finite_difference import POSES, BacklashSlope, DifferenceSetup
from cycloid_profile.articles.formulas import pin_circle, pin_radius
from cycloid_profile.articles.lost_motion_budget import (
    TABLE,
    TEXT,
    Budget,
    BudgetPart,
    PartErrors,
    budget_from_geometry,
    confidence_of_mean,
    cycloid_stage,
    cycloid_stage_as_published,
    involute_stage,
    involute_stage_as_published,
    printed_errors,
    single_reducer_deviation,
)
from cycloid_profile.catalog import PublishedPart, lost_motion_article
from cycloid_profile.contact import LoadCase
from cycloid_profile.geometry import Drive
from cycloid_profile.units import ARCMIN

ABSENT = "–"


@dataclass(frozen=True, slots=True)
class PlainTable:
    """A ``title``, a ``head`` and ``rows`` of as many cells, all of them text, and a ``note`` below."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""

    @property
    def markdown(self) -> str:
        """The table in Markdown, without its title."""
        lines = (self.head, ("---",) * len(self.head), *self.rows)
        return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)


def disc_name(case: LoadCase) -> str:
    """The disc body of a load case as the head of a column."""
    return "elastic disc" if case.disc_bodies else "rigid disc"


def published_tables(
    case: LoadCase, *others: LoadCase, errors: PartErrors | None = None, poses: int = POSES
) -> tuple[PlainTable, ...]:
    """Sensitivities with their ranges and methods, budget with remarks, and the formulas of the budget.

    For the drive and tooth of ``case``, with a further column for each of ``others``, the same reducer with another
    disc body. ``errors`` of the budget are the printed ones unless given.
    """
    given = printed_errors() if errors is None else errors
    setups = {disc_name(one): DifferenceSetup(one, poses=poses) for one in (case, *others)}
    rows = {name: sensitivities(setup.case, setup) for name, setup in setups.items()}
    budgets = {name: budget_from_geometry(setup.case, given, setup) for name, setup in setups.items()}
    first = next(iter(rows.values()))
    return (
        sensitivity_table(rows),
        range_table(first),
        method_table(first),
        budget_table(budgets),
        budget_remarks(next(iter(budgets.values())), given),
        formula_table(case.drive),
    )


def sensitivity_table(columns: Mapping[str, tuple[BacklashSensitivity, ...]]) -> PlainTable:
    """The fifteen factors [′/mm]: printed, corrected, and the mean from geometry, a column for each disc body."""
    first, *_ = columns.values()
    return PlainTable(
        f"Sensitivity of the backlash [′/mm]; k = {1.0 / ARCMIN:.3f}′",
        ("no.", "factor", "printed", "corrected", *columns),
        tuple(
            (
                str(row.factor.number),
                row.name,
                _arcmin(row.printed, 4),
                _arcmin(row.corrected, 4),
                *(_mean(rows[i].geometry) for rows in columns.values()),
            )
            for i, row in enumerate(first)
        ),
    )


def range_table(rows: tuple[BacklashSensitivity, ...]) -> PlainTable:
    """Weights of the fifteen factors, and their range over a turn [′/mm]."""
    shares = weights(tuple(row.corrected for row in rows))
    return PlainTable(
        "Weights, and range over a turn [′/mm]",
        ("no.", "weight, printed", "weight, corrected", "least", "greatest", "single disc"),
        tuple(
            (
                str(row.factor.number),
                f"{row.printed_weight:.4f}",
                ABSENT if share is None else f"{share:.4f}",
                *(
                    (ABSENT,) * 3
                    if row.geometry is None
                    else (
                        _arcmin(each, 2) for each in (row.geometry.least, row.geometry.greatest, row.geometry.one_disc)
                    )
                ),
            )
            for row, share in zip(rows, shares, strict=True)
        ),
    )


def method_table(rows: tuple[BacklashSensitivity, ...]) -> PlainTable:
    """Printed formula of each factor with its value for the drive [′/mm], how it is measured, and why they differ."""
    return PlainTable(
        "Formulas and methods of the sensitivities",
        ("no.", "printed formula", "its value", "measured as", "why they differ"),
        tuple(
            (
                str(row.factor.number),
                row.factor.symbols,
                _arcmin(row.as_published, 4),
                ABSENT if row.geometry is None else row.geometry.statistic,
                row.why,
            )
            for row in rows
        ),
    )


def budget_table(columns: Mapping[str, Budget]) -> PlainTable:
    """The three parts, their total and the published simulation [′], a column for each disc body."""
    article, simulated = lost_motion_article(), lost_motion_article().monte_carlo
    readings = (TEXT.of(article), TABLE.of(article), *columns.values())
    parts = (
        ("involute stage, at the sun", _printed(article.involute), [one.involute for one in readings]),
        ("involute stage, at the output", "“largest”", [one.involute_at_output for one in readings]),
        ("cycloid stage", _printed(article.cycloid), [one.cycloid for one in readings]),
        ("eccentric bearing", _printed(article.bearing), [one.bearing for one in readings]),
        ("total", _printed(article.total), [one.total for one in readings]),
    )
    return PlainTable(
        "Lost motion [′], mean ± half band",
        ("part", "printed", "text: ± is half", "table: ± is T/2", *columns),
        (
            *((name, printed, *(_part(one) for one in found)) for name, printed, found in parts),
            ("range of the total", f"{article.total.low_arcmin:g} to {article.total.high_arcmin:g}",
             *(_range(one.total) for one in readings)),
            (f"mean of {simulated.runs}, 95 %", f"{simulated.mean_arcmin:g} ± {simulated.plus_minus_arcmin:g}",
             *(f"± {_arcmin(confidence_of_mean(one.total, simulated.runs), 4)}" for one in readings)),
        ),
    )  # fmt: skip


def budget_remarks(budget: Budget, errors: PartErrors) -> PlainTable:
    """Why the rows of ``budget_table`` differ; ``errors`` are those of ``budget``."""
    article, simulated = lost_motion_article(), lost_motion_article().monte_carlo
    spread = single_reducer_deviation(simulated.plus_minus_arcmin * ARCMIN, simulated.runs)
    # fmt: off
    return PlainTable(
        "Why the parts differ",
        ("part", "remark"),
        (
            ("involute stage, at the sun",
             "printed deviations are ± about 0: mean play 0, and every other pair jams"),
            ("involute stage, at the output",
             f"over the ratio, {article.ratio:g} there and {budget.ratio:g} here: the smallest part, not the largest"),
            ("cycloid stage",
             f"here: mean of the tooth as ground, pins ±{errors.pin_um:g} µm, discs ±{errors.disc_um:g} µm; "
             "the same for all parts of one reducer"),
            ("eccentric bearing",
             f"here: play as drawn ±{errors.bearing_um:g} µm in radius; their r and K are not printed"),
            ("total", "the printed parts add up to 0.784; no reading of them gives the printed range"),
            (f"mean of {simulated.runs}, 95 %",
             f"± is the confidence of the mean; single reducers scatter by ±{_arcmin(3 * spread, 3)} (3 σ)"),
        ),
    )
    # fmt: on


def formula_table(drive: Drive) -> PlainTable:
    """Formulas of the budget on its printed parameters, cycloid stage with the lengths of ``drive``."""
    errors, d1 = printed_errors(), lost_motion_article().sun_diameter_mm
    A, B, K1 = pin_radius(drive), pin_circle(drive), drive.trochoid.short_width_ratio
    involute = [_arcmin(of(errors, d1).half_band, 3) for of in (involute_stage_as_published, involute_stage)]
    cycloid = [_arcmin(of(drive, errors).half_band, 3) for of in (cycloid_stage_as_published, cycloid_stage)]
    # fmt: off
    return PlainTable(
        "Formulas of the lost-motion budget on its printed parameters",
        ("quantity", "formula as published", "corrected", "why they differ"),
        (
            (f"involute stage, half band at a sun of {d1:g} mm [′]", *involute,
             "T is 6 σ, not σ; the factor 2 of the mean holds for it; D(j2), D(j3) are mm⁴ as printed"),
            ("Ā [′/mm]", _arcmin(A, 4), _arcmin(A, 4), "agree, with ζ = z_c and a the eccentricity"),
            ("B̄ [′/mm]", _arcmin(B / (1.0 - K1**2), 4), _arcmin(B, 4), "√(1−e²) is √(1−K1²) and multiplies"),
            (f"cycloid stage, half band for pins ±{errors.pin_um:g} µm, discs ±{errors.disc_um:g} µm [′]", *cycloid,
             "as B̄, and T_A lacks the factor 2 of the mean"),
        ),
    )
    # fmt: on


def _part(part: BudgetPart | None) -> str:
    if part is None:
        return ABSENT
    digits = 4 if abs(part.mean) < 0.1 * ARCMIN and part.half_band < 0.1 * ARCMIN else 3
    return f"{_arcmin(part.mean, digits)} ± {_arcmin(part.half_band, digits)}"


def _range(part: BudgetPart) -> str:
    return " to ".join(_arcmin(end, 3) for end in part.range)


def _printed(part: PublishedPart) -> str:
    return f"{part.mean_arcmin:g} ± {part.tolerance_arcmin:g}"


def _mean(slope: BacklashSlope | None) -> str:
    return ABSENT if slope is None else _arcmin(slope.mean, 2)


def _arcmin(angle: float | None, digits: int) -> str:
    """An angle in ′ with a true minus, and no minus before a zero."""
    if angle is None:
        return ABSENT
    shown = f"{angle / ARCMIN:.{digits}f}"
    return shown.lstrip("-") if float(shown) == 0.0 else shown.replace("-", "−")
