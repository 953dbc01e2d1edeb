"""Cases that share as little as possible with the package: other drives, laws, shapes, sizes, noise, ways to measure.

Sizes are even on a logarithmic scale from half to three times ``WORKSHOP``, which is written here and owes nothing to
the package's tolerances.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .cases import FILES, Case, measured
from .contact import Body, Law, PowerLaw, ReferenceDepth, Roark, at_rated
from .effects import KINDS, OUTSIDE
from .friction import FORMS
from .hidden import Hidden
from .noise import Noise
from .reducer import REDUCERS, Reducer
from .stage import Stage
from .units import ARCMIN, NEWTON_METRE

SIZES = (0.5, 3.0)  # times the workshop tolerance
# What a workshop that grinds discs of 100 mm holds; lengths grow with the tolerance unit of ISO 286-1.
WORKSHOP = {
    "equidistant_error": 2.5,
    "radial_moving_error": 2.5,
    "generating_eccentricity_error": 0.8,
    "thermal_growth": 2.0,
    "disc_runout": 4.0,
    "disc_oval": 1.5,
    "cumulative_pitch_error": 2.5,
    "wheel_wear_drift": 1.2,
    "grinding_chatter": 0.25,
    "missing_deformation_compensation": 1.5,
    "flank_wear": 2.5,
    "single_tooth_error": 1.3,
    "pin_radius_error": 0.8,
    "pin_circle_radius_error": 4.0,
    "pin_ring_runout": 6.0,
    "pin_ring_oval": 4.0,
    "pin_ring_cumulative_pitch": 3.0,
    "single_pin_error": 1.2,
    "crank_eccentricity_error": 2.5,
    "crank_phase_error": 4.0,
    "crank_hole_error": 4.0,
    "crank_bearing_clearance": 2.5,
    "planet_runout": 12.0,
    "crank_bearing_compliance": 0.8,
    "pin_support_compliance": 0.8,
    "load_proportional_friction": 0.025,
    "encoder_eccentricity": 4.0,
    "x_pit": 5.0,
    "x_flat_band": 2.0,
    "x_three_waves": 1.5,
    "x_tooth_to_tooth": 1.0,
    "x_scratch_step": 1.2,
    "x_te_order7": 2.0,
}
_TWIST_ARCMIN = 2.0  # of shafts in series, at rated torque
_FRICTION, _CREEP = 0.015, 0.06  # of the rated torque; ′
_GIVES = (0.05, 0.25)  # compliance of an elastic disc under one pin, over that of the contact at rated torque
_AS_STATED = (0.8, 1.25)  # of what finite elements give: pillars and holes that a spec leaves out, coarse meshes
_TRIES = 50
# Chatter needs some points on a wave; a scan of 59 lobes has 5,000 points.
_POINTS_PER_WAVE = 6.0


@dataclass(frozen=True)
class Hearing:
    """A class of noise: coefficients for all columns, besides the ``sigma`` of each kind of file."""

    rho: tuple[float, float] = (0.0, 0.0)
    rho2: tuple[float, float] = (0.0, 0.0)
    drift: tuple[float, float] = (0.0, 0.0)
    outliers: float = 0.0
    quantum: tuple[float, float] = (0.0, 0.0)

    def noise(self, sigma: float, draw: np.random.Generator) -> Noise:
        """A noise of this class."""
        rho, rho2, drift, quantum = (float(draw.uniform(*of)) for of in (self.rho, self.rho2, self.drift, self.quantum))
        return Noise(sigma, rho, self.outliers, rho2=rho2, drift=drift, quantum=quantum)


NOISES = {
    "white": Hearing(),
    "AR(1)": Hearing(rho=(0.3, 0.7)),
    "AR(2)": Hearing(rho=(0.5, 0.9), rho2=(-0.5, -0.2)),
    "drift": Hearing(drift=(0.5, 2.0)),
    "outliers": Hearing(outliers=0.005),
    "quantised": Hearing(quantum=(1.0, 3.0)),
}
SIGMA = {"scan": (0.2, 0.6), "loop": (0.003, 0.008), "te": (0.1, 0.3), "lost_motion": (0.003, 0.008)}


def draw_wide(
    seed: int, *, files: Sequence[str] = ("scan",), effects: int = 1, outside: int = 0, names: Sequence[str] = ()
) -> Case:
    """A case that the seed determines, with everything drawn: drive, laws, shapes, sizes, noise, way to measure.

    Raises
    ------
    ValueError
        If the drives drawn show no such effects, or bind, in all of fifty tries.
    """
    draw = np.random.default_rng([seed, 3])
    kinds = {FILES[name] for name in files}
    on_bench = bool(kinds - {"scan"})
    heard_as = str(draw.choice(list(NOISES)))
    noise = {kind: NOISES[heard_as].noise(float(draw.uniform(*SIGMA[kind])), draw) for kind in sorted(kinds)}
    for _ in range(_TRIES):
        drive = str(draw.choice(list(REDUCERS)))
        contact_name, contact = _contact(draw)
        share, reach, gives = float(draw.uniform(*_GIVES)), float(draw.uniform(1.0, 3.0)), draw.random() < 0.5
        spec_body = "elastic" if gives and draw.random() < 0.5 else "rigid"
        if spec_body == "elastic":  # what a spec states is what the discs do, up to the error of its elements
            stated = REDUCERS[drive].body_twist_arcmin * ARCMIN
            share = float(draw.uniform(*_AS_STATED)) * stated / _twist_of_body(drive, reach)
        load, approach = at_rated(REDUCERS[drive])
        body = Body(share * approach / load, reach) if gives else Body()
        reducer = replace(REDUCERS[drive], disc_body=spec_body) if on_bench else REDUCERS[drive]
        truth, shapes = _effects(reducer, files, effects, outside, names, draw)
        if len(truth) < effects + outside:
            continue
        if not on_bench or not Stage(reducer, tuple(truth)).binds():
            break
    else:
        raise ValueError(f"none of {_TRIES} drives has {effects + outside} effects that show and binds nowhere")
    settings = _settings(reducer, files, draw)
    forms = {"reducer": drive, "noise": heard_as}
    if "scan" in kinds:
        forms["scan"] = _scanned(settings)
    if on_bench:
        forms |= {"contact": contact_name, "disc": f"{'rigid' if body.rigid else 'elastic'}, stated {spec_body}"}
    if any(one.name.endswith("_friction") for one in truth):
        forms["friction"] = str(settings["friction_form"])
    forms |= {"shape": ", ".join(shapes)} if shapes else {}
    datum = str(settings.pop("datum"))
    written = measured(reducer, truth, files, settings, noise, datum, seed, contact, body)
    return Case(seed, reducer, written, truth, settings | {"datum": datum}, noise, forms, contact, body)


def _twist_of_body(drive: str, reach: float) -> float:
    """What elastic discs add to the twist at rated torque [rad], over their compliance under one pin as a share."""
    reducer, poses, little = REDUCERS[drive], 12, 0.05
    load, approach = at_rated(reducer)
    output = 2.0 * math.pi * (np.arange(poses) + 0.5) / poses
    torque = np.full(poses, reducer.rated_torque_nm * NEWTON_METRE)
    bodies = (Body(), Body(little * approach / load, reach))
    rigid, elastic = (Stage(reducer, (), Roark(), body).twist(output, torque) for body in bodies)
    return float(np.mean(elastic - rigid)) / little


def _contact(draw: np.random.Generator) -> tuple[str, Law]:
    """The package's own law, written again, in one case of four."""
    laws: list[tuple[str, Law]] = [
        ("Roark", Roark()),
        ("power law", PowerLaw(float(draw.uniform(1.05, 1.25)), float(draw.uniform(0.9, 1.1)))),
        ("linear spring", PowerLaw(1.0, float(draw.uniform(0.9, 1.1)))),
        ("other reference depth", ReferenceDepth(float(draw.uniform(3.0, 15.0)))),
    ]
    return laws[int(draw.integers(len(laws)))]


