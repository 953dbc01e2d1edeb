"""Alternatives to a named effect: ambiguity group, other locations, and the measurement that separates them."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.model.candidate import Candidate, Variety
from cycloid_profile.diagnosis.model.evidence import ALIAS, estimate
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.optimum import Attempt, Optimum
from cycloid_profile.diagnosis.model.whitened import NormalEquations, coordinates, normal_equations
from cycloid_profile.diagnosis.planning.plan import separating_measurement
from cycloid_profile.diagnosis.search import on_other_parts
from cycloid_profile.diagnosis.search.search import SearchResult
from cycloid_profile.diagnosis.verdict._identical_effects import always_identical, cosine
from cycloid_profile.diagnosis.verdict.result import NamedEffect, SizedEffect

_RESCORED_PLACES = 6  # locations of the same effect
_PLACES_OF_LOOPS = 3  # places and shapes of one variety: on a loop they differ little
_REACH_OF_LOCATIONS = 40.0  # half chi²: other locations on curves that are this much worse are not fitted
_LISTED = 5  # names in a note or in a line of progress
_STEPS = 4  # of a replaced member, where linear equations decide if it needs more: the others start at their optimum


def named_effects(
    found: SearchResult, everything: ExactModel, final: Optimum, progress: Callable[[str], None]
) -> tuple[NamedEffect, ...]:
    """Members of the best set with sizes fitted to all rows, each with its alternatives."""
    progress("evaluating alternatives to the named effects")
    best, state = found.best, everything.at(final)
    final = everything.with_residual_noise(final)
    about_best = normal_equations(state.blocks, found.library.candidates)
    described = []
    for i, member in enumerate(best.members):
        group = ambiguity_group(found, about_best, i, progress)
        alternatives = [c for c in group if c.name != member.name]
        # Linearised on the reducer with its effects, because some effects vanish to first order about the nominal
        # geometry.
        by = separating_measurement(state.reducer, state.residuals, member, alternatives, progress)
        without = [c for j, c in enumerate(best.members) if j != i]
        described.append(
            NamedEffect(
                member,
                final.coordinates(i),
                final.covariance_of(i),
                tuple(dict.fromkeys([member.name, *(c.name for c in group)])),
                by,
                best.log_evidence - found.evidence(without),
                _at_other_locations(found, i, progress),
            )
        )
    return tuple(described)


def clear_effects(effects: Sequence[NamedEffect]) -> list[int]:
    """Numbers of the effects to name: those of small groups, else the one of the smallest.

    A further effect that many others could replace is a remainder: something is left, and the files do not show what.
    """
    sizes = [len(one.group) for one in effects]
    clear = [i for i, size in enumerate(sizes) if size <= tuned.LARGEST_GROUP]
    return clear or [sizes.index(min(sizes))]


def group_note(effect: NamedEffect) -> str:
    """Sentence on an effect that is not named because too many others fit as well."""
    some = ", ".join(effect.group[:_LISTED])
    fits = f"what is left fits any of {len(effect.group)} effects, among them {some}: these files do not separate them"
    return f"{fits}; measure {effect.separate_by}" if effect.separate_by else fits


def location_notes(effects: Sequence[NamedEffect]) -> list[str]:
    """One sentence for each other location that fits as well."""
    return [
        f"{one.candidate.name} {_location_text(other)} fits as well: these files do not separate them"
        for one in effects
        for other in one.other_locations
    ]


def _location_text(place: SizedEffect) -> str:
    parts = []
    for key, value in place.candidate.choice.items():
        text = value if isinstance(value, str) else f"{value:g}" if value is not None else ""
        parts.append(f"of all {key}s" if value is None else f"of {key.replace('_', ' ')} {text}")
    sizes = [f"{key} = {place.parameters[key]:.3g}" for key in place.uncertainty]
    return f"{', '.join(parts)} with {', '.join(sizes)}"


def rotation_notes(everything: ExactModel, final: Optimum) -> list[str]:
    """One sentence for each angle that fits as well when it is rotated by 180°."""
    found: dict[frozenset[str], str] = {}
    for members, other in final.rotated_by_180():
        names = frozenset(member.name for member in members)
        if any(known <= names for known in found):
            continue
        if _fits_there(everything, other, final):
            angles = " and ".join(f"{member.angle} of {member.name}" for member in members)
            together = " together" if len(members) > 1 else ""
            found[names] = f"{angles} plus 180°{together} fits as well: these files do not separate them"
    return list(found.values())


def sign_notes(everything: ExactModel, final: Optimum) -> list[str]:
    """One sentence for each size that fits as well with the opposite sign."""
    found = []
    for member, other in final.of_opposite_sign():
        if _fits_there(everything, other, final):
            size = f"{member.size} of {member.name}"
            found.append(f"{size} with the opposite sign fits as well: these files do not separate them")
    return found


def _fits_there(everything: ExactModel, other: Optimum, final: Optimum) -> bool:
    """Whether the coordinates of another optimum fit as well as the final ones, without a further fit."""
    state = everything.state(other.members, other.u)
    if state is None:
        return False
    there = replace(other, misfit=state.misfit_with_prior)
    return everything.deficit(there, final) < _distinguished(final)


def ambiguity_group(
    found: SearchResult, about_best: NormalEquations, member: int, progress: Callable[[str], None]
) -> list[Candidate]:
    """Ambiguity group: aliases, and candidates of other names that fit as well in place of a member."""
    best, library = found.best, found.library
    mine = best.members[member]
    group: dict[str, Candidate] = {}
    (place,) = library.places([mine])
    for i, candidate in enumerate(library.candidates):
        if (
            candidate.name != mine.name
            and cosine(about_best, place, i) > ALIAS
            and always_identical(found.model.reducer, mine, candidate)
        ):
            group.setdefault(candidate.name, candidate)
    others = [m for j, m in enumerate(best.members) if j != member]
    for rescored in found.fitted:
        # Sets fitted during the search also belong to the group if they fit as well.
        alternative = rescored.remaining_member(others)
        if alternative is None or alternative.name == mine.name or rescored.implausible:
            continue
        if _fit_of(rescored) >= _fit_of(best) - _distinguished(best):
            group.setdefault(alternative.name, alternative)
    # The exact model decides. Linear equations say where to look, and where fits of loops end early which names remain.
    at_places, reach, loops = 1, tuned.DISTINGUISHED, found.model.only_loops
    if loops:
        # With few pins in contact, linear equations misjudge effects that load further pins. A loop has one pose: the
        # exact model is cheap, and tries every name of plausible size there.
        at_places, reach = _PLACES_OF_LOOPS, math.inf
    evaluated: list[tuple[int, float]] = []
    tried: Counter[Variety] = Counter()
    for i, deficit in swaps(found, member, reach):
        alternative = library.candidates[i]
        if alternative.name in group or tried[alternative.variety] >= at_places:
            continue
        tried[alternative.variety] += 1
        evaluated.append((i, deficit if loops else math.inf))
    if evaluated:
        asked = list(dict.fromkeys(library.candidates[i].name for i, _ in evaluated))
        more = ", …" if len(asked) > _LISTED else ""
        progress(f"alternatives: {', '.join(asked[:_LISTED])}{more}")
    for (i, deficit), optimum in zip(evaluated, _swapped(found, member, evaluated, {}), strict=True):
        if _fits_as_well(best, optimum, deficit):
            group.setdefault(library.candidates[i].name, library.candidates[i])
    return list(group.values())


def _at_other_locations(found: SearchResult, member: int, progress: Callable[[str], None]) -> tuple[SizedEffect, ...]:
    """The same effect on other discs, cranks, lobes or pins that fits as well.

    Linear equations propose them. About a large effect they miss equivalent parts, which are tried as well.
    """
    scans, best = found.model.only_scans, found.best
    reach = tuned.DISTINGUISHED if scans else _REACH_OF_LOCATIONS
    linear = dict(swaps(found, member, reach, other_locations=True))
    (mine,), u = best.part([member])
    moved = [] if scans else on_other_parts(found.library, replace(best, members=(mine,), u=u), found.model.reducer)
    starts = {place: start for (place,), start in moved if found.library.candidates[place] != mine}
    tried = dict.fromkeys([*list(linear)[:_RESCORED_PLACES], *starts])
    near = [(place, linear.get(place, math.inf)) for place in tried]
    if near:
        progress(f"other locations of {mine.name}")
    standing = [
        optimum
        for (_, deficit), optimum in zip(near, _swapped(found, member, near, starts), strict=True)
        if optimum is not None and _fits_as_well(best, optimum, deficit)
    ]
    return tuple(SizedEffect(one.members[-1], one.coordinates(-1), one.covariance_of(-1)) for one in standing)


def _swapped(
    found: SearchResult,
    member: int,
    alternatives: Sequence[tuple[int, float]],
    starts: Mapping[int, FloatArray],
) -> list[Optimum | None]:
    """The best set with one member replaced by each alternative, the alternative last, on the exact model.

    Each fit begins at its entry in ``starts``, else where linear equations say. Of each alternative its number and its
    deficit in linear equations, infinite where these do not decide.
    """
    others, u = found.best.part([j for j in range(len(found.best.members)) if j != member])
    optima = []
    for i, deficit in alternatives:
        members = (*others, found.library.candidates[i])
        known = [o for o in found.fitted if set(o.members) == set(members) and o.converged]
        # An alternative that fits worse in linear equations is abandoned as soon as it cannot reach the best set.
        beat = math.inf if deficit < tuned.DISTINGUISHED else found.best.misfit
        start = np.concatenate([u, starts[i]]) if i in starts else found.start(members)
        steps = _STEPS if math.isfinite(deficit) else Attempt.steps
        attempt = Attempt(members, start, steps, beat, least_gain=tuned.LEAST_GAIN)
        prior = found.library.prior(members)
        optima.append(_member_last(known[0], members[-1]) if known else found.model.optimum(attempt, prior))
    return optima


def _member_last(optimum: Optimum, member: Candidate) -> Optimum:
    """The same optimum with ``member`` moved to the last position."""
    order = sorted(range(len(optimum.members)), key=lambda i: optimum.members[i] == member)
    where = coordinates(order)
    return replace(
        optimum,
        members=tuple(optimum.members[i] for i in order),
        u=optimum.u[where],
        covariance=optimum.covariance[np.ix_(where, where)],
        R=optimum.R[np.ix_(where, where)],
    )


def _fits_as_well(best: Optimum, alternative: Optimum | None, deficit: float) -> bool:
    """Whether an alternative fits as well as the best set; ``deficit`` is its deficit in linear equations, half chi².

    An alternative whose fit did not converge counts as equal if its linear deficit is below ``DISTINGUISHED``.
    """
    if alternative is None or alternative.implausible or _fit_of(alternative) < _fit_of(best) - _distinguished(best):
        return deficit < tuned.DISTINGUISHED and not (alternative is not None and alternative.converged)
    return True


def _distinguished(best: Optimum) -> float:
    """Half chi² between the best set and one that fits clearly worse, where the best leaves more than noise."""
    return tuned.DISTINGUISHED * best.residual_variance


def _fit_of(optimum: Optimum) -> float:
    """Minus half of chi² and prior term at an exact optimum."""
    return -0.5 * optimum.misfit


def swaps(
    named: SearchResult, member: int, reach: float = tuned.DISTINGUISHED, other_locations: bool = False
) -> list[tuple[int, float]]:
    """Candidates that could replace a member of the best set, each with its deficit (half chi²), smallest first.

    Candidates of other names, or of the same name at other locations if ``other_locations``. The equations are linear
    about the best set. Implausible candidates and deficits of ``reach`` or more are omitted.
    """
    library = named.library.candidates
    places = named.library.places(named.best.members)
    mine = places[member]
    others = [p for p in places if p != mine]
    base = _fit(named.equations, places)
    found = []
    for i, candidate in enumerate(library):
        if i in places or candidate.is_change != library[mine].is_change:
            continue
        if (candidate.name == library[mine].name) != other_locations:
            continue
        members = [*others, i]
        deficit = base - _fit(named.equations, members)
        if deficit < reach:
            u, _ = estimate(named.equations, members)
            own = u[-2:]
            if float(np.hypot(*own)) * candidate.width <= candidate.implausible and not (
                candidate.one_sided and own[0] <= 0.0
            ):
                found.append((i, deficit))
    return sorted(found, key=lambda f: f[1])


def _fit(equations: NormalEquations, members: Sequence[int]) -> float:
    """Half the reduction of chi² by a set, including the prior term."""
    where = coordinates(members)
    u, _ = estimate(equations, members)
    return float(0.5 * u @ equations.b[where]) if len(members) else 0.0
