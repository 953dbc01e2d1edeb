"""What would be seen must show at that size, not only in equations about none of it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.design.ground import built_reducer
from cycloid_profile.discrepancy.candidates import Candidate, candidates
from cycloid_profile.discrepancy.detectable import detectable, noncentrality
from cycloid_profile.discrepancy.laid import Laid
from cycloid_profile.discrepancy.noise import Noise
from cycloid_profile.discrepancy.normal import Whitened, normal
from cycloid_profile.discrepancy.recording import hold_nothing_out, record
from cycloid_profile.discrepancy.seen_on_exact import exact_size, shown
from cycloid_profile.measurement.files import parse_measurement
from cycloid_profile.spec.read import parse_spec
from tests.discrepancy.blind import Hidden, Reducer, spec_text, transmission_error

LIGHT = 12.36  # N·m, 3 % of the rated torque
NOISE = Noise(0.15)
NEEDED = noncentrality(1, 30)


def turn(*hidden: Hidden) -> Laid:
    """A turn under the light torque by the independent generator, without noise, beside the drawing."""
    built = built_reducer(parse_spec(spec_text(Reducer())))
    text = transmission_error(Reducer(), hidden, torque_nm=LIGHT, rows=1200, seed=1)
    ready = hold_nothing_out(record(built, parse_measurement(text, "turn.csv")))
    return Laid(replace(ready, rows=np.arange(1200), held_out=np.zeros(1200, dtype=bool), noise=NOISE), built)


@pytest.fixture(scope="module")
def drawing() -> Laid:
    return turn()


def candidate(laid: Laid, name: str) -> Candidate:
    return next(c for c in candidates(laid.built, frozenset(), True) if c.name == name)


def linear_size(laid: Laid, one: Candidate) -> float:
    return detectable(one, normal([Whitened(laid)], [one]).R, 30)


@pytest.mark.slow
def test_a_play_that_linear_equations_promise_does_not_show_and_the_larger_one_does(drawing):
    """By the generator: the bearings begin to float, and the ripple first falls."""
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
        # The play of the generator is one of its own: a tenth, and a standard deviation of one row.
        assert math.sqrt(changed[-1]) == pytest.approx(math.sqrt(shown([drawing], play, one)), rel=0.1, abs=1.0)
    assert changed[0] < 0.25 * NEEDED
    assert changed[1] > 0.7 * NEEDED


def test_what_is_linear_keeps_its_size(drawing):
    encoder = candidate(drawing, "encoder_eccentricity")
    size = linear_size(drawing, encoder)
    assert exact_size([drawing], encoder, size, NEEDED) == size


def test_what_no_workshop_makes_is_not_seen(drawing):
    softer = candidate(drawing, "crank_bearing_compliance")
    assert exact_size([drawing], softer, 1.01 * softer.implausible, NEEDED) == math.inf
