"""Elastic discs: the finite elements against closed solutions, and the equilibrium against its own equations."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csc_array

from cycloid_profile.contact import LoadCase
from cycloid_profile.contact.bodies import (
    DiscCompliance,
    PartDeviations,
    disc_compliance,
    kept_compliance,
    read_disc_compliance,
    stage_compliance,
    stage_displacements,
    support_model,
)
from cycloid_profile.contact.bodies.elastic_disc._elements import (
    _below,
    _displacements,
    _inwards,
    _three_fixed,
    condensed,
    disc_basis,
    plane_stress,
)
from cycloid_profile.contact.disc import Equilibrium
from cycloid_profile.contact.laws import LAWS
from cycloid_profile.contact.mesh import gaps, mesh, mesh_cycle, output_turn
from cycloid_profile.contact.stage import StageEquilibrium, StageTangent
from cycloid_profile.errors import GeometryError, LoadError
from cycloid_profile.geometry import (
    CentralEccentric,
    DiscOutline,
    circular_contour,
    ring_of_holes,
    ring_of_windows,
)
from cycloid_profile.modification import Equidistant, modify
from cycloid_profile.units import ARCSEC

E, NU, WIDTH = 206e3, 0.3, 11.5
HOLES = (circular_contour("bore", 0j, 16.0), *ring_of_holes("crank hole", 3, 36.0, 13.0))
PILLARS = ring_of_windows("window", 3, (26.0, 48.0), math.radians(34.0), 0.0, math.radians(60.0))


def outline(drive, contours=HOLES) -> DiscOutline:
    return DiscOutline(drive.theoretical_profile, contours)


def bodies(drive, contours=HOLES, **options) -> tuple[DiscCompliance, ...]:
    turned = 2.0 * math.pi / (drive.discs * drive.trochoid.lobes)
    return tuple(disc_compliance(outline(drive, contours), E, NU, WIDTH, j * turned, **options) for j in range(2))


@pytest.fixture(scope="module")
def rigid(rv40e) -> LoadCase:
    return LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), 412e3, law=LAWS["weber-banaschek"])


@pytest.fixture(scope="module")
def elastic(rigid) -> LoadCase:
    return replace(rigid, disc_bodies=bodies(rigid.drive))


def circle(radius: float, points: int) -> np.ndarray:
    return radius * np.exp(2j * math.pi * np.arange(points) / points)


def test_a_ring_under_pressure_is_that_of_lame():
    # Unit width, modulus and outer pressure: a point at r moves inwards by b²/(b² − a²) [(1 − ν) r + (1 + ν) a²/r].
    a, b, points, r = 16.0, 61.0, 360, 50.0
    flank, basis = circle(b, points), disc_basis([circle(b, points), circle(a, 96)])
    pressure = _inwards(basis, flank / b) @ np.full((points, 1), 2.0 * math.pi * b / points)
    read = _below(basis, flank * r / b, flank / b)
    (recession,) = _displacements(plane_stress(basis, NU), _three_fixed(basis), csc_array(pressure), [read])
    # Three fixed unknowns let the ring shift and turn as a whole: the mean over the circle does not see it.
    expected = b**2 / (b**2 - a**2) * ((1.0 - NU) * r + (1.0 + NU) * a**2 / r)
    assert np.mean(recession) == pytest.approx(expected, rel=2e-4)


@pytest.mark.slow
def test_the_near_field_is_that_of_flamant():
    # Between two depths below a force, far from all edges: 2 F/(π E b) ln(t₂/t₁).
    flank = circle(60.0, 600)
    own = [
        condensed(flank, flank / 60.0, [circle(15.0, 48)], [0], [], np.full(600, depth), NU, 6.0)[1][::50]
        for depth in (1.5, 3.0)
    ]
    np.testing.assert_allclose(own[0] - own[1], 2.0 / math.pi * math.log(2.0), rtol=0.03)


def test_forces_and_displacements_are_reciprocal_and_store_energy(elastic):
    meshing = mesh(elastic.drive.trochoid, output_turn(elastic.drive.trochoid, 7), 2)
    found = stage_compliance(elastic.disc_bodies, meshing)
    for one in found:
        np.testing.assert_allclose(one, one.T, rtol=0.0, atol=1e-12 * np.max(np.abs(one)))
        assert np.min(np.linalg.eigvalsh(one)) > -1e-9 * np.max(np.abs(one))


def test_a_kept_compliance_is_that_of_its_discs_and_poses(elastic):
    trochoid, angle = elastic.drive.trochoid, np.array([0.3, 1.1, 0.3, 2.0, 4.4])
    fresh = stage_compliance(elastic.disc_bodies, mesh(trochoid, angle, 2))
    kept = kept_compliance(elastic.disc_bodies, trochoid, angle)
    np.testing.assert_array_equal(kept, fresh)
    for some in (slice(0, 5), slice(2, 4), slice(4, 5)):
        found = stage_compliance(elastic.disc_bodies, mesh(trochoid, angle[some], 2))
        assert np.shares_memory(found, kept)
        np.testing.assert_array_equal(found, fresh[some])
    # Poses of which some are not kept, or in another order, and a disc of the same name that is softer.
    np.testing.assert_array_equal(stage_compliance(elastic.disc_bodies, mesh(trochoid, angle[::-1], 2)), fresh[::-1])
    softer = tuple(replace(one, matrix=2.0 * one.matrix, own=2.0 * one.own) for one in elastic.disc_bodies)
    np.testing.assert_allclose(stage_compliance(softer, mesh(trochoid, angle, 2)), 2.0 * fresh, rtol=1e-12)
    assert kept_compliance((), trochoid, angle) is None


def test_a_compliance_that_is_too_large_is_not_kept(elastic, monkeypatch):
    from cycloid_profile.contact.bodies.elastic_disc import displacements

    trochoid, angle = elastic.drive.trochoid, np.array([0.4, 1.2])
    size = stage_compliance(elastic.disc_bodies, mesh(trochoid, angle, 2)).nbytes
    monkeypatch.setattr(displacements, "_KEPT", displacements._Latest(1.5 * size))
    assert kept_compliance(elastic.disc_bodies, trochoid, np.array([0.4, 1.2, 2.0, 2.2])) is None
    first = kept_compliance(elastic.disc_bodies, trochoid, angle)
    assert kept_compliance(elastic.disc_bodies, trochoid, angle) is not None
    assert np.shares_memory(first, stage_compliance(elastic.disc_bodies, mesh(trochoid, angle, 2)))
    kept_compliance(elastic.disc_bodies, trochoid, angle + 1.0)
    assert not np.shares_memory(first, stage_compliance(elastic.disc_bodies, mesh(trochoid, angle, 2)))


def test_displacements_are_those_of_the_compliance_where_forces_act(elastic):
    meshing = mesh(elastic.drive.trochoid, np.array([0.2, 1.1, 3.0]), 2)
    C, rng = stage_compliance(elastic.disc_bodies, meshing), np.random.default_rng(2)
    load, pins = rng.normal(size=C.shape[:2]), meshing.phase[0].size
    load[:, :pins] *= rng.random((3, pins)) < 0.4
    found = stage_displacements(elastic.disc_bodies, meshing, load)
    expected = np.einsum("pij,pj->pi", C, load)
    expected[:, :pins] *= load[:, :pins] != 0.0
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-15)


def test_holes_move_what_the_whole_disc_does_without_the_flanks_of_each_other(elastic):
    meshing = mesh(elastic.drive.trochoid, np.array([0.2, 3.0]), 2)
    C = stage_compliance(elastic.disc_bodies, meshing).copy()
    load = np.random.default_rng(2).normal(size=C.shape[:2])
    pins = meshing.phase[0].size
    C[:, :pins, :pins] = 0.0
    found = stage_displacements(tuple(one.hole_part for one in elastic.disc_bodies), meshing, load)
    np.testing.assert_allclose(found, np.einsum("pij,pj->pi", C, load), rtol=1e-9, atol=1e-15)


def test_equal_forces_on_all_holes_move_nothing(elastic):
    # A uniform shift and a turn of the holes is motion of the disc, not deformation.
    disc = elastic.disc_bodies[0]
    holes = disc.matrix[:, len(disc.own) :]
    arms = 36.0 * np.exp(2j * math.pi * np.arange(3) / 3) * 1j
    scale = np.max(np.abs(disc.matrix))
    for x, y in ((1.0, 0.0), (0.0, 1.0)):
        assert np.max(np.abs(holes @ np.tile([x, y], 3))) < 1e-9 * scale
    turn = np.stack([arms.real, arms.imag], axis=-1).ravel() / 36.0
    assert np.max(np.abs(holes @ turn)) < 1e-9 * scale


@pytest.mark.slow
def test_finer_meshes_converge(rv40e):
    # Roots, at which all meshes have points: the change falls at least with the size.
    def sampled(refinement: float) -> np.ndarray:
        disc = disc_compliance(outline(rv40e), E, NU, WIDTH, refinement=refinement)
        return disc.own[:: disc.per_lobe]

    coarse, middle, fine = (sampled(size) for size in (0.9, 1.8, 3.6))
    change, last = np.linalg.norm(middle - coarse), np.linalg.norm(fine - middle)
    assert change < 0.02 * np.linalg.norm(fine)
    assert math.log2(change / last) > 1.0


@pytest.mark.slow
@pytest.mark.parametrize("depth", [2.0, 4.0])
def test_the_depth_where_near_and_far_field_meet_does_not_matter(rigid, elastic, depth):
    other = replace(rigid, disc_bodies=bodies(rigid.drive, depth=depth))
    assert Equilibrium().solve(other).delta_max == pytest.approx(Equilibrium().solve(elastic).delta_max, rel=0.01)


def test_the_near_field_of_the_law_ends_where_that_of_the_disc_begins(rv40e):
    # Read at half the pin radius or at all of it, 0.40 of unit modulus and width apart: the law counts the rest.
    read = [disc_compliance(outline(rv40e), 1.0, NU, 1.0, refinement=0.5, depth=depth).own for depth in (1.5, 3.0)]
    assert np.median(read[1]) == pytest.approx(3.6, abs=0.4)
    assert abs(np.median(read[0] - read[1])) < 0.1
    assert np.max(np.abs(read[0] - read[1])) < 0.2


def critical(case: LoadCase, poses: int = 96) -> tuple[float, float, float]:
    """Mean deformation at the critical phase [µm], mean number of loaded pins, and ripple of the rotation [″]."""
    found = Equilibrium(poses=poses).solve(case)
    return 1e3 * found.delta_max, float(np.mean(np.sum(found.force > 0.0, axis=-1))), np.ptp(found.rotation) / ARCSEC


@pytest.mark.parametrize(
    ("contours", "published"),
    [(HOLES, (3.75, 11.5, 3.0)), pytest.param((*HOLES, *PILLARS), (5.41, 12.6, 2.1), marks=pytest.mark.slow)],
    ids=["three holes", "pillar openings"],
)
def test_one_disc_is_that_of_another_finite_element_program(rigid, contours, published):
    # Its elements are linear and its holes staircases; it is judged to 10 %.
    found = critical(replace(rigid, disc_bodies=bodies(rigid.drive, contours)))
    np.testing.assert_allclose(found[:2], published[:2], rtol=0.1)
    assert found[2] == pytest.approx(published[2], rel=0.25)


def test_a_stiff_body_is_a_rigid_one(rigid, elastic):
    stiff = replace(rigid, disc_bodies=tuple(one.scaled(1e-9) for one in elastic.disc_bodies))
    angles = mesh_cycle(rigid.drive.trochoid, 7)
    for solver in (Equilibrium(), StageEquilibrium()):
        found, expected = solver.at(stiff, angles), solver.at(rigid, angles)
        np.testing.assert_allclose(found.force, expected.force, rtol=0.0, atol=1e-6 * expected.max_force)
        np.testing.assert_allclose(found.rotation, expected.rotation, rtol=1e-6)
        np.testing.assert_allclose(found.torsional_stiffness, expected.torsional_stiffness, rtol=1e-6)


@pytest.mark.parametrize("poses", [3, 600], ids=["few", "compiled"])
def test_forces_balance_and_deform_as_they_say(elastic, poses):
    angles = output_turn(elastic.drive.trochoid, poses)
    found = StageEquilibrium().at(elastic, angles)
    drive, stage = elastic.drive, found.stage
    # Gaps of the disc in its place close by approach and recession; the recession is what the forces do.
    shift = stage.motion[..., 0] + 1j * stage.motion[..., 1]
    here = gaps(elastic.profile, drive.pin_radius, stage.meshing, shift, stage.motion[..., 2])
    recession = np.einsum("pij,pj->pi", stage_compliance(elastic.disc_bodies, stage.meshing), found.load)
    pins = found.force[0].size
    loaded = found.force > 0.0
    closed = (-here.gap - recession[:, :pins].reshape(found.force.shape))[loaded]
    np.testing.assert_allclose(closed, found.approach[loaded], rtol=0.0, atol=1e-9)
    contact = elastic.line_contact(here.curvature[loaded])
    np.testing.assert_allclose(elastic.law.force(closed, contact), found.force[loaded], rtol=1e-6, atol=1e-4)
    # Bearings stretch by the motion of the disc and by what its holes give way.
    support = support_model(drive, stage.meshing.crank_angle)
    u = np.concatenate([found.rotation[:, np.newaxis], stage.motion.reshape(poses, -1)], axis=1)
    stretch = np.einsum("psdu,pu->psd", support.spring_stretch, u) - recession[:, pins:].reshape(poses, -1, 2)
    held = found.load[:, pins:].reshape(poses, -1, 2)
    np.testing.assert_allclose(support.bearing.stiffness * stretch, held, rtol=0.0, atol=1e-4)
    # Each disc is in balance: pins push it inwards, bearings hold it.
    inwards = -np.sum(found.force * stage.normal, axis=2)
    on_bearings = np.sum(stage.bearing_force, axis=2)
    np.testing.assert_allclose(inwards + on_bearings, 0.0, atol=1e-9 * 412e3)
    assert found.max_residual < 2e-10


@pytest.mark.slow
def test_no_neighbour_has_less_energy(elastic):
    # An oracle that knows nothing of active pins: the potential of motion and forces, and its slope by differences.
    from cycloid_profile.contact.stage import energy_about

    problem = energy_about(StageEquilibrium().at(elastic, [0.3]))
    least = problem.at(np.zeros((1, problem.arm.size))).energy[0]
    rng = np.random.default_rng(3)
    for size in (1e-4, 1e-5):
        for _ in range(20):
            step = size * rng.normal(size=(1, problem.arm.size)) / problem.arm
            load = problem.load + 1e4 * size * rng.normal(size=problem.load.shape)
            assert replace(problem, load=load).at(step).energy[0] > least - 1e-9


def test_a_sector_further_everything_is_equal(elastic):
    # 13 pin pitches of the crank are a third of its turn on the carrier.
    assert [one.sectors for one in elastic.disc_bodies] == [3, 3]
    angles = mesh_cycle(elastic.drive.trochoid, 5)
    there = angles + 13.0 * 2.0 * math.pi / elastic.drive.trochoid.pins
    first, second = (StageEquilibrium().at(elastic, each) for each in (angles, there))
    np.testing.assert_allclose(first.rotation, second.rotation, rtol=1e-9)
    np.testing.assert_allclose(np.sort(first.force), np.sort(second.force), rtol=0.0, atol=1e-5)


@pytest.mark.parametrize("geometric", [False, True])
def test_the_tangent_is_that_of_differences(elastic, geometric):
    # The shift of one loaded pin along its normal, by its exact effect on the equilibrium.
    sharing = StageEquilibrium().at(elastic, [0.1, 0.9])
    tangent = StageTangent(sharing, geometric=geometric)
    pin = int(np.argmax(sharing.force[0, 0]))
    size = 2e-5
    oversize = np.zeros(elastic.drive.trochoid.pins)
    oversize[pin] = size
    turned = [
        StageEquilibrium(tolerance=1e-12, deviations=PartDeviations(pin_oversize=sign * oversize))
        .at(elastic, [0.1, 0.9])
        .rotation
        for sign in (1.0, -1.0)
    ]
    # A larger pin closes the gaps of both discs.
    slope = -np.sum(tangent.pins[:, :, pin], axis=1)
    np.testing.assert_allclose((turned[0] - turned[1]) / (2.0 * size), slope, rtol=2e-3, atol=1e-9)


def test_forces_that_go_round_the_disc_meet_the_uneven_part_evenly(elastic):
    """Its mean over all turns by a lobe is zero; next to it the three crank holes of this disc are no small part."""
    disc = elastic.disc_bodies[0]
    uneven, points = disc.uneven_part, len(disc.own)
    force = np.zeros(points)
    force[3 : 3 + 8 * disc.per_lobe : disc.per_lobe] = np.hanning(10)[1:-1]
    work = {}
    for name, one in (("whole", disc), ("uneven", uneven)):
        give = one.matrix[:points, :points] + np.diag(one.own)
        around = [np.roll(force, lobe * disc.per_lobe) for lobe in range(disc.lobes)]
        work[name] = np.array([turned @ give @ turned for turned in around])
    np.testing.assert_allclose(work["uneven"], work["whole"] - np.mean(work["whole"]), rtol=0.0, atol=1e-12)
    assert 0.01 < np.ptp(work["whole"]) / np.mean(work["whole"]) < 1.0
    assert not uneven.matrix[points:].any()


def test_a_central_eccentric_holds_its_disc_too(rv40e):
    drive = replace(rv40e, support=CentralEccentric(4e5), first_stage=None)
    contours = (circular_contour("bore", 0j, 16.0), *ring_of_holes("output hole", 6, 40.0, 8.0))
    found = bodies(drive, contours)
    case = LoadCase(drive, modify(drive.theoretical_profile, Equidistant(0.006)), 412e3, law=LAWS["weber-banaschek"])
    rigid, soft = (StageEquilibrium().solve(one) for one in (case, replace(case, disc_bodies=found)))
    assert soft.converged
    assert np.all(np.abs(soft.twist) > np.abs(rigid.twist))
    assert soft.loaded_pins >= rigid.loaded_pins


def test_a_file_returns_the_same_disc(elastic, tmp_path):
    disc, path = elastic.disc_bodies[0], tmp_path / "disc.npz"
    disc.save(path)
    found = read_disc_compliance(path, 39, 3)
    assert found == disc
    np.testing.assert_array_equal(found.matrix, disc.matrix)
    np.testing.assert_array_equal(found.own, disc.own)


def damaged(disc: DiscCompliance, **changes) -> DiscCompliance:
    return replace(disc, **{name: change(np.array(getattr(disc, name))) for name, change in changes.items()})


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"matrix": lambda m: m + np.eye(len(m))[::-1]}, ""),
        ({"matrix": lambda m: np.triu(m)}, "symmetric"),
        ({"matrix": lambda m: m * np.nan}, "finite"),
        ({"own": lambda own: -own}, "positive"),
        ({"own": lambda own: own[:-1]}, "lobes, matrix and own"),
    ],
)
def test_a_file_that_is_no_compliance_is_refused(elastic, tmp_path, change, sentence):
    path = tmp_path / "disc.npz"
    damaged(elastic.disc_bodies[0], **change).save(path)
    if not sentence:
        assert read_disc_compliance(path, 39, 3)
        return
    with pytest.raises(LoadError, match=sentence):
        read_disc_compliance(path, 39, 3)


def test_a_flipped_bit_and_a_foreign_file_are_refused(elastic, tmp_path):
    path = tmp_path / "disc.npz"
    elastic.disc_bodies[0].save(path)
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 4
    path.write_bytes(bytes(data))
    with pytest.raises(LoadError, match="disc_body_file"):
        read_disc_compliance(path, 39, 3)
    path.write_text("not a matrix")
    with pytest.raises(LoadError, match="cannot be read"):
        read_disc_compliance(path, 39, 3)


@pytest.mark.parametrize("how", ["flipped bit", "other disc", "folder", "too large", "no cache"])
def test_a_cache_that_is_damaged_changes_no_number(how, rv40e, elastic, tmp_path, monkeypatch):
    from cycloid_profile.contact.bodies.elastic_disc import finite_elements
    from cycloid_profile.resources import LIMITS, Limit

    computed: list[str] = []

    def counted(key, *_):
        computed.append(key)
        return replace(elastic.disc_bodies[0], key=key)

    monkeypatch.setattr(finite_elements, "_cache_folder", lambda: tmp_path)
    monkeypatch.setattr(finite_elements, "_computed", counted)
    finite_elements._remembered.cache_clear()
    found = disc_compliance(outline(rv40e), 1.0, NU, 1.0)
    (path,) = tmp_path.iterdir()
    if how == "flipped bit":
        data = bytearray(path.read_bytes())
        data[len(data) // 2] ^= 4
        path.write_bytes(bytes(data))
    elif how == "other disc":
        replace(found, key="another", matrix=2.0 * found.matrix).save(path)
    elif how == "too large":
        monkeypatch.setitem(LIMITS, "memory", Limit(1e6, "less than the file"))
        monkeypatch.setattr(finite_elements, "_PAIR_BYTES", 0.0)
    else:
        path.unlink()
        if how == "folder":
            path.mkdir()
    finite_elements._remembered.cache_clear()
    again = disc_compliance(outline(rv40e), 1.0, NU, 1.0)
    np.testing.assert_array_equal(again.matrix, found.matrix)
    assert len(computed) == 2
    finite_elements._remembered.cache_clear()


def test_a_disc_of_another_drive_is_refused(elastic):
    with pytest.raises(LoadError, match="disc_bodies"):
        replace(elastic, disc_bodies=elastic.disc_bodies[:1])


def test_openings_that_cut_into_each_other_are_refused(rv40e):
    contours = (circular_contour("bore", 0j, 30.0), *ring_of_holes("crank hole", 3, 36.0, 13.0))
    with pytest.raises(GeometryError, match="disc openings"):
        disc_compliance(outline(rv40e, contours), E, NU, WIDTH)
