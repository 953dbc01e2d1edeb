"""Likelihood of noise, nuisances and effects against dense covariance matrices, evidence against integrals.

½(χ² + ln det) is −ln L of a normal distribution whose covariance holds the noise and all nuisances.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import block_diag, toeplitz
from scipy.special import ndtr
from scipy.stats import norm

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import Residuals, nuisance_fitted
from cycloid_profile.diagnosis.data.noise import Noise, _Ordinates, sidak, upper_tail
from cycloid_profile.diagnosis.data.recording import record
from cycloid_profile.diagnosis.model._model_error import form_error
from cycloid_profile.diagnosis.model.candidate import Candidate, candidates
from cycloid_profile.diagnosis.model.evidence import (
    Library,
    best_extension_or_self,
    distinct,
    estimate,
    is_plausible,
    linear_evidence,
    log_evidence_at,
    log_priors,
    scores,
)
from cycloid_profile.diagnosis.model.whitened import FileEquations, NormalEquations, Whitened, normal_equations
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.measurement import TRANSMISSION_ERROR, parse_measurement
from cycloid_profile.rig import Settings, simulate
from cycloid_profile.spec import parse_spec
from tests.diagnosis import blind

NOISES = {
    "white": Noise(0.3),
    "every other row": Noise(1.0, 0.0, -0.4),
    "AR(1)": Noise(0.3, 0.7),
    "AR(2)": Noise(0.3, 0.64, -0.4),
    "rough": Noise(2.0, -0.3, 0.5),
}
each_noise = pytest.mark.parametrize("noise", NOISES.values(), ids=NOISES)


def covariance(noise: Noise, starts: np.ndarray) -> np.ndarray:
    """Of rows in runs that know nothing of each other, from the recursion of the correlation."""
    ends = [*np.flatnonzero(starts)[1:], starts.size]
    lengths = np.diff([0, *ends])
    first, r = noise.rho * (1.0 - noise.partial), [1.0, noise.rho]
    while len(r) < starts.size:
        r.append(first * r[-1] + noise.partial * r[-2])
    return noise.sigma**2 * block_diag(*(toeplitz(r[:n]) for n in lengths))


@each_noise
def test_whitened_rows_have_a_unit_covariance(noise):
    starts = np.zeros(23, dtype=bool)
    starts[[0, 1, 3, 10, 22]] = True  # runs of one, two, seven, twelve rows and one
    W, C = noise.whitening(starts) @ np.eye(23), covariance(noise, starts)
    np.testing.assert_allclose(W @ C @ W.T, np.eye(23), atol=1e-12)
    np.testing.assert_allclose(noise.whitening(starts) @ (np.arange(23.0) + 1j), W @ (np.arange(23.0) + 1j), atol=1e-12)
    # The last row of a long run, given all before it.
    assert 1.0 / W[21, 21] == pytest.approx(noise.innovation)


@each_noise
def test_correlations_are_those_of_the_spectrum_of_means_and_of_fewer_rows(noise):
    omega = np.pi * (np.arange(4000) + 0.5) / 4000
    r = noise.correlation(60)
    for k in (0, 1, 2, 7):
        assert np.mean(noise.spectrum(omega) * np.cos(k * omega)) == pytest.approx(noise.sigma**2 * r[k], abs=1e-9)
    C = noise.sigma**2 * toeplitz(r)
    for n in (1, 2, 5):
        means, fewer = np.kron(np.eye(3), np.full(n, 1.0 / n)), np.kron(np.eye(3), np.eye(n)[0])
        for rows, found in ((means, noise.averaged(n)), (fewer, noise.thinned(n))):
            wanted = rows @ C[: 3 * n, : 3 * n] @ rows.T
            np.testing.assert_allclose(found.sigma**2 * toeplitz(found.correlation(3)), wanted, atol=1e-12)
        assert noise.mean_sigma(n) == noise.averaged(n).sigma


@pytest.mark.parametrize(("rho", "partial"), [(0.643, -0.413), (0.347, 0.231), (-0.213, 0.573)])
def test_the_most_likely_noise_of_its_own_spectrum_is_itself(rho, partial):
    # Ordinates that are their own expectation. The grid has steps of 0.02, the finer one about its best of 0.004.
    true, omega = Noise(2.0, rho, partial), np.pi * (np.arange(9600) + 0.5) / 9600
    one, none = np.ones(omega.size), np.zeros(omega.size)
    spectrum = _Ordinates(omega, true.spectrum(omega), one, one, none > 0.0, none)
    found = spectrum._banded(one, 2)
    assert found.rho == pytest.approx(rho, abs=0.003)
    assert found.partial == pytest.approx(partial, abs=0.003)
    assert found.sigma == pytest.approx(2.0, rel=0.01)


def test_tail_probabilities():
    for score in (-2.0, 0.0, 1.0, 6.0):
        assert upper_tail(score) == pytest.approx(norm.sf(score), rel=1e-12)
    # The least of ten p-values: none of ten independent tests is below p with the probability (1 − p)¹⁰.
    assert sidak(0.03, 10) == pytest.approx(1.0 - 0.97**10, rel=1e-12)
    assert sidak(1e-15, 1000) == pytest.approx(1e-12, rel=1e-3)
    assert sidak(1.0, 3) == pytest.approx(1.0)


@cache
def reducer() -> AsBuiltReducer:
    return as_built_reducer(parse_spec(blind.spec_text(blind.Reducer())))


@cache
def library(curves: bool) -> tuple[Candidate, ...]:
    return candidates(reducer(), frozenset({0}), curves)


def some(curves: bool, *names: str) -> list[Candidate]:
    return [next(one for one in library(curves) if one.name == name) for name in names]


@cache
def residuals(kind: str, seed: int = 3) -> Residuals:
    """Residuals of a short file of one effect."""
    plain, hidden = blind.Reducer(), blind.Hidden("equidistant_error", {"amount_um": 1.0})
    if kind == "scan":
        text = blind.scan(plain, [hidden], points=300, noise=blind.Noise(0.3), seed=seed)
    elif kind == "turn":
        text = blind.transmission_error(plain, [hidden], torque_nm=412.0, rows=120, noise=blind.Noise(0.1), seed=seed)
    else:
        text = blind.loop(plain, [hidden], rows=80, noise=blind.Noise(0.004), seed=seed)
    return Residuals(record(reducer(), parse_measurement(text, f"{kind}.csv")), reducer())


def with_noise(one: Residuals, noise: Noise) -> Residuals:
    return one.under(replace(one.recording, noise=replace(noise, sigma=one.recording.noise.sigma)))


KINDS = {
    "scan": (False, ("equidistant_error", "disc_runout", "wheel_wear_drift")),
    "loop": (True, ("equidistant_error", "series_compliance", "crank_hole_error")),
    "turn": (True, ("pin_ring_runout", "encoder_eccentricity")),
}


def dense(block: Whitened, columns: np.ndarray) -> np.ndarray:
    """Covariance of the rows of a file: noise and nuisances of width 1."""
    one, rows = block.residuals, block.chosen
    own = covariance(one.recording.noise, one.recording.starts(rows))
    A = np.hstack([one.nuisance, one.row_error, one.model_error, one.path_error, columns])[rows]
    wide = A.astype(np.longdouble)
    return own + wide @ wide.T


def solved(C: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """C⁻¹ columns to the last digit: rows near zero torque err by thousands of standard deviations."""
    double, found = C.astype(np.float64), np.zeros(columns.shape, dtype=np.longdouble)
    for _ in range(4):
        found += np.linalg.solve(double, (columns - C @ found).astype(np.float64))
    return found.astype(np.float64)


@pytest.mark.parametrize("kind", KINDS)
@each_noise
def test_normal_equations_are_those_of_a_dense_covariance(kind, noise):
    curves, names = KINDS[kind]
    one, members = with_noise(residuals(kind), noise), some(curves, *names)
    # Free nuisances of 10⁶ standard deviations leave a dense matrix with few digits.
    one.nuisance = np.clip(one.nuisance, -10.0, 10.0)
    u = np.array([0.3, 0.0, -0.2, 0.1, 0.5, 0.0])[: 2 * len(members)]
    block = Whitened(one, members=members, u=u)
    r, G = one.residual[block.chosen], one.columns(members).reshape(one.residual.size, -1)[block.chosen]
    C = dense(block, one.form_error(members, u))
    found = normal_equations([block], members)
    np.testing.assert_allclose(found.b, G.T @ solved(C, r), rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(found.R, G.T @ solved(C, G), rtol=1e-6, atol=1e-9)
    assert found.chi2 == pytest.approx(r @ solved(C, r), rel=1e-7)
    assert found.rows == block.z.size == np.count_nonzero(~one.recording.held_out)
    own = covariance(one.recording.noise, one.recording.starts(block.chosen))
    assert block.log_det == pytest.approx(
        np.linalg.slogdet(C.astype(np.float64))[1] - np.linalg.slogdet(own)[1], rel=1e-7
    )
    A, z = block.nuisance, block.z
    fitted = A @ np.linalg.solve(np.eye(A.shape[1]) + A.T @ A, A.T @ z)
    np.testing.assert_allclose(block.projected(z), z - fitted, atol=1e-8)


def test_equations_about_an_estimate_are_those_about_zero():
    block, members = Whitened(residuals("scan")), some(False, *KINDS["scan"][1])
    whole, u = normal_equations([block], members), np.array([0.3, 0.0, -0.2, 0.1, 0.5, 0.0])
    # The effects taken off: what is left has other equations.
    left = block.z - block.columns(members) @ u
    G = block.columns(members)
    shifted = replace(whole, b=block.product(G, left), chi2=float(block.product(left, left)))
    again = shifted.about([0, 1, 2], u)
    np.testing.assert_allclose(again.b, whole.b, rtol=1e-9, atol=1e-6)
    assert again.chi2 == pytest.approx(whole.chi2, rel=1e-9)
    both = whole.plus(whole)
    assert (both.rows, both.chi2, len(both.parts)) == (2 * whole.rows, 2.0 * whole.chi2, 2)
    np.testing.assert_array_equal(both.R, 2.0 * whole.R)
    np.testing.assert_array_equal(both.b, 2.0 * whole.b)


def test_contribution_of_a_member_is_what_the_others_cannot_take_over():
    block, members = Whitened(residuals("scan")), some(False, *KINDS["scan"][1])
    found, u = normal_equations([block], members), np.array([0.3, 0.0, -0.2, 0.1, 0.5, 0.0])
    # M is no projection: its root makes it one.
    root = np.linalg.cholesky(block.projected(np.eye(block.z.size))).T
    G = root @ block.columns(members)
    for of in range(3):
        own, others = G[:, 2 * of : 2 * of + 2] @ u[2 * of : 2 * of + 2], np.delete(G, [2 * of, 2 * of + 1], axis=1)
        left = own - others @ np.linalg.lstsq(others, own, rcond=1e-9)[0]
        recording = block.residuals.recording
        rms = math.sqrt(np.mean(left**2)) * recording.noise.sigma
        assert found.contribution([0, 1, 2], u, of) == pytest.approx(rms / recording.accuracy, rel=1e-6)


@pytest.mark.parametrize("held_out", [False, True])
def test_nuisances_are_fitted_to_the_rows_asked_for(held_out):
    one = residuals("scan")
    rows = one.recording.held_out == held_out
    # A turn and a small shift of the disc on the table: less than a third of the shift is left, as it might be form.
    shifted = one.under(one.recording)
    shifted.residual = one.residual + one.nuisance @ np.array([3e-5, 0.8, -0.5])
    found, before = nuisance_fitted(shifted, held_out), nuisance_fitted(one, held_out)
    turned, x, y = np.linalg.lstsq(one.nuisance, found - before, rcond=None)[0]
    assert abs(turned) < 1e-6
    assert abs(x) < 0.8 / 3.0
    assert abs(y) < 0.5 / 3.0
    # The turn is free: nothing of it is left in the rows it was fitted to.
    assert one.nuisance[rows, 0] @ found[rows] == pytest.approx(0.0, abs=1e-6 * np.abs(one.nuisance[:, 0]).sum())
    # The shift is not: beyond two accuracies it stays.
    far = one.under(one.recording)
    far.residual = one.residual + one.nuisance[:, 1] * 50.0
    left = np.abs(np.linalg.lstsq(one.nuisance, nuisance_fitted(far, held_out) - before, rcond=None)[0][1])
    assert left == pytest.approx(48.0, abs=2.0)


def equations(b: list[float], R: list[list[float]], members: list[Candidate]) -> NormalEquations:
    b, R = np.asarray(b, dtype=float), np.asarray(R, dtype=float)
    return NormalEquations(tuple(members), b, R, 900.0, 1000, (FileEquations(R, 1000, 0.3, 0.008),))


def test_the_form_of_an_effect_has_no_error_in_a_zero_that_is_not_seen():
    reducer = as_built_reducer(parse_spec(blind.spec_text(blind.Reducer())))
    curve = simulate(reducer, TRANSMISSION_ERROR, Settings(points=240, noise=0.1))
    recording, angle = record(reducer, curve), np.radians(curve["output_angle_deg"])
    signature = np.sin(angle + 0.3)
    error, raised = (form_error(signature + zero, reducer, recording, angle, angle) for zero in (0.0, 5.0))
    np.testing.assert_allclose(raised, error, rtol=0.0, atol=1e-12)
    assert np.max(np.abs(error)) > 0.01


@pytest.mark.parametrize(("b", "R"), [(3.0, 4.0), (-1.0, 2.0), (40.0, 25.0)])
@pytest.mark.parametrize("one_sided", [False, True])
def test_evidence_of_one_size_is_its_integral(b, R, one_sided):
    (member,) = some(False, "flank_wear")
    member = replace(member, one_sided=one_sided)
    likelihood = lambda x: math.exp(b * x - 0.5 * R * x * x)  # noqa: E731
    prior = lambda x: (2.0 if one_sided else 1.0) * norm.pdf(x)  # noqa: E731
    low = 0.0 if one_sided else -10.0
    integral, _ = quad(lambda x: likelihood(x) * prior(x), low, 10.0, points=[b / (1.0 + R)], epsabs=0.0, epsrel=1e-11)
    found = equations([b, 0.0], [[R, 0.0], [0.0, 0.0]], [member])
    assert linear_evidence(found, np.array([-2.5]), [0]) == pytest.approx(math.log(integral) - 2.5, rel=1e-9)
    u, spread = estimate(found, [0])
    # At the optimum χ² fell by 2bû − Rû².
    fall = float(2.0 * b * u[0] - R * u[0] ** 2)
    assert log_evidence_at(fall, u, spread, -2.5, [member]) == pytest.approx(math.log(integral) - 2.5, rel=1e-9)
    (weighed,) = scores(found, np.array([-2.5]), np.array([[0]])) or (None,)
    if one_sided and b < 0.0:
        assert weighed is None
    else:
        assert weighed.log_evidence == pytest.approx(math.log(integral) - 2.5, rel=1e-9)


def test_evidence_of_a_direction_and_of_two_effects_is_their_integral():
    runout, wear = some(False, "disc_runout", "flank_wear")
    wear = replace(wear, one_sided=True)
    b, R = np.array([2.0, -1.0]), np.array([[5.0, 1.5], [1.5, 3.0]])

    # The trapezoidal rule of a normal integrand errs by rounding.
    x, y = np.meshgrid(axis := np.linspace(-9.0, 9.0, 401), axis)
    quadratic = R[0, 0] * x * x + 2.0 * R[0, 1] * x * y + R[1, 1] * y * y
    first = np.sum(np.exp(b[0] * x + b[1] * y - 0.5 * quadratic) * norm.pdf(x) * norm.pdf(y)) * 0.045**2
    second, _ = quad(lambda x: math.exp(4.0 * x - 3.0 * x * x) * 2.0 * norm.pdf(x), 0.0, 8.0, epsabs=0.0, epsrel=1e-11)
    found = equations([*b, 4.0, 0.0], block_diag(R, np.diag([6.0, 0.0])), [runout, wear])
    priors = np.array([-1.0, -2.0])
    for members, wanted in (([0], math.log(first) - 1.0), ([0, 1], math.log(first * second) - 3.0)):
        assert linear_evidence(found, priors, members) == pytest.approx(wanted, abs=1e-8)
        (one,) = scores(found, priors, np.array([members]))
        assert one.members == tuple(members)
        assert one.log_evidence == pytest.approx(wanted, abs=1e-8)
    assert linear_evidence(found, priors, []) == 0.0
    # The better of the wear alone and with the runout.
    best = best_extension_or_self(found, priors, [1])
    alone, both = (linear_evidence(found, priors, members) for members in ([1], [1, 0]))
    assert best.log_evidence == pytest.approx(max(alone, both))
    assert best.members == ((1, 0) if both > alone else (1,))


def test_a_candidate_is_visible_by_either_of_its_columns():
    three = some(False, "disc_runout", "disc_oval", "cumulative_pitch_error")
    R = block_diag(np.diag([9.0, 0.0]), np.diag([0.0, 9.0]), np.zeros((2, 2)))
    np.testing.assert_array_equal(distinct(equations([0.0] * 6, R, three), []), [0, 1])


def test_effects_that_share_a_pattern_share_the_evidence():
    # Two effects of one pattern: the evidence of both together is less than that of one alone.
    runout, oval = some(False, "disc_runout", "disc_oval")
    pattern = np.array([[9.0, 0.0], [0.0, 9.0]])
    found = equations([6.0, 3.0, 6.0, 3.0], np.block([[pattern, pattern], [pattern, pattern]]), [runout, oval])
    alone, both = linear_evidence(found, np.zeros(2), [0]), linear_evidence(found, np.zeros(2), [0, 1])
    # By hand: ½ bᵀ(1 + R)⁻¹b − ½ ln|1 + R| with the eigenvalues 10 and 19 of 1 + R.
    assert alone == pytest.approx(0.5 * 45.0 / 10.0 - math.log(10.0))
    assert both == pytest.approx(0.5 * 90.0 / 19.0 - math.log(19.0))


def test_plausible_sizes_are_within_the_prior_and_on_the_side_that_exists():
    runout, wear = some(False, "disc_runout", "flank_wear")
    for u, good in (((2.4, 2.5), True), ((2.5, 2.5), False), ((-2.4, -2.5), True)):
        assert is_plausible([runout], np.array(u)) is good
    wear = replace(wear, one_sided=True)
    for u, good in (((3.4, 0.0), True), ((3.6, 0.0), False), ((-0.1, 0.0), False), ((0.0, 0.0), False)):
        assert is_plausible([wear], np.array(u)) is good
        assert is_plausible([runout, wear], np.array([1.0, 1.0, *u])) is good


def test_prior_odds_are_shared_by_the_locations_of_an_effect():
    found, odds = log_priors(library(False)), 0.05 / 0.95
    for name in {one.name for one in library(False)}:
        shares = [math.exp(value) for one, value in zip(library(False), found, strict=True) if one.name == name]
        assert sum(shares) == pytest.approx(odds)
    change = [replace(library(False)[0].change, log_odds=-1.5)]
    assert log_priors([library(False)[0], *change])[1] == pytest.approx(math.log(odds) - 1.5)
    both = Library(tuple(library(False)[:3]), 7)
    assert both.prior(both.candidates[1:]) == pytest.approx(float(np.sum(log_priors(library(False)[:3])[1:])))


def test_half_normal_prior_by_the_normal_integral():
    (wear,) = some(False, "flank_wear")
    wear = replace(wear, one_sided=True)
    for u, sigma in ((0.5, 0.5), (-0.5, 0.5), (2.0, 0.1)):
        spread = np.diag([sigma**2, 1.0])
        plain = log_evidence_at(0.0, np.array([u, 0.0]), spread, 0.0, [replace(wear, one_sided=False)])
        half = log_evidence_at(0.0, np.array([u, 0.0]), spread, 0.0, [wear])
        assert half - plain == pytest.approx(math.log(2.0 * ndtr(u / sigma)))
