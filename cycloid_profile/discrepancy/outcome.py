"""What came out of a diagnosis: verdict, named effects, places, gaps before and after."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.candidates import Candidate
from cycloid_profile.discrepancy.detection import Detection, Finding
from cycloid_profile.discrepancy.laid import Laid
from cycloid_profile.discrepancy.nearest import Near
from cycloid_profile.discrepancy.recording import Recording
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.effect import Effect


@dataclass(frozen=True, eq=False)
class Sized:
    """A ``candidate`` with its ``coordinates`` and their covariance."""

    candidate: Candidate
    coordinates: FloatArray
    covariance: FloatArray

    @property
    def effect(self) -> Effect:
        """The effect."""
        found = self.candidate.effect(self.coordinates)
        assert found is not None
        return found

    @property
    def parameters(self) -> dict[str, Any]:
        """Its parameters."""
        return self.candidate.parameters(self.coordinates)

    @property
    def uncertainty(self) -> dict[str, float]:
        """Standard deviation of size and angle."""
        return self.candidate.uncertainty(self.coordinates, self.covariance)


@dataclass(frozen=True, eq=False)
class NamedEffect(Sized):
    """An effect that was found.

    ``group``, names that the data cannot tell from it, itself first; ``separate_by`` the measurement that would;
    ``evidence`` ln of how much less likely the data are without it; ``elsewhere``, the same effect at other places that
    the data cannot tell from its own.
    """

    group: tuple[str, ...]
    separate_by: str | None
    evidence: float
    elsewhere: tuple[Sized, ...] = ()


@dataclass(frozen=True, eq=False)
class FileGap:
    """A recording before and after, rows to fit and rows held out: root mean squares in its unit, chi² per row after.

    ``before`` and ``after`` are the recording laid on the reducer of the spec and on the one with the effects.
    """

    recording: Recording
    before: Laid
    after: Laid
    fit_before: float
    fit_after: float
    held_out_before: float
    held_out_after: float
    chi2_per_row: float

    @property
    def noise(self) -> float:
        """Standard deviation of the noise."""
        return self.recording.noise.sigma

    @property
    def closure(self) -> float | None:
        """Share of the gap beyond the noise that is gone on held-out rows; None where there was hardly any."""
        noise2 = self.noise**2
        gap = self.held_out_before**2 - noise2
        if gap < noise2:
            return None
        return 1.0 - (self.held_out_after**2 - noise2) / gap


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What came out: ``verdict`` is ``agrees``, ``effects_found`` or ``unknown_effect``.

    ``detection`` before and ``left`` after; ``where``, the striking places before; ``remainder``, what the named
    effects leave, or None; ``nearest``, for an unknown effect, effects of the library that come nearest and why
    each is not the answer; ``not_seen``, smallest detectable size of every effect with the name of its
    parameter.
    """

    built: Built
    corrected: Built
    verdict: str
    effects: tuple[NamedEffect, ...]
    detection: Detection
    left: Detection
    where: tuple[Finding, ...]
    remainder: Finding | None
    nearest: tuple[Near, ...]
    not_seen: dict[str, tuple[float, str]]
    gaps: tuple[FileGap, ...]
    notes: tuple[str, ...]
    log_evidence: float
