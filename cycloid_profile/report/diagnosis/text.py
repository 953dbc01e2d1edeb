"""A diagnosis in sentences: numbers with uncertainty and unit, effects, locations, verdict, confidence."""

from __future__ import annotations

import inspect
import math
import re
from typing import Literal

from cycloid_profile._display import with_unit
from cycloid_profile.diagnosis import FALSE_ALARM, Diagnosis, Finding, NamedEffect, SizedEffect
from cycloid_profile.effects import Effect, parameters
from cycloid_profile.report.page import Verdict, at_an_arm
from cycloid_profile.units import SIGNS, sign_of, unit_of

# Parameters that say which part has the effect.
PARTS = ("disc", "crank", "form", "lobe", "first_lobe", "pin", "planet", "flank")
_LEAST_P = 1e-300  # smaller ones are zero in double precision
_ANGLES = {"arcmin": 1.0, "arcsec": 60.0}  # units in an arc minute
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_CERTAIN = math.log(1e6)  # odds above a million to one mean no more than their logarithm
_UNCERTAINTY_FIGURES = 2  # GUM, 7.2.6


def minus(number: str) -> str:
    """The number with a true minus sign."""
    return number.replace("-", "−")


def with_uncertainty(value: float, sigma: float | None, unit: str) -> str:
    """A value rounded to two figures of its standard deviation ``sigma``."""
    if sigma is None or not math.isfinite(sigma) or sigma <= 0.0:
        return minus(with_unit(f"{value:.4g}", unit))
    decimals = min(max(_UNCERTAINTY_FIGURES - 1 - math.floor(math.log10(sigma)), 0), 6)
    number, error = minus(f"{value:.{decimals}f}"), f"{sigma:.{decimals}f}"
    close = with_unit("", unit) == unit
    return f"{number}{unit} ± {error}{unit}" if close else f"{number} ± {error} {unit}"


def odds(evidence: float) -> str:
    """How probable an effect is in words, from the logarithm of its odds against none."""
    if evidence > _CERTAIN:
        return "practically certain"
    if evidence < 0.0:
        return "less probable than none"
    ratio = float(f"{math.exp(evidence):.2g}")
    return f"{ratio:,.0f} to 1" if ratio >= 10.0 else f"{ratio:g} to 1"


def p_text(p: float) -> str:
    """Text of a p-value; an upper bound if it is below the smallest number."""
    if p < _LEAST_P:
        return "p below 10⁻³⁰⁰"
    if p >= 1e-3:
        return f"p = {p:.2g}"
    digits, power = f"{p:.1e}".split("e")
    return f"p = {digits}·10{str(int(power)).translate(_SUPERSCRIPT)}"


def readable(name: object) -> str:
    """A name without underscores."""
    return str(name).replace("_", " ")


def describe_effect(one: NamedEffect) -> str:
    """An effect with its part and size; the names of a group that the files cannot separate."""
    if len(one.group) > 1:
        return f"one of these, which the files cannot distinguish: {', '.join(readable(n) for n in one.group)}"
    place = part_text(one) + (" or at another location" if one.other_locations else "")
    return f"{readable(one.candidate.name)}{place}, {size_text(one)}"


def part_text(one: SizedEffect) -> str:
    """Disc, crank or lobe in brackets; empty where there is only one."""
    known = {p.name: p for p in parameters(one.candidate.kind)}
    texts = []
    for key in PARTS:
        if key in known and (key in one.candidate.choice or known[key].optional):
            value = one.parameters.get(key)
            if value is not None:
                texts.append(f"{readable(key)} {value:g}")
            elif key != "flank":  # both flanks are the rule
                texts.append(f"all {key}s")
    return f" ({', '.join(texts)})" if texts else ""


def size_text(one: SizedEffect) -> str:
    """Text of the size of an effect with uncertainty and unit."""
    name = one.candidate.size
    return with_uncertainty(one.parameters[name], one.uncertainty.get(name), sign_of(name))


def remedy_of(kind: type[Effect]) -> str:
    """The remedy in the description of an effect; empty where there is none."""
    return kind.remedy


def meaning_of(kind: type[Effect]) -> str:
    """The first sentence of the description of an effect."""
    first = " ".join((inspect.getdoc(kind) or "").split("\n\n")[0].split())
    return re.split(r"(?<=\.) (?=[A-Z])", first)[0]


def describe_place(finding: Finding, diagnosis: Diagnosis) -> str:
    """Location and size of a difference between measurement and simulation."""
    unit = SIGNS.get(finding.unit, finding.unit)
    size = with_unit(f"{abs(finding.amplitude):.2g}", unit)
    whole = {
        "waves per turn": f"a wave of {finding.start:g} per turn of the disc, amplitude {size}",
        "order": f"order {finding.start:g} per turn of the output, amplitude {size}",
        "file": f"the whole file, {size} rms",
    }.get(finding.coordinate)
    if whole is None:
        above = finding.amplitude > 0.0
        direction = f"measured {'above' if above else 'below'} predicted by"
        if finding.unit == "um":
            direction = "missing material," if above else "excess material,"
        whole = f"{_range(finding, diagnosis)}, {direction} {size} on average"
    return f"{whole} ({finding.file})"


