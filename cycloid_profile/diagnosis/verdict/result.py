"""Result of a diagnosis: verdict, named effects, significant locations, residuals before and after."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cycloid_profile._display import Described, frame
from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis.data.recording import Recording
from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.detection import Detection, Finding
from cycloid_profile.diagnosis.model.residuals import Residuals
from cycloid_profile.diagnosis.verdict.nearest_effects import NearestEffect
from cycloid_profile.diagnosis.verdict.rest_curves import EmpiricalFit
from cycloid_profile.effects import AsBuiltReducer, Effect
from cycloid_profile.units import SIGNS


@dataclass(frozen=True, eq=False)
class SizedEffect:
    """A ``candidate`` at ``coordinates``, with their covariance."""

    candidate: Candidate
    coordinates: FloatArray
    covariance: FloatArray

    @property
    def effect(self) -> Effect:
        """The effect at these coordinates."""
        found = self.candidate.effect(self.coordinates)
        assert found is not None
        return found

    @property
    def parameters(self) -> dict[str, Any]:
        """Parameters of the effect."""
        return self.candidate.parameters(self.coordinates)

    @property
    def uncertainty(self) -> dict[str, float]:
        """Standard deviation of size and angle."""
        return self.candidate.uncertainty(self.coordinates, self.covariance)


@dataclass(frozen=True, eq=False)
class NamedEffect(SizedEffect):
    """A named effect.

    ``group``: names that the data cannot separate from the effect; the effect itself comes first. ``separate_by``:
    measurement that separates them. ``evidence``: log evidence lost without the effect. ``other_locations``: the same
    effect at locations that fit as well.
    """

    group: tuple[str, ...]
    separate_by: str | None
    evidence: float
    other_locations: tuple[SizedEffect, ...] = ()


@dataclass(frozen=True, eq=False)
class FileGap:
    """Residuals of a file before and after the named effects: root mean squares in its unit, chi² per row after.

    ``before`` and ``after``: residuals on the reducer of the spec, and on the reducer with the effects.
    """

    recording: Recording
    before: Residuals
    after: Residuals
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
        """Share of the initial residual beyond noise that vanished on held-out rows; None if within the noise."""
        noise2 = self.noise**2
        gap = self.held_out_before**2 - noise2
        if gap < noise2:
            return None
        return 1.0 - (self.held_out_after**2 - noise2) / gap


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis(Described):
    """Result of a diagnosis; ``verdict`` is ``agrees``, ``effects_found`` or ``unknown_effect``.

    ``detection``: tests without the named effects; ``residual_detection``: tests with them. ``where``: significant
    places without them. ``remainder``: largest place that the effects leave, or None. ``nearest``: known effects most
    similar to an unknown effect. ``not_seen``: smallest detectable size of every effect and the name of its parameter.
    ``log_evidence``: of the best set. ``empirical``: smooth curves for what the effects leave.
    """

    reducer: AsBuiltReducer
    corrected: AsBuiltReducer
    verdict: str
    effects: tuple[NamedEffect, ...]
    detection: Detection
    residual_detection: Detection
    where: tuple[Finding, ...]
    remainder: Finding | None
    nearest: tuple[NearestEffect, ...]
    not_seen: dict[str, tuple[float, str]]
    gaps: tuple[FileGap, ...]
    notes: tuple[str, ...]
    log_evidence: float
    empirical: tuple[EmpiricalFit, ...] = ()

    @property
    def within_model_error(self) -> bool:
        """Whether the error of the model may explain all that the effects leave beyond the noise."""
        return bool(self.effects) and not self.residual_detection.significant_findings

    @property
    def unexplained(self) -> bool:
        """Whether something is left that the error of the model does not explain."""
        return self.remainder is not None and not self.within_model_error

    def _key_figures(self) -> Mapping[str, str]:
        effects = {
            one.candidate.name: ", ".join(
                f"{key} = {_text(value)}" + (f" ± {one.uncertainty[key]:.2g}" if key in one.uncertainty else "")
                for key, value in one.parameters.items()
            )
            for one in self.effects
        }
        gaps = {
            f"gap of {gap.recording.name}": f"{gap.fit_before:.4g} to {gap.fit_after:.4g} "
            f"{SIGNS[gap.recording.unit]} rms, noise {gap.noise:.4g} {SIGNS[gap.recording.unit]}"
            for gap in self.gaps
        }
        near = {f"not {one.name}": f"explains {100.0 * one.share:.0f} %" for one in self.nearest}
        return {"verdict": self.verdict, **effects, **near, **gaps}

    def to_frame(self) -> Any:
        """Named effects as a ``pandas.DataFrame``, one row for each parameter.

        Columns: ``effect``, ``parameter``, ``value``, a number or the name of a choice, and ``uncertainty`` (one
        standard deviation, NaN for parts and choices) in the unit of the parameter name, ``group``, ``separate_by``.

        Raises
        ------
        CycloidError
            If pandas is not installed.
        """
        rows = [(one, key, value) for one in self.effects for key, value in one.parameters.items()]
        return frame(
            {
                "effect": [one.candidate.name for one, _, _ in rows],
                "parameter": [key for _, key, _ in rows],
                "value": [value if isinstance(value, str) else float(value) for _, _, value in rows],
                "uncertainty": [one.uncertainty.get(key, float("nan")) for one, key, _ in rows],
                "group": [", ".join(one.group) for one, _, _ in rows],
                "separate_by": [one.separate_by for one, _, _ in rows],
            }
        )


def _text(value: Any) -> str:
    """A number with four digits, or the name of a choice."""
    return value if isinstance(value, str) else f"{value:.4g}"
