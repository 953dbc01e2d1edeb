"""The chain from a spec to a finished design: plain calls of the steps, in order."""

from __future__ import annotations

from dataclasses import dataclass, replace

from cycloid_profile.compensation.fixed_point import Compensation, compensate, compensate_by
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.classical import Classical
from cycloid_profile.contact.equilibrium import Equilibrium
from cycloid_profile.contact.sharing import LoadSharing, Status
from cycloid_profile.design.accuracy import Accuracy, accuracy
from cycloid_profile.design.checks import Check, design_checks
from cycloid_profile.design.from_spec import (
    compensation_solver,
    conventional_profile,
    disc_outline,
    drive_of,
    load_case,
    thinnest_wall,
)
from cycloid_profile.errors import CompensationError, SolveError, SpecError
from cycloid_profile.geometry.drive import Drive
from cycloid_profile.geometry.outline import DiscOutline
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.spec.model import Spec
from cycloid_profile.units import UM

_LARGEST_DELTA_UM = 1000.0


@dataclass(frozen=True, slots=True)
class DesignRecord:
    """A finished design with everything it came from.

    ``conventional`` is the tooth before deformation compensation, ``profile`` the one to be ground.
    ``compensation`` is None where none was asked for or it was refused; ``refusal`` then says why.
    """

    spec: Spec
    drive: Drive
    case: LoadCase
    conventional: ToothProfile
    profile: ToothProfile
    classical: LoadSharing
    equilibrium: LoadSharing
    compensation: Compensation | None
    refusal: str | None
    conventional_accuracy: Accuracy
    compensated_accuracy: Accuracy
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
            for sharing in (self.classical, self.equilibrium)
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
    conventional = conventional_profile(spec, drive)
    case = load_case(spec, drive, conventional)
    compensation, refusal = _compensation(spec, case)
    profile = conventional if compensation is None else compensation.profile
    before = accuracy(case)
    after = before if compensation is None else accuracy(replace(case, profile=profile))
    outline = disc_outline(spec, drive, profile)
    return DesignRecord(
        spec=spec,
        drive=drive,
        case=case,
        conventional=conventional,
        profile=profile,
        classical=Classical().solve(case),
        equilibrium=Equilibrium().solve(case),
        compensation=compensation,
        refusal=refusal,
        conventional_accuracy=before,
        compensated_accuracy=after,
        outline=outline,
        checks=design_checks(drive, profile, after.backlash, thinnest_wall(outline)),
    )


def _compensation(spec: Spec, case: LoadCase) -> tuple[Compensation | None, str | None]:
    """The compensation asked for, or None with the reason if it had to be refused."""
    wanted = spec.modification.deformation_compensation
    if wanted is False or wanted == 0.0:
        return None, None
    if wanted is not True and not 0.0 < wanted <= _LARGEST_DELTA_UM:
        raise SpecError(
            "modification.deformation_compensation",
            f"{wanted:.6g}",
            f"is outside 0 to {_LARGEST_DELTA_UM:g}",
            "give delta_max as a positive amount in µm",
        )
    try:
        if wanted is True:
            return compensate(case, compensation_solver(spec)), None
        return compensate_by(case, wanted * UM), None
    except (CompensationError, SolveError) as error:
        return None, str(error)
