"""Tables of a diagnosis, a measurement plan and a correction, for the terminal."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from cycloid_profile._display import figure_text, with_unit
from cycloid_profile.articles import PlainTable
from cycloid_profile.diagnosis import Detectability, Diagnosis, detectable_text, p_value_text
from cycloid_profile.units import SIGNS

VERDICTS = {
    "agrees": "measurement and simulation agree",
    "effects_found": "the missing effect has been found",
    "unknown_effect": "the difference is not in the library of effects",
}
_MOST_PLACES = 8  # rows of the table on one screen


def diagnosis_tables(values: Mapping[str, Any]) -> Iterator[PlainTable]:
    """Tables of the JSON object of a diagnosis: effects, places, nearest effects, gap, smallest detectable sizes."""
    if values["effects"]:
        head = ("effect", "parameters", "confused with", "separated by")
        yield PlainTable("missing effects", head, tuple(_effect(one) for one in values["effects"]))
    found = [values["remainder"]] if values["verdict"] == "unknown_effect" else values["where"]
    places = tuple(_place(p, p_value_text(p["p_value"])) for p in found if p is not None)
    if places:
        yield PlainTable("where", ("file", "coordinate", "at", "size", "p"), places[:_MOST_PLACES])
    if values["effects"] and values["remainder"]:
        rest = values["remainder"]
        cause = "the error of the model, perhaps" if rest["within_model_error"] else "none in the library"
        yield PlainTable("left by the effects", ("file", "coordinate", "at", "size", "cause"), (_place(rest, cause),))
    if values["nearest"]:
        shares = tuple((n["name"], f"{100.0 * n['share_explained']:.0f} %", n["why_not"]) for n in values["nearest"])
        yield PlainTable("nearest effects", ("effect", "explains", "rejected because"), shares)
    keys = ("noise", "fit_before", "fit_after", "held_out_before", "held_out_after")
    yield PlainTable(
        "measured minus predicted, rms",
        ("file", "noise", "fitted before", "fitted after", "held out before", "held out after", "unit"),
        tuple((g["file"], *("–" if g[k] is None else f"{g[k]:.4g}" for k in keys), SIGNS[g["unit"]])
              for g in values["gap"]),
    )  # fmt: skip
    if values["verdict"] == "agrees":
        unseen = tuple((n["name"], _with_unit_symbol(n["smallest_detectable"])) for n in values["not_seen"])
        yield PlainTable("smallest detectable size of each effect", ("effect", "size"), unseen)


def _place(one: Mapping[str, Any], last: str) -> tuple[str, ...]:
    """Row of a place, with what its ``last`` column says."""
    return one["file"], one["coordinate"], _range_text(one), _size_text(one), last


def gap_table(diagnosis: Diagnosis) -> PlainTable:
    """Gap of each file on fitted and held-out rows, before and after any effects, for the report."""
    with_effects = bool(diagnosis.effects)
    shown = {"fit_before": "fitted", "held_out_before": "held out"}
    if with_effects:
        shown = {
            "fit_before": "fitted, before", "fit_after": "after",
            "held_out_before": "held out, before", "held_out_after": "after",
        }  # fmt: skip
    head = ("file", "rows", "unit", "noise", *shown.values(), *(("closed",) if with_effects else ()), "χ² per row")
    rows = []
    for one in diagnosis.gaps:
        closed = "–" if one.closure is None else f"{100.0 * min(one.closure, 1.0):.1f} %".replace("-", "−")
        file = one.recording
        rows.append((
            file.name,
            f"{file.rows.size:,} ({file.held_out.sum():,} held out)",
            SIGNS[file.unit],
            figure_text(one.noise, digits=3),
            *(figure_text(getattr(one, key), digits=3) for key in shown),
            *((closed,) if with_effects else ()),
            figure_text(one.chi2_per_row, digits=3),
        ))  # fmt: skip
    return PlainTable("", head, tuple(rows))


def nearest_table(diagnosis: Diagnosis) -> PlainTable:
    """Effects nearest to an unexplained difference, for the report."""
    rows = tuple((one.name.replace("_", " "), f"{100.0 * one.share:.0f} %", one.why) for one in diagnosis.nearest)
    return PlainTable("", ("effect", "share of the gap explained alone", "reason for rejection"), rows)


def change_tables(values: Mapping[str, Any]) -> Iterator[PlainTable]:
    """Tables of the JSON object ``against``: what changed, what did not, figures of the loop, and files."""
    head = ("effect", "parameter", "before", "after", "change", "σ", "confused with")
    yield PlainTable(
        "what changed", head, tuple(_change(one) for one in values["changes"]) or (("nothing", *("–",) * 6),)
    )
    if values["unchanged"]:
        yield PlainTable("no significant change", head, tuple(_change(one) for one in values["unchanged"]))
    if values["figures"]:
        figures = tuple(
            (one["name"], f"{one['before']:.4g}", f"{one['after']:.4g}", _signed(one), f"{one['significance']:.1f}")
            for one in values["figures"]
        )
        yield PlainTable("figures of the loop", ("figure", "before", "after", "change", "σ"), figures)
    keys = ("rms_before", "rms_without_changes", "rms_after")
    yield PlainTable(
        "measured minus predicted at both times, rms",
        ("before", "after", "before", "after, without the changes", "with them", "unit"),
        tuple((one["before"] or "–", one["after"], *("–" if one[k] is None else f"{one[k]:.4g}" for k in keys),
               SIGNS[one["unit"]]) for one in values["files"]),
    )  # fmt: skip


def _change(one: Mapping[str, Any]) -> tuple[str, ...]:
    parts = ", ".join(f"{key} {value}" for key, value in one["parts"].items())
    name = f"{one['name']} ({parts})" if parts else one["name"]
    amounts = ("–" if one[key] is None else f"{one[key]:.4g}" for key in ("before", "after"))
    return (
        name,
        one["parameter"],
        *amounts,
        _signed(one),
        f"{one['significance']:.1f}",
        ", ".join(one["group"][1:]) or "–",
    )


def _signed(one: Mapping[str, Any]) -> str:
    return "–" if one["change"] is None else f"{one['change']:+.3g} ± {one['uncertainty']:.2g}"


def plan_tables(rows: Sequence[Detectability], name: str) -> Iterator[PlainTable]:
    """Smallest size of each effect that each measurement detects, and that it identifies."""
    measurements = list(dict.fromkeys(row.measurements for row in rows))
    cells = {(row.effect, row.measurements): row for row in rows}
    for title, size in (
        (f"{name}: smallest size that would be detected, 80 % of the time", "detectable"),
        ("smallest size that would also be identified, or the effect it is confused with", "identifiable"),
    ):
        yield PlainTable(
            title,
            ("effect", *measurements),
            tuple((effect, *(_smallest(one, getattr(one, size)) for one in (cells[effect, m] for m in measurements)))
                  for effect in dict.fromkeys(row.effect for row in rows)),
        )  # fmt: skip


def correction_tables(values: Mapping[str, Any]) -> Iterator[PlainTable]:
    """Cancelled effects and the gap to the nominal tooth, from the JSON object of a correction."""
    cancelled = [
        (one["name"], ", ".join(f"{k} = {v:.4g}" for k, v in one["parameters"].items()), source)
        for key, source in (("effects", "found"), ("known_effects", "in the spec"))
        for one in values[key]
    ]
    cancelled += [(one["name"], f"at most {one['largest_um']:.3g} µm", f"in the spec, {one['label']}")
                  for one in values.get("empirical", ())]  # fmt: skip
    smooth = values["remainder"]
    if smooth is not None:
        cancelled.append(("smooth remainder", f"at most {smooth['largest_um']:.3g} µm", smooth["label"]))
    title = f"{values['name']}, disc {values['disc']}: cancelled"
    yield PlainTable(title, ("effect", "parameters", "from"), tuple(cancelled))
    keys = ("noise_um", "rms_before_um", "rms_after_um")
    rows = tuple((scan["file"], *(f"{scan[key]:.4g}" for key in keys)) for scan in values["scans"])
    yield PlainTable("gap to the nominal tooth [µm]", ("file", "noise", "before", "after"), rows)


def correction_sentences(values: Mapping[str, Any]) -> list[str]:
    """Largest deviation, expected scan, clamping where the lobes differ, and notes."""
    sentences = [
        f"at most {values['largest_um']:.3g} µm from the nominal tooth (limit {values['limit_um']:g}); "
        f"a new scan is expected at {values['rms_expected_um']:.3g} µm rms"
    ]
    if not values["lobes_alike"]:
        turns = ", ".join(f"{scan['lobe_1_at_deg']:.4f}° in {scan['file']}" for scan in values["scans"])
        sentences.append(f"lobes differ: lobe 1 of the program is the one at {turns}; clamp the disc by it")
    return sentences + [f"note: {sentence}" for sentence in (*values["not_ground_away"], *values["notes"])]


def _effect(one: Mapping[str, Any]) -> tuple[str, ...]:
    errors = one["uncertainty"]
    sizes = ", ".join(
        f"{key} = {value:.4g}" + (f" ± {errors[key]:.2g}" if key in errors else "")
        for key, value in one["parameters"].items()
    )
    others = [*one["group"][1:], *(["other locations"] if one["elsewhere"] else [])]
    return one["name"], sizes, ", ".join(others) or "–", one["separate_by"] or "–"


def _range_text(place: Mapping[str, Any]) -> str:
    start, end = place["from"], place["to"]
    return f"{start:.4g}" if start == end else f"{start:.4g} to {end:.4g}"


def _size_text(place: Mapping[str, Any]) -> str:
    key = next(k for k in place if k.startswith("rms_"))
    return with_unit(f"{place[key]:.3g}", SIGNS[key[4:]])


def _with_unit_symbol(size: str) -> str:
    number, _, unit = size.rpartition(" ")
    return with_unit(number, SIGNS[unit]) if unit in SIGNS else size


def _smallest(one: Detectability, size: float) -> str:
    """A detectable or identifiable ``size``, else the effect it is confused with; a dash where undetectable."""
    if math.isinf(one.detectable):
        return "–"
    if math.isinf(size):
        return f"as {one.most_similar}"
    number, _, unit = detectable_text(size, one.size, symbols=True).rpartition(" ")
    return with_unit(number, unit) if number else unit
