"""Errors of equivalent discs and cranks look alike on the bench: each is fitted."""

from __future__ import annotations

import numpy as np
import pytest
from cycloid_profile.diagnosis.search.local_search import LocalSearch
from cycloid_profile.diagnosis.search.member_swaps import swap_members

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis.data.recording import record
from cycloid_profile.diagnosis.model.candidate import candidates
from cycloid_profile.diagnosis.model.evidence import Library
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.optimum import Attempt, Optimum
from cycloid_profile.diagnosis.search._symmetric_parts import on_other_parts
from cycloid_profile.effects import AsBuiltReducer, CrankHoleError
from cycloid_profile.rig import Settings, simulate
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Reducer, spec_text

ROWS = 200  # five for each pin pitch
SOME = {"crank_hole_error", "crank_phase_error", "disc_oval", "equidistant_error", "pin_ring_oval"}


@pytest.fixture(scope="module")
def drawn() -> AsBuiltReducer:
    return as_built_reducer(parse_spec(spec_text(Reducer())))


@pytest.fixture(scope="module")
def library(drawn: AsBuiltReducer) -> Library:
    return Library([c for c in candidates(drawn, frozenset(), True) if c.name in SOME], 2)


def bench(drawn: AsBuiltReducer, machine: AsBuiltReducer) -> ExactModel:
    files = [
        simulate(machine, "transmission_error", Settings(noise=0.05, seed=1, points=ROWS)),
        simulate(machine, "transmission_error", Settings(noise=0.05, seed=2, points=ROWS, torque=12.36e3)),
        simulate(machine, "lost_motion_map", Settings(noise=0.001, seed=3, points=ROWS)),
    ]
    return ExactModel(drawn, [record(drawn, one) for one in files])


def fitted(model: ExactModel, library: Library, *wanted: tuple[str, dict, list[float]]) -> Optimum:
    members = [
        next(c for c in library.candidates if c.name == name and all(c.choice.get(k) == v for k, v in choice.items()))
        for name, choice, _ in wanted
    ]
    start = np.concatenate([np.array(size) / m.width for m, (_, _, size) in zip(members, wanted, strict=True)])
    found = model.optimum(Attempt(tuple(members), start), library.prior(members))
    assert found is not None
    return found


def search_from(model: ExactModel, library: Library, *sets: Optimum) -> LocalSearch:
    found = {tuple(sorted(library.places(one.members))): one for one in sets}
    return LocalSearch(model, library, 8, lambda _: None, found)


def test_a_set_is_tried_on_each_disc_and_crank(drawn, library):
    model = bench(drawn, CrankHoleError(amplitude_um=2.6, direction_deg=122.0, crank=3, disc=2).apply(drawn))
    one = fitted(
        model,
        library,
        ("crank_hole_error", {"crank": 2, "disc": 1}, [1.4, -2.2]),
        ("disc_oval", {"disc": 1}, [0.1, 0.2]),
        ("equidistant_error", {"disc": None}, [0.1, 0.0]),
    )
    starts = on_other_parts(search_from(model, library, one))
    reported = [
        tuple((c.choice.get("disc"), c.choice.get("crank")) for c in library.members(places)) for places, _ in starts
    ]
    hole, oval, both = (1, 2), (1, None), (None, None)
    assert sorted(reported, key=str) == sorted(
        [((1, crank), oval, both) for crank in (1, 3)] + [((2, crank), (2, None), both) for crank in (1, 2, 3)], key=str
    )
    assert (hole, oval, both) not in reported
    # Rotation by 180° reverses a direction and leaves an oval unchanged.
    moved = next(u for places, u in starts if library.members(places)[0].choice["disc"] == 2)
    np.testing.assert_allclose(moved[:2], -one.u[:2])
    np.testing.assert_allclose(moved[2:], one.u[2:], atol=1e-12)


def test_effects_that_break_pin_symmetry_are_not_moved(drawn, library):
    model = bench(drawn, drawn)
    ring = fitted(model, library, ("pin_ring_oval", {}, [0.1, 0.1]), ("disc_oval", {"disc": 1}, [0.1, 0.2]))
    assert on_other_parts(search_from(model, library, ring)) == []


@pytest.mark.slow
def test_two_effects_on_the_wrong_disc_are_replaced_by_the_right_one(drawn, library):
    """A bore error of 2.6 µm was named as another bore and a crank phase of the other disc, e¹¹ times less likely."""
    model = bench(drawn, CrankHoleError(amplitude_um=2.6, direction_deg=122.0, crank=3, disc=2).apply(drawn))
    wrong = fitted(
        model,
        library,
        ("crank_phase_error", {"crank": None, "disc": 1}, [2.7, 0.0]),
        ("crank_hole_error", {"crank": 2, "disc": 1}, [1.4, -2.2]),
    )
    right = swap_members(search_from(model, library, wrong), model, wrong)
    assert right.log_evidence > wrong.log_evidence + 3.0
    assert [(m.name, m.choice["crank"], m.choice["disc"]) for m in right.members] == [("crank_hole_error", 3, 2)]


def test_remaining_member_ignores_locations(drawn, library):
    model = bench(drawn, drawn)
    one = fitted(
        model,
        library,
        ("crank_hole_error", {"crank": 2, "disc": 1}, [1.0, 0.0]),
        ("disc_oval", {"disc": 1}, [0.1, 0.2]),
    )
    hole, oval = one.members
    other_locations = next(c for c in library.candidates if c.name == "disc_oval" and c.choice["disc"] == 2)
    other = next(c for c in library.candidates if c.name == "equidistant_error")
    assert one.remaining_member([other_locations]) is hole
    assert one.remaining_member([hole]) is oval
    assert one.remaining_member([other]) is None
    assert one.remaining_member([]) is None
    assert one.remaining_member([hole, other_locations]) is None
