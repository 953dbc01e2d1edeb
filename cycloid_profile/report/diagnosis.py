"""A diagnosis as one self-contained HTML page: what differs, where, what it is, how sure, what to do."""

from __future__ import annotations

import inspect
import math
import re
from pathlib import Path
from typing import Any

from cycloid_profile.discrepancy.detection import FALSE_ALARM, Finding
from cycloid_profile.discrepancy.diagnosis import Diagnosis, FileGap, NamedEffect
from cycloid_profile.discrepancy.told import SHOWN, unit_of
from cycloid_profile.effects.effect import Effect, parameters
from cycloid_profile.effects.registry import EFFECTS
from cycloid_profile.report.page import inline_svg, template

TEMPLATE = "diagnosis.html.j2"

_LEAST_P = 1e-300
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PARTS = ("disc", "crank", "form", "lobe", "first_lobe", "pin", "planet", "flank")
_UNCERTAINTY_FIGURES = 2
_CLOSE = ("", "°", "′", "″")


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
        summary=_summary(diagnosis),
        effects=[_effect(one) for one in diagnosis.effects],
        places=[place_in_words(finding, diagnosis) for finding in diagnosis.where],
        remainder=None if diagnosis.remainder is None else place_in_words(diagnosis.remainder, diagnosis),
        nearest=[(in_words(one.name), f"{100.0 * one.share:.0f} %", one.why) for one in diagnosis.nearest],
        sure=_sure(diagnosis),
        gaps=[_gap(gap) for gap in diagnosis.gaps],
        not_seen=[_not_seen(n, size, parameter) for n, (size, parameter) in diagnosis.not_seen.items()],
        pictures=drawn,
        new_spec=new_spec,
    )


def headline(diagnosis: Diagnosis) -> str:
    """The verdict in one sentence."""
    if diagnosis.effects:
        named = "; and ".join(_named(one) for one in diagnosis.effects)
        rest = ". Something more is left that is not in the library" if diagnosis.remainder else ""
        return f"The simulation lacks {named}{rest}."
    if diagnosis.verdict == "unknown_effect":
        place = diagnosis.where[0] if diagnosis.where else diagnosis.remainder
        where = "" if place is None else f": {place_in_words(place, diagnosis)}"
        return f"Measurement and simulation differ by something that is not in the library of effects{where}."
    if diagnosis.detection.significant:
        return "Measurement and simulation agree as closely as the simulation can be trusted."
    return "Measurement and simulation agree within the noise."


def in_words(name: str) -> str:
    """Name of an effect without underscores."""
    return name.replace("_", " ")


def cure_of(kind: type[Effect]) -> str:
    """What to do on the machine, from the description of the effect; empty where it says nothing."""
    text = " ".join((inspect.getdoc(kind) or "").split())
    found = re.search(r"Cure: (.+?)\.(?: |$)", text)
    return found[1] if found else ""


def meaning_of(kind: type[Effect]) -> str:
    """The first sentence of the description."""
    first = " ".join((inspect.getdoc(kind) or "").split("\n\n")[0].split())
    return re.split(r"(?<=\.) (?=[A-Z])", first)[0]


def place_in_words(finding: Finding, diagnosis: Diagnosis) -> str:
    """Where a finding is and how large, in words."""
    unit = SHOWN.get(finding.unit, finding.unit)
    size = _joined(f"{abs(finding.amplitude):.2g}", unit)
    start = finding.start
    if finding.coordinate == "waves per turn":
        text = f"a wave of {start:g} per turn of the disc, amplitude {size}"
    elif finding.coordinate == "order":
        text = f"order {start:g} per turn of the output, amplitude {size}"
    elif finding.coordinate == "file":
        text = f"all over the file, {size} rms"
    else:
        text = f"{_range_in_words(finding, diagnosis)}, {_signed(finding)} {size} in the mean"
    return f"{text} ({finding.file})"


def _signed(finding: Finding) -> str:
    if finding.unit == "um":
        return "material missing," if finding.amplitude > 0.0 else "material standing out,"
    return "measured above predicted by" if finding.amplitude > 0.0 else "measured below predicted by"


