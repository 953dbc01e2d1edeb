"""Starting pairs: neither of two effects need rank first alone."""

from __future__ import annotations

import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis.data.recording import record
from cycloid_profile.diagnosis.model.candidate import candidates
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.library import Library
from cycloid_profile.diagnosis.model.normal_equations import normal_equations
from cycloid_profile.diagnosis.search.initial_pairs import rank_initial_pairs
from cycloid_profile.diagnosis.search.initial_singles import rank_initial_singles
from cycloid_profile.diagnosis.search.second_order import second_order_with_first
from cycloid_profile.effects import (
    AsBuiltReducer,
    CrankPhaseError,
    CumulativePitchError,
    Effect,
    EncoderEccentricity,
    PinRingRunout,
)
from cycloid_profile.rig import Settings, simulate
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Reducer, spec_text

ROWS = 75


@pytest.fixture(scope="module")
def drawn() -> AsBuiltReducer:
    return as_built_reducer(parse_spec(spec_text(Reducer())))


def bench(drawn: AsBuiltReducer, *hidden: Effect) -> ExactModel:
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
def test_a_pair_with_no_leading_member_is_among_the_first(drawn):
    """Started from the best single effect, the search stopped at a bore and a planet of the other disc."""
    model = bench(drawn, CumulativePitchError(0.86, phase_deg=58.0, disc=1), CrankPhaseError(5.7, crank=2, disc=2))
    library = Library(candidates(drawn, frozenset(), True), 2)
    equations = normal_equations(model.baseline.blocks, library.candidates)
    singles = rank_initial_singles(model, library, equations, 1e5, lambda _: None)
    pairs = rank_initial_pairs(model, library, singles, lambda _: None, thorough=False)[:3]
    reported = [{member.name: member.choice for member in pair.members} for pair in pairs]
    assert {"cumulative_pitch_error": {"disc": 1}, "crank_phase_error": {"crank": 2, "disc": 2}} in reported


@pytest.mark.slow
def test_second_order_effects_are_paired_with_first_order_effects(drawn):
    """Ring runout turns the output with the square of its size; alone it explains half of the gap."""
    model = bench(drawn, PinRingRunout(3.2, phase_deg=108.0), EncoderEccentricity(6.0, phase_deg=279.0))
    library = Library(candidates(drawn, frozenset(), True), 2)
    starts = second_order_with_first(model, library)
    assert {library.candidates[encoder].name for (_, encoder), _ in starts[:3]} == {"encoder_eccentricity"}
    # The exact model decides between them.
    (ring, encoder), u = next(start for start in starts if library.candidates[start[0][0]].name == "pin_ring_runout")
    reported = library.candidates[encoder].parameters(u[2:] * library.candidates[encoder].width)
    assert reported["amplitude_arcsec"] == pytest.approx(6.0, abs=0.3)
    reported = library.candidates[ring].parameters(u[:2] * library.candidates[ring].width)
    # A rotation by 180° changes hardly anything.
    assert (reported["phase_deg"] - 108.0 + 90.0) % 180.0 - 90.0 == pytest.approx(0.0, abs=10.0)
    assert 2.0 < reported["amplitude_um"] < 5.0
