"""The published budgets beside those of a drive as plain rows of text, for terminal, report and documentation."""

from __future__ import annotations

from dataclasses import dataclass

from cycloid_profile.catalog.published import lost_motion_article
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.geometry.drive import Drive
from cycloid_profile.tolerance.exact_sensitivities import Bench, Slope
from cycloid_profile.tolerance.published_budget import (
    TABLE,
    TEXT,
    Budget,
    Part,
    PartErrors,
    budget_from_geometry,
    confidence_of_mean,
    cycloid_stage,
    cycloid_stage_as_published,
    involute_stage,
    involute_stage_as_published,
    printed_errors,
    scatter_behind,
)
from cycloid_profile.tolerance.published_sensitivities import Sensitivity, sensitivities, weights
from cycloid_profile.tolerance.sensitivity_formulas import pin_circle, pin_radius
from cycloid_profile.units import ARCMIN

ABSENT = "–"


@dataclass(frozen=True, slots=True)
class PlainTable:
    """A ``title``, a ``head`` and ``rows`` of as many cells, all of them text."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    @property
    def markdown(self) -> str:
        """The table in Markdown, without its title."""
        lines = (self.head, ("---",) * len(self.head), *self.rows)
        return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)


def published_tables(
    case: LoadCase, errors: PartErrors | None = None, bench: Bench | None = None
) -> tuple[PlainTable, ...]:
    """Sensitivities, budget, and the formulas of the budget, for the drive and tooth of ``case``.

    ``errors`` of the budget are the printed ones unless given.
    """
    used, given = Bench(case) if bench is None else bench, printed_errors() if errors is None else errors
    return (
        sensitivity_table(sensitivities(case, used)),
        budget_table(budget_from_geometry(case, given, used), given),
        formula_table(case.drive),
    )


def sensitivity_table(rows: tuple[Sensitivity, ...]) -> PlainTable:
    """The fifteen factors [′/mm]."""
    shares = weights(tuple(row.corrected for row in rows))
    return PlainTable(
        f"Sensitivity of the backlash [′/mm], with weights in brackets; k = {1.0 / ARCMIN:.3f}′",
        ("no.", "factor", "printed, RV-40E", "printed formula", "as published", "corrected", "from geometry here",
         "one disc by itself", "measured as", "why they differ"),
        tuple(_sensitivity_row(row, share) for row, share in zip(rows, shares, strict=True)),
    )  # fmt: skip


def _sensitivity_row(row: Sensitivity, share: float | None) -> tuple[str, ...]:
    corrected = ABSENT if row.corrected is None else f"{_arcmin(row.corrected, 4)} ({share:.4f})"
    return (
        str(row.factor.number),
        row.name,
        f"{_arcmin(row.printed, 4)} ({row.printed_weight:.4f})",
        row.factor.symbols,
        ABSENT if row.as_published is None else _arcmin(row.as_published, 4),
        corrected,
        ABSENT if row.geometry is None else _slope(row.geometry),
        ABSENT if row.geometry is None or row.geometry.one_disc is None else _arcmin(row.geometry.one_disc, 2),
        ABSENT if row.geometry is None else row.geometry.statistic,
        row.why,
    )


def budget_table(budget: Budget, errors: PartErrors) -> PlainTable:
    """The three parts, their total and the published simulation [′]; ``errors`` are those of ``budget``."""
    article = lost_motion_article()
    text, table = TEXT.of(article), TABLE.of(article)
    sun, output = budget.involute, None if budget.involute is None else budget.involute.over(budget.ratio)
    rows = (
        (
            "involute stage, at the sun",
            _printed(article.involute.mean_arcmin, article.involute.tolerance_arcmin),
            (text.involute, table.involute, sun),
            "printed deviations are ± about 0: mean play 0, and every other pair jams",
        ),
        (
            "involute stage, at the output",
            "“the largest portion”",
            (text.at_output[0], table.at_output[0], output),
            f"over the ratio, {article.ratio:g} there and {budget.ratio:g} here: the smallest part, not the largest",
        ),
        (
            "cycloid stage",
            _printed(article.cycloid.mean_arcmin, article.cycloid.tolerance_arcmin),
            (text.cycloid, table.cycloid, budget.cycloid),
            f"here: mean of the tooth as ground, pins ±{errors.pin_um:g} µm, discs ±{errors.disc_um:g} µm; "
            "all of one reducer alike",
        ),
        (
            "eccentric bearing",
            _printed(article.bearing.mean_arcmin, article.bearing.tolerance_arcmin),
            (text.bearing, table.bearing, budget.bearing),
            f"here: play as drawn ±{errors.bearing_um:g} µm in radius; their r and K are not printed",
        ),
        (
            "total",
            f"{article.total.low_arcmin:g} to {article.total.high_arcmin:g}",
            (text.total, table.total, budget.total),
            "the printed parts add up to 0.784; no reading of them gives the printed range",
        ),
    )
    simulated = article.monte_carlo
    spread = scatter_behind(simulated.plus_minus_arcmin * ARCMIN, simulated.runs)
    interval = (_arcmin(confidence_of_mean(one.total, simulated.runs), 4) for one in (text, table, budget))
    return PlainTable(
        "Lost motion [′], mean ± half band",
        ("part", "as published", "corrected, ± is the half band", "corrected, ± is T/2", "from geometry here",
         "why they differ"),
        (
            *((name, printed, *(_part(one) for one in parts), why) for name, printed, parts, why in rows),
            (
                f"mean of {simulated.runs} drawn reducers, 95 %",
                _printed(simulated.mean_arcmin, simulated.plus_minus_arcmin),
                *(f"± {cell}" for cell in interval),
                f"± tells how well a mean is known; behind it reducers scatter by ±{_arcmin(3 * spread, 3)} (3 σ)",
            ),
        ),
    )  # fmt: skip


def formula_table(drive: Drive) -> PlainTable:
    """Formulas of the budget on its printed parameters, cycloid stage with the lengths of ``drive``."""
    article, errors = lost_motion_article(), printed_errors()
    d1 = article.sun_diameter_mm
    B, K1 = pin_circle(drive), drive.trochoid.short_width_ratio
    halves = [
        (part.half_band, other.half_band)
        for part, other in (
            (involute_stage_as_published(errors, d1), involute_stage(errors, d1)),
            (cycloid_stage_as_published(drive, errors), cycloid_stage(drive, errors)),
        )
    ]
    return PlainTable(
        "Formulas of the lost-motion budget on its printed parameters",
        ("quantity", "formula as published", "corrected", "why they differ"),
        (
            (
                f"involute stage, half band at a sun of {d1:g} mm [′]",
                *(_arcmin(half, 3) for half in halves[0]),
                "T is 6 σ, not σ; the factor 2 of the mean holds for it; D(j2), D(j3) are mm⁴ as printed",
            ),
            ("Ā [′/mm]", *(2 * (_arcmin(pin_radius(drive), 4),)), "agree, with ζ = z_c and a the eccentricity"),
            (
                "B̄ [′/mm]",
                _arcmin(B / (1.0 - K1**2), 4),
                _arcmin(B, 4),
                "√(1−e²) is √(1−K1²) and multiplies",
            ),
            (
                f"cycloid stage, half band for pins ±{errors.pin_um:g} µm, discs ±{errors.disc_um:g} µm [′]",
                *(_arcmin(half, 3) for half in halves[1]),
                "as B̄, and T_A lacks the factor 2 of the mean",
            ),
        ),
    )


def _part(part: Part | None) -> str:
    if part is None:
        return ABSENT
    low, high = part.range
    digits = 4 if abs(part.mean) < 0.1 * ARCMIN and part.half_band < 0.1 * ARCMIN else 3
    band = f"{_arcmin(part.mean, digits)} ± {_arcmin(part.half_band, digits)}"
    return f"{band} ({_arcmin(low, digits)} to {_arcmin(high, digits)})"


def _printed(mean: float, band: float) -> str:
    return f"{mean:g} ± {band:g}"


def _slope(slope: Slope) -> str:
    mean, least, greatest = (_arcmin(value, 2) for value in (slope.mean, slope.least, slope.greatest))
    return mean if least == greatest else f"{mean} ({least} to {greatest})"


def _arcmin(angle: float, digits: int) -> str:
    """An angle in ′ with a true minus, and no minus before a zero."""
    shown = f"{angle / ARCMIN:.{digits}f}"
    return shown.lstrip("-") if float(shown) == 0.0 else shown.replace("-", "−")
