"""The part of the tolerance report that says which tolerance to tighten, and what the cheapest ones are."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

from cycloid_profile.design.tolerance_ranking import TighteningAdvice
from cycloid_profile.plot.allocation import cost_bars, limited_quantities, tolerance_bars
from cycloid_profile.plot.tolerance_ranking import ranking_plot, tornado_plot
from cycloid_profile.report.tolerance_sections import UNITS, Section, words
from cycloid_profile.tolerance.allocated import Allocation, percent
from cycloid_profile.tolerance.contributions import Contribution, Contributions, Estimate
from cycloid_profile.tolerance.plain_tables import PlainTable
from cycloid_profile.tolerance.responses import RESPONSES
from cycloid_profile.tolerance.sensitivity import PartsSensitivity

HALVED = "each tolerance halved by itself, change of the 99.73 % percentile"
_ORDER = list(RESPONSES)
_SURE = 2.0  # standard errors


def ranking_head(found: Contributions) -> tuple[str, ...]:
    """Head of the table of contributions."""
    gain = () if found.yield_as_drawn is None else ("yield gained [%]",)
    return ("tolerance", "± as drawn", *gain, *(f"{words(name)} [{UNITS[name]}]" for name in found.quantities))


def ranking_rows(found: Contributions) -> list[tuple[str, ...]]:
    """Each tolerance halved by itself: yield gained, and change of the 99.73 % percentile of each quantity."""
    rows: list[tuple[str, ...]] = []
    for one in found.ranked():
        wide = "–" if one.plus_minus is None else f"{one.plus_minus:g} {one.unit}"
        gained = () if one.yield_halved is None else (_shown(one.yield_halved, 100.0),)
        rows.append((one.label, wide, *gained, *(_shown(figures.percentile_9973) for figures in one.halved)))
    return rows


def advice_sentence(advice: TighteningAdvice) -> str:
    """The tolerance to tighten first, if any stands out."""
    found = advice.last
    first = found.ranked()[0]
    if found.yield_as_drawn is not None and first.yield_halved is not None:
        gained = first.yield_halved
        if gained.value > _SURE * gained.error and gained.value > 0.0:
            share = 1000.0 * gained.value
            return f"Tighten {first.label.replace('_', ' ')} first: halved, {share:.0f} more of 1000 reducers pass."
        return "No single tolerance, halved, lets surely more reducers pass."
    figures = first.halved[0].percentile_9973
    name = found.quantities[0]
    return (
        f"Tighten {first.label.replace('_', ' ')} first: halved, the 99.73 % percentile of the {words(name)} "
        f"changes by {figures.value:+.2g} {UNITS[name]}."
    )


def advice_section(advice: TighteningAdvice, name: str) -> Section:
    """Ranking, Sobol indices and sensitivities."""
    rows = tuple(ranking_rows(advice.last))
    drawn = [
        (
            f"ranking_{words(quantity).replace(' ', '_')}",
            f"{words(quantity).capitalize()}: what each tolerance contributes.",
            partial(ranking_plot, advice.of(quantity).found, advice.of(quantity).shares, quantity, name),
        )
        for quantity in advice.quantities
        if quantity != "least_backlash_arcmin"
    ]
    shown = [quantity for quantity in advice.quantities if quantity != "least_backlash_arcmin"]
    drawn.append(
        (
            "sensitivities",
            "Derivative times tolerance at the drawing. All parts together as the root of the sum of squares.",
            partial(tornado_plot, advice.sensitivities, shown, name),
        )
    )
    return Section(
        "Which tolerance to tighten",
        texts=(advice_sentence(advice),),
        tables=(
            PlainTable(HALVED.capitalize(), ranking_head(advice.last), rows),
            PlainTable("Sensitivity at the drawing, per unit of the size", *_slopes(advice)),
        ),
        drawn=tuple(drawn),
        note="± is the standard error. The same reducers with and without, so that small changes show. "
        "Scatter brings the first touch nearer: a finer tolerance can raise the backlash.",
    )


def allocation_section(found: Allocation, name: str) -> Section:
    """The cheapest tolerances, before and after."""
    texts = [
        f"{found.status.value.capitalize()}. Cost {found.cost_before:.4g} → {found.cost_after:.4g}, yield "
        f"{percent(found.yield_before)} → {percent(found.yield_after)} of reducers the search did not see; "
        f"one more percent costs {found.cost_per_percent:.3g}."
    ]
    if found.assumed_costs:
        texts.append("No cost was given: all tolerances were taken to cost the same, half as wide twice as much.")
    rows = tuple(
        (line.label, f"±{line.plus_minus_before:.3g} {line.unit}", f"±{line.plus_minus_after:.3g} {line.unit}",
         f"{line.ratio:.2f}", _cost(line.cost_before), _cost(line.cost_after), line.bound or "–")
        for line in found.lines
    )  # fmt: skip
    head = ("tolerance", "as drawn", "cheapest", "ratio", "cost before", "cost after", "at its bound")
    return Section(
        "Cheapest tolerances",
        texts=tuple(texts),
        tables=(PlainTable("", head, rows),),
        drawn=(
            ("allocation_tolerances", "Tolerances as drawn and cheapest.", partial(tolerance_bars, found, name)),
            ("allocation_costs", "What they cost.", partial(cost_bars, found, name)),
            ("allocation_yield", "The limited quantities before and after.", partial(limited_quantities, found, name)),
        ),
        note="Only what is limited is looked after; see docs/allocation.md.",
    )


def advice_told(advice: TighteningAdvice) -> dict[str, Any]:
    """Ranking and sensitivities as plain values."""
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
        "sensitivities": [
            {"label": row.label, "parameter": row.parameter, "unit": row.unit, "parts": row.count,
             "worst_part": dict(zip(advice.quantities, _largest(row, advice), strict=True)),
             "root_sum_square": {q: _rss(row, q) for q in advice.quantities}}
            for row in advice.sensitivities
        ],
    }  # fmt: skip


def allocation_told(found: Allocation) -> dict[str, Any]:
    """The allocation as plain values."""
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


def _contribution(one: Contribution, names: tuple[str, ...]) -> dict[str, Any]:
    return {
        "label": one.label,
        "yield_gained_halved_percent": None if one.yield_halved is None else 100.0 * one.yield_halved.value,
        "yield_gained_zero_percent": None if one.yield_zero is None else 100.0 * one.yield_zero.value,
        "variance_share": {q: share.value for q, share in zip(names, one.variance_share, strict=True)},
        "halved_changes_p99_73": {q: f.percentile_9973.value for q, f in zip(names, one.halved, strict=True)},
        "halved_changes_mean": {q: f.mean.value for q, f in zip(names, one.halved, strict=True)},
    }


def _slopes(advice: TighteningAdvice) -> tuple[tuple[str, ...], tuple[tuple[str, ...], ...]]:
    head = ("size", "parts", *(f"{words(q)}, one part · all" for q in advice.quantities))
    rows = tuple(
        (
            f"{row.label} [1/{row.unit}]",
            str(row.count),
            *(
                f"{largest:.3g} · {_rss(row, q):.3g} {UNITS[q]}"
                for q, largest in zip(advice.quantities, _largest(row, advice), strict=True)
            ),
        )
        for row in advice.sensitivities
    )
    return head, rows


def _largest(row: PartsSensitivity, advice: TighteningAdvice) -> list[float]:
    """Derivative of each quantity by the size of the worst part."""
    return [row.worst[_ORDER.index(q)].of(q).largest for q in advice.quantities]


def _rss(row: PartsSensitivity, quantity: str) -> float:
    return row.root_sum_square[_ORDER.index(quantity)]


def _shown(one: Estimate, factor: float = 1.0) -> str:
    value, error = factor * one.value, factor * one.error
    if not math.isfinite(value):
        return "–"
    digits = max(0, 1 - math.floor(math.log10(error))) if error > 0.0 else 3
    return f"{value:+.{min(digits, 4)}f} ± {error:.{min(digits, 4)}f}"


def _cost(cost: float | None) -> str:
    return "–" if cost is None else f"{cost:.2f}"
