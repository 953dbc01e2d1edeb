"""The chain from a spec to a finished design: plain calls of the steps, in order."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.compensation.fixed_point import Compensation
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.classical import Classical
from cycloid_profile.contact.equilibrium import Equilibrium
from cycloid_profile.contact.running import Losses, losses
from cycloid_profile.contact.sharing import LoadSharing, Status
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.design.accuracy import Accuracy, accuracy
from cycloid_profile.design.as_built import AsBuiltAccuracy, accuracy_as_built
from cycloid_profile.design.checks import Check, load_checks, shape_checks
from cycloid_profile.design.from_spec import (
    allowable_pressure,
    bearing_radius,
    built_of,
    conventional_profile,
    disc_outline,
    drive_of,
    load_case,
    output_speed,
    thinnest_wall,
)
from cycloid_profile.design.ground import compensation_of
from cycloid_profile.geometry.drive import Drive
from cycloid_profile.geometry.outline import DiscOutline
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.spec.model import Spec


@dataclass(frozen=True, slots=True)
class DesignRecord:
    """A finished design with everything it came from.

    ``conventional`` is the tooth before deformation compensation, ``profile`` the one to be ground.
    ``compensation`` is None where none was asked for or it was refused; ``refusal`` then says why.
    ``classical`` and ``equilibrium`` share the load on one disc of the conventional tooth; ``under_load`` is
    the whole stage with the tooth to be ground, at rated torque over one turn of the crank; all of these as drawn.
    ``as_built`` is the reducer with the effects of the spec, None without any.
    """

    spec: Spec
    drive: Drive
    case: LoadCase
    conventional: ToothProfile
    profile: ToothProfile
    classical: LoadSharing
    equilibrium: LoadSharing
    under_load: LoadSharing
    losses: Losses
    compensation: Compensation | None
    refusal: str | None
    conventional_accuracy: Accuracy
    compensated_accuracy: Accuracy
    as_built: AsBuiltAccuracy | None
    outline: DiscOutline
    checks: tuple[Check, ...]

    @property
    def failures(self) -> tuple[str, ...]:
        """Why the disc cannot work as asked, one sentence each; empty for a sound design."""
        refused = (self.refusal,) if self.refusal else ()
        checks = (check.sentence for check in self.checks if check.severe and not check.passed)
        return (*refused, *self._unsolved(), *checks)

    def _unsolved(self) -> list[str]:
        """Solves that ended without an answer."""
        said = [
            f"load sharing ({sharing.solver}) ended with '{sharing.status.value}'"
            for sharing in (self.classical, self.equilibrium, self.under_load)
            if sharing.status is not Status.CONVERGED
        ]
        if not (self.conventional_accuracy.converged and self.compensated_accuracy.converged):
            said.append(
                "the equilibrium of the whole drive was not found at every pose and load: "
                "check torque, bearing stiffness and material"
            )
        return said


def design_disc(spec: Spec) -> DesignRecord:
    """Compute the whole design of a spec.

    Raises
    ------
    GeometryError, LoadError, SpecError
        If the drive or its tooth cannot exist.
    """
    drive = drive_of(spec)
    case = load_case(spec, drive, conventional_profile(spec, drive))
    compensation, refusal = compensation_of(spec, case)
    conventional = case.profile
    profile = conventional if compensation is None else compensation.profile
    before = accuracy(case)
    after = before if compensation is None else accuracy(replace(case, profile=profile))
    outline = disc_outline(spec, drive, profile)
    under_load = StageEquilibrium().at(replace(case, profile=profile), _crank_turn(drive))
    return DesignRecord(
        spec=spec,
        drive=drive,
        case=case,
        conventional=conventional,
        profile=profile,
        classical=Classical().solve(case),
        equilibrium=Equilibrium().solve(case),
        under_load=under_load,
        losses=losses(under_load, output_speed(spec), spec.load.friction_coefficient, bearing_radius(outline)),
        compensation=compensation,
        refusal=refusal,
        conventional_accuracy=before,
        compensated_accuracy=after,
        as_built=accuracy_as_built(built_of(spec, replace(case, profile=profile))) if spec.effects else None,
        outline=outline,
        checks=(
            *shape_checks(drive, profile, after.backlash, thinnest_wall(outline)),
            *load_checks(under_load, allowable_pressure(spec)),
        ),
    )


def _crank_turn(drive: Drive) -> FloatArray:
    """Crank angles over one turn that meet the pins a little later each time, some six for every pin [rad]."""
    poses = min(6 * drive.trochoid.pins, 600) + 1
    angles: FloatArray = 2.0 * math.pi * np.arange(poses) / poses
    return angles
