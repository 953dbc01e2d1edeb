"""Visibility and separation of hidden effects, from the generator's own files."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.diagnosis.blind import KINDS, Body, Hidden, Noise, PowerLaw, draw_case, draw_wide, scan
from tests.diagnosis.blind.reducer import Reducer
from tests.diagnosis.separable import Scaled, View, derivative, inseparable, rivals, seen, strength

SCAN = View(("scan",))
RADIAL = Hidden("radial_moving_error", {"amount_um": 2.0, "disc": 1})
OVAL = Hidden("disc_oval", {"amplitude_um": 2.0, "phase_deg": 30.0, "disc": 1})


@pytest.mark.slow
def test_infeed_and_temperature_are_aliases_on_a_scan():
    (found,) = seen([RADIAL], SCAN)
    assert found.aliases == {"thermal_growth"}
    assert 0.0 < found.sine < 1.0


def test_noise_of_one_standard_deviation_is_found_where_the_length_says():
    """λ² is the signal-to-noise ratio of a matched filter: 2 µm of oval over 5,000 points of 0.3 µm, rms 2/√2."""
    whole = np.linalg.norm(derivative(SCAN, OVAL))
    assert whole == pytest.approx(2.0 / np.sqrt(2.0) / 0.3 * np.sqrt(5000.0), rel=0.02)


def test_what_a_turn_on_the_table_explains_is_no_signal():
    """The registration follows a shifted disc: wholly where the datum is free, else as far as a bore is uncertain."""
    runout = Hidden("disc_runout", {"amplitude_um": 3.0, "phase_deg": 30.0, "form": 1, "disc": 1})
    free = View(("scan",), datum="free")
    assert np.linalg.norm(derivative(free, runout)) < 0.1
    assert np.linalg.norm(derivative(SCAN, runout)) == pytest.approx(3.0 / 0.1, rel=0.01)


def test_correlated_noise_hides_a_slow_effect():
    slow = View(("scan",), noise=(("scan", Noise(0.3, rho=0.6)),))
    ratio = np.linalg.norm(derivative(slow, OVAL)) / np.linalg.norm(derivative(SCAN, OVAL))
    assert ratio == pytest.approx(np.sqrt(0.4 / 1.6), rel=0.02)  # variance at order 0 of AR(1): (1 + ρ)/(1 − ρ)


def test_the_more_drift_the_less_is_seen():
    """A slow shift in x and y looks like a thinner disc: as far as the noise drifts, and no further."""
    one = Hidden("equidistant_error", {"amount_um": 2.0, "disc": 1})
    drifts = [View(("scan",), noise=(("scan", Noise(0.3, drift=drift)),)) for drift in (0.0, 0.5, 2.0)]
    seen_so = [float(np.linalg.norm(derivative(view, one))) for view in drifts]
    assert seen_so[0] > seen_so[1] > seen_so[2] > 4.0


def test_sizes_have_the_wanted_separation():
    draw = np.random.default_rng(3)
    (sized,) = Scaled(("scan",), 6.0, 60.0)([OVAL], {"output_angle_deg": 0.0}, draw)
    (found,) = seen([sized], SCAN)
    scale = found.sine * np.linalg.norm(SCAN.change([sized]))
    assert 6.0 <= scale <= 60.0
    too_small = Hidden("series_compliance", {"stiffness_nm_per_arcmin": 150.0})
    assert Scaled(("scan",), 6.0, 60.0)([too_small], {"output_angle_deg": 0.0}, draw) is None


def test_rivals_are_every_effect_that_the_files_show():
    named = {name for name, _ in rivals(SCAN)}
    assert named == {name for name, kind in KINDS.items() if "scan" in kind.shows} - {"grinding_chatter"}
    assert scan(Reducer(), points=200)


def test_strength_is_that_of_the_case():
    case = draw_case(7, names=("disc_oval",), sizes=(1.0, 1.0))
    (one,) = case.truth
    assert strength(case, one) == pytest.approx(np.linalg.norm(derivative(SCAN, OVAL)), rel=0.02)
    wide = draw_wide(11, names=("disc_oval",))
    assert strength(wide, wide.truth[0]) > 10.0


def test_what_another_contact_law_would_do_is_no_signal():
    """Softer bearings bend a loop as a softer contact does: of a foreign reducer nobody knows which it is."""
    softer = Hidden("crank_bearing_compliance", {"added_um_per_kn": 0.5})
    known = View(("loop",))
    unknown = replace(known, may_be=((PowerLaw(1.25), Body()), (PowerLaw(1.0, 1.1), Body())))
    alone, left = (float(np.linalg.norm(view.change([softer]))) for view in (known, unknown))
    assert left < 0.2 * alone
    friction = Hidden("coulomb_friction", {"torque_nm": 5.0})
    assert np.linalg.norm(unknown.change([friction])) > 0.8 * np.linalg.norm(known.change([friction]))


def test_effects_that_no_analysis_of_a_loop_separates():
    case = draw_case(5, files=("loop",), names=("equidistant_error",))
    names = {"pin_radius_error", "coulomb_friction", "series_compliance"}
    # Thicker pins are a thicker disc. On one disc of two they are not.
    assert inseparable(case, Hidden("equidistant_error", {"amount_um": 1.0}), names) == {"pin_radius_error"}
    assert not inseparable(case, Hidden("equidistant_error", {"amount_um": 1.0, "disc": 1}), names)
