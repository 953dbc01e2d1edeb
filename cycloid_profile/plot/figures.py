"""The figure that belongs to a result, for notebooks; all pictures of a design with the captions of its report."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import msgspec

from cycloid_profile.contact import LoadSharing
from cycloid_profile.correction import Correction
from cycloid_profile.design import Accuracy, DesignRecord, ToleranceRecord, as_built_reducer
from cycloid_profile.diagnosis import Diagnosis
from cycloid_profile.geometry import ToothProfile
from cycloid_profile.measurement import Measurement
from cycloid_profile.plot import design, diagnosis, measured, tolerance
from cycloid_profile.plot.style import figure_holding
from cycloid_profile.rig import AngleMap, Loop, MeasurementResidual, TransmissionError
from cycloid_profile.spec.model import ModificationSpec, Spec
from cycloid_profile.tolerance.allocation import Allocation
from cycloid_profile.tolerance.study import StudySummary

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def _nominal_tooth(spec: Spec) -> Any:
    nominal = msgspec.structs.replace(spec, modification=ModificationSpec(), effects=())
    return design.tooth(as_built_reducer(nominal).case.profile, name=spec.name)


def _forces(sharing: LoadSharing) -> Any:
    return design.load_map(sharing) if sharing.crank_angle.size > 1 else design.load_sharing(sharing)


_FIGURES: dict[type, Callable[[Any], Any]] = {
    Spec: _nominal_tooth,
    ToothProfile: design.tooth,
    DesignRecord: design.profile_comparison,
    LoadSharing: _forces,
    Accuracy: design.accuracy,
    Diagnosis: diagnosis.diagnosis_summary,
    Correction: diagnosis.correction,
    ToleranceRecord: tolerance.distributions,
    StudySummary: tolerance.distributions,
    Allocation: tolerance.tolerance_bars,
    Measurement: measured.measurement,
    MeasurementResidual: measured.measurement_residual,
    TransmissionError: measured.transmission_error,
    Loop: measured.hysteresis_loop,
    AngleMap: measured.angle_map,
}


def figure_of(result: object) -> Figure | None:
    """The figure that belongs to a result, None where its type has none."""
    draw = next((_FIGURES[kind] for kind in type(result).__mro__ if kind in _FIGURES), None)
    return None if draw is None else figure_holding(draw(result))
