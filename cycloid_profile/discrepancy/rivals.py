"""What else a named effect could be: rivals that stand in its place as well, and the measurement that would tell."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from cycloid_profile.discrepancy.alias import always_alike, cosine
from cycloid_profile.discrepancy.candidates import Candidate, Variety
from cycloid_profile.discrepancy.evidence import ALIAS, estimate, linear_evidence
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.naming import Named
from cycloid_profile.discrepancy.normal import Normal, coordinates, normal
from cycloid_profile.discrepancy.optimum import Attempt, Optimum
from cycloid_profile.discrepancy.outcome import NamedEffect, Sized
from cycloid_profile.discrepancy.plan import separating_measurement

DISTINGUISHED = 4.5  # half chi²: three standard deviations between two explanations
_RESCORED_SWAPS = 4  # names, each of one disc and of all
_RESCORED_PLACES = 6  # of the same name
# Where few pins carry linear equations misjudge what loads other pins: more is judged by the exact model, which costs
# little at the one place of a loop.
_RESCORED_OF_LOOPS = 15
_PLACES_OF_LOOPS = 3
_REACH_OF_CURVES = 40.0  # half chi²
_STEPS = 4


def named_effects(
    found: Named, everything: ExactModel, final: Optimum, tell: Callable[[str], None]
) -> tuple[NamedEffect, ...]:
    """Members of the best set with sizes from all rows, and what could stand in place of each."""
    tell("what could stand in their place")
    best, state = found.best, everything.at(final)
    final = everything.with_noise_left(final)
    about = normal(state.blocks, found.library.candidates)
    told = []
    for i, member in enumerate(best.members):
        group = _group(found, about, i, tell)
        rivals = [c for c in group if c.name != member.name]
        # On the reducer with its effects: some of them show nothing in small about the drawing.
        by = separating_measurement(state.built, everything.recordings, member, rivals, tell)
        without = [c for j, c in enumerate(best.members) if j != i]
        told.append(
            NamedEffect(
                member,
                final.coordinates(i),
                final.covariance_of(i),
                tuple(dict.fromkeys([member.name, *(c.name for c in group)])),
                by,
                best.log_evidence - _evidence_of(found, without),
                _elsewhere(found, i, tell),
            )
        )
    return tuple(told)


def elsewhere_told(effects: Sequence[NamedEffect]) -> list[str]:
    """Sentences about places that might as well be others."""
    return [
        f"{one.candidate.name} may as well be {_words(other)}: these files do not tell"
        for one in effects
        for other in one.elsewhere
    ]


def _words(place: Sized) -> str:
    parts = [
        f"of all {key}s" if value is None else f"of {key.replace('_', ' ')} {value:g}"
        for key, value in place.candidate.choice.items()
    ]
    sizes = [f"{key} = {place.parameters[key]:.3g}" for key in place.uncertainty]
    return f"{', '.join(parts)} with {', '.join(sizes)}"


def turned_round(everything: ExactModel, final: Optimum) -> list[str]:
    """Sentences about angles that might as well be half a turn more."""
    found: dict[frozenset[str], str] = {}
    for members, other in final.turned_round():
        names = frozenset(member.name for member in members)
        if any(known <= names for known in found):
            continue
        state = everything.state(other.members, other.u)
        if state is not None and state.chi2 < final.chi2 + 2.0 * DISTINGUISHED:
            angles = " and ".join(f"{member.angle} of {member.name}" for member in members)
            together = " together" if len(members) > 1 else ""
            found[names] = f"{angles} may as well be 180° more{together}: these files do not tell"
    return list(found.values())


def _evidence_of(found: Named, members: Sequence[Candidate]) -> float:
    """Evidence of a set, exact if it was rescored, else linear about the best."""
    if not members:
        return 0.0
    wanted = {id(m) for m in members}
    for optimum in found.rescored:
        if {id(m) for m in optimum.members} == wanted:
            return optimum.log_evidence
    best, mine = (
        linear_evidence(found.equations, found.library.priors, found.library.places(some))
        for some in (found.best.members, members)
    )
    return found.best.log_evidence - best + mine


def _group(found: Named, about: Normal, member: int, tell: Callable[[str], None]) -> list[Candidate]:
    """Candidates of other names that could stand in place of a member: aliases, and sets as likely when rescored."""
    best, library = found.best, found.library
    mine = best.members[member]
    group: dict[str, Candidate] = {}
    (place,) = library.places([mine])
    for i, candidate in enumerate(library.candidates):
        if (
            candidate.name != mine.name
            and cosine(about, place, i) > ALIAS
            and always_alike(found.model.built, mine, candidate)
        ):
            group.setdefault(candidate.name, candidate)
    others = [m for j, m in enumerate(best.members) if j != member]
    for rescored in found.rescored:
        # What was fitted on the way to the best, and fits as well.
        rival = rescored.beside(others)
        if rival is None or rival.name == mine.name or rescored.implausible:
            continue
        if _fit_of(rescored) >= _fit_of(best) - DISTINGUISHED:
            group.setdefault(rival.name, rival)
    names, at_places, reach = _RESCORED_SWAPS, 1, DISTINGUISHED
    if found.model.only_loops:
        names, at_places, reach = _RESCORED_OF_LOOPS, _PLACES_OF_LOOPS, _REACH_OF_CURVES
    judged: list[tuple[int, float]] = []
    tried: Counter[Variety] = Counter()
    for i, less in swaps(found, member, reach):
        rival = library.candidates[i]
        if rival.name in group or tried[rival.variety] >= at_places:
            continue
        asked = {one for one, *_ in tried}
        if rival.name in asked or len(asked) < names:
            # The nearest rivals are judged by the exact model, the others by the linear one.
            tried[rival.variety] += 1
            judged.append((i, less))
        elif less < DISTINGUISHED:
            group[rival.name] = rival
    if judged:
        tell(f"could it be {', '.join(dict.fromkeys(library.candidates[i].name for i, _ in judged))}?")
    for (i, less), optimum in zip(judged, _swapped(found, member, judged), strict=True):
        if _stands(best, optimum, less):
            group.setdefault(library.candidates[i].name, library.candidates[i])
    return list(group.values())


def _elsewhere(found: Named, member: int, tell: Callable[[str], None]) -> tuple[Sized, ...]:
    """The same effect on other discs, cranks, lobes or pins, where the files allow that."""
    reach = DISTINGUISHED if found.model.only_scans else _REACH_OF_CURVES
    near = swaps(found, member, reach, elsewhere=True)[:_RESCORED_PLACES]
    if near:
        tell(f"could {found.best.members[member].name} be elsewhere?")
    standing = [
        optimum
        for (_, less), optimum in zip(near, _swapped(found, member, near), strict=True)
        if optimum is not None and _stands(found.best, optimum, less)
    ]
    return tuple(Sized(one.members[-1], one.coordinates(-1), one.covariance_of(-1)) for one in standing)


def _swapped(found: Named, member: int, rivals: Sequence[tuple[int, float]]) -> list[Optimum | None]:
    """The best set with a member replaced, each rival last, on the exact model."""
    others = [m for j, m in enumerate(found.best.members) if j != member]
    optima = []
    for i, less in rivals:
        members = (*others, found.library.candidates[i])
        known = [o for o in found.rescored if {id(m) for m in o.members} == {id(m) for m in members} and o.settled]
        # One that the linear model thinks worse need not be followed to its end once it is hopeless.
        beat = math.inf if less < DISTINGUISHED else found.best.misfit
        attempt = Attempt(members, found.start(members), steps=_STEPS, beat=beat)
        prior = found.library.prior(members)
        optima.append(_last(known[0], members[-1]) if known else found.model.optimum(attempt, prior))
    return optima


def _last(optimum: Optimum, member: Candidate) -> Optimum:
    """The same optimum with one of its members told last."""
    order = sorted(range(len(optimum.members)), key=lambda i: optimum.members[i] is member)
    where = coordinates(order)
    return replace(
        optimum,
        members=tuple(optimum.members[i] for i in order),
        u=optimum.u[where],
        covariance=optimum.covariance[np.ix_(where, where)],
        R=optimum.R[np.ix_(where, where)],
    )


def _stands(best: Optimum, rival: Optimum | None, less: float) -> bool:
    """Whether a rival that linear equations think worse by ``less`` fits as well; what was not fitted to the end and
    is no worse by them is not told apart.
    """
    if rival is None or rival.implausible or _fit_of(rival) < _fit_of(best) - DISTINGUISHED:
        return less < DISTINGUISHED and not (rival is not None and rival.settled)
    return True


def _fit_of(optimum: Optimum) -> float:
    """Minus half of chi² and prior of an exact optimum."""
    return -0.5 * optimum.misfit


def swaps(named: Named, member: int, reach: float = DISTINGUISHED, elsewhere: bool = False) -> list[tuple[int, float]]:
    """Candidates that could stand in place of a member of the best set, with what they fit worse (half chi²).

    Of other names, or of its own at other places if ``elsewhere``. Linear about the best set; implausible ones, and
    ones that fit worse by more than ``reach``, are left out.
    """
    library = named.library.candidates
    places = named.library.places(named.best.members)
    mine = places[member]
    others = [p for p in places if p != mine]
    base = _fit(named.equations, places)
    found = []
    for i, candidate in enumerate(library):
        if i in places or (candidate.name == library[mine].name) != elsewhere:
            continue
        members = [*others, i]
        less = base - _fit(named.equations, members)
        if less < reach:
            u, _ = estimate(named.equations, members)
            own = u[-2:]
            if float(np.hypot(*own)) * candidate.width <= candidate.implausible and not (
                candidate.one_sided and own[0] <= 0.0
            ):
                found.append((i, less))
    return sorted(found, key=lambda f: f[1])


def _fit(equations: Normal, members: Sequence[int]) -> float:
    """Half the fall of chi² by a set, its priors counted."""
    where = coordinates(members)
    u, _ = estimate(equations, members)
    return float(0.5 * u @ equations.b[where]) if len(members) else 0.0
