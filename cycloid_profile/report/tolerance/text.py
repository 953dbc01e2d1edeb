"""A tolerance analysis as sentences and tables of text, for the terminal and the report."""

from __future__ import annotations

import math
from collections.abc import Iterator

from cycloid_profile._display import with_unit
from cycloid_profile.articles import PlainTable
from cycloid_profile.design import LEAST_BACKLASH, PERCENTS, TighteningAdvice, ToleranceRecord
from cycloid_profile.report.page import at_an_arm
from cycloid_profile.tolerance.allocation import Allocation, percent
from cycloid_profile.tolerance.inputs import Limit
from cycloid_profile.tolerance.model import RESPONSES
from cycloid_profile.tolerance.ranking import Contributions, Estimate, ToleranceSensitivity
from cycloid_profile.tolerance.study import Interval, StudySummary
from cycloid_profile.units import sign_of, unit_of

_ORDER = list(RESPONSES)
_ANGLES = {"arcmin": 1.0, "arcsec": 1.0 / 60.0}  # arc minutes in a unit
_SIGNIFICANT = 2.0  # standard errors


def label(quantity: str) -> str:
    """Name of a quantity without its unit."""
    return quantity.rsplit("_", 1)[0].replace("_", " ")


def headline(record: ToleranceRecord) -> str:
    """Sentence with the yield of all limits, or with percentiles of the backlash if there is no limit."""
    yields = [one for summary in record.summaries for one in summary.yields]
    if not yields:
        first = record.quantities[0]
        return (
            f"Backlash of {first.spread.count:,} reducers: half of them below {first.percentiles[50.0].value:.2f}′, "
            f"99 of 100 below {first.percentiles[99.0].value:.2f}′."
        )
    last = yields[-1]
    limits = "all limits" if last.limit is None else "the limit"
    low, high = 1000 * last.share.low, 1000 * last.share.high
    return f"{round(1000 * last.share.value)} of 1000 reducers keep {limits} (95 % interval {low:.0f} to {high:.0f})."


def summary_sentences(record: ToleranceRecord) -> list[str]:
    """Assumptions, the tolerance to tighten first, compensated and conventional tooth, reducers that bind, and missing
    results.
    """
    sentences = []
    if record.tolerances.assumed:
        sentences.append("The spec has no [tolerance] table: ordinary manufacturing tolerances are assumed.")
    sentences.append(advice_sentence(record.advice))
    sentences += comparison_sentences(record)
    least = next(one for one in record.quantities if one.name == LEAST_BACKLASH)
    if least.spread.low < 0.0:
        binding = sum(int((chunk < 0.0).sum()) for chunk in record.backlash.store.columns(LEAST_BACKLASH))
        share = 1000.0 * binding / record.backlash.samples
        sentences.append(f"{share:.3g} of 1000 reducers bind somewhere in a turn: pins and discs overlap without load.")
    lost = sum(one.spread.lost for one in record.quantities)
    if lost:
        sentences.append(f"{lost:,} values could not be computed; these reducers count as failed.")
    return sentences


def tolerance_meaning(record: ToleranceRecord) -> list[str]:
    """Angles of 99 of 100 reducers as lengths, and the sentences of the summary."""
    sentences = []
    for one in record.quantities:
        angle = _ANGLES.get(unit_of(one.name))
        if angle is not None and one.name != LEAST_BACKLASH:
            value = one.percentiles[99.0].value
            shown = f"{_number(value)}{sign_of(one.name)} = {at_an_arm(value * angle)}"
            sentences.append(f"{label(one.name).capitalize()} of 99 of 100 reducers: below {shown}.")
    return [*sentences, *summary_sentences(record)]


def advice_sentence(advice: TighteningAdvice) -> str:
    """The tolerance to tighten first, if its gain is significant."""
    found = advice.last
    first = found.ranked()[0]
    gained = first.yield_halved
    if found.yield_as_drawn is None or gained is None:
        name = found.quantities[0]
        change = first.halved[0].percentile_9973.value
        effect = f"the 99.73 % percentile of the {label(name)} changes by {with_unit(f'{change:+.2g}', sign_of(name))}"
    elif gained.value > max(_SIGNIFICANT * gained.error, 0.0):
        effect = f"{1000.0 * gained.value:.0f} more of 1000 reducers pass"
    else:
        return "Halving any single tolerance does not raise the yield significantly."
    return f"Tighten {first.label.replace('_', ' ')} first: halved, {effect}."


