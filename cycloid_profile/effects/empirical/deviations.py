"""The two empirical effects, and their tables ``[[empirical]]`` of a spec file.

They describe one specimen where the library of effects ends. Their numbers have the units of the keys, so that a spec
file reads back exactly.
"""

from __future__ import annotations

import hashlib
import math
import re
from dataclasses import dataclass, field, fields, replace
from typing import Any, ClassVar

import msgspec
import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.effects.base import EffectLocation
from cycloid_profile.effects.reducer import AsBuiltReducer
from cycloid_profile.effects.series import BranchTwist, SplineTwist
from cycloid_profile.errors import SpecError
from cycloid_profile.modification import MeasuredDeviation, NormalDeviation
from cycloid_profile.spec.model import EMPIRICAL_LABEL, DataFileSpec, EmpiricalSpec
from cycloid_profile.units import ARCMIN, NEWTON_METRE, UM

_SHA256 = re.compile(r"[0-9a-f]{64}")
_LEAST_POINTS = 4  # of a periodic cubic spline

Numbers = tuple[float, ...]


@dataclass(frozen=True)
class Empirical:
    """Base of both empirical effects; ``data``, the measured files behind the curve."""

    name: ClassVar[str]
    label: ClassVar[str] = EMPIRICAL_LABEL
    location: ClassVar[EffectLocation]
    data: tuple[DataFileSpec, ...] = field(default=(), kw_only=True)

    def __post_init__(self) -> None:
        for one in self.data:
            if not _SHA256.fullmatch(one.sha256):
                raise SpecError(f"{self.name}.data.sha256", f"'{one.sha256}'", "is no SHA-256",
                                "give 64 hexadecimal digits in small letters")  # fmt: skip

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        """The reducer with this effect."""
        raise NotImplementedError


@dataclass(frozen=True)
class FormDeviation(Empirical):
    """Smooth deviation of the flanks without a known cause: a periodic cubic spline along the disc.

    ``removal_um``, material removed along the normal at even phases, the first at the root of lobe 1, positive into
    the disc [µm]. ``lobes``, lobes after which it repeats: 1 or those of the disc. ``disc`` counted from 1, None for
    all, in the frame of the carrier. ``uncertainty_um``, root mean square standard error [µm].

    Raises ``SpecError`` if there are fewer than 4 points, or a number is impossible.
    """

    name = "form_deviation"
    location = EffectLocation.FLANK
    removal_um: Numbers
    lobes: int = 1
    disc: int | None = None
    uncertainty_um: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "removal_um", _numbers(f"{self.name}.removal_um", self.removal_um, _LEAST_POINTS))
        if not 0.0 <= self.uncertainty_um < math.inf:
            raise SpecError(
                f"{self.name}.uncertainty_um", self.uncertainty_um, "is below zero", "give a standard error"
            )

    def curve(self, turned: float = 0.0) -> NormalDeviation:
        """The removal as a curve; ``turned``, angle along the disc by which it begins earlier, over a lobe [rad]."""
        points = len(self.removal_um)
        phase = np.arange(points) * (2.0 * math.pi * self.lobes / points) - turned
        return NormalDeviation(np.asarray(phase, dtype=np.float64), np.array(self.removal_um) * UM, self.lobes)

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        """The reducer with the deviation; raises ``SpecError`` where disc or lobes do not exist."""
        lobes = reducer.case.drive.trochoid.lobes
        if self.lobes not in (1, lobes):
            limit = f"is neither 1 nor the {lobes} of the disc"
            raise SpecError(f"{self.name}.lobes", self.lobes, limit, "fit the curve to a scan of this drive")
        if self.disc is not None and not 1 <= self.disc <= reducer.discs:
            limit = f"is not one of the {reducer.discs} discs"
            raise SpecError(f"{self.name}.disc", self.disc, limit, f"give 1 to {reducer.discs}")
        for j in range(reducer.discs) if self.disc is None else (self.disc - 1,):
            # Disc j is mounted at −2πj/(N z_c) to the first; a form common to all lobes moves with them.
            whole = self.disc is None and self.lobes > 1
            removal = MeasuredDeviation(self.curve(2.0 * math.pi * j / reducer.discs if whole else 0.0))
            reducer = reducer.with_tooth(j, removal.apply(reducer.teeth[j]))
        return reducer