def _range_in_words(finding: Finding, diagnosis: Diagnosis) -> str:
    start, end = finding.start, finding.end
    if finding.coordinate == "lobe":
        lobes = diagnosis.built.case.drive.trochoid.lobes
        if abs(end - start - 1.0) < 1e-9 and start == round(start):
            return f"lobe {start:.0f}"
        first, last = math.floor(start), math.ceil(end) - 1
        low, high = 360.0 * (start - first) - 180.0, 360.0 * (end - last) - 180.0
        if first == last:
            return f"lobe {first}, ψ from {_degrees(low)} to {_degrees(high)}"
        return f"lobe {first} from ψ = {_degrees(low)} to lobe {min(last, lobes)} at ψ = {_degrees(high)}"
    if finding.coordinate == "psi_deg":
        return f"ψ from {_degrees(start)} to {_degrees(end)} on all lobes"
    if finding.coordinate == "output_angle_deg":
        return f"output angle {start:.4g}° to {end:.4g}°"
    for gap in diagnosis.gaps:
        recording = gap.recording
        if finding.coordinate == "row" and recording.name == finding.file:
            rows = [recording.rows[min(max(int(at), 0), recording.rows.size - 1)] for at in (start, end)]
            torque = recording.measurement["torque_nm"][rows]
            return f"rows {rows[0] + 1} to {rows[1] + 1}, torque {_torque(torque[0])} to {_torque(torque[1])} N·m"
    return f"{in_words(finding.coordinate)} {start:.4g} to {end:.4g}"


def _degrees(value: float) -> str:
    return f"{value:.0f}°".replace("-", "−")


def _torque(value: float) -> str:
    return f"{value:.0f}".replace("-", "−")


def _summary(diagnosis: Diagnosis) -> str:
    """What follows the verdict: the gap on rows that took no part."""
    told = []
    for gap in diagnosis.gaps:
        after = gap.held_out_after / gap.noise
        if not math.isfinite(after):
            continue
        if diagnosis.effects:
            before = gap.held_out_before / gap.noise
            told.append(f"{gap.recording.name} from {before:#.3g} to {after:#.3g}")
        else:
            told.append(f"{gap.recording.name} {after:#.3g}")
    if not told:
        return ""
    first = "On rows held out, the rms in units of the noise goes: " if diagnosis.effects else (
        "On rows held out, the rms in units of the noise: "
    )  # fmt: skip
    return first + ", ".join(told) + "."


def _named(one: NamedEffect) -> str:
    """An effect with its size; of a group, that it is one of these."""
    if len(one.group) > 1:
        return f"one of these, which the files cannot tell apart: {', '.join(in_words(n) for n in one.group)}"
    return f"{in_words(one.candidate.name)}{_choice(one)}, {_size(one)}"


def _choice(one: NamedEffect) -> str:
    told = []
    known = {p.name: p for p in parameters(one.candidate.kind)}
    for key in _PARTS:
        if key in known and (key in one.candidate.choice or known[key].optional):
            value = one.parameters.get(key)
            told.append(f"all {key}s" if value is None else f"{in_words(key)} {value:g}")
    return f" ({', '.join(told)})" if told else ""


def _size(one: NamedEffect) -> str:
    name = one.candidate.size
    return with_uncertainty(one.parameters[name], one.uncertainty.get(name), _unit(name))


def _unit(parameter: str) -> str:
    if parameter.endswith("_deg"):
        return "°"
    unit = unit_of(parameter)
    return SHOWN.get(unit, unit)


def with_uncertainty(value: float, sigma: float | None, unit: str) -> str:
    """A value with as many decimals as its standard deviation leaves meaning."""
    if sigma is None or not math.isfinite(sigma) or sigma <= 0.0:
        return _joined(f"{value:.4g}", unit).replace("-", "−")
    decimals = min(max(_UNCERTAINTY_FIGURES - 1 - math.floor(math.log10(sigma)), 0), 6)
    number = f"{value:.{decimals}f}".replace("-", "−")
    if unit in _CLOSE:
        return f"{number}{unit} ± {sigma:.{decimals}f}{unit}"
    return f"{number} ± {sigma:.{decimals}f} {unit}".strip()


def _joined(number: str, unit: str) -> str:
    """A number with its unit; signs of angles stand close."""
    return f"{number}{unit}" if unit in _CLOSE else f"{number} {unit}"


