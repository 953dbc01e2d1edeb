"""How the pins of one disc share the load: the result type of every load-sharing solver."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.case import LoadCase


class Status(Enum):
    """How a solve ended; the value is the sentence shown."""

    CONVERGED = "converged"
    NOT_CONVERGED = "stopped at the step limit before converging: check the modification amounts"
    NO_CONTACT = "no pin touches: lower the modification or raise the torque"
    INTERFERENCE = "pin and disc overlap before any load: raise the clearance"


@dataclass(frozen=True, slots=True)
class LoadSharing:
    """Load on the pins of one disc at one or more poses.

    Arrays have shape (poses, pins): ``phase`` ψ [rad]; ``gap`` left when the disc first touches [mm];
    ``approach`` [mm] and ``force`` [N] under load; ``pressure`` [MPa]; ``lever`` [mm].
    ``rotation`` shape (poses,) beyond first touch [rad]. ``delta_max`` is the deformation at the
    critical phase, a z_c times the largest rotation [mm]. ``residual`` is the largest relative error
    of the moment balance. ``history`` holds (largest force [N], δmax [mm]) after each iteration.
    """

    case: LoadCase
    solver: str
    phase: FloatArray
    gap: FloatArray
    approach: FloatArray
    force: FloatArray
    pressure: FloatArray
    lever: FloatArray
    rotation: FloatArray
    max_force: float
    delta_max: float
    status: Status
    residual: float
    history: tuple[tuple[float, float], ...]

    @property
    def loaded_pins(self) -> int:
        """Most pins that carry at one pose."""
        # A pin that merely touches may show a force of rounding size.
        return int(np.max(np.sum(self.force > 1e-9 * np.max(self.force), axis=-1)))

    @property
    def max_pressure(self) -> float:
        """Highest peak pressure [MPa]."""
        return float(np.max(self.pressure))

    @property
    def iterations(self) -> int:
        """Number of iterations."""
        return len(self.history)
