"""Change of the amount of an effect, in its parameters, with uncertainty."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.verdict.json_output import rounded, rounded_number


@dataclass(frozen=True)
class ParameterChange:
    """A ``parameter`` before and after, None where it has no meaning; ``uncertainty``: one standard deviation
    of the change.
    """

    parameter: str
    before: float | None
    after: float | None
    change: float | None
    uncertainty: float | None


@dataclass(frozen=True, eq=False)
class AmountChange:
    """Change of one effect: coordinates before, of the change, and the covariance of both, in the candidate's unit.

    ``group``: names whose change the data cannot separate from this, itself first. ``evidence``: log evidence lost
    without the change; 0 of an effect without a significant one.
    """

    candidate: Candidate
    before: FloatArray
    change: FloatArray
    covariance: FloatArray
    group: tuple[str, ...]
    evidence: float

    @property
    def significance(self) -> float:
        """Size of the change in standard deviations, of both coordinates together."""
        n = self.candidate.coordinates
        own = self.covariance[2 : 2 + n, 2 : 2 + n]
        v = self.change[:n]
        return math.sqrt(max(float(v @ np.linalg.solve(own, v)), 0.0))

    @property
    def p_value(self) -> float:
        """Probability of so large a change by chance."""
        from scipy.stats import chi2

        return float(chi2.sf(self.significance**2, self.candidate.coordinates))

    @property
    def parts(self) -> dict[str, Any]:
        """Parts and shape of the effect."""
        return {key: value for key, value in self.candidate.choice.items() if value is not None}

    @property
    def parameters(self) -> tuple[ParameterChange, ...]:
        """Size, and angle where it has one; a stiffness is reported as its compliance, which is zero without it."""
        one = self.candidate
        if one.angle is None:
            name = one.size.replace("stiffness_nm_per_arcmin", "compliance_arcmin_per_nm") if one.inverse else one.size
            sigma = math.sqrt(max(float(self.covariance[2, 2]), 0.0))
            x, change = float(self.before[0]), float(self.change[0])
            return (ParameterChange(name, x, x + change, change, sigma),)
        return self._size_and_angle(one.size, one.angle)

    def _size_and_angle(self, size: str, angle: str) -> tuple[ParameterChange, ...]:
        then, now = self.before, self.before + self.change
        lengths = [math.hypot(*x) for x in (then, now)]
        along, across = np.zeros((2, 4)), np.zeros((2, 4))
        for k, (x, length) in enumerate(zip((then, now), lengths, strict=True)):
            unit = x / length if length else self.change / math.hypot(*self.change)
            both = 2 + 2 * k
            along[k, :both] = np.tile(unit, 1 + k)
            across[k, :both] = np.tile([-unit[1], unit[0]], 1 + k) / length if length else 0.0
        sizes = along[1] - along[0]
        per_degree = math.pi / 180.0 * self.candidate.waves
        turns = (across[1] - across[0]) / per_degree
        period = 360.0 / self.candidate.waves
        angles = [math.atan2(x[1], x[0]) / per_degree % period for x in (then, now)]
        turned = (angles[1] - angles[0] + 0.5 * period) % period - 0.5 * period
        known = min(lengths) > 0.0
        return (
            ParameterChange(size, lengths[0], lengths[1], lengths[1] - lengths[0], self._sigma(sizes)),
            ParameterChange(
                angle,
                angles[0] if lengths[0] else None,
                angles[1] if lengths[1] else None,
                turned if known else None,
                self._sigma(turns) if known else None,
            ),
        )

    def _sigma(self, along: FloatArray) -> float:
        return math.sqrt(max(float(along @ self.covariance @ along), 0.0))


def amount_to_json(one: AmountChange) -> list[dict[str, Any]]:
    """One JSON object for each parameter."""
    shared = {
        "significance": rounded_number(one.significance),
        "p_value": rounded_number(one.p_value),
        "ln_evidence": rounded_number(one.evidence),
        "group": list(one.group),
    }
    return [
        {
            "name": one.candidate.name,
            "parts": rounded(one.parts),
            "parameter": row.parameter,
            "before": number_or_none(row.before),
            "after": number_or_none(row.after),
            "change": number_or_none(row.change),
            "uncertainty": number_or_none(row.uncertainty),
            **shared,
        }
        for row in one.parameters
    ]


def number_or_none(value: float | None) -> float | None:
    """A rounded number; None stays."""
    return None if value is None else rounded_number(value)
