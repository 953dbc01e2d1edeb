"""From a spec to a finished design: the steps in order, and their results in one record."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile._display import Described, figure_text, labelled
from cycloid_profile.arrays import FloatArray
from cycloid_profile.compensation import Compensation
from cycloid_profile.contact import LoadCase, LoadSharing, Losses, LossRange, SolveStatus, loss_range
from cycloid_profile.contact.disc import Classical, Equilibrium
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.design.checks import (
    Check,
    CheckStatus,
    load_checks,
    output_hole_checks,
    shape_checks,
    strength_checks,
)
from cycloid_profile.design.drive_accuracy import ACCURACY, Accuracy, AsBuiltAccuracy, accuracy, accuracy_as_built
from cycloid_profile.design.from_spec import (
    compensation_of,
    conventional_profile,
    disc_outline,
    drive_of,
    load_case,
    output_speed,
    reducer_with_effects,
    thinnest_wall,
)
from cycloid_profile.design.strength import Strength, strength_under_load
from cycloid_profile.geometry import DiscOutline, Drive, ToothProfile
from cycloid_profile.spec.model import Spec
from cycloid_profile.units import NEWTON_METRE, UM


@dataclass(frozen=True, slots=True, repr=False)
class DesignRecord(Described):
    """A finished design with every intermediate result.

    ``conventional`` is the tooth before deformation compensation, ``profile`` the final one.
    ``compensation`` is None if not requested or if refused; ``refusal`` then holds the reason.
    ``classical`` and ``equilibrium`` share the load on one disc of the conventional tooth. ``under_load`` is the
    whole stage with the final tooth, at rated torque over one turn of the crank. All of these have nominal parts.
    ``as_built`` is the reducer with the effects of the spec, None without any. ``outline`` is that of ``disc``, counted
    from 1, with its openings turned by ``openings_turn`` against its teeth, compared with disc 1 [rad].
    """

    spec: Spec
    drive: Drive
    case: LoadCase
    conventional: ToothProfile
    profile: ToothProfile
    classical: LoadSharing
    equilibrium: LoadSharing
    under_load: LoadSharing
    loss_range: LossRange
    strength: Strength
    compensation: Compensation | None
    refusal: str | None
    conventional_accuracy: Accuracy
    compensated_accuracy: Accuracy
    as_built: AsBuiltAccuracy | None
    outline: DiscOutline
    checks: tuple[Check, ...]
    disc: int = 1
    openings_turn: float = 0.0

    @property
    def label(self) -> str:
        """Addition to the names of the files of this disc, empty for disc 1."""
        return "" if self.disc == 1 else f"disc_{self.disc}"

    @property
    def losses(self) -> Losses:
        """Losses with the likely friction."""
        return self.loss_range.likely

    @property
    def failures(self) -> tuple[str, ...]:
        """Reasons why the disc cannot work as specified, one sentence each; empty for a sound design."""
        refused = (self.refusal,) if self.refusal else ()
        checks = (check.sentence for check in self.checks if check.severe and not check.passed)
        return (*refused, *self._unsolved(), *checks)

    def _unsolved(self) -> list[str]:
        """Solves that did not converge."""
        sentences = [
            f"load sharing ({sharing.solver}) ended with '{sharing.status.value}'"
            for sharing in (self.classical, self.equilibrium, self.under_load)
            if sharing.status is not SolveStatus.CONVERGED
        ]
        if not (self.conventional_accuracy.converged and self.compensated_accuracy.converged):
            sentences.append(
                "the equilibrium of the whole drive was not found at every pose and load: "
                "check torque, bearing stiffness and material"
            )
        return sentences

    def _key_figures(self) -> dict[str, str]:
        d = self.drive
        before, after = (
            labelled(ACCURACY, one.figures()) for one in (self.conventional_accuracy, self.compensated_accuracy)
        )
        delta = 0.0 if self.compensation is None else self.compensation.delta_max / UM
        failed = [check.name for check in self.checks if not (check.passed or check.missing)]
        missing = sum(check.status is CheckStatus.NOT_CHECKED for check in self.checks)
        passed = sum(check.passed for check in self.checks)
        return {
            "name": self.spec.name,
            "gear": f"{d.trochoid.lobes} lobes, {d.trochoid.pins} pins, discs: {d.discs}",
            "short-width ratio K1": figure_text(d.trochoid.short_width_ratio),
            "rated torque": figure_text(self.case.torque / NEWTON_METRE, "N·m"),
            "deformation compensation": self.refusal or figure_text(delta, "µm"),
            **{label: " → ".join(dict.fromkeys((before[label], after[label]))) for label in after},
            "largest pin force": figure_text(self.under_load.max_force, "N"),
            "peak pressure": figure_text(self.under_load.max_pressure, "MPa"),
            "effects": ", ".join(
                [*(effect["name"] for effect in self.spec.effects), *(one.name for one in self.spec.empirical)]
            )
            or "none",
            "checks": (f"failed: {', '.join(failed)}" if failed else f"{passed} passed")
            + (f"; {missing} not checked" if missing else ""),
        }


def design_disc(spec: Spec) -> DesignRecord:
    """Compute the whole design of a spec.

    Raises
    ------
    GeometryError, LoadError, SpecError
        If the drive or its tooth cannot exist.
    """
    drive = drive_of(spec)
    case = load_case(spec, drive, conventional_profile(spec, drive))
    before = accuracy(case)
    compensation, refusal = compensation_of(spec, case)
    conventional = case.profile
    profile = conventional if compensation is None else compensation.profile
    after = before if compensation is None else accuracy(replace(case, profile=profile))
    outline = disc_outline(spec, drive, profile)
    under_load = StageEquilibrium().at(replace(case, profile=profile), _crank_angles(drive))
    found = strength_under_load(spec, under_load, outline)
    raceway = 0.0 if found.crank_rollers is None else found.crank_rollers.rollers.inner_raceway_radius
    return DesignRecord(
        spec=spec,
        drive=drive,
        case=case,
        conventional=conventional,
        profile=profile,
        classical=Classical().solve(case),
        equilibrium=Equilibrium().solve(case),
        under_load=under_load,
        loss_range=loss_range(under_load, output_speed(spec), spec.load.friction_coefficient, raceway),
        strength=found,
        compensation=compensation,
        refusal=refusal,
        conventional_accuracy=before,
        compensated_accuracy=after,
        as_built=accuracy_as_built(reducer_with_effects(spec, replace(case, profile=profile)))
        if spec.effects or spec.empirical
        else None,
        outline=outline,
        checks=(
            *shape_checks(drive, profile, after.backlash, thinnest_wall(outline)),
            *output_hole_checks(spec),
            *load_checks(under_load),
            *strength_checks(found),
        ),
    )


def _crank_angles(drive: Drive) -> FloatArray:
    """Crank angles over one revolution, about six for each pin, phases of successive pins slightly different [rad]."""
    poses = min(6 * drive.trochoid.pins, 600) + 1
    return 2.0 * math.pi * np.arange(poses) / poses
