"""Pins, cranks, planets and bearings as they were made."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .hidden import Hidden, named
from .reducer import Reducer
from .units import ARCMIN, DEGREE, UM

Array = np.ndarray


@dataclass(frozen=True)
class Parts:
    """``pin_centre`` and ``pin_radius``, a value each pin; ``eccentric`` in the frame of its crank and ``hole`` in that

    of the carrier, off their places, (discs, cranks); ``lead`` of the planets, complex; ``stiffness`` and ``play`` of
    a bearing; ``seat``, compliance of a pin. mm, N.
    """

    pin_centre: Array
    pin_radius: Array
    eccentric: Array
    hole: Array
    lead: Array
    stiffness: float
    play: float
    seat: float


def parts(reducer: Reducer, effects: Sequence[Hidden]) -> Parts:
    """The parts with all effects."""
    centre, radius = _ring(reducer, effects)
    eccentric, hole, lead = _cranks(reducer, effects)
    softer = sum(one["added_um_per_kn"] for one in named(effects, "crank_bearing_compliance")) * UM / 1e3
    return Parts(
        centre,
        radius,
        eccentric,
        hole,
        lead,
        1.0 / (1.0 / reducer.bearing_stiffness_n_per_mm + softer),
        sum(one["radial_um"] for one in named(effects, "crank_bearing_clearance")) * UM,
        sum(one["added_um_per_kn"] for one in named(effects, "pin_support_compliance")) * UM / 1e3,
    )


def _ring(reducer: Reducer, effects: Sequence[Hidden]) -> tuple[Array, Array]:
    angle = 2.0 * np.pi * np.arange(reducer.pins) / reducer.pins
    radial, along = np.full(reducer.pins, reducer.pin_circle_radius_mm), np.zeros(reducer.pins)
    radius, off = np.full(reducer.pins, reducer.pin_radius_mm), 0j
    for one in effects:
        amount, amplitude, phase = (one.get(key) for key in ("amount_um", "amplitude_um", "phase_deg"))
        phase = phase * DEGREE
        if one.name == "pin_circle_radius_error":
            radial = radial + amount * UM
        elif one.name == "pin_ring_oval":
            radial = radial + amplitude * UM * np.cos(2.0 * (angle - phase))
        elif one.name == "pin_ring_cumulative_pitch":
            along = along + amplitude * UM * np.sin(angle - phase)
        elif one.name == "pin_ring_runout":
            off = off + amplitude * UM * np.exp(1j * phase)
        elif one.name == "pin_radius_error":
            radius = radius + amount * UM
        elif one.name == "single_pin_error":
            radius[(one.number("pin") or 1) - 1] += amount * UM
    return radial * np.exp(1j * (angle + along / reducer.pin_circle_radius_mm)) + off, radius


def _cranks(reducer: Reducer, effects: Sequence[Hidden]) -> tuple[Array, Array, Array]:
    shape = (reducer.discs, reducer.cranks)
    length, ahead, hole = np.full(shape, reducer.eccentricity_mm), np.zeros(shape), np.zeros(shape, dtype=complex)
    lead = np.zeros(reducer.cranks, dtype=complex)
    disc, crank = np.indices(shape) + 1
    for one in effects:
        here = _chosen(one, "disc", disc) & _chosen(one, "crank", crank)
        if one.name == "crank_eccentricity_error":
            length = length + here * one["amount_um"] * UM
        elif one.name == "crank_phase_error":
            ahead = ahead + here * one["angle_arcmin"] * ARCMIN
        elif one.name == "crank_hole_error":
            hole = hole + here * one["amplitude_um"] * UM * np.exp(1j * one.get("direction_deg") * DEGREE)
        elif one.name == "planet_runout":
            swing = one["amplitude_um"] * UM / reducer.planet_radius_mm * np.exp(1j * one.get("phase_deg") * DEGREE)
            lead = lead + _chosen(one, "planet", crank[0]) * swing
    return length * np.exp(1j * ahead), hole, lead


def _chosen(one: Hidden, key: str, number: Array) -> Array:
    chosen = one.number(key)
    return np.full(number.shape, True) if chosen is None else number == chosen
