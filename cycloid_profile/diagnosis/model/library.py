"""Hypotheses of a search with their prior probabilities."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.evidence import log_priors


@dataclass(frozen=True, eq=False)
class Library:
    """``candidates``; chatter among them can have any of ``frequencies`` numbers of waves."""

    candidates: tuple[Candidate, ...]
    frequencies: int

    @cached_property
    def priors(self) -> FloatArray:
        """Log prior of each candidate, shape (candidates,)."""
        return log_priors(self.candidates, frequencies=self.frequencies)

    def with_more(self, more: Sequence[Candidate]) -> Library:
        """The library extended by candidates it does not have; existing indices are unchanged."""
        fresh = [one for one in dict.fromkeys(more) if one not in self._numbers]
        return Library((*self.candidates, *fresh), self.frequencies) if fresh else self

    def places(self, members: Sequence[Candidate]) -> list[int]:
        """Indices of candidates."""
        return [self._numbers[member] for member in members]

    def members(self, places: Sequence[int]) -> tuple[Candidate, ...]:
        """Candidates of indices."""
        return tuple(self.candidates[i] for i in places)

    def prior(self, members: Sequence[Candidate]) -> float:
        """Sum of the log priors of members."""
        return float(sum(self.priors[self.places(members)]))

    def where(self, name: str, choice: Mapping[str, Any]) -> Candidate | None:
        """The candidate of a name with this choice of parts, None if absent."""
        return self._by_choice.get((name, _key(choice)))

    @cached_property
    def names(self) -> frozenset[str]:
        """Names of the effects."""
        return frozenset(candidate.name for candidate in self.candidates)

    def of_name(self, name: str) -> list[int]:
        """Indices of an effect at all its locations."""
        return [i for i, candidate in enumerate(self.candidates) if candidate.name == name]

    @cached_property
    def _by_choice(self) -> dict[tuple[str, tuple[tuple[str, Any], ...]], Candidate]:
        return {(candidate.name, _key(candidate.choice)): candidate for candidate in self.candidates}

    @cached_property
    def _numbers(self) -> dict[Candidate, int]:
        return {candidate: i for i, candidate in enumerate(self.candidates)}


def _key(choice: Mapping[str, Any]) -> tuple[tuple[str, Any], ...]:
    return tuple(sorted(choice.items()))
