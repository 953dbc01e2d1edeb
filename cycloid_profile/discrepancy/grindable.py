"""Which effects grinding a disc takes away, and a sentence on each of the others."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from cycloid_profile.discrepancy.outcome import NamedEffect
from cycloid_profile.effects.effect import Effect, Place
from cycloid_profile.effects.registry import EFFECTS

_CAUTIONS = {
    "grinding_chatter": "a wave is cancelled only where it comes again in the same place: keep speed and clamping",
    "flank_wear": "wear is not made by the grinding machine: the correction suits regrinding, and wear will come again",
    "thermal_growth": "the correction suits discs ground at the same temperature",
    "single_tooth_error": "a slip or a hit need not come again: scan another disc before grinding by this program",
}


def grindable(effects: Iterable[NamedEffect], disc: int) -> tuple[tuple[NamedEffect, ...], tuple[str, ...]]:
    """Those to cancel, and a sentence on each of the others."""
    named, left = [], []
    for one in effects:
        doubts = [name for name in one.group if EFFECTS[name].place is not Place.FLANK]
        if one.candidate.kind.place is not Place.FLANK:
            left.append(_not_ground(one.candidate.name))
        elif not _of_disc(one.effect, disc):
            left.append(f"{one.candidate.name} is on another disc: scan and correct that one")
        elif doubts:
            by = f": measure {one.separate_by}" if one.separate_by else ""
            left.append(f"{one.candidate.name} may as well be {' or '.join(doubts)} and is not ground away{by}")
        else:
            named.append(one)
    return tuple(named), tuple(left)


def grindable_known(known: Sequence[Effect], disc: int) -> tuple[tuple[Effect, ...], tuple[str, ...]]:
    """The same of effects that the spec already held; those of other discs are passed over."""
    ground = tuple(one for one in known if one.place is Place.FLANK and _of_disc(one, disc))
    return ground, tuple(_not_ground(one.name) for one in known if one.place is not Place.FLANK)


def cautions(named: Sequence[NamedEffect], known: Sequence[Effect]) -> tuple[str, ...]:
    """What to mind when these are ground away."""
    names = [one.candidate.name for one in named] + [one.name for one in known]
    return (*dict.fromkeys(_CAUTIONS[name] for name in names if name in _CAUTIONS), *_alike(named))


def _alike(named: Iterable[NamedEffect]) -> list[str]:
    return [
        f"{one.candidate.name} may as well be {' or '.join(one.group[1:])}: "
        "the scan does not tell them apart, and the correction suits both"
        for one in named
        if len(one.group) > 1
    ]


def _not_ground(name: str) -> str:
    return f"{name} is no error of the flank ({EFFECTS[name].place.value}): grinding the disc does not take it away"


def _of_disc(effect: Effect, disc: int) -> bool:
    return getattr(effect, "disc", None) in (None, disc + 1)
