"""Steps of the verdict by themselves: what comes nearest, what fits as well, what is left, and how much of it."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from cycloid_profile.diagnosis.model.candidate import candidates
from cycloid_profile.diagnosis.model.evidence import Library
from cycloid_profile.diagnosis.model.optimum import Optimum
from cycloid_profile.diagnosis.model.residuals import Residuals, fitted_rms
from cycloid_profile.diagnosis.verdict import _alternatives as alternatives
from cycloid_profile.diagnosis.verdict._identical_effects import always_identical, cosine
from cycloid_profile.diagnosis.verdict.nearest_effects import nearest
from cycloid_profile.diagnosis.verdict.remainder import ScanResidual, smooth_remainder
from cycloid_profile.diagnosis.verdict.rest_curves import empirical_fits, exceeds_noise
from cycloid_profile.diagnosis.verdict.result import FileGap
from cycloid_profile.diagnosis.verdict.workflow import _gap
from cycloid_profile.units import UM
from tests.diagnosis.test_likelihood import equations, reducer, residuals
from tests.diagnosis.test_moves import some


def test_nearest_effects_explain_their_share():
    # χ² is 900 over 1000 rows: with 1000 more to explain, u = R⁻¹b explains bᵀR⁻¹b of them.
    members = list(some("disc_oval", "cumulative_pitch_error", "disc_runout", "crank_hole_error", disc=1))
    (wear,) = some("flank_wear")
    members = [*members, replace(wear, one_sided=True)]
    u = np.array([2.0, 1.0, 1.0, 0.0, 0.0, 0.5, 1.0, 1.0, -2.0, 0.0])
    R = np.diag([100.0, 100.0, 300.0, 300.0, 50.0, 50.0, 10.0, 10.0, 200.0, 0.0])
    linear = replace(equations(R @ u, R, members), chi2=2000.0)
    found = nearest(SimpleNamespace(reducer=reducer()), linear)
    assert [one.name for one in found] == ["flank_wear", "disc_oval", "cumulative_pitch_error"]
    assert [one.share for one in found] == pytest.approx([0.8, 0.5, 0.3])
    assert found[0].why == "amount_um would have to be negative"
    assert found[1].why.endswith("it leaves 50 % of the gap")
    assert found[1].parameters["amplitude_um"] == pytest.approx(math.sqrt(5.0) * members[0].width)
    assert not any(one.too_large for one in found)


def test_what_is_too_large_is_fitted_exactly_and_says_so():
    (oval,) = some("disc_oval", disc=1)
    R, u = np.diag([100.0, 100.0]), np.array([3.0, 2.0])
    linear = replace(equations(R @ u, R, [oval]), chi2=2600.0)
    asked = []

    def optimum(attempt, prior):
        asked.append((attempt.members, attempt.start, prior))
        return SimpleNamespace(u=np.array([3.2, 2.4]), chi2=1080.0)

    model = SimpleNamespace(reducer=reducer(), baseline=SimpleNamespace(chi2=2600.0), optimum=optimum)
    (found,) = nearest(model, linear)
    ((members, start, prior),) = asked
    assert (members, prior) == ((oval,), 0.0)
    np.testing.assert_allclose(start, u)
    # (2600 − 1080)/(2600 − 1000) and 4 of the 3.5 widths that are plausible.
    assert found.share == pytest.approx(0.95)
    assert found.too_large
    assert found.parameters["amplitude_um"] == pytest.approx(4.0 * oval.width)
    assert f"larger than a ground drive of this size plausibly has ({3.5 * oval.width:.3g})" in found.why
    # An exact fit that explains less than the linear one is not taken.
    worse = SimpleNamespace(
        reducer=reducer(), baseline=model.baseline, optimum=lambda *_: SimpleNamespace(u=u * 0.5, chi2=1400.0)
    )
    (found,) = nearest(worse, linear)
    assert found.share == pytest.approx(1300.0 / 1600.0)
    assert not found.too_large
    assert found.why.endswith("it leaves 19 % of the gap")


def test_patterns_and_their_angle():
    one, two, three = some("equidistant_error", "radial_moving_error", "disc_oval", disc=1)
    R = np.zeros((6, 6))
    R[0, 0], R[2, 2], R[0, 2] = 4.0, 25.0, -6.0
    R[2, 0], R[4:, 4:] = R[0, 2], np.eye(2)
    linear = equations(np.zeros(6), R, [one, two, three])
    assert cosine(linear, 0, 1) == cosine(linear, 1, 0) == pytest.approx(0.6)
    assert cosine(linear, 0, 2) == cosine(linear, 2, 0) == 0.0
    assert cosine(equations(np.zeros(4), np.zeros((4, 4)), [one, two]), 0, 1) == 0.0


def test_effects_of_one_shape_are_identical_on_one_disc_only():
    infeed, warm, thin = some("radial_moving_error", "thermal_growth", "equidistant_error", disc=1)
    (other,) = some("thermal_growth", disc=2)
    assert always_identical(reducer(), infeed, infeed)
    assert always_identical(reducer(), infeed, warm) == always_identical(reducer(), warm, infeed)
    assert not always_identical(reducer(), infeed, thin)
    assert not always_identical(reducer(), warm, other)
    assert not always_identical(reducer(), infeed, some("disc_oval", disc=1)[0])
    assert not always_identical(reducer(), some("pin_radius_error")[0], some("pin_radius_error")[0])


def best_of(members, u, misfit=0.0, converged=True):
    n = 2 * len(members)
    return Optimum(tuple(members), np.asarray(u), np.eye(n), np.eye(n), 0.0, misfit, 100, 5.0, converged)


def test_swaps_lose_what_the_other_cannot_explain():
    oval, pitch = some("disc_oval", "cumulative_pitch_error", disc=1)
    (twin,) = some("disc_oval", disc=2)
    (wear,) = some("flank_wear", disc=1)
    members = [oval, pitch, twin, replace(wear, one_sided=True)]
    R = np.diag([50.0, 50.0, 40.0, 40.0, 45.0, 45.0, 30.0, 0.0])
    for a, b, c in ((0, 2, 42.0), (0, 4, 46.0), (0, 6, -38.0), (1, 5, 46.0)):
        R[a, b] = R[b, a] = c
    b = R[:, 0] * 0.9
    linear, known = equations(b, R, members), Library(tuple(members), 2)
    found = SimpleNamespace(library=known, equations=linear, best=best_of([oval], [0.9, 0.0]))

    def fit(i: int) -> float:
        some = slice(2 * i, 2 * i + 2)
        return 0.5 * float(b[some] @ np.linalg.solve(np.eye(2) + R[some, some], b[some]))

    names = alternatives.swaps(found, 0, reach=1e9)
    # The wear would have to be negative, which none is.
    assert [i for i, _ in names] == [1]
    assert names[0][1] == pytest.approx(fit(0) - fit(1))
    assert alternatives.swaps(found, 0, reach=fit(0) - fit(1) - 1e-9) == []
    ((place, deficit),) = alternatives.swaps(found, 0, reach=1e9, other_locations=True)
    assert place == 2
    assert deficit == pytest.approx(fit(0) - fit(2))
    # Given another member the alternative explains what that one leaves.
    both = SimpleNamespace(library=known, equations=linear, best=best_of([twin, oval], [0.5, 0.0, 0.4, 0.0]))
    ((place, deficit),) = alternatives.swaps(both, 1, reach=1e9)

    def together(*numbers: int) -> float:
        where = [2 * i + c for i in numbers for c in (0, 1)]
        return 0.5 * float(b[where] @ np.linalg.solve(np.eye(len(where)) + R[np.ix_(where, where)], b[where]))

    assert place == 1
    assert deficit == pytest.approx(together(2, 0) - together(2, 1))


def test_what_fits_as_well_is_within_three_standard_deviations():
    members = some("disc_oval", disc=1)
    best = best_of(members, [0.1, 0.2], misfit=100.0)
    assert alternatives._fits_as_well(best, best_of(members, [0.1, 0.2], misfit=108.9), 0.0)
    assert not alternatives._fits_as_well(best, best_of(members, [0.1, 0.2], misfit=109.1), 0.0)
    # Not converged: the linear equations decide.
    for converged, deficit, good in ((True, 4.4, False), (False, 4.4, True), (False, 4.6, False)):
        worse = best_of(members, [0.1, 0.2], misfit=200.0, converged=converged)
        assert alternatives._fits_as_well(best, worse, deficit) is good
    assert alternatives._fits_as_well(best, None, 4.4)
    assert not alternatives._fits_as_well(best, None, 4.6)
    assert not alternatives._fits_as_well(best, best_of(members, [3.0, 2.0], misfit=100.0), 0.0)


def test_a_member_moved_last_keeps_its_numbers():
    members = some("disc_oval", "disc_runout", "cumulative_pitch_error", disc=1)
    draw = np.random.default_rng(1)
    spread = draw.normal(size=(6, 6))
    whole = replace(best_of(members, draw.normal(size=6)), covariance=spread @ spread.T, R=spread.T @ spread)
    moved = alternatives._member_last(whole, members[0])
    assert moved.members == (members[1], members[2], members[0])
    for new, old in ((0, 1), (1, 2), (2, 0), (-1, 0)):
        np.testing.assert_array_equal(moved.coordinates(new), whole.coordinates(old))
        np.testing.assert_array_equal(moved.covariance_of(new), whole.covariance_of(old))
    np.testing.assert_allclose(np.linalg.eigvalsh(moved.R), np.linalg.eigvalsh(whole.R), atol=1e-12)
    np.testing.assert_array_equal(np.diag(moved.R)[-2:], np.diag(whole.R)[:2])


@pytest.mark.parametrize(("before", "after", "closed"), [(5.0, 3.0, 2.0 / 3.0), (5.0, 1.0, 1.0), (5.0, 5.0, 0.0)])
def test_closure_is_the_share_of_the_variance_beyond_noise(before, after, closed):
    recording = SimpleNamespace(noise=SimpleNamespace(sigma=1.0))
    gap = FileGap(recording, None, None, 0.0, 0.0, before, after, 1.0)
    assert gap.closure == pytest.approx(closed)
    assert replace(gap, held_out_before=1.41).closure is None
    assert replace(gap, held_out_before=1.42).closure is not None


def test_a_gap_is_measured_on_fitted_and_held_out_rows():
    before = residuals("scan")
    after = before.under(before.recording)
    after.residual = 0.5 * before.residual
    gap = _gap(before.recording, before, after)
    rows = before.recording.held_out
    assert gap.fit_before == fitted_rms(before, ~rows, False)
    assert gap.held_out_before == fitted_rms(before, rows, True)
    assert gap.fit_after == pytest.approx(0.5 * gap.fit_before, rel=0.05)
    assert gap.held_out_after == pytest.approx(0.5 * gap.held_out_before, rel=0.05)
    assert gap.noise == before.recording.noise.sigma
    # χ² of 1 µm of infeed and the noise, per row, a quarter of it after halving; three nuisances are fitted.
    assert gap.chi2_per_row == pytest.approx(0.25 * (1.0 + (1.0 / gap.noise) ** 2), rel=0.15)


def test_only_a_loop_far_above_its_noise_leaves_a_rest():
    loop = residuals("loop")
    for factor, exceeds in ((2.0, False), (4.0, True)):
        one = loop.under(loop.recording)
        draw = np.random.default_rng(3).normal(size=loop.residual.size)
        one.residual = factor * loop.recording.noise.sigma * draw
        assert exceeds_noise(one) is exceeds
        assert not exceeds_noise(residuals("scan"))


def test_a_rest_becomes_a_curve_only_if_held_out_rows_come_closer():
    # 1 µm of infeed: on a scan a form, on a loop a twist.
    scan, turn = residuals("scan"), residuals("turn")
    (found,) = empirical_fits([scan, turn])
    assert (found.file, found.unit) == (scan.recording.name, "um")
    assert found.held_out_before == pytest.approx(fitted_rms(scan, scan.recording.held_out))
    assert found.held_out_after < 0.5 * found.held_out_before
    after = Residuals(scan.recording, found.effect.apply(reducer()))
    assert found.held_out_after == pytest.approx(fitted_rms(after, scan.recording.held_out))
    clean = scan.under(scan.recording)
    clean.residual = scan.recording.noise.sigma * np.random.default_rng(2).normal(size=scan.residual.size)
    assert empirical_fits([clean]) == ()


def test_a_remainder_is_known_as_well_as_its_points_allow():
    # A mean over n points of noise σ errs by σ/√n; p free coefficients by √(p/n) σ.
    draw, lobes = np.random.default_rng(8), 12
    x = np.sort(draw.uniform(0.0, 2.0 * math.pi * lobes, 3000))
    form, errors, stated = 2.0 * np.cos(2.0 * x), [], []
    for rho in (0.0, 0.5):
        rows = (form + 0.3 * draw.normal(size=x.size)) * UM
        found = smooth_remainder([ScanResidual(x, rows, 0.3 * UM, rho)], lobes)
        assert found is not None
        at = np.linspace(0.0, 2.0 * math.pi * lobes, 4000, endpoint=False)
        tooth = SimpleNamespace(lobes=lobes, phase_period=2.0 * math.pi * lobes)
        value = found.curve.derivatives(at, np.ones_like(at), tooth).value
        errors.append(math.sqrt(np.mean((value - 2.0 * np.cos(2.0 * at) * UM) ** 2)))
        stated.append(found.uncertainty)
        assert found.rms == pytest.approx(math.sqrt(2.0) * UM, rel=0.02)
        assert found.largest == pytest.approx(2.0 * UM, rel=0.05)
        assert found.lobes_without == ()
    assert 0.5 < errors[0] / stated[0] < 2.0
    # Of neighbours with a correlation of one half a third of the information is left.
    assert stated[1] / stated[0] == pytest.approx(math.sqrt(3.0), rel=0.2)


def test_noise_alone_leaves_no_curve():
    # A curve must gain four standard deviations of χ²: one noise in thirty thousand does.
    for seed in range(12):
        draw = np.random.default_rng(seed)
        x = np.sort(draw.uniform(0.0, 2.0 * math.pi * 12, 600))
        assert smooth_remainder([ScanResidual(x, 0.3 * UM * draw.normal(size=x.size), 0.3 * UM)], 12) is None


def half_fall(part: Optimum, whole: Optimum) -> float:
    """The deficit where both have the same error of the model."""
    return 0.5 * (part.misfit - whole.misfit)


def test_angles_that_fit_as_well_after_half_a_turn_are_notes():
    ring, everywhere = some("pin_ring_runout", "cumulative_pitch_error", disc=None)
    final = best_of([ring, everywhere], [0.1, 0.2, 0.3, 0.4], 1000.0)

    def notes(*misfit: float | None) -> list[str]:
        answers = iter(None if one is None else SimpleNamespace(misfit_with_prior=one) for one in misfit)
        everything = SimpleNamespace(state=lambda *_: next(answers), deficit=half_fall)
        return alternatives.rotation_notes(everything, final)

    # In turn: the ring, the discs, and both together. Nine of the misfit are three standard deviations.
    assert notes(1009.1, 1009.1, 1009.1) == []
    assert notes(None, None, None) == []
    (one,) = notes(1009.1, 1008.9, 1009.1)
    assert one.startswith("phase_deg of cumulative_pitch_error plus 180° fits as well")
    (both,) = notes(1009.1, None, 990.0)
    assert both.startswith("phase_deg of pin_ring_runout and phase_deg of cumulative_pitch_error plus 180° together")
    # Both together follow from each alone.
    assert len(notes(1001.0, 1001.0, 1001.0)) == 2


def test_a_size_that_fits_as_well_with_the_opposite_sign_is_a_note():
    (crank,), (friction,) = some("crank_eccentricity_error", crank=1), some("coulomb_friction")
    final = best_of([crank, friction], [0.4, 0.0, 0.3, 0.0], 1000.0)
    asked = []

    def notes(misfit: float) -> list[str]:
        def state(_, u):
            asked.append(u)
            return SimpleNamespace(misfit_with_prior=misfit)

        return alternatives.sign_notes(SimpleNamespace(state=state, deficit=half_fall), final)

    # Friction has one sign. Nine of the misfit are three standard deviations.
    assert notes(1009.1) == []
    (one,) = notes(1008.9)
    assert one.startswith("amount_um of crank_eccentricity_error with the opposite sign fits as well")
    np.testing.assert_allclose(asked[0], [-0.4, 0.0, 0.3, 0.0])
    # Both sizes count by one error of the model, whatever they leave by their own.
    everything = SimpleNamespace(state=lambda *_: SimpleNamespace(misfit_with_prior=2000.0), deficit=lambda *_: 4.0)
    assert len(alternatives.sign_notes(everything, final)) == 1


def test_alternatives_are_fitted_exactly_unless_they_were():
    oval, pitch = some("disc_oval", "cumulative_pitch_error", disc=1)
    (twin,) = some("disc_oval", disc=2)
    known = Library((oval, pitch, twin), 2)
    best = best_of([oval], [0.9, 0.0], misfit=100.0)
    asked, begun = [], []

    def optimum(attempt, prior):
        asked.append((attempt.members, attempt.beat, prior))
        begun.append(attempt.start)
        return best_of(attempt.members, [0.5, 0.0], misfit=105.0)

    fitted = best_of([twin], [0.8, 0.1], misfit=99.0)
    found = SimpleNamespace(
        library=known,
        best=best,
        fitted=[fitted],
        model=SimpleNamespace(optimum=optimum),
        start=lambda _: np.array([0.1, 0.0]),
    )
    ((other, again), (far,)) = (
        alternatives._swapped(found, 0, [(1, 1.0), (2, 1.0)], {}),
        alternatives._swapped(found, 0, [(1, 20.0)], {1: np.array([0.7, 0.2])}),
    )
    assert (other.members, again.members, far.members) == ((pitch,), (twin,), (pitch,))
    assert again.misfit == 99.0
    # A near one is fitted to the end, a far one as long as it can still reach the best.
    prior = known.prior([pitch])
    assert asked == [((pitch,), math.inf, prior), ((pitch,), 100.0, prior)]
    # It begins where linear equations say, unless its start is given.
    np.testing.assert_allclose(begun, [[0.1, 0.0], [0.7, 0.2]])


def test_the_nearest_alternatives_join_the_group_if_they_fit_exactly():
    oval, pitch = some("disc_oval", "cumulative_pitch_error", disc=1)
    known, R = Library((oval, pitch), 2), np.diag([50.0, 50.0, 40.0, 40.0])
    R[0, 2] = R[2, 0] = 44.0
    linear = equations(R[:, 0] * 0.9, R, [oval, pitch])
    for misfit, group in ((105.0, [pitch]), (120.0, [])):
        said: list[str] = []
        model = SimpleNamespace(
            only_loops=False, reducer=reducer(), optimum=lambda one, _, m=misfit: best_of(one.members, [0.5, 0.0], m)
        )
        found = SimpleNamespace(
            library=known, equations=linear, best=best_of([oval], [0.9, 0.0], 100.0), fitted=[], model=model,
            start=lambda _: None,
        )  # fmt: skip
        assert alternatives.ambiguity_group(found, linear, 0, said.append) == group
        assert said == ["alternatives: cumulative_pitch_error"]
    # Nothing to evaluate, nothing to say.
    alone = SimpleNamespace(
        library=Library((oval,), 2), equations=equations(R[:2, 0], R[:2, :2], [oval]), best=found.best, fitted=[],
        model=model, start=lambda _: None,
    )  # fmt: skip
    assert alternatives.ambiguity_group(alone, alone.equations, 0, said.append) == []
    assert len(said) == 1


def test_every_near_name_is_fitted_exactly():
    known = candidates(reducer(), frozenset(), True)
    first = {one.name: one for one in reversed(known)}
    members = [first.pop("disc_oval"), *first.values()]
    R = np.diag(np.full(2 * len(members), 1000.0))
    b = np.where(np.arange(2 * len(members)) < 2, 50.0, 1.0)  # half chi² of 2.5 by the oval, so that all are near
    asked: list[float] = []

    def optimum(attempt, _):
        asked.append(attempt.beat)

    found = SimpleNamespace(
        library=Library(tuple(members), 2), equations=equations(b, R, members), fitted=[],
        model=SimpleNamespace(only_loops=False, reducer=reducer(), optimum=optimum),
        best=best_of(members[:1], [0.05, 0.0], 100.0), start=lambda _: None,
    )  # fmt: skip
    # A fit that is given up says that a name fits worse.
    assert alternatives.ambiguity_group(found, found.equations, 0, lambda _: None) == []
    assert asked == [100.0] * len(first)


def test_every_name_is_fitted_in_place_of_the_effect_of_a_loop():
    known = candidates(reducer(), frozenset(), True)
    first = {one.name: one for one in reversed(known)}
    oval = first.pop("disc_oval")
    assert len(first) > 15
    members = [oval, *first.values()]
    # Half chi² of 125 by the oval, nearly nothing by the others in linear equations.
    R = np.diag(np.full(2 * len(members), 1000.0))
    b = np.where(np.arange(2 * len(members)) < 2, 500.0, 1.0)
    asked: list[str] = []
    said: list[str] = []

    def optimum(attempt, _):
        asked.append(attempt.members[0].name)
        return best_of(attempt.members, [0.5, 0.0], 105.0)

    found = SimpleNamespace(
        library=Library(tuple(members), 2), equations=equations(b, R, members), best=best_of([oval], [0.5, 0.0], 100.0),
        fitted=[], start=lambda _: None, model=SimpleNamespace(only_loops=True, reducer=reducer(), optimum=optimum),
    )  # fmt: skip
    group = alternatives.ambiguity_group(found, found.equations, 0, said.append)
    assert set(asked) == {one.name for one in group} == set(first)
    assert said == [f"alternatives: {', '.join(asked[:5])}, …"]
