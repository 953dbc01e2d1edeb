"""Kinds of measured files: columns, units and needed keys of each (docs/rig.md, "Files").

Higher-level subpackages register their handlers for each kind with ``functools.singledispatch``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from cycloid_profile.errors import MeasurementError, did_you_mean
from cycloid_profile.units import ARCMIN, ARCSEC, UM


@dataclass(frozen=True)
class MeasurementKind:
    """A kind of measured file; ``name``, identifier in files, commands and JSON.

    ``columns`` in the order of the file, the measured value last; ``unit`` of residual and noise, and its
    ``unit_size`` in base units [mm or rad]; ``needed_keys`` of the file; ``coordinate``, name of the field of a row in
    JSON output.
    """

    name: ClassVar[str]
    columns: ClassVar[tuple[str, str]]
    unit: ClassVar[str]
    unit_size: ClassVar[float]
    coordinate: ClassVar[str]
    needed_keys: ClassVar[tuple[str, ...]] = ()
    is_curve: ClassVar[bool] = True
    over_output_turn: ClassVar[bool] = False
    zero_unknown: ClassVar[bool] = True

    def __str__(self) -> str:
        return self.name

    def __reduce__(self) -> tuple[object, ...]:
        # Kinds are compared by identity, also after a transfer to another process.
        return kind_named, (self.name,)

    @property
    def title(self) -> str:
        """Name in words."""
        return self.name.replace("_", " ")

    @property
    def value_column(self) -> str:
        """Column of the measured value of a curve."""
        return self.columns[1]

    @property
    def noise_key(self) -> str:
        """Key of a stated standard deviation of the noise."""
        return f"noise_{self.unit}"


class ProfileScan(MeasurementKind):
    """Points of the tooth flanks of one disc, ball radius taken off."""

    name = "profile_scan"
    columns = ("x_mm", "y_mm")
    unit, unit_size = "um", UM
    coordinate = "lobe"
    is_curve = False


class Hysteresis(MeasurementKind):
    """Output angle under a torque that runs up and down, input locked."""

    name = "hysteresis"
    columns = ("torque_nm", "angle_arcmin")
    unit, unit_size = "arcmin", ARCMIN
    coordinate = "row"

    @property
    def title(self) -> str:
        return "hysteresis loop"


class _OverOutputTurn(MeasurementKind):
    """A curve over one turn of the output at one torque."""

    coordinate = "output_angle_deg"
    needed_keys = ("torque_nm",)
    over_output_turn = True


class TransmissionErrorCurve(_OverOutputTurn):
    """Actual minus ideal output angle."""

    name = "transmission_error"
    columns = ("output_angle_deg", "error_arcsec")
    unit, unit_size = "arcsec", ARCSEC


class LostMotionMap(_OverOutputTurn):
    """Output angle at +torque minus angle at −torque: a difference, whose zero is known."""

    name = "lost_motion_map"
    columns = ("output_angle_deg", "lost_motion_arcmin")
    unit, unit_size = "arcmin", ARCMIN
    zero_unknown = False


PROFILE_SCAN = ProfileScan()
HYSTERESIS = Hysteresis()
TRANSMISSION_ERROR = TransmissionErrorCurve()
LOST_MOTION_MAP = LostMotionMap()
KINDS: dict[str, MeasurementKind] = {
    kind.name: kind for kind in (PROFILE_SCAN, HYSTERESIS, TRANSMISSION_ERROR, LOST_MOTION_MAP)
}


def kind_named(name: str, what: str = "kind") -> MeasurementKind:
    """The kind of that name; raises ``MeasurementError`` about ``what`` with the nearest name if there is none."""
    if name not in KINDS:
        remedy = did_you_mean(name, KINDS, f"choose from {', '.join(KINDS)}")
        raise MeasurementError(what, f"'{name}'", "is not known", remedy)
    return KINDS[name]
