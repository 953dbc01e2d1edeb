"""A tolerance study as plain values for JSON, and as rows for terminal, table and report."""

from __future__ import annotations

import math
from typing import Any

from cycloid_profile.design.tolerance_record import ToleranceRecord
from cycloid_profile.report.tolerance_advice import advice_told, allocation_told
from cycloid_profile.report.tolerance_sections import UNITS, words
from cycloid_profile.tolerance.limits import Limit
from cycloid_profile.tolerance.quantities import QUANTITIES
from cycloid_profile.tolerance.scatter import Scatter
from cycloid_profile.tolerance.summary import Interval, QuantitySummary, StudySummary


def told(record: ToleranceRecord) -> dict[str, Any]:
    """One object for ``--json``; numbers that are none are null."""
    return {
        "schema": 1,
        "name": record.spec.name,
        "seed": record.spec.tolerance.seed,
        "sequence": record.spec.tolerance.sequence,
        "tolerances_assumed": record.tolerances.assumed,
        "tolerances": [_scatter(one) for one in record.tolerances.scatters],
        "quantities": [_quantity(record, summary, one) for summary, one in quantities(record)],
        "yields": [
            {**_limit(one.limit), "samples": summary.samples, **_percent(one.share)}
            for summary in record.summaries
            for one in summary.yields
        ],
        "compared": [
            {
                "quantity": one.quantity,
                "conventional": {"mean": one.mean[0], "deviation": one.deviation[0]},
                "compensated": {"mean": one.mean[1], "deviation": one.deviation[1]},
                "ratio_of_deviations": _number(one.ratio),
                "ratio_error": _number(one.error),
                "compensated_is": f"{one.verdict} sensitive",
            }
            for one in record.compared
        ],
        **advice_told(record.advice),
        "allocation": None if record.allocation is None else allocation_told(record.allocation),
    }


def quantities(record: ToleranceRecord) -> list[tuple[StudySummary, QuantitySummary]]:
    """Each quantity once, from the study that has most of it."""
    found: dict[str, tuple[StudySummary, QuantitySummary]] = {}
    for summary in record.summaries:
        for one in summary.quantities:
            found.setdefault(one.name, (summary, one))
    return [found[name] for name in QUANTITIES if name in found]


def quantity_rows(record: ToleranceRecord) -> list[tuple[str, ...]]:
    """Quantity, reducers, drawn, mean, deviation, median, 95, 99 and 99.73 %."""
    rows = []
    for _, one in quantities(record):
        p = one.percentiles
        rows.append(
            (
                f"{words(one.name)} [{UNITS[one.name]}]",
                f"{one.spread.count:,}",
                _shown(record.drawn.get(one.name, math.nan)),
                _with_error(one.mean),
                _shown(one.spread.deviation),
                *(_with_range(p[percent]) for percent in (50.0, 95.0, 99.0, 99.73)),
            )
        )
    return rows


def yield_rows(record: ToleranceRecord) -> list[tuple[str, ...]]:
    """Limit, share that passes, its interval, what that is of a thousand, and the reducers counted."""
    rows: list[tuple[str, ...]] = []
    for summary in record.summaries:
        for one in summary.yields:
            limit = "all limits together" if one.limit is None else limit_inwords(one.limit)
            s = one.share
            rows.append(
                (
                    limit,
                    f"{100.0 * s.value:.2f} %",
                    f"{100.0 * s.low:.2f} to {100.0 * s.high:.2f} %",
                    f"{round(1000.0 * s.value)} of 1000",
                    f"{summary.samples:,}",
                )
            )
    return rows


def limit_inwords(limit: Limit) -> str:
    """A limit with its unit."""
    ends = ((sign, end) for sign, end in (("≥", limit.at_least), ("≤", limit.at_most)) if math.isfinite(end))
    return f"{words(limit.quantity)} {' and '.join(f'{sign} {end:g}' for sign, end in ends)} {UNITS[limit.quantity]}"


