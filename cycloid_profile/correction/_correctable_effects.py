"""Selection of the effects that grinding a disc can correct, with a reason for each of the others."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from cycloid_profile.diagnosis import NamedEffect
from cycloid_profile.effects import EFFECTS, Effect, EffectLocation, Empirical

_CAUTIONS = {
    "grinding_chatter": "a wave is cancelled only if it recurs at the same place: keep speed and clamping",
    "flank_wear": "the grinding machine does not cause wear: the correction suits regrinding, and wear will recur",
    "thermal_growth": "the correction is valid for discs ground at the same temperature",
    "form_deviation": "the form has no known cause: scan another disc before grinding with this program",
    "single_tooth_error": "a slip or a hit may not recur: scan another disc before grinding with this program",
}


def correctable(effects: Iterable[NamedEffect], disc: int) -> tuple[tuple[NamedEffect, ...], tuple[str, ...]]:
    """Named effects that grinding corrects, and a sentence on each of the others."""
    named, not_ground_away = [], []
    for one in effects:
        doubts = [name for name in one.group if EFFECTS[name].location is not EffectLocation.FLANK]
        if one.candidate.kind.location is not EffectLocation.FLANK:
            not_ground_away.append(_not_correctable_reason(one.candidate.name, one.candidate.kind.location))
        elif not _of_disc(one.effect, disc):
            not_ground_away.append(f"{one.candidate.name} is on another disc: scan and correct that one")
        elif doubts:
            by = f": measure {one.separate_by}" if one.separate_by else ""
            not_ground_away.append(
                f"{one.candidate.name} is not separated from {' or '.join(doubts)} and is not corrected by grinding{by}"
            )
        else:
            named.append(one)
    return tuple(named), tuple(not_ground_away)


def correctable_known(
    known: Sequence[Effect | Empirical], disc: int
) -> tuple[tuple[Effect | Empirical, ...], tuple[str, ...]]:
    """The same for effects of the spec; those of other discs are ignored."""
    flank_effects = tuple(one for one in known if one.location is EffectLocation.FLANK and _of_disc(one, disc))
    others = (one for one in known if one.location is not EffectLocation.FLANK)
    return flank_effects, tuple(_not_correctable_reason(one.name, one.location) for one in others)


def cautions(named: Sequence[NamedEffect], known: Sequence[Effect | Empirical]) -> tuple[str, ...]:
    """Conditions under which a correction of these effects is valid."""
    names = [one.candidate.name for one in named] + [one.name for one in known]
    return (*dict.fromkeys(_CAUTIONS[name] for name in names if name in _CAUTIONS), *_indistinguishable(named))


def _indistinguishable(named: Iterable[NamedEffect]) -> list[str]:
    return [
        f"{one.candidate.name} is not separated from {' or '.join(one.group[1:])} by the scan: "
        "the correction is the same for both"
        for one in named
        if len(one.group) > 1
    ]


def _not_correctable_reason(name: str, location: EffectLocation) -> str:
    return f"{name} is not a flank error ({location.value}): grinding the disc does not remove it"


def _of_disc(effect: Effect | Empirical, disc: int) -> bool:
    return getattr(effect, "disc", None) in (None, disc + 1)
