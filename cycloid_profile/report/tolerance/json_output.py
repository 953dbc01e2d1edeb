"""A tolerance analysis as plain values for JSON; figures that do not exist are None."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

from cycloid_profile._display import finite
from cycloid_profile.design import TighteningAdvice, ToleranceRecord
from cycloid_profile.report.tolerance.text import advice_sentence, root_sum_square, worst_part
from cycloid_profile.tolerance.allocation import Allocation
from cycloid_profile.tolerance.inputs import Limit, Scatter
from cycloid_profile.tolerance.model import QUANTITIES
from cycloid_profile.tolerance.ranking import Contribution
from cycloid_profile.tolerance.study import Interval, QuantitySummary


def to_json(record: ToleranceRecord) -> dict[str, Any]:
    """The object of ``--json``."""
    return {
        "schema": 1,
        "name": record.spec.name,
        "seed": record.spec.tolerance.seed,
        "sequence": record.spec.tolerance.sequence,
        "tolerances_assumed": record.tolerances.assumed,
        "tolerances": [_scatter(one) for one in record.tolerances.scatters],
        "quantities": [_quantity(one, record.drawn.get(one.name, math.nan)) for one in record.quantities],
        "yields": [
            {**_limit(one.limit), "samples": summary.samples, "yield_percent": 100.0 * one.share.value,
             "low": 100.0 * one.share.low, "high": 100.0 * one.share.high}
            for summary in record.summaries
            for one in summary.yields
        ],
        "compared": [
            {
                "quantity": one.quantity,
                "conventional": {"mean": finite(one.mean[0]), "deviation": finite(one.deviation[0])},
                "compensated": {"mean": finite(one.mean[1]), "deviation": finite(one.deviation[1])},
                "ratio_of_deviations": finite(one.ratio),
                "ratio_error": finite(one.error),
                "compensated_is": f"{one.verdict} sensitive",
            }
            for one in record.compared
        ],
        **_advice(record.advice),
        "allocation": None if record.allocation is None else _allocation(record.allocation),
    }  # fmt: skip


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


def _quantity(one: QuantitySummary, drawn: float) -> dict[str, Any]:
    return {
        "name": one.name,
        "meaning": QUANTITIES[one.name],
        "samples": one.spread.count + one.spread.lost,
        "without_answer": one.spread.lost,
        "drawn": finite(drawn),
        "mean": _interval(one.mean),
        "deviation": finite(one.spread.deviation),
        "least": finite(one.spread.low),
        "greatest": finite(one.spread.high),
        "percentiles": {f"{percent:g}": _interval(value) for percent, value in one.percentiles.items()},
    }


def _advice(advice: TighteningAdvice) -> dict[str, Any]:
    """Contributions, Sobol indices and sensitivities."""
    found = advice.last
    return {
        "advice": advice_sentence(advice),
        "contributions": [_contribution(one, found.quantities) for one in found.ranked()],
        "sobol": [
            {"label": share.group, "quantity": share.quantity, "first": share.first.value, "total": share.total.value,
             "first_low": share.first.low, "first_high": share.first.high, "total_low": share.total.low,
             "total_high": share.total.high, "linear": share.linear}
            for quantity in advice.quantities
            for share in advice.of(quantity).shares.of(quantity)
        ],
        "sobol_sampling": [
            {"quantities": list(one.shares.quantities), "reducers": one.shares.reducers, "width": one.shares.width,
             "wanted": one.shares.wanted, "settled": one.shares.settled}
            for one in advice.ranked
        ],
        "sensitivities": [
            {"label": row.label, "parameter": row.parameter, "unit": row.unit, "parts": row.count,
             "worst_part": {q: worst_part(row, q) for q in advice.quantities},
             "root_sum_square": {q: root_sum_square(row, q) for q in advice.quantities}}
            for row in advice.sensitivities
        ],
    }  # fmt: skip


def _contribution(one: Contribution, names: tuple[str, ...]) -> dict[str, Any]:
    return {
        "label": one.label,
        "yield_gained_halved_percent": None if one.yield_halved is None else 100.0 * one.yield_halved.value,
        "yield_gained_zero_percent": None if one.yield_zero is None else 100.0 * one.yield_zero.value,
        "variance_share": {q: share.value for q, share in zip(names, one.variance_share, strict=True)},
        "halved_changes_p99_73": {q: f.percentile_9973.value for q, f in zip(names, one.halved, strict=True)},
        "halved_changes_mean": {q: f.mean.value for q, f in zip(names, one.halved, strict=True)},
    }


def _allocation(found: Allocation) -> dict[str, Any]:
    return {
        "status": found.status.name.lower(),
        "wanted_percent": 100.0 * found.wanted,
        "yield_before_percent": 100.0 * found.yield_before.value,
        "yield_percent": 100.0 * found.yield_after.value,
        "yield_low": 100.0 * found.yield_after.low,
        "yield_high": 100.0 * found.yield_after.high,
        "cost_before": found.cost_before,
        "cost": found.cost_after,
        "cost_per_percent": found.cost_per_percent,
        "tolerances": [
            {"label": line.label, "unit": line.unit, "plus_minus_before": line.plus_minus_before,
             "plus_minus": line.plus_minus_after, "bound": line.bound or None}
            for line in found.lines
        ],
    }  # fmt: skip


def _limit(limit: Limit | None) -> dict[str, Any]:
    if limit is None:
        return {"name": "all", "at_least": None, "at_most": None}
    return {"name": limit.quantity, "at_least": finite(limit.at_least), "at_most": finite(limit.at_most)}


def _interval(one: Interval) -> dict[str, float | None]:
    return {key: finite(value) for key, value in asdict(one).items()}
