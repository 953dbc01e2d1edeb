"""What a diagnosis found, how far the gap closed, and how sure that is, in sentences."""

from __future__ import annotations

import math

from cycloid_profile.discrepancy.detection import FALSE_ALARM
from cycloid_profile.discrepancy.outcome import Diagnosis
from cycloid_profile.report.effect_in_words import effect_in_words
from cycloid_profile.report.number_in_words import p_in_words
from cycloid_profile.report.place_in_words import place_in_words


def headline(diagnosis: Diagnosis) -> str:
    """The verdict in one sentence."""
    if diagnosis.effects:
        lacking = "; and ".join(effect_in_words(one) for one in diagnosis.effects)
        rest = ". Something more is left that is not in the library" if diagnosis.remainder else ""
        return f"The simulation lacks {lacking}{rest}."
    if diagnosis.verdict == "unknown_effect":
        place = diagnosis.where[0] if diagnosis.where else diagnosis.remainder
        where = "" if place is None else f": {place_in_words(place, diagnosis)}"
        return f"Measurement and simulation differ by something that is not in the library of effects{where}."
    if diagnosis.detection.significant:
        return "Measurement and simulation agree as closely as the simulation can be trusted."
    return "Measurement and simulation agree within the noise."


def summary(diagnosis: Diagnosis) -> str:
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


def sure(diagnosis: Diagnosis) -> list[str]:
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