def _effects(
    reducer: Reducer, files: Sequence[str], effects: int, outside: int, names: Sequence[str], draw: np.random.Generator
) -> tuple[list[Hidden], list[str]]:
    """Effects of distinct names that the files show, and the shapes of theirs that are not the package's."""
    kinds = {FILES[name] for name in files}
    found: list[Hidden] = []
    shapes: list[str] = []
    for pool, count in ((KINDS, effects), (OUTSIDE, outside)):
        shown = [
            name
            for name, kind in pool.items()
            if kind.shows & kinds and (not names or name in names) and (reducer.cranks or not kind.of_cranks)
        ]
        if len(shown) < count:
            return [], []
        for name in draw.choice(shown, size=count, replace=False) if count else []:
            kind = pool[name]
            multiple = float(np.exp(draw.uniform(*np.log(SIZES))))
            on_all = bool(kind.shows & (kinds - {"scan"}))
            discs = tuple(range(1, reducer.discs + 1)) if on_all else tuple(2 if f == "scan2" else 1 for f in files)
            one = kind.draw(str(name), reducer, 1.0, discs, draw)
            size = multiple * typical(str(name), reducer)
            size = 1.0 / size if kind.inverse else size
            one = Hidden(one.name, one.parameters | {kind.key: math.copysign(size, one[kind.key])})
            one, shape = _shaped(one, reducer, draw)
            found.append(one)
            shapes += shape
    return found, shapes


