"""Everything a tolerance study yields, in one folder: report, table, pictures and result; the samples lie beside."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Callable
from pathlib import Path

from cycloid_profile.design.tolerance_record import ToleranceRecord
from cycloid_profile.export.folder import whole_or_nothing
from cycloid_profile.plot.budget import budget_plot, sensitivity_plot
from cycloid_profile.plot.style import save
from cycloid_profile.plot.tolerance_distribution import distribution_plot
from cycloid_profile.report.page import inline_svg, template
from cycloid_profile.report.tolerance_advice import advice_section, advice_sentence, allocation_section
from cycloid_profile.report.tolerance_sections import Section
from cycloid_profile.report.tolerance_told import (
    comparison_rows,
    comparison_sentence,
    quantities,
    quantity_rows,
    told,
    tolerance_rows,
    yield_rows,
)
from cycloid_profile.tolerance.exact_sensitivities import Bench
from cycloid_profile.tolerance.plain_tables import PlainTable, budget_table, formula_table, sensitivity_table
from cycloid_profile.tolerance.published_budget import budget_from_geometry, printed_errors
from cycloid_profile.tolerance.published_sensitivities import sensitivities
from cycloid_profile.tolerance.summary import Yield

PLOTS = "plots"
QUANTITY_HEAD = ("quantity", "reducers", "as drawn", "mean", "deviation", "50 %", "95 %", "99 %", "99.73 %")
YIELD_HEAD = ("limit", "passes", "95 % interval", "of 1000", "reducers")
TOLERANCE_HEAD = ("error", "parts", "tolerance", "standard deviation", "distribution", "share of a batch")
COMPARISON_HEAD = ("quantity", "mean, without", "with", "deviation, without", "with", "ratio of deviations",
                   "with compensation")  # fmt: skip
_INTERVALS = "In brackets the 95 % interval that the number of reducers leaves."


def write_tolerance(record: ToleranceRecord, folder: Path, tell: Callable[[str], None] = lambda _: None) -> Path:
    """Write ``report.html``, ``tolerance.csv``, ``tolerance.json`` and the pictures; returns the path of the report."""
    with whole_or_nothing(folder) as scratch:
        plots = scratch / PLOTS
        plots.mkdir()
        told_sections = []
        for section in sections(record):
            pictures = []
            for stem, caption, draw in section.drawn:
                tell(f"drawing {stem}")
                save(draw(), plots, stem)
                pictures.append((caption, inline_svg(plots / f"{stem}.svg", stem)))
            told_sections.append({"title": section.title, "texts": section.texts, "tables": section.tables,
                                  "note": section.note, "pictures": pictures})  # fmt: skip
        page = template("tolerance.html.j2").render(
            name=record.spec.name,
            seed=record.spec.tolerance.seed,
            sequence=record.spec.tolerance.sequence,
            headline=headline(record),
            summary=summary_sentences(record),
            sections=told_sections,
        )
        (scratch / "report.html").write_text(page, encoding="utf-8", newline="\n")
        (scratch / "tolerance.csv").write_text(_csv(record), encoding="utf-8", newline="\n")
        result = json.dumps(told(record), indent=1, ensure_ascii=False, allow_nan=False)
        (scratch / "tolerance.json").write_text(result + "\n", encoding="utf-8", newline="\n")
    return folder / "report.html"


def sections(record: ToleranceRecord) -> list[Section]:
    """The report in order."""
    found = [_distributions(record), advice_section(record.advice, record.spec.name)]
    if record.allocation is not None:
        found.append(allocation_section(record.allocation, record.spec.name))
    found.append(_tolerances(record))
    if record.compared:
        found.append(_comparison(record))
    found.append(_published(record))
    return found


def headline(record: ToleranceRecord) -> str:
    """How many pass, in one sentence."""
    yields = [one for summary in record.summaries for one in summary.yields]
    if not yields:
        _, first = quantities(record)[0]
        return (
            f"Backlash of {first.spread.count:,} reducers: half of them below {first.percentiles[50.0].value:.2f}′, "
            f"99 of 100 below {first.percentiles[99.0].value:.2f}′."
        )
    last = yields[-1]
    what = "all limits" if last.limit is None else "the limit"
    low, high = 1000 * last.share.low, 1000 * last.share.high
    return f"{round(1000 * last.share.value)} of 1000 reducers keep {what} (95 % interval {low:.0f} to {high:.0f})."


def summary_sentences(record: ToleranceRecord) -> list[str]:
    """What else a reader wants first."""
    said = []
    if record.tolerances.assumed:
        said.append("The spec has no [tolerance] table: what a good workshop holds was taken for every error.")
    said.append(advice_sentence(record.advice))
    claim = comparison_sentence(record)
    if claim:
        said.append(claim)
    _, least = next(one for one in quantities(record) if one[1].name == "least_backlash_arcmin")
    if least.spread.low < 0.0:
        binding = sum(int((chunk < 0.0).sum()) for chunk in record.backlash.store.columns("least_backlash_arcmin"))
        share = 1000.0 * binding / record.backlash.samples
        said.append(f"{share:.3g} of 1000 reducers bind somewhere in a turn: pins and discs overlap before any load.")
    lost = sum(one.spread.lost for _, one in quantities(record))
    if lost:
        said.append(f"{lost:,} answers were not found; such reducers count as failed.")
    return said


def _distributions(record: ToleranceRecord) -> Section:
    tables = [PlainTable("", QUANTITY_HEAD, tuple(quantity_rows(record)))]
    rows = yield_rows(record)
    if rows:
        tables.append(PlainTable("Yield", YIELD_HEAD, tuple(rows)))
    passed = _passed(record)
    shown = [
        (one, passed.get(one.name), record.drawn[one.name])
        for _, one in quantities(record)
        if one.name != "least_backlash_arcmin"
    ]
    caption = "Share of reducers by value, each the largest over a turn of the output."
    return Section(
        "What comes off the line",
        tables=tuple(tables),
        drawn=(("distributions", caption, lambda: distribution_plot(shown, record.spec.name)),),
        note=_INTERVALS,
    )


def _tolerances(record: ToleranceRecord) -> Section:
    note = (
        "Tolerances are limits; a standard deviation of a third of them means Cp = 1. "
        "Directions are drawn evenly where none is given."
    )
    return Section("What scatters", tables=(PlainTable("", TOLERANCE_HEAD, tuple(tolerance_rows(record))),), note=note)


def _comparison(record: ToleranceRecord) -> Section:
    sentence = comparison_sentence(record)
    return Section(
        "Deformation compensation and tolerances",
        texts=() if sentence is None else (sentence,),
        tables=(PlainTable("", COMPARISON_HEAD, tuple(comparison_rows(record))),),
        note="The same reducers, error by error, ground without and with deformation compensation. "
        "The ratio has twice its standard error; within a hundredth of 1 it counts as equal.",
    )


def _published(record: ToleranceRecord) -> Section:
    case, name = record.built.case, record.spec.name
    bench, errors = Bench(case), printed_errors()
    rows, budget = sensitivities(case, bench), budget_from_geometry(case, errors, bench)
    return Section(
        "Published budgets beside geometry",
        tables=(sensitivity_table(rows), budget_table(budget, errors), formula_table(case.drive)),
        drawn=(
            (
                "published_sensitivities",
                "Sensitivity of the backlash to fifteen errors, published and from geometry.",
                lambda: sensitivity_plot(rows, name),
            ),
            (
                "published_budget",
                "Lost motion in three parts, published and from geometry.",
                lambda: budget_plot(budget, name),
            ),
        ),
        note="As published, with misprints mended, and computed here; see docs/budget.md.",
    )


def _passed(record: ToleranceRecord) -> dict[str, Yield]:
    """Yield of each limited quantity, from the study with most reducers."""
    every = (one for summary in reversed(record.summaries) for one in summary.yields)
    return {one.limit.quantity: one for one in every if one.limit is not None}


def _ends(passed: Yield | None) -> tuple[str, str]:
    if passed is None or passed.limit is None:
        return "", ""
    low, high = passed.limit.at_least, passed.limit.at_most
    return f"{low:g}" if math.isfinite(low) else "", f"{high:g}" if math.isfinite(high) else ""


def _csv(record: ToleranceRecord) -> str:
    """The distributions as one flat table."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(("quantity", "reducers", "drawn", "mean", "deviation", "least", "p50", "p95", "p99", "p99_73",
                     "greatest", "at_least", "at_most", "yield_percent", "yield_low", "yield_high"))  # fmt: skip
    passed = _passed(record)
    for _, one in quantities(record):
        limit = passed.get(one.name)
        share = () if limit is None else (limit.share.value, limit.share.low, limit.share.high)
        writer.writerow(
            (
                one.name,
                one.spread.count,
                *(
                    f"{value:.9g}"
                    for value in (record.drawn[one.name], one.mean.value, one.spread.deviation, one.spread.low)
                ),
                *(f"{one.percentiles[percent].value:.9g}" for percent in (50.0, 95.0, 99.0, 99.73)),
                f"{one.spread.high:.9g}",
                *_ends(limit),
                *(f"{100.0 * value:.6g}" for value in share),
                *("",) * (3 - len(share)),
            )
        )
    return text.getvalue()
