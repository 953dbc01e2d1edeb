"""A diagnosis as one self-contained HTML page: what differs, where, what it is, how sure, what to do."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

from cycloid_profile.discrepancy.outcome import Diagnosis, FileGap, NamedEffect
from cycloid_profile.effects.effect import parameters
from cycloid_profile.effects.registry import EFFECTS
from cycloid_profile.report.effect_in_words import PARTS, cure_of, in_words, meaning_of, size_in_words, which_part
from cycloid_profile.report.number_in_words import joined, minus, odds, with_uncertainty
from cycloid_profile.report.page import inline_svg, template
from cycloid_profile.report.place_in_words import place_in_words
from cycloid_profile.report.verdict_in_words import headline, summary, sure
from cycloid_profile.units import SIGNS, sign_of

TEMPLATE = "diagnosis.html.j2"


def diagnosis_report(
    diagnosis: Diagnosis, name: str, plots: Path, pictures: list[tuple[str, str]], new_spec: str | None
) -> str:
    """HTML text of the report; ``pictures``, stem and caption of the SVG files in ``plots``; ``new_spec``, file name of
    the spec with the effects added.
    """
    drawn = [(caption, inline_svg(plots / f"{stem}.svg", stem)) for stem, caption in pictures]
    return template(TEMPLATE).render(
        d=diagnosis,
        name=name,
        headline=headline(diagnosis),
        summary=summary(diagnosis),
        effects=[_effect(one) for one in diagnosis.effects],
        places=[place_in_words(finding, diagnosis) for finding in diagnosis.where],
        remainder=None if diagnosis.remainder is None else place_in_words(diagnosis.remainder, diagnosis),
        nearest=[(in_words(one.name), f"{100.0 * one.share:.0f} %", one.why) for one in diagnosis.nearest],
        sure=sure(diagnosis),
        gaps=[_gap(gap) for gap in diagnosis.gaps],
        not_seen=[_not_seen(n, size, parameter) for n, (size, parameter) in diagnosis.not_seen.items()],
        pictures=drawn,
        new_spec=new_spec,
    )


def _effect(one: NamedEffect) -> dict[str, Any]:
    """What the page says of an effect."""
    kind = one.candidate.kind
    values = []
    for parameter in parameters(kind):
        value = one.parameters.get(parameter.name)
        if value is None or parameter.name in PARTS:
            continue
        text = with_uncertainty(value, one.uncertainty.get(parameter.name), sign_of(parameter.name))
        values.append((re.sub(r" \[.*\]$", "", parameter.text), text))
    size = one.parameters[one.candidate.size]
    return {
        "title": in_words(one.candidate.name) + which_part(one),
        "meaning": meaning_of(kind),
        "negative": size < 0.0,
        "parameters": values,
        "others": [in_words(n) for n in one.group[1:]],
        "elsewhere": [f"{which_part(other).strip(' ()')}, {size_in_words(other)}" for other in one.elsewhere],
        "separate_by": None if one.separate_by is None else in_words(one.separate_by),
        "odds": odds(one.evidence),
        "cures": [(in_words(n), cure_of(EFFECTS[n])) for n in one.group],
    }


def _gap(gap: FileGap) -> dict[str, Any]:
    def finite(value: float) -> float | None:
        return value if math.isfinite(value) else None

    return {
        "file": gap.recording.name,
        "kind": in_words(gap.recording.kind),
        "unit": SIGNS[gap.recording.unit],
        "rows": f"{gap.recording.rows.size} ({int(gap.recording.held_out.sum())} held out)",
        "noise": gap.noise,
        "fit_before": finite(gap.fit_before),
        "fit_after": finite(gap.fit_after),
        "held_before": finite(gap.held_out_before),
        "held_after": finite(gap.held_out_after),
        "closure": "–" if gap.closure is None else minus(f"{100.0 * min(gap.closure, 1.0):.1f} %"),
        "chi2": finite(gap.chi2_per_row),
    }


def _not_seen(name: str, size: float, parameter: str) -> tuple[str, str]:
    """An effect, and from what size on these files would have shown it."""
    known = next(p for p in parameters(EFFECTS[name]) if p.name == parameter)
    nothing = "these files do not show it"
    unit = sign_of(parameter)
    if parameter == "stiffness_nm_per_arcmin":
        # The size found is the compliance that is seen; stiffer than its reciprocal is not.
        seen = math.isfinite(size) and size > 0.0 and 1.0 / size > known.low
        return in_words(name), f"anything stiffer than {float(f'{1.0 / size:.2g}'):,.0f} {unit}" if seen else nothing
    if not math.isfinite(size) or size > known.high:
        return in_words(name), nothing
    return in_words(name), f"anything below {joined(f'{size:.2g}', unit)}"