def _effect(one: NamedEffect) -> dict[str, Any]:
    """What the page says of an effect."""
    kind = one.candidate.kind
    values = []
    for parameter in parameters(kind):
        value = one.parameters.get(parameter.name)
        if value is None or parameter.name in _PARTS:
            continue
        text = with_uncertainty(value, one.uncertainty.get(parameter.name), _unit(parameter.name))
        values.append((re.sub(r" \[.*\]$", "", parameter.text), text))
    size = one.parameters[one.candidate.size]
    return {
        "title": in_words(one.candidate.name) + _choice(one),
        "meaning": meaning_of(kind),
        "negative": size < 0.0,
        "parameters": values,
        "others": [in_words(n) for n in one.group[1:]],
        "separate_by": None if one.separate_by is None else in_words(one.separate_by),
        "odds": odds(one.evidence),
        "cures": [(in_words(n), cure_of(EFFECTS[n])) for n in one.group],
    }


def odds(evidence: float) -> str:
    """ln of odds in words."""
    if evidence < 0.0:
        return f"e^{evidence:.0f} : 1".replace("-", "−")
    return f"e^{evidence:,.0f} : 1"


def p_in_words(p: float) -> str:
    """A p-value as it is printed; what underflows is an upper bound."""
    if p < _LEAST_P:
        return "p below 10⁻³⁰⁰"
    if p >= 1e-3:
        return f"p = {p:.2g}"
    digits, power = f"{p:.1e}".split("e")
    return f"p = {digits}·10{str(int(power)).translate(_RAISED)}"


def _sure(diagnosis: Diagnosis) -> list[str]:
    """How sure it is, sentence by sentence."""
    before = p_in_words(diagnosis.detection.p_value)
    alarm = f"an alarm is raised below p = {FALSE_ALARM:g}"
    if diagnosis.verdict == "agrees":
        both = f"Noise alone would make as much with {before}; {alarm}."
        if diagnosis.detection.significant:
            both += " It is more than noise, but smaller than the simulation can be trusted for."
        return [both]
    said = [f"That measurement and simulation differ: noise alone would do it with {before}; {alarm}."]
    left = diagnosis.left
    if diagnosis.effects:
        said.append(f"With the effects added, what is left has {p_in_words(left.p_value)}: {_left(diagnosis)}.")
        said.append(
            "Odds compare the data with and without an effect, places and sizes it could have had paid for. "
            "They hold among the effects of the library; no odds exist for what is not in it."
        )
    else:
        said.append(f"The best that the library offers still leaves {p_in_words(left.p_value)}.")
    return said


def _left(diagnosis: Diagnosis) -> str:
    if not diagnosis.left.significant:
        return "no more than noise"
    if diagnosis.remainder is not None:
        return "more than noise, and not explained"
    if diagnosis.left.striking:
        return "more than noise, but less than a twentieth of the first gap; it is not named"
    return "more than noise, but smaller than the simulation can be trusted for"


def _gap(gap: FileGap) -> dict[str, Any]:
    def finite(value: float) -> float | None:
        return value if math.isfinite(value) else None

    return {
        "file": gap.recording.name,
        "kind": in_words(gap.recording.kind),
        "unit": SHOWN[gap.recording.unit],
        "rows": f"{gap.recording.rows.size} ({int(gap.recording.held_out.sum())} held out)",
        "noise": gap.noise,
        "fit_before": finite(gap.fit_before),
        "fit_after": finite(gap.fit_after),
        "held_before": finite(gap.held_out_before),
        "held_after": finite(gap.held_out_after),
        "closure": "–" if gap.closure is None else f"{100.0 * min(gap.closure, 1.0):.1f} %".replace("-", "−"),
        "chi2": finite(gap.chi2_per_row),
    }


def _not_seen(name: str, size: float, parameter: str) -> tuple[str, str]:
    """An effect, and from what size on these files would have shown it."""
    known = next(p for p in parameters(EFFECTS[name]) if p.name == parameter)
    nothing = "these files do not show it"
    unit = _unit(parameter)
    if parameter == "stiffness_nm_per_arcmin":
        # The size found is the compliance that is seen; stiffer than its reciprocal is not.
        seen = math.isfinite(size) and size > 0.0 and 1.0 / size > known.low
        return in_words(name), f"anything stiffer than {float(f'{1.0 / size:.2g}'):,.0f} {unit}" if seen else nothing
    if not math.isfinite(size) or size > known.high:
        return in_words(name), nothing
    return in_words(name), f"anything below {_joined(f'{size:.2g}', unit)}"
