"""What is wrong with one disc and crank looks like what is wrong with others: those are tried, not guessed."""

from __future__ import annotations

import numpy as np
import pytest

from cycloid_profile.design.ground import built_reducer
from cycloid_profile.discrepancy.candidates import candidates
from cycloid_profile.discrepancy.climbing import Climb
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.exchange import exchanged
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.optimum import Attempt, Optimum
from cycloid_profile.discrepancy.other_parts import of_other_parts
from cycloid_profile.discrepancy.recording import record
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.crank import CrankHoleError
from cycloid_profile.rig.simulate import Settings, simulate
from cycloid_profile.spec.read import parse_spec
from tests.discrepancy.blind import Reducer, spec_text

ROWS = 200  # five a pin pitch
SOME = {"crank_hole_error", "crank_phase_error", "disc_oval", "equidistant_error", "pin_ring_oval"}


@pytest.fixture(scope="module")
def drawn() -> Built:
    return built_reducer(parse_spec(spec_text(Reducer())))


@pytest.fixture(scope="module")
def library(drawn: Built) -> Library:
    return Library([c for c in candidates(drawn, frozenset(), True) if c.name in SOME], 2)


def bench(drawn: Built, machine: Built) -> ExactModel:
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


def begun(model: ExactModel, library: Library, *sets: Optimum) -> Climb:
    found = {tuple(sorted(library.places(one.members))): one for one in sets}
    return Climb(model, library, 8, lambda _: None, found)


def test_a_set_is_tried_on_each_disc_and_crank(drawn, library):
    model = bench(drawn, CrankHoleError(amplitude_um=2.6, direction_deg=122.0, crank=3, disc=2).apply(drawn))
    one = fitted(
        model,
        library,
        ("crank_hole_error", {"crank": 2, "disc": 1}, [1.4, -2.2]),
        ("disc_oval", {"disc": 1}, [0.1, 0.2]),
        ("equidistant_error", {"disc": None}, [0.1, 0.0]),
    )
    starts = of_other_parts(begun(model, library, one))
    told = [
        tuple((c.choice.get("disc"), c.choice.get("crank")) for c in library.members(places)) for places, _ in starts
    ]
    hole, oval, both = (1, 2), (1, None), (None, None)
    assert sorted(told, key=str) == sorted(
        [((1, crank), oval, both) for crank in (1, 3)] + [((2, crank), (2, None), both) for crank in (1, 2, 3)], key=str
    )
    assert (hole, oval, both) not in told
    # Half a turn on a direction is the opposite one, and an oval the same.
    moved = next(u for places, u in starts if library.members(places)[0].choice["disc"] == 2)
    np.testing.assert_allclose(moved[:2], -one.u[:2])
    np.testing.assert_allclose(moved[2:], one.u[2:], atol=1e-12)


def test_what_tells_pins_apart_is_left_to_few_rows(drawn, library):
    model = bench(drawn, drawn)
    ring = fitted(model, library, ("pin_ring_oval", {}, [0.1, 0.1]), ("disc_oval", {"disc": 1}, [0.1, 0.2]))
    assert of_other_parts(begun(model, library, ring)) == []


@pytest.mark.slow
def test_two_on_the_wrong_disc_give_way_to_one_on_the_right(drawn, library):
    """A bore of 2.6 µm was told as another bore and a crank's lead on the other disc, e¹¹ times less likely."""
    model = bench(drawn, CrankHoleError(amplitude_um=2.6, direction_deg=122.0, crank=3, disc=2).apply(drawn))
    wrong = fitted(
        model,
        library,
        ("crank_phase_error", {"crank": None, "disc": 1}, [2.7, 0.0]),
        ("crank_hole_error", {"crank": 2, "disc": 1}, [1.4, -2.2]),
    )
    right = exchanged(begun(model, library, wrong), model, wrong)
    assert right.log_evidence > wrong.log_evidence + 3.0
    assert [(m.name, m.choice["crank"], m.choice["disc"]) for m in right.members] == [("crank_hole_error", 3, 2)]


def test_who_stands_beside_the_same_names_does_so_wherever_these_are(drawn, library):
    model = bench(drawn, drawn)
    one = fitted(
        model,
        library,
        ("crank_hole_error", {"crank": 2, "disc": 1}, [1.0, 0.0]),
        ("disc_oval", {"disc": 1}, [0.1, 0.2]),
    )
    hole, oval = one.members
    elsewhere = next(c for c in library.candidates if c.name == "disc_oval" and c.choice["disc"] == 2)
    other = next(c for c in library.candidates if c.name == "equidistant_error")
    assert one.beside([elsewhere]) is hole
    assert one.beside([hole]) is oval
    assert one.beside([other]) is None
    assert one.beside([]) is None
    assert one.beside([hole, elsewhere]) is None