def tolerance_rows(record: ToleranceRecord) -> list[tuple[str, ...]]:
    """Name, parts it is drawn for, limits, deviation, distribution, and what is common to a batch."""
    rows: list[tuple[str, ...]] = []
    for one in record.tolerances.scatters:
        wide = "–" if one.plus_minus is None else f"±{one.plus_minus:g} {one.unit}"
        rows.append((one.label, str(len(one.choices)), wide, f"{_shown(one.size.standard_deviation)} {one.unit}",
                     type(one.size).__name__.lower(), f"{one.batch_share:g}"))  # fmt: skip
    return rows


def comparison_rows(record: ToleranceRecord) -> list[tuple[str, ...]]:
    """Quantity, deviation without and with compensation, ratio with two errors, and the answer."""
    return [
        (
            f"{words(one.quantity)} [{UNITS[one.quantity]}]",
            _shown(one.mean[0]),
            _shown(one.mean[1]),
            _shown(one.deviation[0]),
            _shown(one.deviation[1]),
            f"{one.ratio:.4f} ± {2.0 * one.error:.2g}",
            f"{one.verdict} sensitive",
        )
        for one in record.compared
    ]


def comparison_sentence(record: ToleranceRecord) -> str | None:
    """Whether the compensated design is less sensitive to tolerances, which [TP] claims; None without compensation."""
    if not record.compared:
        return None
    said = {one.quantity: one.verdict for one in record.compared}
    parts = ", ".join(f"{words(name)} {verdict} sensitive" for name, verdict in said.items())
    confirmed = all(verdict == "less" for verdict in said.values())
    answer = "holds" if confirmed else "does not hold for all of them" if "less" in said.values() else "does not hold"
    claim = "Published claim that deformation compensation makes a reducer less sensitive to tolerances"
    return f"{claim}: it {answer} ({parts})."


def _scatter(one: Scatter) -> dict[str, Any]:
    return {
        "name": one.kind.name,
        "label": one.label,
        "parameter": one.axes.size.name,
        "parts": len(one.choices),
        "plus_minus": one.plus_minus,
        "deviation": one.size.standard_deviation,
        "unit": one.unit,
        "distribution": type(one.size).__name__.lower(),
    }


def _quantity(record: ToleranceRecord, summary: StudySummary, one: QuantitySummary) -> dict[str, Any]:
    return {
        "name": one.name,
        "meaning": QUANTITIES[one.name],
        "samples": summary.samples,
        "without_answer": one.spread.lost,
        "drawn": _number(record.drawn.get(one.name, math.nan)),
        "mean": _interval(one.mean),
        "deviation": _number(one.spread.deviation),
        "least": _number(one.spread.low),
        "greatest": _number(one.spread.high),
        "percentiles": {f"{percent:g}": _interval(value) for percent, value in one.percentiles.items()},
    }


def _limit(limit: Limit | None) -> dict[str, Any]:
    if limit is None:
        return {"name": "all", "at_least": None, "at_most": None}
    return {"name": limit.quantity, "at_least": _number(limit.at_least), "at_most": _number(limit.at_most)}


def _interval(one: Interval) -> dict[str, float | None]:
    return {"value": _number(one.value), "low": _number(one.low), "high": _number(one.high)}


def _percent(share: Interval) -> dict[str, float]:
    return {"yield_percent": 100.0 * share.value, "low": 100.0 * share.low, "high": 100.0 * share.high}


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _shown(value: float) -> str:
    if not math.isfinite(value):
        return "–"
    return f"{value:.0f}" if abs(value) >= 1000.0 else f"{value:.3g}"


def _with_error(one: Interval) -> str:
    half = 0.5 * (one.high - one.low)
    return f"{_shown(one.value)} ± {half:.0f}" if half >= 1.0 else f"{_shown(one.value)} ± {half:.1g}"


def _with_range(one: Interval) -> str:
    return f"{_shown(one.value)} ({_shown(one.low)} to {_shown(one.high)})"
