"""Tables that compare the published budgets with those of a drive, as text for terminal, report and documentation."""

from __future__ import annotations

from dataclasses import dataclass

from cycloid_profile.articles.backlash_sensitivities import BacklashSensitivity, sensitivities, weights
from cycloid_profile.articles.finite_difference import BacklashSlope, DifferenceSetup
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


def published_tables(
    case: LoadCase, errors: PartErrors | None = None, setup: DifferenceSetup | None = None
) -> tuple[PlainTable, ...]:
    """Sensitivities, budget, and the formulas of the budget, for the drive and tooth of ``case``.

    ``errors`` of the budget are the printed ones unless given.
    """
    used, given = DifferenceSetup(case) if setup is None else setup, printed_errors() if errors is None else errors
    return (
        sensitivity_table(sensitivities(case, used)),
        budget_table(budget_from_geometry(case, given, used), given),
        formula_table(case.drive),
    )


def sensitivity_table(rows: tuple[BacklashSensitivity, ...]) -> PlainTable:
    """The fifteen factors [′/mm]."""
    shares = weights(tuple(row.corrected for row in rows))
    return PlainTable(
        f"Sensitivity of the backlash [′/mm], with weights in brackets; k = {1.0 / ARCMIN:.3f}′",
        ("no.", "factor", "printed, RV-40E", "printed formula", "as published", "corrected", "from geometry here",
         "single disc", "measured as", "why they differ"),
        tuple(_sensitivity_row(row, share) for row, share in zip(rows, shares, strict=True)),
    )  # fmt: skip


def _sensitivity_row(row: BacklashSensitivity, share: float | None) -> tuple[str, ...]:
    found = row.geometry
    return (
        str(row.factor.number),
        row.name,
        f"{_arcmin(row.printed, 4)} ({row.printed_weight:.4f})",
        row.factor.symbols,
        _arcmin(row.as_published, 4),
        ABSENT if row.corrected is None else f"{_arcmin(row.corrected, 4)} ({share:.4f})",
        ABSENT if found is None else _slope(found),
        ABSENT if found is None else _arcmin(found.one_disc, 2),
        ABSENT if found is None else found.statistic,
        row.why,
    )


def budget_table(budget: Budget, errors: PartErrors) -> PlainTable:
    """The three parts, their total and the published simulation [′]; ``errors`` are those of ``budget``."""
    article, simulated = lost_motion_article(), lost_motion_article().monte_carlo
    readings = (TEXT.of(article), TABLE.of(article), budget)
    spread = single_reducer_deviation(simulated.plus_minus_arcmin * ARCMIN, simulated.runs)
    # fmt: off
    rows = (
        ("involute stage, at the sun", _printed(article.involute), [one.involute for one in readings],
         "printed deviations are ± about 0: mean play 0, and every other pair jams"),
        ("involute stage, at the output", "“the largest portion”", [one.involute_at_output for one in readings],
         f"over the ratio, {article.ratio:g} there and {budget.ratio:g} here: the smallest part, not the largest"),
        ("cycloid stage", _printed(article.cycloid), [one.cycloid for one in readings],
         f"here: mean of the tooth as ground, pins ±{errors.pin_um:g} µm, discs ±{errors.disc_um:g} µm; "
         "the same for all parts of one reducer"),
        ("eccentric bearing", _printed(article.bearing), [one.bearing for one in readings],
         f"here: play as drawn ±{errors.bearing_um:g} µm in radius; their r and K are not printed"),
        ("total", f"{article.total.low_arcmin:g} to {article.total.high_arcmin:g}", [one.total for one in readings],
         "the printed parts add up to 0.784; no reading of them gives the printed range"),
    )
    return PlainTable(
        "Lost motion [′], mean ± half band",
        ("part", "as published", "corrected, ± is the half band", "corrected, ± is T/2", "from geometry here",
         "why they differ"),
        (
            *((name, printed, *(_part(one) for one in parts), why) for name, printed, parts, why in rows),
            (f"mean of {simulated.runs} drawn reducers, 95 %",
             f"{simulated.mean_arcmin:g} ± {simulated.plus_minus_arcmin:g}",
             *(f"± {_arcmin(confidence_of_mean(one.total, simulated.runs), 4)}" for one in readings),
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
    low, high = part.range
    digits = 4 if abs(part.mean) < 0.1 * ARCMIN and part.half_band < 0.1 * ARCMIN else 3
    band = f"{_arcmin(part.mean, digits)} ± {_arcmin(part.half_band, digits)}"
    return f"{band} ({_arcmin(low, digits)} to {_arcmin(high, digits)})"


def _printed(part: PublishedPart) -> str:
    return f"{part.mean_arcmin:g} ± {part.tolerance_arcmin:g}"


def _slope(slope: BacklashSlope) -> str:
    mean, least, greatest = (_arcmin(value, 2) for value in (slope.mean, slope.least, slope.greatest))
    return mean if least == greatest else f"{mean} ({least} to {greatest})"


def _arcmin(angle: float | None, digits: int) -> str:
    """An angle in ′ with a true minus, and no minus before a zero."""
    if angle is None:
        return ABSENT
    shown = f"{angle / ARCMIN:.{digits}f}"
    return shown.lstrip("-") if float(shown) == 0.0 else shown.replace("-", "−")
