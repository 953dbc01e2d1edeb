"""What a little of an amount does need not be what more of it does: beside a leading effect it is tried at a size."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.design.ground import built_reducer
from cycloid_profile.discrepancy.alias import always_alike
from cycloid_profile.discrepancy.candidates import Candidate, candidates
from cycloid_profile.discrepancy.climbing import Climb, about
from cycloid_profile.discrepancy.evidence import estimate
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.finite_pairs import A_LITTLE, pairs_of_finite_size
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.optimum import Attempt, Optimum
from cycloid_profile.discrepancy.recording import record
from cycloid_profile.effects.compliance import PinSupportCompliance
from cycloid_profile.effects.process import RadialMovingError
from cycloid_profile.rig.simulate import Settings, simulate
from cycloid_profile.spec.read import parse_spec
from tests.discrepancy.blind import Reducer, spec_text

SOME = {"radial_moving_error", "equidistant_error", "pin_radius_error", "thermal_growth", "pin_support_compliance"}


@pytest.fixture(scope="module")
def model() -> ExactModel:
    """A turn at two torques with softer pins, and an infeed of 2.7 µm on disc 2."""
    drawn = built_reducer(parse_spec(spec_text(Reducer())))
    machine = PinSupportCompliance(added_um_per_kn=3.0).apply(RadialMovingError(amount_um=-2.7, disc=2).apply(drawn))
    files = [
        simulate(machine, "transmission_error", Settings(noise=0.15, seed=1, points=1800)),
        simulate(machine, "transmission_error", Settings(noise=0.15, seed=2, points=1800, torque=12.36e3)),
    ]
    return ExactModel(drawn, [record(drawn, one) for one in files])


@pytest.fixture(scope="module")
def library(model: ExactModel) -> Library:
    """Some of the amounts."""
    return Library([c for c in candidates(model.built, frozenset(), True) if c.name in SOME], 2)


@pytest.fixture(scope="module")
def lead(model: ExactModel, library: Library) -> Optimum:
    """The infeed alone."""
    infeed = next(c for c in library.candidates if c.name == "radial_moving_error" and c.choice.get("disc") == 2)
    found = model.optimum(Attempt((infeed,), np.array([-2.6 / infeed.width, 0.0])), library.prior([infeed]))
    assert found is not None
    return found


def softer(library: Library) -> Candidate:
    """The pins on softer springs."""
    return next(c for c in library.candidates if c.name == "pin_support_compliance")


def test_equations_about_none_of_it_would_have_the_pins_stiffer(model, library, lead):
    u = estimate(about(model, library, lead), library.places([*lead.members, softer(library)]))[0]
    assert u[2] < 0.0


@pytest.mark.slow
def test_it_is_found_from_a_size_that_shows(model, library, lead):
    starts = pairs_of_finite_size(model, library, [lead])
    found = Climb(model, library, 8, lambda _: None).judge(starts, lead, A_LITTLE)
    assert [member.name for member in found.members] == ["radial_moving_error", "pin_support_compliance"]
    assert found.coordinates(1)[0] == pytest.approx(3.0, abs=0.3)


def test_every_shape_is_tried_once(model, library, lead):
    starts = pairs_of_finite_size(model, library, [lead, lead])
    partners = [library.members(members)[1] for members, _ in starts]
    assert len({id(one) for one in partners}) == len(partners)
    assert not any(always_alike(model.built, one, lead.members[0]) for one in partners)
    assert all(abs(u[2]) >= 0.3 for _, u in starts)


def test_what_falls_below_the_least_is_given_up(model, library, lead):
    start = np.array([*lead.u, 0.04, 0.0])
    attempt = Attempt((*lead.members, softer(library)), start, steps=1)
    assert model.optimum(attempt, 0.0) is not None
    assert model.optimum(replace(attempt, least=2.0), 0.0) is None