def typical(name: str, reducer: Reducer) -> float:
    """The workshop tolerance for this reducer, in the unit of the effect's size; of a stiffness its inverse."""
    rated = reducer.rated_torque_nm
    if name in {"series_compliance", "x_rate_stiffening"}:
        return _TWIST_ARCMIN / rated
    if name == "coulomb_friction":
        return _FRICTION * rated
    if name == "x_loop_creep":
        return _CREEP
    pool = KINDS if name in KINDS else OUTSIDE
    if not pool[name].key.endswith("_um"):
        return WORKSHOP[name]
    diameter = 2.0 * reducer.pin_circle_radius_mm
    return WORKSHOP[name] * (0.45 * diameter ** (1.0 / 3.0) + 0.001 * diameter) / (0.45 * 100.0 ** (1.0 / 3.0) + 0.1)


def _shaped(one: Hidden, reducer: Reducer, draw: np.random.Generator) -> tuple[Hidden, list[str]]:
    """The effect with a shape of its own, and the name of that shape."""
    blend = {"x_blend_rad": float(draw.uniform(0.2, 1.0))}
    start, clock = float(draw.uniform(0.0, 2.0 * math.pi)), str(draw.choice(["generating", "polar", "arc"]))
    exponent = float(draw.uniform(1.0, 1.5))
    if one.name == "wheel_wear_drift":
        return _with(one, blend | {"x_start_rad": start}), ["jump of wheel wear at any angle"]
    if one.name == "single_tooth_error":
        return _with(one, blend), ["tip blend"]
    if one.name == "flank_wear":
        return _with(one, {"x_exponent": exponent}), ["wear by lever"]
    if one.name == "grinding_chatter":
        most = min(1500.0, 5000.0 / _POINTS_PER_WAVE)
        waves = {"waves_per_turn": float(draw.uniform(4.0 * reducer.lobes, most))}
        return _with(one, blend | waves | {"x_clock": clock}), [f"chatter even in {clock}"]
    return one, []


def _with(one: Hidden, more: dict[str, object]) -> Hidden:
    return Hidden(one.name, one.parameters | more)


def _settings(reducer: Reducer, files: Sequence[str], draw: np.random.Generator) -> dict[str, object]:
    """How it is measured: everything that a bench or a machine leaves open."""
    datum = str(draw.choice(["bore", "free"]))
    some = draw.random() < 0.3
    missing = draw.choice(reducer.lobes, size=int(draw.integers(1, max(2, reducer.lobes // 5))), replace=False) + 1
    rows = {
        "scan": int(draw.integers(3000, 7000)),
        "scan2": int(draw.integers(3000, 7000)),
        "loop": int(draw.integers(150, 400)),
        "te": int(draw.integers(900, 1500)),
        "te_light": int(draw.integers(900, 1500)),
        "lost_motion": int(draw.integers(300, 700)),
    }
    return {
        "turn_deg": float(draw.uniform(-180.0, 180.0)),
        "offset_um": [float(v) for v in draw.uniform(-20.0, 20.0, 2)] if datum == "free" else [0.0, 0.0],
        "output_angle_deg": round(float(draw.uniform(0.0, 360.0)), 3),
        "friction_form": str(draw.choice(list(FORMS))),
        "anticlockwise": bool(draw.random() < 0.5),
        "missing_lobes": sorted(int(lobe) for lobe in missing) if some else [],
        "rows": {name: rows[name] for name in files},
        "datum": datum,
    }


def _scanned(settings: dict[str, object]) -> str:
    gaps = ", lobes missing" if settings["missing_lobes"] else ""
    return f"datum {settings['datum']}{gaps}"
