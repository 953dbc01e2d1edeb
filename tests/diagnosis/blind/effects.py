"""The effects that can be hidden: size to draw from, parts to choose, and the files that show them.

The typical size is the tolerance a good workshop holds (docs/effects.md, "Parameters").
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .hidden import Hidden
from .reducer import Reducer

BENCH = frozenset({"loop", "te", "lost_motion"})
_TWIST = frozenset({"loop", "lost_motion"})
_SCAN = frozenset({"scan"})


@dataclass(frozen=True)
class Kind:
    """An effect to draw: ``key`` of its size and the ``typical`` one, the files in which it ``shows``.

    ``signed`` sizes have either sign, an ``inverse`` one is a stiffness. ``angles`` are drawn from a turn, ``parts``
    from those of the reducer, whatever else from ``ranges``. An effect ``on_disc`` may be on one disc or on all.
    ``cranks``: of crank bearings, which a central eccentric has not.
    """

    key: str
    typical: float
    shows: frozenset[str]
    signed: bool = False
    inverse: bool = False
    angles: tuple[str, ...] = ()
    parts: tuple[str, ...] = ()
    ranges: tuple[tuple[str, float, float], ...] = ()
    on_disc: bool = False
    cranks: bool = False

    @property
    def of_cranks(self) -> bool:
        """Whether only a reducer with crank shafts can have it."""
        return "crank" in self.parts or "planet" in self.parts or self.cranks

    def draw(
        self, name: str, reducer: Reducer, multiple: float, discs: tuple[int, ...], draw: np.random.Generator
    ) -> Hidden:
        """One of them, so many times its typical size; ``discs`` are those it may be on alone."""
        size = self.typical / multiple if self.inverse else self.typical * multiple
        values: dict[str, Any] = {self.key: float(size * (draw.choice([-1.0, 1.0]) if self.signed else 1.0))}
        values |= {angle: float(draw.uniform(0.0, 360.0)) for angle in self.angles}
        values |= {key: float(draw.uniform(low, high)) for key, low, high in self.ranges}
        counts = {"lobe": reducer.lobes, "first_lobe": reducer.lobes, "pin": reducer.pins, "form": 2, "flank": 2}
        for part in self.parts:
            values[part] = int(draw.integers(1, counts.get(part, reducer.cranks) + 1))
        if self.on_disc:
            disc = draw.choice([0, *discs] if name not in ONE_DISC else list(discs))
            values |= {"disc": int(disc)} if disc else {}
        return Hidden(name, values)


ONE_DISC = {"single_tooth_error", "crank_hole_error", "x_pit"}


def _flank(key: str, typical: float, bench: frozenset[str] = BENCH, **more: Any) -> Kind:
    return Kind(key, typical, _SCAN | bench, on_disc=True, **more)


KINDS: dict[str, Kind] = {
    "equidistant_error": _flank("amount_um", 2.0, _TWIST, signed=True),
    "radial_moving_error": _flank("amount_um", 2.0, _TWIST, signed=True),
    "generating_eccentricity_error": _flank("amount_um", 1.0, _TWIST, signed=True),
    "thermal_growth": _flank("temperature_k", 3.0, _TWIST, signed=True),
    "disc_runout": _flank("amplitude_um", 3.0, angles=("phase_deg",), parts=("form",)),
    "disc_oval": _flank("amplitude_um", 2.0, angles=("phase_deg",)),
    "cumulative_pitch_error": _flank("amplitude_um", 3.0, angles=("phase_deg",)),
    "wheel_wear_drift": _flank("amount_um", 1.0, parts=("first_lobe",)),
    "grinding_chatter": _flank("amplitude_um", 0.3, angles=("phase_deg",), ranges=(("waves_per_turn", 200.0, 1500.0),)),
    "missing_deformation_compensation": _flank("amount_um", 2.0, _TWIST, signed=True),
    "flank_wear": _flank("amount_um", 2.0, _TWIST, parts=("flank",)),
    "single_tooth_error": _flank("amount_um", 1.0, frozenset(), signed=True, parts=("lobe",)),
    "pin_radius_error": Kind("amount_um", 1.0, _TWIST, signed=True),
    "pin_circle_radius_error": Kind("amount_um", 3.0, _TWIST, signed=True),
    "pin_ring_runout": Kind("amplitude_um", 5.0, BENCH, angles=("phase_deg",)),
    "pin_ring_oval": Kind("amplitude_um", 3.0, BENCH, angles=("phase_deg",)),
    "pin_ring_cumulative_pitch": Kind("amplitude_um", 4.0, BENCH, angles=("phase_deg",)),
    "single_pin_error": Kind("amount_um", 1.0, frozenset({"te", "lost_motion"}), parts=("pin",)),
    "crank_eccentricity_error": Kind("amount_um", 3.0, BENCH, signed=True, parts=("crank",), on_disc=True),
    "crank_phase_error": Kind("angle_arcmin", 5.0, BENCH, signed=True, parts=("crank",), on_disc=True),
    "crank_hole_error": Kind("amplitude_um", 3.0, BENCH, angles=("direction_deg",), parts=("crank",), on_disc=True),
    "crank_bearing_clearance": Kind("radial_um", 2.0, _TWIST, cranks=True),
    "planet_runout": Kind("amplitude_um", 10.0, frozenset({"te"}), angles=("phase_deg",), parts=("planet",)),
    "series_compliance": Kind("stiffness_nm_per_arcmin", 150.0, _TWIST, inverse=True),
    "crank_bearing_compliance": Kind("added_um_per_kn", 1.0, _TWIST, cranks=True),
    "pin_support_compliance": Kind("added_um_per_kn", 1.0, _TWIST),
    "coulomb_friction": Kind("torque_nm", 5.0, frozenset({"loop"})),
    "load_proportional_friction": Kind("coefficient", 0.03, frozenset({"loop"})),
    "encoder_eccentricity": Kind("amplitude_arcsec", 5.0, frozenset({"te"}), angles=("phase_deg",)),
}

OUTSIDE: dict[str, Kind] = {
    "x_pit": _flank(
        "depth_um",
        4.0,
        frozenset(),
        parts=("lobe",),
        ranges=(("psi_rad", 0.4, 1.8), ("width_rad", 0.04, 0.15)),
    ),
    "x_flat_band": _flank("amount_um", 2.0, frozenset(), ranges=(("psi_rad", 0.4, 1.8), ("width_rad", 0.15, 0.5))),
    "x_three_waves": _flank("amplitude_um", 1.5, angles=("phase_deg",)),
    "x_tooth_to_tooth": _flank("amount_um", 1.0, signed=True),
    "x_scratch_step": _flank("amount_um", 1.0, frozenset(), ranges=(("psi_rad", 0.5, 1.6),)),
    "x_loop_creep": Kind("amount_arcmin", 0.05, frozenset({"loop"}), signed=True, ranges=(("rows", 40.0, 160.0),)),
    "x_te_order7": Kind("amplitude_arcsec", 2.0, frozenset({"te"}), angles=("phase_deg",)),
    "x_rate_stiffening": Kind(
        "stiffness_nm_per_arcmin", 150.0, frozenset({"loop"}), inverse=True, ranges=(("bend_arcmin", 1.5, 3.0),)
    ),
}
