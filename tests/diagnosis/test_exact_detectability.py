"""A detectable size must be visible with the exact model, not only in linear equations about zero."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import Residuals
from cycloid_profile.diagnosis.data.noise import Noise
from cycloid_profile.diagnosis.data.recording import record, use_all_rows
from cycloid_profile.diagnosis.model.candidate import Candidate, candidates
from cycloid_profile.diagnosis.model.whitened import Whitened, normal_equations
from cycloid_profile.diagnosis.planning.detectable import detectable, exact_size, noncentrality, noncentrality_of
from cycloid_profile.measurement import parse_measurement
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Hidden, Reducer, spec_text, transmission_error

LIGHT = 12.36  # N·m, 3 % of the rated torque
NOISE = Noise(0.15)
NEEDED = noncentrality(1, 30)


def turn(*hidden: Hidden) -> Residuals:
    """A turn at light torque by the independent generator, without noise, and that of the drawing."""
    reducer = as_built_reducer(parse_spec(spec_text(Reducer())))
    text = transmission_error(Reducer(), hidden, torque_nm=LIGHT, rows=1200, seed=1)
    ready = use_all_rows(record(reducer, parse_measurement(text, "turn.csv")))
    return Residuals(replace(ready, rows=np.arange(1200), held_out=np.zeros(1200, dtype=bool), noise=NOISE), reducer)


@pytest.fixture(scope="module")
def drawing() -> Residuals:
    return turn()


def candidate(residuals: Residuals, name: str) -> Candidate:
    return next(c for c in candidates(residuals.reducer, frozenset(), True) if c.name == name)


def linear_size(residuals: Residuals, one: Candidate) -> float:
    return detectable(one, normal_equations([Whitened(residuals)], [one]).R, 30)


@pytest.mark.slow
def test_linear_detectable_clearance_falls_short_and_the_exact_one_is_visible(drawing):
    """In the generator the bearings lose contact, and the ripple decreases first."""
    play = candidate(drawing, "crank_bearing_clearance")
    promised = linear_size(drawing, play)
    size = exact_size([drawing], play, promised, NEEDED)
    assert promised < size < play.implausible
    changed = []
    for one in (promised, size):
        made = turn(Hidden("crank_bearing_clearance", {"radial_um": one}))
        block = Whitened(drawing)
        z = block.white(made.residual - drawing.residual)
        changed.append(block.product(z, z))
        # The generator has its own clearance law: tolerance 10 % and one standard deviation of a row.
        assert math.sqrt(changed[-1]) == pytest.approx(
            math.sqrt(noncentrality_of([drawing], play, one)), rel=0.1, abs=1.0
        )
    # What linear equations promise falls short by a third or more.
    assert changed[0] < 0.67 * NEEDED < changed[1]


def test_linear_effects_keep_their_detectable_size(drawing):
    encoder = candidate(drawing, "encoder_eccentricity")
    size = linear_size(drawing, encoder)
    assert exact_size([drawing], encoder, size, NEEDED) == size


def test_implausible_sizes_are_not_detectable(drawing):
    softer = candidate(drawing, "crank_bearing_compliance")
    assert exact_size([drawing], softer, 1.01 * softer.implausible, NEEDED) == math.inf
