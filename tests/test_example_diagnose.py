"""The examples of diagnosis: what they hide is what they find, and the published rigidity needs a spring in series.

Published numbers are those of docs/articles.md: 72 and 95 N·m/′ measured, 108 N·m/′ of a catalogue, about 560 N·m/′
of mesh and crank bearings alone. The springs are those of two in series, by hand.
"""

from __future__ import annotations

import pytest

import cycloid_profile as cp
from cycloid_profile.spec import read_spec
from tests.plugins import forget
from tests.script_modules import example


@pytest.mark.slow
def test_scan_names_what_was_hidden(tmp_path, capsys):
    module = example("diagnose_scan")
    found, gap = module.found, module.gap
    assert found.verdict == "effects_found"
    by_name = {one.candidate.name: one for one in found.effects}
    assert set(by_name) == {"cumulative_pitch_error", "missing_deformation_compensation"}
    for name, size, hidden in (
        ("cumulative_pitch_error", "amplitude_um", 1.5),
        ("cumulative_pitch_error", "phase_deg", 70.0),
        ("missing_deformation_compensation", "amount_um", 1.0),
    ):
        one = by_name[name]
        # Noise that is drawn once: four standard deviations.
        assert abs(one.parameters[size] - hidden) < 4.0 * one.uncertainty[size]
        # Wear that follows another power of the lever has nearly the shape of a missing compensation.
        assert one.group[0] == name
        assert set(one.group) <= {name, "flank_wear"}
        assert one.parameters["disc"] == 1
    # sin ψ S cos t of 1.5 µm and |sin ψ| S of 1 µm, with 0.3 µm of noise; 800 rows are held out.
    assert gap.fit_before > 2.5 * gap.noise
    assert gap.fit_after == pytest.approx(0.3, rel=0.05)
    assert gap.held_out_after == pytest.approx(0.3, rel=0.1)
    assert module.again.verdict == "agrees"
    module.main(["--out", str(tmp_path / "new")])
    new_spec = read_spec(tmp_path / "new" / "rv40e_diagnosed.toml")
    assert [e["name"] for e in new_spec.effects] == [one.candidate.name for one in found.effects]
    assert {path.suffix for path in (tmp_path / "new").iterdir()} == {".csv", ".toml", ".png", ".svg"}
    out = capsys.readouterr().out
    assert "with the effects added: agrees" in out
    assert "amplitude_um = 1.5" in out


@pytest.mark.slow
def test_an_effect_from_a_plugin_is_named_and_cancelled():
    module = example("three_jaw_clamping")
    (one,) = module.found.effects
    for size in ("amplitude_um", "phase_deg"):
        assert abs(one.parameters[size] - module.HIDDEN[size]) < 4.0 * one.uncertainty[size]
    assert one.group == ("three_jaw_clamping",)
    assert module.gap.held_out_after == pytest.approx(module.NOISE, rel=0.15)
    assert module.corrected.rms_expected == pytest.approx(module.NOISE, rel=0.1)
    # Without it, the library ends here.
    forget()
    blind = cp.diagnosis.diagnose(module.drawn, [module.scan])
    assert blind.verdict == "unknown_effect"
    assert all(near.share < 0.1 for near in blind.nearest)


@pytest.mark.slow
def test_published_rigidity_needs_a_spring_in_series(tmp_path, capsys):
    module = example("diagnose_published_rigidity")
    explained = module.explained
    module.main(["--out", str(tmp_path)])
    assert {path.suffix for path in tmp_path.iterdir()} == {".png", ".svg"}
    assert [one.published for one in explained.values()] == [108.0, 95.0, 72.0]
    for one, series in zip(explained.values(), (139.3, 118.4, 84.7), strict=True):
        # The loop evaluates to the published number: 2 % for the noise of the two points that it is read at.
        assert one.made == pytest.approx(one.published, rel=0.02)
        assert one.series == pytest.approx(series, rel=2e-3)
        assert one.found.verdict == "effects_found"
        (effect,) = one.found.effects
        assert effect.candidate.name == "series_compliance"
        # ± contains what contact law, disc and bearings may err by: some per cent of the loop without the spring.
        stiffness, error = effect.parameters["stiffness_nm_per_arcmin"], effect.uncertainty["stiffness_nm_per_arcmin"]
        assert stiffness == pytest.approx(one.series, rel=1e-2)
        assert abs(stiffness - one.series) < error < 0.05 * stiffness
        (gap,) = one.found.gaps
        assert gap.held_out_before > 1.0
        # The error of the contact law takes the hundredth part of the gap that it may.
        assert gap.held_out_after < 0.01 * gap.held_out_before
    out = capsys.readouterr().out
    assert "alone: 480.1 N·m/′" in out
    for word in ("which part is soft", "one output angle", "single number is no measurement", "72 became 95"):
        assert word in out