@dataclass(frozen=True)
class TorqueTwistResidual(Empirical):
    """Further twist of a loop without a known cause: a spline against the torque applied, for each of its branches.

    Twist [arc minutes] at rising knots of the torque [N·m], with its standard error; between them a natural cubic
    spline, beyond them constant. Where the torque has no history, as in a transmission error, the mean of both.

    Raises ``SpecError`` unless each branch has at least two rising knots with one number each.
    """

    name = "torque_twist_residual"
    location = EffectLocation.COMPLIANCE
    rising_torque_nm: Numbers
    rising_twist_arcmin: Numbers
    rising_uncertainty_arcmin: Numbers
    falling_torque_nm: Numbers
    falling_twist_arcmin: Numbers
    falling_uncertainty_arcmin: Numbers

    def __post_init__(self) -> None:
        super().__post_init__()
        for branch in ("rising", "falling"):
            keys = [f"{branch}_{column}" for column in ("torque_nm", "twist_arcmin", "uncertainty_arcmin")]
            knots = _numbers(f"{self.name}.{keys[0]}", getattr(self, keys[0]), 2)
            if np.any(np.diff(knots) <= 0.0):
                raise SpecError(f"{self.name}.{keys[0]}", "given", "does not rise", "sort the knots", " ")
            object.__setattr__(self, keys[0], knots)
            for key in keys[1:]:
                values = _numbers(f"{self.name}.{key}", getattr(self, key), len(knots))
                if len(values) > len(knots):
                    limit = f"has {len(values)} numbers for {len(knots)} knots"
                    raise SpecError(f"{self.name}.{key}", "given", limit, "give one for each knot", " ")
                object.__setattr__(self, key, values)

    @property
    def twist(self) -> BranchTwist:
        """Both curves in base units."""
        return BranchTwist(
            _spline(self.rising_torque_nm, self.rising_twist_arcmin),
            _spline(self.falling_torque_nm, self.falling_twist_arcmin),
        )

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        """The reducer with the twist in series with the stage."""
        return replace(reducer, further_twists=(*reducer.further_twists, self.twist))


_KINDS: dict[str, type[FormDeviation] | type[TorqueTwistResidual]] = {
    FormDeviation.name: FormDeviation,
    TorqueTwistResidual.name: TorqueTwistResidual,
}


def data_file(name: str, content: bytes, date: str | None = None) -> DataFileSpec:
    """Name, SHA-256 and date of a measured file, as an empirical effect keeps them."""
    return DataFileSpec(file=name, sha256=hashlib.sha256(content).hexdigest(), date=date)


def empirical_from_spec(table: EmpiricalSpec) -> Empirical:
    """The effect of one table of ``[[empirical]]``.

    Raises ``SpecError`` if a key is missing, belongs to the other kind, or has an impossible value.
    """
    kind = _KINDS[table.name]
    known = {one.name: one for one in fields(kind)}
    for one in msgspec.structs.fields(EmpiricalSpec):
        given = getattr(table, one.name) != one.default
        if given and one.name not in known and one.name not in ("name", "label"):
            raise SpecError(one.name, "given", f"is no key of {table.name}", f"known are {', '.join(known)}", " ")
    values = {name: getattr(table, name) for name in known}
    return kind(**{name: value for name, value in values.items() if value is not None})


def empirical_to_table(of: Empirical) -> dict[str, Any]:
    """The effect as a table ``[[empirical]]`` of a spec file, and for JSON: plain values, its label and its data."""
    values = {one.name: getattr(of, one.name) for one in fields(of)}
    table: dict[str, Any] = msgspec.to_builtins(EmpiricalSpec(name=of.name, label=of.label, **values))  # type: ignore[arg-type]
    return table


def _numbers(what: str, values: Any, least: int) -> Numbers:
    found = tuple(float(value) for value in values)
    if len(found) < least:
        raise SpecError(what, "given", f"has {len(found)} numbers", f"give at least {least}", " ")
    if not all(math.isfinite(value) for value in found):
        raise SpecError(what, "given", "has a number that is not finite", "leave such points out", " ")
    return found


def _spline(torque_nm: Numbers, twist_arcmin: Numbers) -> SplineTwist:
    return SplineTwist(_scaled(torque_nm, NEWTON_METRE), _scaled(twist_arcmin, ARCMIN))


def _scaled(values: Numbers, unit: float) -> Numbers:
    scaled: FloatArray = np.array(values) * unit
    return tuple(scaled.tolist())
