"""The tooth that is ground, and the reducer built with it."""

from __future__ import annotations

from dataclasses import replace

from cycloid_profile.compensation.fixed_point import Compensation, compensate, compensate_by
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.design.from_spec import (
    built_of,
    compensation_solver,
    conventional_profile,
    drive_of,
    load_case,
)
from cycloid_profile.effects.built import Built
from cycloid_profile.errors import CompensationError, SolveError, SpecError
from cycloid_profile.spec.model import Spec
from cycloid_profile.units import UM

_LARGEST_DELTA_UM = 1000.0


def built_reducer(spec: Spec) -> Built:
    """The reducer of a spec, tooth compensated where it asks for that, with its effects.

    Raises
    ------
    GeometryError, LoadError, SpecError
        If the drive, its tooth or an effect cannot exist.
    CompensationError
        If the compensation asked for had to be refused.
    """
    drive = drive_of(spec)
    case = load_case(spec, drive, conventional_profile(spec, drive))
    compensation, refusal = compensation_of(spec, case)
    if refusal is not None:
        raise CompensationError(
            "deformation compensation", "refused", f"({refusal})", "lower it or set it to false", " "
        )
    return built_of(spec, case if compensation is None else replace(case, profile=compensation.profile))


def compensation_of(spec: Spec, case: LoadCase) -> tuple[Compensation | None, str | None]:
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
            designed_for = replace(case, torque=spec.modification.compensation_load_share * case.torque)
            return compensate(designed_for, compensation_solver(spec)), None
        return compensate_by(case, wanted * UM), None
    except (CompensationError, SolveError) as error:
        return None, str(error)
