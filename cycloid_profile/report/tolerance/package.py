"""Files of a tolerance analysis in one folder: report, table, pictures and JSON."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cycloid_profile import plot
from cycloid_profile.articles import (
    DifferenceSetup,
    PlainTable,
    budget_from_geometry,
    budget_remarks,
    budget_table,
    disc_name,
    formula_table,
    method_table,
    printed_errors,
    range_table,
    sensitivities,
)
from cycloid_profile.articles import sensitivity_table as published_sensitivity_table
from cycloid_profile.design import LEAST_BACKLASH, ToleranceRecord
from cycloid_profile.export.writing import PROTECTED, Protection, atomic_folder
from cycloid_profile.plot import save
from cycloid_profile.report.page import (
    PLOTS,
    REPORT,
    Verdict,
    json_text,
    pdf_name,
    picture,
    render,
    write_report,
    write_text,
)
from cycloid_profile.report.tolerance import text
from cycloid_profile.report.tolerance.json_output import to_json
from cycloid_profile.tolerance.allocation import Allocation

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Section:
    """A part of the report; ``drawn`` holds the name, the caption and the drawing function of each picture."""

    title: str
    texts: tuple[str, ...] = ()
    tables: tuple[PlainTable, ...] = ()
    drawn: tuple[tuple[str, str, Callable[[], Figure]], ...] = ()
    note: str = ""


def write_tolerance(
    record: ToleranceRecord,
    folder: Path,
    progress: Callable[[str], None] = lambda _: None,
    protection: Protection = PROTECTED,
    pdf: bool = False,
) -> Path:
    """Write ``report.html``, ``tolerance.csv``, ``tolerance.json`` and the pictures; returns the path of the report.

    ``pdf``: write the report as PDF, too.
    """
    with atomic_folder(folder, protection) as scratch:
        plots = scratch / PLOTS
        plots.mkdir()
        filled = []
        parts = sections(record)
        wanted, number = sum(len(section.drawn) for section in parts), 0
        for section in parts:
            pictures = []
            for stem, caption, draw in section.drawn:
                number += 1
                progress(f"drawing picture {number} of {wanted}")
                save(draw(), plots, stem)
                pictures.append(picture(scratch, f"{PLOTS}/{stem}", caption))
            filled.append((section, pictures))
        write_text(scratch / "tolerance.csv", _csv(record))
        write_text(scratch / "tolerance.json", json_text(to_json(record)))
        stores = [one.store.folder.resolve() for one in record.summaries]
        kept = [
            f"{one.relative_to(folder.resolve()).as_posix()}/" for one in stores if one.is_relative_to(folder.resolve())
        ]
        tolerance = record.spec.tolerance
        page = render(
            "tolerance.html.j2",
            scratch,
            record.spec.name,
            title="tolerances",
            verdict=Verdict(text.headline(record), "found"),
            subject="Simulated reducers with random errors within their tolerances, "
            f"seed {tolerance.seed}, {tolerance.sequence} numbers.",
            meaning=text.tolerance_meaning(record),
            also=[*([pdf_name(REPORT)] if pdf else []), *kept],
            notes={
                **dict.fromkeys(kept, "every simulated reducer, as Parquet"),
                "tolerance.csv": "the distributions",
                "tolerance.json": "all values",
                pdf_name(REPORT): "this report",
            },
            pictures=[one for _, pictures in filled for one in pictures],
            sections=filled,
        )
        write_report(scratch, REPORT, page, pdf)
    return folder / REPORT


def sections(record: ToleranceRecord) -> list[Section]:
    """The sections of the report in order."""
    caption = "Share of reducers by value, each the largest over a turn of the output."
    distributions = Section(
        "Distribution and yield",
        tables=(text.quantity_table(record), *text.yield_tables(record)),
        drawn=(("distributions", caption, partial(plot.distributions, record)),),
    )
    found = [distributions, _advice(record)]
    if record.allocation is not None:
        found.append(_allocation(record.allocation, record.spec.name))
    found.append(
        Section(
            "Tolerances",
            tables=(text.tolerance_table(record),),
            note="Tolerances are limits; a standard deviation of a third of them means Cp = 1. "
            "Directions are uniformly distributed unless given.",
        )
    )
    if record.compared:
        found.append(
            Section(
                "Deformation compensation and tolerances",
                texts=tuple(text.comparison_sentences(record)),
                tables=(text.comparison_table(record),),
                note="The same reducers, error by error, without and with deformation compensation. "
                "The ratio has twice its standard error; within a hundredth of 1 it counts as equal.",
            )
        )
    return [*found, _published(record)]


def _advice(record: ToleranceRecord) -> Section:
    """Contributions, Sobol indices and sensitivities."""
    advice, name = record.advice, record.spec.name
    shown = [quantity for quantity in advice.quantities if quantity != LEAST_BACKLASH]
    rankings = [
        (
            f"ranking_{text.label(quantity).replace(' ', '_')}",
            f"{text.label(quantity).capitalize()}: contribution of each tolerance.",
            partial(plot.ranking, advice, quantity=quantity, name=name),
        )
        for quantity in shown
    ]
    caption = "Derivative times tolerance at nominal dimensions. All parts together as the root of the sum of squares."
    return Section(
        "Which tolerance to tighten",
        texts=(text.advice_sentence(advice), *text.sobol_sentences(advice)),
        tables=(text.ranking_table(advice.last), text.sensitivity_table(advice)),
        drawn=(*rankings, ("sensitivities", caption, partial(plot.tornado, advice, quantities=shown, name=name))),
        note="± is the standard error. The same reducers are compared, so that small changes are resolved. "
        "Scatter brings the first contact closer: a finer tolerance can raise the backlash.",
    )


def _allocation(found: Allocation, name: str) -> Section:
    return Section(
        "Tolerance allocation",
        texts=tuple(text.allocation_sentences(found)),
        tables=(text.allocation_table(found),),
        drawn=(
            (
                "allocation_tolerances",
                "Tolerances as drawn and cheapest.",
                partial(plot.tolerance_bars, found, name=name),
            ),
            ("allocation_costs", "Cost of each tolerance.", partial(plot.cost_bars, found, name=name)),
            (
                "allocation_yield",
                "The limited quantities before and after.",
                partial(plot.limited_quantities, found, name=name),
            ),
        ),
        note="The allocation considers only quantities with a limit; see docs/allocation.md.",
    )


def _published(record: ToleranceRecord) -> Section:
    case, name = record.reducer.case, record.spec.name
    bench, errors = DifferenceSetup(case), printed_errors()
    rows, budget = sensitivities(case, bench), budget_from_geometry(case, errors, bench)
    by_error = "Sensitivity of the backlash to fifteen errors, published and from geometry."
    by_part = "Lost motion in three parts, published and from geometry."
    return Section(
        "Budget of the published method and of this drive",
        tables=(
            published_sensitivity_table({disc_name(case): rows}),
            range_table(rows),
            method_table(rows),
            budget_table({disc_name(case): budget}),
            budget_remarks(budget, errors),
            formula_table(case.drive),
        ),
        drawn=(
            ("published_sensitivities", by_error, partial(plot.sensitivities, rows, name=name)),
            ("published_budget", by_part, partial(plot.budget, budget, name=name)),
        ),
        note="Published values with misprints corrected, and values computed here; see docs/budget.md.",
    )


def _csv(record: ToleranceRecord) -> str:
    """The distributions as one flat table."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    columns = record.columns()
    writer.writerow(columns)
    for row in zip(*columns.values(), strict=True):
        writer.writerow(_cell(name, value) for name, value in zip(columns, row, strict=True))
    return file.getvalue()


def _cell(column: str, value: Any) -> Any:
    if not isinstance(value, float):
        return value
    return f"{value:g}" if column.startswith("at_") else f"{value:.{6 if column.startswith('yield') else 9}g}"
