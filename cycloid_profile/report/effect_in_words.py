"""An effect as a sentence names it: without underscores, which part, how large, what it means and cures it."""

from __future__ import annotations

import inspect
import re

from cycloid_profile.discrepancy.outcome import NamedEffect, Sized
from cycloid_profile.effects.effect import Effect, parameters
from cycloid_profile.report.number_in_words import with_uncertainty
from cycloid_profile.units import sign_of

PARTS = ("disc", "crank", "form", "lobe", "first_lobe", "pin", "planet", "flank")


def in_words(name: str) -> str:
    """Name of an effect without underscores."""
    return name.replace("_", " ")


def effect_in_words(one: NamedEffect) -> str:
    """An effect with its size; of a group, that it is one of these."""
    if len(one.group) > 1:
        return f"one of these, which the files cannot tell apart: {', '.join(in_words(n) for n in one.group)}"
    place = which_part(one) + (" or elsewhere" if one.elsewhere else "")
    return f"{in_words(one.candidate.name)}{place}, {size_in_words(one)}"


def which_part(one: Sized) -> str:
    """Which disc, crank or lobe, in brackets; empty where there is one only."""
    told = []
    known = {p.name: p for p in parameters(one.candidate.kind)}
    for key in PARTS:
        if key in known and (key in one.candidate.choice or known[key].optional):
            value = one.parameters.get(key)
            told.append(f"all {key}s" if value is None else f"{in_words(key)} {value:g}")
    return f" ({', '.join(told)})" if told else ""


def size_in_words(one: Sized) -> str:
    """Size with its uncertainty and unit."""
    name = one.candidate.size
    return with_uncertainty(one.parameters[name], one.uncertainty.get(name), sign_of(name))


def cure_of(kind: type[Effect]) -> str:
    """What to do on the machine, from the description of the effect; empty where it says nothing."""
    text = " ".join((inspect.getdoc(kind) or "").split())
    found = re.search(r"Cure: (.+?)\.(?: |$)", text)
    return found[1] if found else ""


def meaning_of(kind: type[Effect]) -> str:
    """The first sentence of the description."""
    first = " ".join((inspect.getdoc(kind) or "").split("\n\n")[0].split())
    return re.split(r"(?<=\.) (?=[A-Z])", first)[0]