def sobol_sentences(advice: TighteningAdvice) -> list[str]:
    """How the sampling of the Sobol indices ended, one sentence for each study."""
    return [
        f"Sobol indices of {', '.join(label(name) for name in one.shares.quantities)}: {one.shares.ending}."
        for one in advice.ranked
    ]


def comparison_sentences(record: ToleranceRecord) -> list[str]:
    """Which quantities are less sensitive to tolerances with deformation compensation; empty without it."""
    by_verdict: dict[str, list[str]] = {}
    for one in record.compared:
        by_verdict.setdefault(one.verdict, []).append(label(one.quantity))
    parts = "; ".join(f"{verdict} sensitive: {', '.join(names)}" for verdict, names in by_verdict.items())
    return [f"Sensitivity to tolerances with deformation compensation against without: {parts}."] if parts else []


def allocation_sentences(found: Allocation) -> list[str]:
    """Sentences on the outcome, cost and yield of the cheapest tolerances."""
    sentences = [
        f"{found.status.value.capitalize()}. Cost {found.cost_before:.4g} → {found.cost_after:.4g}, yield "
        f"{percent(found.yield_before)} → {percent(found.yield_after)} of independent reducers; "
        f"one more percent costs {found.cost_per_percent:.3g}."
    ]
    if found.assumed_costs:
        sentences.append("No cost was given: every tolerance costs the same, and twice as much at half the width.")
    return sentences


def terminal_tables(record: ToleranceRecord) -> Iterator[PlainTable]:
    """Distribution, yield, contributions and the cheapest tolerances."""
    yield quantity_table(record)
    yield from yield_tables(record)
    yield ranking_table(record.advice.last)
    if record.allocation is not None:
        yield allocation_table(record.allocation)


def quantity_table(record: ToleranceRecord) -> PlainTable:
    """Distribution of each quantity."""
    head = ("quantity", "reducers", "as drawn", "mean", "deviation", *(f"{p:g} %" for p in PERCENTS))
    rows = tuple(
        (
            f"{label(one.name)} [{sign_of(one.name)}]",
            f"{one.spread.count:,}",
            _number(record.drawn.get(one.name, math.nan)),
            _with_half_interval(one.mean),
            _number(one.spread.deviation),
            *(_with_range(one.percentiles[p]) for p in PERCENTS),
        )
        for one in record.quantities
    )
    return PlainTable("distribution, in brackets 95 % intervals", head, rows)


def yield_tables(record: ToleranceRecord) -> list[PlainTable]:
    """Yield of each limit and of all together; empty without limits."""
    rows = tuple(
        (
            _together(summary, record) if one.limit is None else _limit(one.limit),
            f"{100.0 * one.share.value:.2f} %",
            f"{100.0 * one.share.low:.2f} to {100.0 * one.share.high:.2f} %",
            f"{round(1000.0 * one.share.value)} of 1000",
            f"{summary.samples:,}",
        )
        for summary in record.summaries
        for one in summary.yields
    )
    return [PlainTable("yield", ("limit", "passes", "95 % interval", "of 1000", "reducers"), rows)] if rows else []


def _together(summary: StudySummary, record: ToleranceRecord) -> str:
    """Name of the joint yield of a study: those of a study without load keep fewer limits than there are."""
    limits, most = len(summary.yields) - 1, max(len(one.yields) - 1 for one in record.summaries)
    return "all limits together" if limits == most else f"these {limits} limits together"


def tolerance_table(record: ToleranceRecord) -> PlainTable:
    """The tolerances: parts, limits, deviation, distribution, and the share common to a batch."""
    head = ("error", "parts", "tolerance", "standard deviation", "distribution", "share of a batch")
    rows = tuple(
        (one.label, str(len(one.choices)), "–" if one.plus_minus is None else f"±{one.plus_minus:g} {one.unit}",
         f"{_number(one.size.standard_deviation)} {one.unit}", type(one.size).__name__.lower(), f"{one.batch_share:g}")
        for one in record.tolerances.scatters
    )  # fmt: skip
    return PlainTable("", head, rows)


