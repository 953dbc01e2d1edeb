"""Lobe index of scans: re-indexed equations, and the index after the effects are known."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import Residuals
from cycloid_profile.diagnosis.data.recording import record
from cycloid_profile.diagnosis.model.candidate import candidates
from cycloid_profile.diagnosis.model.evidence import Library
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.flank_grid import FlankGrid
from cycloid_profile.diagnosis.model.optimum import Attempt
from cycloid_profile.diagnosis.model.whitened import Whitened, normal_equations
from cycloid_profile.diagnosis.search.lobe_index import (
    offsets_about,
    reindexed_equations,
    with_offsets,
    with_raised_index,
)
from cycloid_profile.diagnosis.search.search import search_effects
from cycloid_profile.effects import AsBuiltReducer, CumulativePitchError, DiscOval, PinRingOval
from cycloid_profile.rig import Settings, simulate
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Reducer, spec_text
from tests.diagnosis.protocol import FIVE, Question, ask

LOBES = 39
HALF_A_TURN = 20  # lobes: 180° and half a lobe; an oval differs by that half lobe only
OVAL_UM, OVAL_DEG = 2.3, 142.5


@pytest.fixture(scope="module")
def reducer() -> AsBuiltReducer:
    return as_built_reducer(parse_spec(spec_text(Reducer())))


def test_reindexed_equations_equal_those_of_the_reindexed_scan(reducer):
    machine = DiscOval(amplitude_um=OVAL_UM, phase_deg=OVAL_DEG, disc=1).apply(reducer)
    scan = record(reducer, simulate(machine, "profile_scan", Settings(noise=0.3, seed=1, points=1560)))
    scan = replace(scan, held_out=np.zeros_like(scan.held_out))
    library = candidates(reducer, frozenset({0}), False)
    flank_grid = FlankGrid(reducer)
    here = normal_equations([Whitened(Residuals(scan, reducer, flank_grid))], library)
    for lobes in (1, 7, 30):
        there = normal_equations(
            [Whitened(Residuals(with_raised_index(scan, -lobes, LOBES), reducer, flank_grid))], library
        )
        further = reindexed_equations(here, lobes, LOBES)
        assert np.max(np.abs(further.b - there.b)) < 2e-3 * np.max(np.abs(there.b))
        assert np.max(np.abs(further.R - there.R)) < 2e-3 * np.max(np.abs(there.R))


@pytest.mark.slow
def test_a_scan_indexed_180_degrees_off_is_corrected_given_the_oval(reducer):
    machine = DiscOval(amplitude_um=OVAL_UM, phase_deg=OVAL_DEG, disc=1).apply(reducer)
    scan = simulate(machine, "profile_scan", Settings(noise=0.3, seed=1, points=1560))
    turn = simulate(machine, "transmission_error", Settings(noise=0.15, seed=2, points=60, torque=12e3))
    right = [record(reducer, scan), record(reducer, turn)]
    wrong = [with_raised_index(right[0], HALF_A_TURN, LOBES), right[1]]
    flank_grid = FlankGrid(reducer)
    library = Library(candidates(reducer, frozenset({0}), True), 2)
    oval = next(c for c in library.candidates if c.name == "disc_oval" and c.choice.get("disc") == 1)
    # Compromise of both files, found with the wrong index.
    angle = math.radians(2.0 * (OVAL_DEG - 0.8))
    start = OVAL_UM / oval.width * np.array([math.cos(angle), math.sin(angle)])
    models = {
        name: ExactModel(reducer, some, flank_grid, [Residuals(r, reducer, flank_grid) for r in some])
        for name, some in (("right", right), ("wrong", wrong))
    }
    best = models["wrong"].optimum(Attempt((oval,), start, steps=1), library.prior([oval]))
    counted = with_offsets(models["wrong"], offsets_about(models["wrong"], library, best))
    first = right[0].placed.turn
    assert counted.recordings[0].placed.turn == pytest.approx(first, abs=1e-4)
    best = models["right"].optimum(Attempt((oval,), start, steps=1), library.prior([oval]))
    assert not any(offsets_about(models["right"], library, best))


@pytest.mark.slow
def test_effects_of_a_scan_are_tried_with_every_lobe_index(reducer):
    """A pitch error of both discs cancels on the bench to first order, next to another effect there."""
    machine = PinRingOval(amplitude_um=2.0, phase_deg=20.0).apply(
        CumulativePitchError(1.7, phase_deg=250.0).apply(reducer)
    )
    scan = record(reducer, simulate(machine, "profile_scan", Settings(noise=0.3, seed=1, points=1560)))
    turns = [
        record(
            reducer, simulate(machine, "transmission_error", Settings(noise=0.15, seed=seed, points=60, torque=torque))
        )
        for seed, torque in ((2, 12e3), (3, None))
    ]
    some, flank_grid = [with_raised_index(scan, 11, LOBES), *turns], FlankGrid(reducer)
    library = Library(candidates(reducer, frozenset({0}), True), 2)
    model = ExactModel(reducer, some, flank_grid, [Residuals(r, reducer, flank_grid) for r in some])
    found = search_effects(model, library.candidates, 1e4, lambda _: None)
    best = {one.name: (one, found.best.coordinates(i)) for i, one in enumerate(found.best.members)}
    assert set(best) == {"cumulative_pitch_error", "pin_ring_oval"}
    pitch, size = best["cumulative_pitch_error"]
    assert pitch.choice["disc"] is None
    # The origin of the scan is known to 0.1 µm, or 3.4° of this error; half a lobe is 4.6°.
    assert pitch.parameters(size)["phase_deg"] == pytest.approx(250.0, abs=3.4)
    assert found.model.recordings[0].placed.turn == pytest.approx(scan.placed.turn, abs=1e-4)


@pytest.mark.slow
def test_five_files_name_an_oval_with_ambiguous_lobe_index():
    answer = ask(Question("five", 78, {"effects": 1, "files": FIVE, "sizes": (1.0, 1.5), "names": ("disc_oval",)}))
    assert answer.outcome == "exact", answer