def headline(diagnosis: Diagnosis) -> str:
    """The verdict in one sentence."""
    if diagnosis.effects:
        missing = "; and ".join(describe_effect(one) for one in diagnosis.effects)
        return f"The simulation lacks {missing}{_rest(diagnosis)}."
    if diagnosis.verdict == "unknown_effect":
        place = diagnosis.where[0] if diagnosis.where else diagnosis.remainder
        where = "" if place is None else f": {describe_place(place, diagnosis)}"
        return f"Measurement and simulation differ by something that is not in the library of effects{where}."
    if diagnosis.detection.significant:
        return "Measurement and simulation agree within the accuracy of the simulation."
    return "Measurement and simulation agree within the noise."


def _rest(diagnosis: Diagnosis) -> str:
    """What the effects leave; empty if it is noise."""
    if diagnosis.remainder is None:
        return ""
    if not diagnosis.within_model_error:
        return "; the residual holds a further effect that is not in the library"
    place = describe_place(diagnosis.remainder, diagnosis)
    return f"; the residual exceeds the noise, within the error of the model: {place}"


def diagnosis_verdict(diagnosis: Diagnosis) -> Verdict:
    """The headline with its colour."""
    kinds: dict[str, Literal["good", "found", "failed"]] = {
        "agrees": "good", "effects_found": "found", "unknown_effect": "failed"
    }  # fmt: skip
    return Verdict(headline(diagnosis), kinds[diagnosis.verdict])


def diagnosis_meaning(diagnosis: Diagnosis) -> list[str]:
    """The gap of each file in units of its noise, on rows that took no part in the fit, and angles as lengths."""
    sentences = []
    for gap in diagnosis.gaps:
        held = math.isfinite(gap.held_out_after)
        before, after = (gap.held_out_before, gap.held_out_after) if held else (gap.fit_before, gap.fit_after)
        rows = "rows that took no part in the fit differ" if held else "measurement and prediction differ"
        added = "; with the effects added, by" if diagnosis.effects else None
        first = f"{gap.recording.name}: {rows} by {before / gap.noise:#.3g} times the noise"
        sentences.append(f"{first}{added} {after / gap.noise:#.3g} times." if added else f"{first}.")
        if gap.recording.unit in _ANGLES:
            noise = with_unit(f"{gap.noise:.2g}", SIGNS[gap.recording.unit])
            sentences.append(f"Its noise of {noise} = {at_an_arm(gap.noise / _ANGLES[gap.recording.unit])}.")
    for one in diagnosis.effects:
        unit = unit_of(one.candidate.size)
        if unit in _ANGLES:
            size = at_an_arm(one.parameters[one.candidate.size] / _ANGLES[unit])
            sentences.append(f"{readable(one.candidate.name).capitalize()}, {size_text(one)}: {size}.")
    return sentences


def confidence(diagnosis: Diagnosis) -> list[str]:
    """p-values of the difference and of the residual, sentence by sentence."""
    noise = f"Noise alone causes such a difference with {p_text(diagnosis.detection.p_value)}"
    sentences = [f"{noise}; the alarm threshold is p = {FALSE_ALARM:g}."]
    left = p_text(diagnosis.residual_detection.p_value)
    if diagnosis.verdict == "agrees":
        if diagnosis.detection.significant:
            sentences.append("The difference exceeds the noise, but not the accuracy of the simulation.")
    elif diagnosis.effects:
        sentences.append(f"With the effects added, the residual has {left}: {_residual(diagnosis)}.")
        sentences.append(
            "The probability of an effect compares the data with and without it, and allows for the locations and "
            "sizes tried. It holds among the effects of the library only."
        )
    else:
        sentences.append(f"The best fit with the library leaves a residual with {left}.")
    return sentences


def _residual(diagnosis: Diagnosis) -> str:
    if not diagnosis.within_model_error:
        return "more than noise, and unexplained"
    if diagnosis.remainder is not None:
        return "more than noise, but within the error of the model"
    if diagnosis.residual_detection.significant:
        return "more than noise, but within the accuracy of the simulation"
    return "no more than noise"


def _range(finding: Finding, diagnosis: Diagnosis) -> str:
    start, end = finding.start, finding.end
    if finding.coordinate == "lobe":
        return _lobe_range(start, end, diagnosis.reducer.case.drive.trochoid.lobes)
    if finding.coordinate == "psi_deg":
        return f"ψ from {_rounded(start)}° to {_rounded(end)}° on all lobes"
    if finding.coordinate == "output_angle_deg":
        return f"output angle {start:.4g}° to {end:.4g}°"
    for gap in diagnosis.gaps:
        recording = gap.recording
        if finding.coordinate == "row" and recording.name == finding.file:
            rows = [int(start), int(end)]
            torque = " to ".join(_rounded(recording.measurement["torque_nm"][row - 1]) for row in rows)
            return f"rows {rows[0]} to {rows[1]}, torque {torque} N·m"
    return f"{readable(finding.coordinate)} {start:.4g} to {end:.4g}"


def _lobe_range(start: float, end: float, lobes: int) -> str:
    """A range of lobes, counted from 1, with ψ from −180° to 180° within a lobe."""
    if abs(end - start - 1.0) < 1e-9 and start == round(start):
        return f"lobe {start:.0f}"
    first, last = math.floor(start), math.ceil(end) - 1
    low, high = (f"{_rounded(360.0 * part - 180.0)}°" for part in (start - first, end - last))
    if first == last:
        return f"lobe {first}, ψ from {low} to {high}"
    return f"lobe {first} from ψ = {low} to lobe {min(last, lobes)} at ψ = {high}"


def _rounded(value: float) -> str:
    return minus(f"{value:.0f}")
