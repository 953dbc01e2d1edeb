"""Which lobe of a scan is the first: equations counted on, and the count sought anew once the effects are known."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.design.ground import built_reducer
from cycloid_profile.discrepancy.candidates import candidates
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.laid import Laid
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.lobes import counted_on, moved, recounted
from cycloid_profile.discrepancy.normal import Whitened, normal
from cycloid_profile.discrepancy.optimum import Attempt
from cycloid_profile.discrepancy.probes import Probes
from cycloid_profile.discrepancy.recording import record
from cycloid_profile.discrepancy.scans_first import led_by_scans
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.process import CumulativePitchError, DiscOval
from cycloid_profile.effects.ring import PinRingOval
from cycloid_profile.rig.simulate import Settings, simulate
from cycloid_profile.spec.read import parse_spec
from tests.discrepancy.blind import Reducer, spec_text
from tests.discrepancy.protocol import FIVE, Question, ask

LOBES = 39
HALF_A_TURN = 20  # lobes, and half a lobe too far: an oval looks the same but for that
OVAL_UM, OVAL_DEG = 2.3, 142.5


@pytest.fixture(scope="module")
def built() -> Built:
    return built_reducer(parse_spec(spec_text(Reducer())))


def test_equations_of_another_count_are_those_of_the_scan_laid_with_it(built):
    machine = DiscOval(amplitude_um=OVAL_UM, phase_deg=OVAL_DEG, disc=1).apply(built)
    scan = record(built, simulate(machine, "profile_scan", Settings(noise=0.3, seed=1, points=1560)))
    scan = replace(scan, held_out=np.zeros_like(scan.held_out))
    library = candidates(built, frozenset({0}), False)
    probes = Probes(built)
    here = normal([Whitened(Laid(scan, built, probes))], library)
    for lobes in (1, 7, 30):
        there = normal([Whitened(Laid(counted_on(scan, -lobes, LOBES), built, probes))], library)
        further = moved(here, lobes, LOBES)
        assert np.max(np.abs(further.b - there.b)) < 2e-3 * np.max(np.abs(there.b))
        assert np.max(np.abs(further.R - there.R)) < 2e-3 * np.max(np.abs(there.R))


@pytest.mark.slow
def test_a_scan_counted_from_half_a_turn_off_is_counted_right_beside_the_named_oval(built):
    machine = DiscOval(amplitude_um=OVAL_UM, phase_deg=OVAL_DEG, disc=1).apply(built)
    scan = simulate(machine, "profile_scan", Settings(noise=0.3, seed=1, points=1560))
    turn = simulate(machine, "transmission_error", Settings(noise=0.15, seed=2, points=60, torque=12e3))
    right = [record(built, scan), record(built, turn)]
    wrong = [counted_on(right[0], HALF_A_TURN, LOBES), right[1]]
    probes = Probes(built)
    library = Library(candidates(built, frozenset({0}), True), 2)
    oval = next(c for c in library.candidates if c.name == "disc_oval" and c.choice.get("disc") == 1)
    # The compromise of both files, as the search finds it with the wrong count.
    angle = math.radians(2.0 * (OVAL_DEG - 0.8))
    start = OVAL_UM / oval.width * np.array([math.cos(angle), math.sin(angle)])
    models = {
        name: ExactModel(built, some, probes, [Laid(r, built, probes) for r in some])
        for name, some in (("right", right), ("wrong", wrong))
    }
    best = models["wrong"].optimum(Attempt((oval,), start, steps=1), library.prior([oval]))
    counted = recounted(models["wrong"], models["wrong"], library, best)
    assert counted is not models["wrong"]
    first = right[0].placed.turn
    assert counted.recordings[0].placed.turn == pytest.approx(first, abs=1e-4)
    # Counted right it stays, and the same model comes back.
    best = models["right"].optimum(Attempt((oval,), start, steps=1), library.prior([oval]))
    assert recounted(models["right"], models["right"], library, best) is models["right"]


@pytest.mark.slow
def test_what_a_scan_shows_alone_is_tried_from_every_lobe_on(built):
    """A pitch error of both discs cancels on the bench to first order, and another effect stands beside it there."""
    machine = PinRingOval(amplitude_um=2.0, phase_deg=20.0).apply(
        CumulativePitchError(1.7, phase_deg=250.0).apply(built)
    )
    scan = record(built, simulate(machine, "profile_scan", Settings(noise=0.3, seed=1, points=1560)))
    turns = [
        record(
            built, simulate(machine, "transmission_error", Settings(noise=0.15, seed=seed, points=60, torque=torque))
        )
        for seed, torque in ((2, 12e3), (3, None))
    ]
    some, probes = [counted_on(scan, 11, LOBES), *turns], Probes(built)
    library = Library(candidates(built, frozenset({0}), True), 2)
    model = ExactModel(built, some, probes, [Laid(r, built, probes) for r in some])
    counted, found = led_by_scans(model, library, 1e4, lambda _: None)
    assert found is not None
    pitch, oval = found.members
    assert (pitch.name, pitch.choice["disc"]) == ("cumulative_pitch_error", None)
    # The origin of the scan is known to 0.1 µm, which is 3.4° of this error; half a lobe is 4.6°.
    assert pitch.parameters(found.coordinates(0))["phase_deg"] == pytest.approx(250.0, abs=3.4)
    assert oval.name == "pin_ring_oval"
    assert counted.recordings[0].placed.turn == pytest.approx(scan.placed.turn, abs=1e-4)
    # Counted right, it stays; without a scan, or with a clean one, there is nothing to begin with.
    assert led_by_scans(counted, library, 1e4, lambda _: None)[0] is counted
    assert led_by_scans(model.without_scans(), library, 1e4, lambda _: None)[1] is None


@pytest.mark.slow
def test_five_files_name_an_oval_whose_half_turns_look_alike():
    answer = ask(Question("five", 78, {"effects": 1, "files": FIVE, "sizes": (1.0, 1.5), "names": ("disc_oval",)}))
    assert answer.outcome == "exact", answer
