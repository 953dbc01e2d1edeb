"""Where a search for two effects begins: neither of them need do best alone."""

from __future__ import annotations

import pytest

from cycloid_profile.design.ground import built_reducer
from cycloid_profile.discrepancy.candidates import candidates
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.normal import normal
from cycloid_profile.discrepancy.recording import record
from cycloid_profile.discrepancy.second_order import second_order_beside_first
from cycloid_profile.discrepancy.starting import leading_singles
from cycloid_profile.discrepancy.starting_pairs import leading_pairs
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.crank import CrankPhaseError
from cycloid_profile.effects.effect import Effect
from cycloid_profile.effects.friction import EncoderEccentricity
from cycloid_profile.effects.process import CumulativePitchError
from cycloid_profile.effects.ring import PinRingRunout
from cycloid_profile.rig.simulate import Settings, simulate
from cycloid_profile.spec.read import parse_spec
from tests.discrepancy.blind import Reducer, spec_text

ROWS = 75


@pytest.fixture(scope="module")
def drawn() -> Built:
    return built_reducer(parse_spec(spec_text(Reducer())))


def bench(drawn: Built, *hidden: Effect) -> ExactModel:
    machine = drawn
    for effect in hidden:
        machine = effect.apply(machine)
    files = [
        simulate(machine, "transmission_error", Settings(noise=0.15, seed=1, points=ROWS)),
        simulate(machine, "transmission_error", Settings(noise=0.15, seed=2, points=ROWS, torque=12.4e3)),
        simulate(machine, "lost_motion_map", Settings(noise=0.004, seed=3, points=ROWS)),
    ]
    return ExactModel(drawn, [record(drawn, one) for one in files])


@pytest.mark.slow
def test_a_pair_of_which_neither_leads_is_among_the_first(drawn):
    """About the best single effect the search came to rest beside it, on a bore and a planet of the other disc."""
    model = bench(drawn, CumulativePitchError(0.86, phase_deg=58.0, disc=1), CrankPhaseError(5.7, crank=2, disc=2))
    library = Library(candidates(drawn, frozenset(), True), 2)
    equations = normal(model.nothing.blocks, library.candidates)
    singles = leading_singles(model, library, equations, 1e5, lambda _: None)
    pairs = leading_pairs(model, library, singles, lambda _: None, thorough=False)[:3]
    told = [{member.name: member.choice for member in pair.members} for pair in pairs]
    assert {"cumulative_pitch_error": {"disc": 1}, "crank_phase_error": {"crank": 2, "disc": 2}} in told


@pytest.mark.slow
def test_what_cancels_to_first_order_is_sought_beside_what_does_not(drawn):
    """A pin ring off its axis turns the output with the square of its size; alone it explains half of the gap."""
    model = bench(drawn, PinRingRunout(3.2, phase_deg=108.0), EncoderEccentricity(6.0, phase_deg=279.0))
    library = Library(candidates(drawn, frozenset(), True), 2)
    starts = second_order_beside_first(model, library)
    assert {library.candidates[encoder].name for (_, encoder), _ in starts[:3]} == {"encoder_eccentricity"}
    # Which of them is right shows on the exact model.
    (ring, encoder), u = next(start for start in starts if library.candidates[start[0][0]].name == "pin_ring_runout")
    told = library.candidates[encoder].parameters(u[2:] * library.candidates[encoder].width)
    assert told["amplitude_arcsec"] == pytest.approx(6.0, abs=0.3)
    told = library.candidates[ring].parameters(u[:2] * library.candidates[ring].width)
    # Half a turn on hardly differs.
    assert (told["phase_deg"] - 108.0 + 90.0) % 180.0 - 90.0 == pytest.approx(0.0, abs=10.0)
    assert 2.0 < told["amplitude_um"] < 5.0
