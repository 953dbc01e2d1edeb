"""The chain from a spec to a finished design: plain calls of the steps, in order."""

from __future__ import annotations

from dataclasses import dataclass

from cycloid_profile.compensation.fixed_point import Compensation, compensate, compensate_by
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.classical import Classical
from cycloid_profile.contact.equilibrium import Equilibrium
from cycloid_profile.contact.sharing import LoadSharing
from cycloid_profile.design.accuracy import Accuracy, accuracy
from cycloid_profile.design.checks import Check, design_checks
from cycloid_profile.design.from_spec import (
    compensation_solver,
    conventional_profile,
    disc_outline,
    drive_of,
    load_case,
)
from cycloid_profile.errors import CompensationError, SolveError, SpecError
from cycloid_profile.geometry.drive import Drive
from cycloid_profile.geometry.outline import DiscOutline
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.spec.model import Spec
from cycloid_profile.units import UM


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
        return (*refused, *(check.sentence for check in self.checks if check.severe and not check.passed))


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
    after = before if compensation is None else accuracy(load_case(spec, drive, profile))
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
        checks=design_checks(drive, outline, after.backlash),
    )


def _compensation(spec: Spec, case: LoadCase) -> tuple[Compensation | None, str | None]:
    """The compensation asked for, or None with the reason if it had to be refused."""
    wanted = spec.modification.deformation_compensation
    if wanted is False or wanted == 0.0:
        return None, None
    if wanted is not True and wanted < 0.0:
        raise SpecError(
            "modification.deformation_compensation", wanted, "is negative", "give delta_max as a positive amount in µm"
        )
    try:
        if wanted is True:
            return compensate(case, compensation_solver(spec)), None
        return compensate_by(case, wanted * UM), None
    except (CompensationError, SolveError) as error:
        return None, str(error)
