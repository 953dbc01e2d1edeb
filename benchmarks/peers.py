"""This package compared with cycloidgen 8 where it is installed: ``python -m benchmarks.peers``.

Time and error side by side on one drive in one run; the error is the distance to ``exact``. cycloidgen is no
dependency: install it, this package and mpmath into an environment of their own.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from importlib.util import find_spec
from time import perf_counter
from typing import Any

import mpmath as mp
import numpy as np

import cycloid_profile as cp
from benchmarks import exact
from benchmarks.document import machine, put, table
from benchmarks.rv40e import EQUIDISTANT, TORQUE, loaded_rv40e
from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.geometry import point_cloud

POINTS, CHECKED = 1_000_000, 199
SHIFT, TURN = 0.005 - 0.003j, 1e-4  # mm, rad: a disc that is not where the drawing has it
DEFAULT, FINEST = 2_000, 200_000  # points on the peer's polygon: its default, its ceiling for a chord tolerance
MANY = 1_000  # poses of this package's batch
HEAD = ("quantity", "setting", "cycloid_profile", "time", "cycloidgen 8", "time", "time ratio")
STEEL = cp.Material(210_000.0, 0.3)  # the peer's bearing steel, given to both
NEWTON_METRE_PER_ARCMIN = math.pi / 10_800.0 / 1_000.0


def main() -> None:
    if find_spec("cycloidgen") is None:
        print("cycloidgen is not installed here: nothing to compare with")
        return
    case = loaded_rv40e(cp.Johnson(), STEEL)
    rows = [*_profile(case), *_gaps(case), *_sharing(case)]
    rows.append(("whole stage: 7 unknowns, crank bearings", "–", "offered", "", "not offered", "", ""))
    put("peers", f"{machine(('numpy', 'scipy', 'cycloidgen'))}\n\n{table(HEAD, rows)}")


def _peer_spec() -> Any:
    from cycloidgen.core.spec import GearSpec, OffsetMode, Process

    return GearSpec(
        pin_circle_radius=64.0,
        pin_radius=3.0,
        eccentricity=1.3,
        lobes=39,
        disc_thickness=11.5,
        disc_count=2,
        process=Process.EDM,
        offset_mode=OffsetMode.EQUIDISTANT,
        profile_clearance=EQUIDISTANT,
        disc_material="Bearing steel 100Cr6",
        pin_material="Bearing steel 100Cr6",
        output_torque_Nm=TORQUE / 1_000.0,
    )


def _profile(case: cp.LoadCase) -> list[tuple[str, ...]]:
    from cycloidgen.core import profile as peer

    spec, lobes = _peer_spec(), case.drive.trochoid.lobes
    psi = np.linspace(0.0, case.drive.trochoid.phase_period, POINTS, endpoint=False)
    t = psi / lobes

    def theirs() -> tuple[Any, Any, Any]:
        R, Rr, E = spec.effective_R, spec.effective_Rr, spec.eccentricity
        return (
            peer.disc_profile(t, R, Rr, E, lobes),
            peer.profile_normal(t, R, E, lobes),
            peer.profile_curvature(t, R, Rr, E, lobes),
        )

    (cloud, our_time), ((points, normals, bend), their_time) = _in_turn(
        lambda: point_cloud(case.profile, psi), theirs, rounds=9
    )
    some = range(0, POINTS, POINTS // CHECKED)
    ours = _profile_errors(
        [mp.mpf(psi[i]) for i in some], cloud.position[some], cloud.normal[some], cloud.curvature[some]
    )
    # Each side is held to the very number it was given, ψ or t = ψ/39.
    other = _profile_errors(
        [mp.mpf(t[i]) * lobes for i in some], points[some] @ [1, 1j], normals[some] @ [1, 1j], bend[some]
    )
    shown = ["{:.1e} mm; {:.1e} rad; {:.1e}/mm".format(*errors) for errors in (ours, other)]
    name = "1,000,000 points; errors of position, normal, curvature"
    return [
        (name, "closed form", shown[0], _time(our_time), shown[1], _time(their_time), _ratio(their_time / our_time))
    ]


def _profile_errors(
    phase: list[Any], position: ComplexArray, normal: ComplexArray, curvature: FloatArray
) -> tuple[float, float, float]:
    """Largest errors against the formulas at 30 digits."""
    return (
        max(float(abs(exact.tooth(s) - mp.mpmathify(z))) for s, z in zip(phase, position.tolist(), strict=True)),
        max(float(abs(exact.normal(s) - mp.mpmathify(z))) for s, z in zip(phase, normal.tolist(), strict=True)),
        max(float(abs(exact.curvature(s) - k)) for s, k in zip(phase, curvature.tolist(), strict=True)),
    )


def _gaps(case: cp.LoadCase) -> list[tuple[str, ...]]:
    """Gaps of the 40 pins at one pose, in the nominal place and with the disc moved."""
    from cycloidgen.core import kinematics, profile

    spec, phi = _peer_spec(), 0.3  # the peer's crank turns clockwise
    meshing = cp.mesh(case.drive.trochoid, -phi)
    ring = 2.0 * np.pi * np.arange(40) / 40
    pins = 64.0 * np.column_stack([np.cos(ring), np.sin(ring)])

    def theirs(n: int, moved: bool) -> FloatArray:
        if not moved:
            kinematics._mesh_gaps.cache_clear()  # timed, not remembered
            return np.array(kinematics.mesh_gaps(spec, phi, n))
        # It has no moved disc of its own; these are the two functions that mesh_gaps is made of.
        turned = kinematics.to_disc_frame(pins - [SHIFT.real, SHIFT.imag], phi, 1.3, 39)
        back = np.array([[math.cos(TURN), -math.sin(TURN)], [math.sin(TURN), math.cos(TURN)]])
        polygon = profile.sampled_profile(spec.effective_R, spec.effective_Rr, 1.3, 39, n).points
        return np.array(profile.distance_to_polyline(turned @ back, polygon)) - 3.0

    rows = []
    for moved, name in (
        (False, "gaps of 40 pins; largest error"),
        (True, "the same, disc shifted 6 µm and turned 0.1 mrad"),
    ):
        shift, turn = (SHIFT, TURN) if moved else (0.0, 0.0)
        true = np.array(
            [float(exact.contact(k, mp.mpf(-phi), mp.mpmathify(shift), mp.mpf(turn)).gap) for k in range(40)]
        )
        for n in (DEFAULT, FINEST // 10, FINEST):
            (found, our_time), (others, their_time) = _in_turn(
                lambda shift=shift, turn=turn: cp.gaps(case.profile, 3.0, meshing, shift, turn),
                lambda n=n, moved=moved: theirs(n, moved),
                rounds=3 if n == FINEST else 15,
            )
            rows.append(
                (
                    name,
                    ("`distance_to_polyline`" if moved else "`mesh_gaps`")
                    + f", polygon of {n:,}"
                    + (" (its default)" if n == DEFAULT else ""),
                    f"{1e3 * np.max(np.abs(found.gap[0, 0] - true)):.0e} µm",
                    _time(our_time),
                    f"{_short(1e3 * np.max(np.abs(others - true)))} µm",
                    _time(their_time),
                    _ratio(their_time / our_time),
                )
            )
    return rows


def _sharing(case: cp.LoadCase) -> list[tuple[str, ...]]:
    """One disc on a held crank, 206 N·m, the same law on both sides, at the eight poses the peer takes."""
    from cycloidgen.analysis import stiffness as peer
    from cycloidgen.core import kinematics

    spec = _peer_spec()
    states = kinematics.sweep(spec)[:: kinematics.SWEEP_STEPS // 8]
    crank = -np.array([state.phi for state in states])
    true = [exact.load_sharing(mp.mpf(phi)) for phi in crank]
    force = np.array([[float(f) for f in pose.force] for pose in true])
    rigidity = 2.0 * float(mp.fsum(pose.stiffness for pose in true)) / len(true) * NEWTON_METRE_PER_ARCMIN
    carrying = float(np.mean(np.sum(force > 0.0, axis=1)))

    def public() -> Any:
        kinematics._mesh_gaps.cache_clear()
        return peer.analyse_stiffness(spec, steps=8)

    def by_pose(n: int) -> tuple[FloatArray, FloatArray]:
        kinematics._mesh_gaps.cache_clear()
        shares, turns = np.zeros((len(states), 40)), np.zeros(len(states))
        for i, state in enumerate(states):
            parts = peer._ring_contacts(spec, state, TORQUE / 2.0)
            gap = np.maximum(kinematics.mesh_gaps(spec, state.phi, n)[state.loaded_mask], 0.0)
            turns[i], shares[i, state.loaded_mask] = peer._solve_rotation(parts.c, parts.arms, gap, TORQUE / 2.0)
        return shares, turns

    (ours, our_time), (summary, their_time) = _in_turn(
        lambda: cp.Equilibrium().at(case, crank, -TORQUE), public, rounds=15
    )
    ours_rigidity = float(np.mean(ours.torsional_stiffness)) * NEWTON_METRE_PER_ARCMIN
    rows: list[tuple[str, ...]] = [
        (
            f"mesh rigidity, mean of 8 poses (exact {rigidity:.1f} N·m/′)",
            "`analyse_stiffness`, 2,000",
            f"{ours_rigidity:.1f} N·m/′, {ours_rigidity / rigidity - 1.0:+.2%}",
            _time(our_time),
            f"{summary.ring_stage_Nm_per_arcmin:.1f} N·m/′, {summary.ring_stage_Nm_per_arcmin / rigidity - 1.0:+.0%}",
            _time(their_time),
            _ratio(their_time / our_time),
        ),
        (
            f"pins that carry, mean (exact {carrying:.2f})",
            "the same",
            f"{np.mean(np.sum(ours.loaded, axis=-1)):.2f}",
            "",
            f"{summary.pins_engaged:.2f}",
            "",
            "",
        ),
    ]
    batch = np.resize(crank, MANY)
    _, batch_time = _in_turn(lambda: cp.Equilibrium().at(case, batch, -TORQUE), lambda: None, rounds=9)[0]
    our_error = np.max(np.abs(ours.force[:, 0] - force)) / np.max(force)
    our_turn = np.max(np.abs(ours.rotation / np.array([float(pose.rotation) for pose in true]) - 1.0))
    for n in (DEFAULT, FINEST):
        _, ((shares, turns), loop_time) = _in_turn(lambda: None, lambda n=n: by_pose(n), rounds=1 if n == FINEST else 9)
        error = np.max(np.abs(shares - force)) / np.max(force)
        turn = np.max(np.abs(-turns / np.array([float(pose.rotation) for pose in true]) - 1.0))
        rows.append(
            (
                "largest error of a pin force, of the largest; of the rotation; time a pose",
                f"its inner functions, polygon of {n:,}",
                f"{our_error:.1%}; {our_turn:.2%}",
                f"{_time(our_time / len(crank))}, {_time(batch_time / MANY)} with {MANY:,} poses",
                f"{error:.1%}; {turn:.2%}",
                _time(loop_time / len(states)),
                _ratio(loop_time / our_time),
            )
        )
    return rows


def _in_turn(ours: Callable[[], Any], theirs: Callable[[], Any], rounds: int) -> tuple[tuple[Any, float], ...]:
    """Answer and least time of each side, the two timed by turns after a first call of each."""
    answers, least = [ours(), theirs()], [math.inf, math.inf]
    for _ in range(rounds):
        for side, call in enumerate((ours, theirs)):
            start = perf_counter()
            answers[side] = call()
            least[side] = min(least[side], perf_counter() - start)
    return tuple(zip(answers, least, strict=True))


def _short(value: float) -> str:
    """Two digits, no exponent."""
    return f"{float(f'{value:.2g}'):g}"


def _ratio(value: float) -> str:
    return f"**{float(f'{value:.2g}'):,.10g}**"


def _time(seconds: float) -> str:
    if seconds < 1e-3:
        return f"{1e6 * seconds:.3g} µs"
    return f"{1e3 * seconds:.3g} ms" if seconds < 1.0 else f"{seconds:.3g} s"


if __name__ == "__main__":
    main()