def comparison_table(record: ToleranceRecord) -> PlainTable:
    """Each quantity without and with deformation compensation."""
    head = ("quantity", "mean, without", "with", "deviation, without", "with", "ratio of deviations",
            "with compensation")  # fmt: skip
    rows = tuple(
        (f"{label(one.quantity)} [{sign_of(one.quantity)}]", *(_number(mean) for mean in one.mean),
         *(_number(deviation) for deviation in one.deviation), f"{one.ratio:.4f} ± {2.0 * one.error:.2g}",
         f"{one.verdict} sensitive")
        for one in record.compared
    )  # fmt: skip
    return PlainTable("", head, rows)


def ranking_table(found: Contributions) -> PlainTable:
    """Table of each tolerance halved separately: gain in yield, and change of the 99.73 % percentile of each
    quantity."""
    with_yield = found.yield_as_drawn is not None
    head = ("tolerance", "± as drawn", *(("yield gained [%]",) if with_yield else ()),
            *(f"{label(name)} [{sign_of(name)}]" for name in found.quantities))  # fmt: skip
    rows = tuple(
        (one.label, "–" if one.plus_minus is None else f"{one.plus_minus:g} {one.unit}",
         *(() if one.yield_halved is None else (_estimate(one.yield_halved, 100.0),)),
         *(_estimate(figures.percentile_9973) for figures in one.halved))
        for one in found.ranked()
    )  # fmt: skip
    return PlainTable("each tolerance halved by itself, change of the 99.73 % percentile", head, rows)


def sensitivity_table(advice: TighteningAdvice) -> PlainTable:
    """Derivative of each quantity by each size: the worst part, and all parts as root of the sum of squares."""
    head = ("size", "parts", *(f"{label(q)}, one part · all" for q in advice.quantities))
    rows = tuple(
        (f"{row.label} [1/{row.unit}]", str(row.count),
         *(f"{worst_part(row, q):.3g} · {root_sum_square(row, q):.3g} {sign_of(q)}" for q in advice.quantities))
        for row in advice.sensitivities
    )  # fmt: skip
    return PlainTable("sensitivity at the nominal dimensions, per unit of the size", head, rows)


def allocation_table(found: Allocation) -> PlainTable:
    """The tolerances before and after the allocation, with their costs."""
    head = ("tolerance", "as drawn", "cheapest", "ratio", "cost before", "cost after", "at its bound")
    rows = tuple(
        (line.label, f"±{line.plus_minus_before:.3g} {line.unit}", f"±{line.plus_minus_after:.3g} {line.unit}",
         f"{line.ratio:.2f}", _cost(line.cost_before), _cost(line.cost_after), line.bound or "–")
        for line in found.lines
    )  # fmt: skip
    return PlainTable("cheapest tolerances", head, rows)


def worst_part(row: ToleranceSensitivity, quantity: str) -> float:
    """Largest derivative of a quantity by the size of one part."""
    return row.worst[_ORDER.index(quantity)].of(quantity).largest


def root_sum_square(row: ToleranceSensitivity, quantity: str) -> float:
    """Derivatives by the sizes of all parts, as root of the sum of squares."""
    return row.root_sum_square[_ORDER.index(quantity)]


def _limit(limit: Limit) -> str:
    ends = ((sign, end) for sign, end in (("≥", limit.at_least), ("≤", limit.at_most)) if math.isfinite(end))
    bounds = (with_unit(f"{sign} {end:g}", sign_of(limit.quantity)) for sign, end in ends)
    return f"{label(limit.quantity)} {' and '.join(bounds)}"


def _number(value: float) -> str:
    if not math.isfinite(value):
        return "–"
    return f"{value:.0f}" if abs(value) >= 1000.0 else f"{value:.3g}"


def _with_half_interval(one: Interval) -> str:
    """Text of a value ± half the width of its 95 % interval."""
    half = 0.5 * (one.high - one.low)
    return f"{_number(one.value)} ± {half:.0f}" if half >= 1.0 else f"{_number(one.value)} ± {half:.1g}"


def _with_range(one: Interval) -> str:
    return f"{_number(one.value)} ({_number(one.low)} to {_number(one.high)})"


def _estimate(one: Estimate, factor: float = 1.0) -> str:
    value, error = factor * one.value, factor * one.error
    if not math.isfinite(value):
        return "–"
    digits = max(0, 1 - math.floor(math.log10(error))) if error > 0.0 else 3
    return f"{value:+.{min(digits, 4)}f} ± {error:.{min(digits, 4)}f}"


def _cost(cost: float | None) -> str:
    return "–" if cost is None else f"{cost:.2f}"
