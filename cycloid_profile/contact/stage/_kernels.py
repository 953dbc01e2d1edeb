"""Least energy of one pose of a stage, compiled by numba; imported inside functions only.

Deformations e = e₀ + J q − C y of all contacts and bearings follow from the motion q and, in elastic discs, from the
forces y that deform them (docs/theory.md, Eqs. 37, 81). Rigid discs have an empty C.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.compiled import contracted, inner, kernel
from cycloid_profile.contact.bodies._bearing_kernels import CompiledBearing, bearing_response
from cycloid_profile.contact.laws._kernels import response
from cycloid_profile.contact.laws.compiled import CompiledLaw

NEWTON_STEPS = 80
HALVINGS = 40
ARMIJO = 1e-4
# Energies this close, relative, differ by rounding alone.
ROUNDING = 1e-13
# A trace of damping keeps the matrix regular while a disc is unloaded between pins or within the play of its bearings.
DAMPING = 1e-9


class SlicedWidth(NamedTuple):
    """Slices over the face width, empty for line contacts: ``height`` from the mid-plane [mm], ``weight`` with the sum
    1, ``relief`` [mm]; ``tilt``, unknowns of the slopes of each disc, shape (discs, 2), or (0, 2) for discs that cannot
    tilt; ``slope`` where the gaps were taken, shape (discs, 2), of many poses (poses, discs, 2) [rad]; ``stiffness``
    of the bearings of a disc against its tilt [N·mm/rad].
    """

    height: FloatArray
    weight: FloatArray
    relief: FloatArray
    tilt: IntArray
    slope: FloatArray
    stiffness: float


class PoseProblem(NamedTuple):
    """One pose: ``constant`` of each contact (``contact_constant``) and ``gap``, shape (discs, pins); ``frame``
    (3, discs, pins), normal and lever; ``own`` as ``SupportModel.disc_unknowns``; ``spring_stretch`` and ``stretch`` as
    in ``StageEnergy``, of this pose; ``compliance`` C of the discs, shape (forces, forces) or (0, 0) [mm/N]; ``width``,
    the slices.

    Forces are those of the pins, disc by disc, then the two components of each bearing.
    """

    law: CompiledLaw
    constant: FloatArray
    gap: FloatArray
    frame: FloatArray
    own: IntArray
    spring_stretch: FloatArray
    stretch: FloatArray
    bearing: CompiledBearing
    play: float
    torque: float
    rotation: float
    arm: FloatArray
    compliance: FloatArray
    width: SlicedWidth


class Workspace(NamedTuple):
    """Arrays of one search: ``stiffness`` of the pins; of the bearings ``now``, direction of the stretch, and ``rate``,
    stiffness along and across it, both shape (bearings, 2); ``force`` of all; rows of ``motions`` (4 + unknowns,
    unknowns) and, for elastic discs alone, of ``forces`` (7, forces); ``full`` (forces, columns), deformations whose
    forces are wanted; the others as in ``eliminated``. ``centre`` and ``spread`` of the pins as in ``over_width``.
    """

    stiffness: FloatArray
    now: FloatArray
    rate: FloatArray
    force: FloatArray
    motions: FloatArray
    forces: FloatArray
    full: FloatArray
    wide: FloatArray
    place: IntArray
    weight: FloatArray
    upper: FloatArray
    last: IntArray
    centre: FloatArray
    spread: FloatArray


@inner
def workspace(discs: int, pins: int, bearings: int, unknowns: int, elastic: bool) -> Workspace:  # pragma: no cover
    """Arrays for a search of this size."""
    n = discs * pins + 2 * bearings
    m = n if elastic else 0
    return Workspace(
        np.zeros((discs, pins)), np.zeros((bearings, 2)), np.zeros((bearings, 2)), np.zeros(n),
        np.zeros((4 + unknowns, unknowns)), np.zeros((7, m)), np.zeros((m, 1 + unknowns)), np.zeros((m, 1 + unknowns)),
        np.zeros((m, 2), np.int64), np.zeros((m, 2)), np.zeros((m, m)), np.zeros(m, np.int64), np.zeros((discs, pins)),
        np.zeros((discs, pins)),
    )  # fmt: skip


@inner
def least_energy(  # pragma: no cover - compiled, out of the sight of the coverage tool
    problem: PoseProblem, tolerance: float, step: FloatArray, load: FloatArray, work: Workspace
) -> float:
    """Newton from ``step`` and the forces ``load`` that deform the discs, both replaced by those of least energy; the
    imbalance there. ``load`` is empty for rigid discs.
    """
    unknowns, elastic = step.size, problem.compliance.size > 0
    trial, direction, gradient, found = work.motions[0], work.motions[1], work.motions[2], work.motions[3]
    hessian = work.motions[4:]
    if elastic:
        receded, more_load, receding, new_load, new_receded = (
            work.forces[0], work.forces[1], work.forces[2], work.forces[3], work.forces[4],
        )  # fmt: skip
        times(problem.compliance, load, receded)
    else:
        receded = more_load = receding = new_load = new_receded = load
    energy = energy_at(problem, step, receded, gradient, work) + stored_in_discs(load, receded)
    off: float = imbalance(problem, gradient, load, work)
    for _ in range(NEWTON_STEPS):
        if not (off >= tolerance and off < np.inf):
            break
        if elastic:
            slope = elastic_direction(problem, gradient, load, hessian, direction, more_load, work)
            times(problem.compliance, more_load, receding)
        else:
            fill_hessian(problem, work, hessian)
            damp(hessian, problem.arm)
            solve(hessian, gradient, direction)
            slope = 0.0
        for a in range(unknowns):
            slope += gradient[a] * direction[a]
        slack = ROUNDING * (abs(energy) + abs(problem.torque * problem.rotation))
        fraction, lower = 1.0, energy
        for _ in range(HALVINGS):
            for a in range(unknowns):
                trial[a] = step[a] + fraction * direction[a]
            for i in range(load.size):
                new_load[i] = load[i] + fraction * more_load[i]
                new_receded[i] = receded[i] + fraction * receding[i]
            lower = energy_at(problem, trial, new_receded, found, work) + stored_in_discs(new_load, new_receded)
            if not lower > energy + ARMIJO * fraction * slope + slack:
                break
            fraction *= 0.5
        energy = lower
        for a in range(unknowns):
            step[a], gradient[a] = trial[a], found[a]
        for i in range(load.size):
            load[i], receded[i] = new_load[i], new_receded[i]
        off = imbalance(problem, gradient, load, work)
    return off


@inner
def times(matrix: FloatArray, vector: FloatArray, product: FloatArray) -> None:  # pragma: no cover
    """``product`` of a symmetric matrix and a vector with many zeros."""
    product[:] = 0.0
    for j in range(vector.size):
        if vector[j] != 0.0:
            for i in range(vector.size):
                product[i] += matrix[j, i] * vector[j]


@inner
def stored_in_discs(load: FloatArray, receded: FloatArray) -> float:  # pragma: no cover
    """Strain energy ½ yᵀ C y of the discs."""
    energy = 0.0
    for i in range(load.size):
        energy += 0.5 * load[i] * receded[i]
    return energy


@inner
def imbalance(
    problem: PoseProblem, gradient: FloatArray, load: FloatArray, work: Workspace
) -> float:  # pragma: no cover
    """Largest generalised force out of balance, as a moment over the torque; infinite where one is NaN.

    In elastic discs also the largest difference between a force and the one that deforms the disc.
    """
    worst: float = 0.0
    for a in range(gradient.size):
        worst = max(worst, abs(gradient[a]) * problem.arm[a])
        if math.isnan(gradient[a]):
            return np.inf
    longest = np.max(problem.arm)
    for i in range(load.size):
        worst = max(worst, abs(work.force[i] - load[i]) * longest)
    relative: float = worst / abs(problem.torque)
    return relative


@inner
def energy_at(  # pragma: no cover
    problem: PoseProblem, step: FloatArray, receded: FloatArray, gradient: FloatArray, work: Workspace
) -> float:
    """Energy of contacts, bearings and torque at a step, the discs ``receded`` by C y; fills the gradient by the motion
    and, in ``work``, all forces and stiffnesses.
    """
    frame, own, stretched = problem.frame, problem.own, problem.spring_stretch
    discs, pins = problem.gap.shape
    elastic, sliced = receded.size > 0, problem.width.height.size > 0
    gradient[:] = 0.0
    energy: float = -problem.torque * (problem.rotation + step[0])
    gradient[0] = -problem.torque
    for d in range(discs):
        x, y, t = step[own[d, 0]], step[own[d, 1]], step[own[d, 2]]
        fx, fy, m = 0.0, 0.0, 0.0
        for k in range(pins):
            delta = frame[0, d, k] * x + frame[1, d, k] * y + frame[2, d, k] * t - problem.gap[d, k]
            if elastic:
                delta -= receded[d * pins + k]
            if sliced:
                F, rate, stored = on_slices(problem, d, k, delta, step, gradient, work)
                if not F > 0.0:
                    work.force[d * pins + k], work.stiffness[d, k] = 0.0, 0.0
                    continue
            else:
                if not delta > 0.0:
                    work.force[d * pins + k], work.stiffness[d, k] = 0.0, 0.0
                    continue
                F, rate, stored = response(problem.law, problem.constant[d, k], delta)
            energy += stored
            work.force[d * pins + k], work.stiffness[d, k] = F, rate
            fx += F * frame[0, d, k]
            fy += F * frame[1, d, k]
            m += F * frame[2, d, k]
        gradient[own[d, 0]] += fx
        gradient[own[d, 1]] += fy
        gradient[own[d, 2]] += m
    for d in range(len(problem.width.tilt)):
        for i in range(2):
            a = problem.width.tilt[d, i]
            slope = problem.width.slope[d, i] + step[a]
            energy += 0.5 * problem.width.stiffness * slope * slope
            gradient[a] += problem.width.stiffness * slope
    for s in range(len(stretched)):
        first = discs * pins + 2 * s
        sx, sy = problem.stretch[s, 0], problem.stretch[s, 1]
        for a in range(step.size):
            sx += stretched[s, 0, a] * step[a]
            sy += stretched[s, 1, a] * step[a]
        if elastic:
            sx -= receded[first]
            sy -= receded[first + 1]
        length = math.sqrt(sx * sx + sy * sy)
        share, work.rate[s, 0], stored = bearing_response(problem.bearing, problem.play, length)
        energy += stored
        work.now[s, 0], work.now[s, 1] = (sx / length, sy / length) if length > 0.0 else (1.0, 0.0)
        work.rate[s, 1] = share
        work.force[first], work.force[first + 1] = 0.0, 0.0
        if share > 0.0:
            work.force[first], work.force[first + 1] = share * sx, share * sy
            for a in range(step.size):
                gradient[a] += share * (stretched[s, 0, a] * sx + stretched[s, 1, a] * sy)
    return energy


@inner
def on_slices(  # pragma: no cover
    problem: PoseProblem, d: int, k: int, delta: float, step: FloatArray, gradient: FloatArray, work: Workspace
) -> tuple[float, float, float]:
    """Force, stiffness and energy of pin ``k`` on disc ``d`` with the approach ``delta`` at the mid-plane; adds the
    moment of the force to the gradient and fills ``centre`` and ``spread`` of ``work`` (``over_width``).
    """
    tilt, slope = problem.width.tilt, 0.0
    nx, ny = problem.frame[0, d, k], problem.frame[1, d, k]
    if len(tilt) > 0:
        at = problem.width.slope
        slope = nx * (at[d, 0] + step[tilt[d, 0]]) + ny * (at[d, 1] + step[tilt[d, 1]])
    F, M, rate, centre, spread, stored = over_width(problem.law, problem.constant[d, k], problem.width, delta, slope)
    work.centre[d, k], work.spread[d, k] = centre, spread
    if len(tilt) > 0:
        gradient[tilt[d, 0]] += M * nx
        gradient[tilt[d, 1]] += M * ny
    return F, rate, stored


@inner
def over_width(  # pragma: no cover
    law: CompiledLaw, constant: float, width: SlicedWidth, delta: float, slope: float
) -> tuple[float, float, float, float, float, float]:
    """Sums over the slices of one pin, ``slope`` of the tooth along its normal (docs/theory.md, Eqs. 115, 116): force,
    moment about the mid-plane, stiffness Σk, its ``centre`` Σkz/Σk, its ``spread`` Σkz² − (Σkz)²/Σk, and energy.
    """
    F, M, k0, k1, k2, energy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for s in range(width.height.size):
        z, w = width.height[s], width.weight[s]
        approach = delta + z * slope - width.relief[s]
        if approach > 0.0:
            force, rate, stored = response(law, constant, approach)
            force, rate = w * force, w * rate
            F += force
            M += z * force
            k0 += rate
            k1 += z * rate
            k2 += z * z * rate
            energy += w * stored
    if not F > 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    centre = k1 / k0
    return F, M, k0, centre, max(k2 - centre * k1, 0.0), energy


@inner
def add_tilting(problem: PoseProblem, work: Workspace, hessian: FloatArray, coupled: bool) -> None:  # pragma: no cover
    """Add what the tilt of the discs adds to the second derivative: bearings and ``spread``, and, if ``coupled``, the
    ``centre`` of the pins.
    """
    tilt, frame, own = problem.width.tilt, problem.frame, problem.own
    for d in range(len(tilt)):
        for i in range(2):
            hessian[tilt[d, i], tilt[d, i]] += problem.width.stiffness
        for k in range(work.stiffness.shape[1]):
            rate = work.stiffness[d, k]
            if rate > 0.0:
                centre = work.centre[d, k]
                own_tilt = work.spread[d, k] + (rate * centre * centre if coupled else 0.0)
                for i in range(2):
                    for j in range(2):
                        hessian[tilt[d, i], tilt[d, j]] += own_tilt * frame[i, d, k] * frame[j, d, k]
                    if coupled:
                        for b in range(3):
                            both = rate * centre * frame[i, d, k] * frame[b, d, k]
                            hessian[tilt[d, i], own[d, b]] += both
                            hessian[own[d, b], tilt[d, i]] += both


@inner
def fill_hessian(problem: PoseProblem, work: Workspace, hessian: FloatArray) -> None:  # pragma: no cover
    """Second derivative of the energy with rigid discs, where ``energy_at`` left stiffnesses."""
    hessian[:] = 0.0
    frame, own, stretched = problem.frame, problem.own, problem.spring_stretch
    discs, pins = work.stiffness.shape
    unknowns = len(hessian)
    for d in range(discs):
        for k in range(pins):
            rate = work.stiffness[d, k]
            if rate > 0.0:
                for a in range(3):
                    for b in range(3):
                        hessian[own[d, a], own[d, b]] += rate * frame[a, d, k] * frame[b, d, k]
    for s in range(len(stretched)):
        ux, uy, along, across = work.now[s, 0], work.now[s, 1], work.rate[s, 0], work.rate[s, 1]
        xx, yy = across + (along - across) * ux * ux, across + (along - across) * uy * uy
        xy = (along - across) * ux * uy
        for a in range(unknowns):
            ax, ay = stretched[s, 0, a], stretched[s, 1, a]
            if ax == 0.0 and ay == 0.0:
                continue
            bx, by = xx * ax + xy * ay, xy * ax + yy * ay
            for b in range(unknowns):
                hessian[a, b] += bx * stretched[s, 0, b] + by * stretched[s, 1, b]
    add_tilting(problem, work, hessian, True)


@inner
def elastic_direction(  # pragma: no cover
    problem: PoseProblem,
    gradient: FloatArray,
    load: FloatArray,
    hessian: FloatArray,
    direction: FloatArray,
    more_load: FloatArray,
    work: Workspace,
) -> float:
    """Newton's ``direction`` of the motion and ``more_load`` of the forces that deform the discs, solved together
    (docs/theory.md, Eq. 82); the slope of the energy along the forces.
    """
    n, unknowns = load.size, direction.size
    recede, change, right = work.forces[5], work.forces[6], work.motions[0]
    for i in range(n):
        more_load[i] = work.force[i] - load[i]
    times(problem.compliance, more_load, recede)
    motion_columns(problem, work)
    for i in range(n):
        work.full[i, unknowns] = -recede[i]
    count = eliminated(problem, work, unknowns + 1)
    hessian[:] = 0.0
    for a in range(unknowns):  # a slice takes a second more to compile: its error names sizes
        right[a] = gradient[a]
    for i in range(count):
        for a in range(unknowns):
            one = work.wide[i, a]
            right[a] += one * work.wide[i, unknowns]
            for b in range(a + 1):  # the lower half, all that ``solve`` reads
                hessian[a, b] += one * work.wide[i, b]
    add_tilting(problem, work, hessian, False)
    damp(hessian, problem.arm)
    solve(hessian, right, direction)
    for i in range(count):
        change[i] = work.wide[i, unknowns]
        for a in range(unknowns):
            change[i] += work.wide[i, a] * direction[a]
    back(work, count, change, more_load)
    slope = 0.0
    for i in range(n):
        slope -= recede[i] * more_load[i]
    return slope


@inner
def motion_columns(problem: PoseProblem, work: Workspace) -> None:  # pragma: no cover
    """Fill the first columns of ``full`` with J, the deformation of contacts and bearings per motion; of slices, at the
    ``centre`` of their stiffness (docs/theory.md, Eq. 118).
    """
    own, frame, stretched = problem.own, problem.frame, problem.spring_stretch
    tilt, full = problem.width.tilt, work.full
    discs, pins = problem.gap.shape
    unknowns = problem.arm.size
    full[:, :unknowns] = 0.0
    for d in range(discs):
        for k in range(pins):
            for a in range(3):
                full[d * pins + k, own[d, a]] += frame[a, d, k]
            for i in range(2 if len(tilt) > 0 else 0):
                full[d * pins + k, tilt[d, i]] = work.centre[d, k] * frame[i, d, k]
    for s in range(len(stretched)):
        for i in range(2):
            for a in range(unknowns):
                full[discs * pins + 2 * s + i, a] = stretched[s, i, a]


@contracted
def eliminated(problem: PoseProblem, work: Workspace, columns: int) -> int:  # pragma: no cover
    """Fill ``upper`` with U, Uᵀ U = I + Dᵀ C D, and ``wide`` with U⁻ᵀ Dᵀ ``full``, its first ``columns``; the number of
    columns of D, the root of the stiffness K = D Dᵀ of contacts and bearings.

    The stiffness with elastic discs is K (I + C K)⁻¹ = D (Uᵀ U)⁻¹ Dᵀ. A column of D has at most two entries, ``weight``
    at ``place``. Those of one disc follow each other: without supports in common C couples no two discs, and a row of U
    ends in the column ``last``.
    """
    place, weight, upper, wide, last, C = work.place, work.weight, work.upper, work.wide, work.last, problem.compliance
    count: int = stiffness_root(problem, work)
    for i in range(count):
        i0, i1, x, y = place[i, 0], place[i, 1], weight[i, 0], weight[i, 1]
        last[i] = i
        for j in range(i, count):
            # Without a sign an index needs no look at numbers counted from the end.
            first, second = np.uint64(place[j, 0]), np.uint64(place[j, 1])
            upper[i, j] = weight[j, 0] * (x * C[i0, first] + y * C[i1, first])
            upper[i, j] += weight[j, 1] * (x * C[i0, second] + y * C[i1, second])
            if upper[i, j] != 0.0:
                last[i] = j
        upper[i, i] += 1.0
        for c in range(columns):
            wide[i, c] = x * work.full[i0, c] + y * work.full[i1, c]
    for i in range(count):
        # Rows are subtracted as soon as they are known: sums of independent numbers run side by side.
        scale = 1.0 / math.sqrt(upper[i, i])
        end = last[i] + 1
        for j in range(i, end):
            upper[i, j] *= scale
        for c in range(columns):
            wide[i, c] *= scale
        for k in range(i + 1, end):
            share = upper[i, k]
            last[k] = max(last[k], last[i])
            for j in range(k, end):
                upper[k, j] -= share * upper[i, j]
            for c in range(columns):
                wide[k, c] -= share * wide[i, c]
    return count


@inner
def stiffness_root(problem: PoseProblem, work: Workspace) -> int:  # pragma: no cover
    """Fill ``place`` and ``weight`` of the columns of D, as in ``eliminated``; their number."""
    place, weight = work.place, work.weight
    count = 0
    discs, pins = problem.gap.shape
    bearings = len(problem.stretch) // discs
    for d in range(discs):
        for k in range(pins):
            if work.stiffness[d, k] > 0.0:
                place[count, 0] = place[count, 1] = d * pins + k
                weight[count, 0], weight[count, 1] = math.sqrt(work.stiffness[d, k]), 0.0
                count += 1
        for s in range(d * bearings, (d + 1) * bearings):
            ux, uy, along, across = work.now[s, 0], work.now[s, 1], work.rate[s, 0], work.rate[s, 1]
            first = discs * pins + 2 * s
            for stiffness, x, y in ((along, ux, uy), (across, -uy, ux)):
                if stiffness > 0.0:
                    root = math.sqrt(stiffness)
                    place[count, 0], place[count, 1] = first, first + 1
                    weight[count, 0], weight[count, 1] = root * x, root * y
                    count += 1
    return count


@inner
def back(work: Workspace, count: int, change: FloatArray, added: FloatArray) -> None:  # pragma: no cover
    """Add D U⁻¹ ``change`` to ``added``; ``change`` is overwritten."""
    for i in range(count - 1, -1, -1):
        for j in range(i + 1, work.last[i] + 1):
            change[i] -= work.upper[i, j] * change[j]
        change[i] /= work.upper[i, i]
        added[work.place[i, 0]] += work.weight[i, 0] * change[i]
        added[work.place[i, 1]] += work.weight[i, 1] * change[i]


@inner
def damp(hessian: FloatArray, arm: FloatArray) -> None:  # pragma: no cover
    """Add a trace to the diagonal."""
    largest = 0.0
    for a in range(arm.size):
        largest = max(largest, hessian[a, a])
    for a in range(arm.size):
        hessian[a, a] += DAMPING * largest / (arm[a] * arm[a])


@inner
def solve(matrix: FloatArray, right: FloatArray, found: FloatArray) -> None:  # pragma: no cover
    """``found`` = −matrix⁻¹·``right`` by Cholesky's factors, written over the lower half of ``matrix``."""
    n = right.size
    for a in range(n):
        for b in range(a + 1):
            total = matrix[a, b]
            for c in range(b):
                total -= matrix[a, c] * matrix[b, c]
            if a == b:
                matrix[a, a] = math.sqrt(total)
            else:
                matrix[a, b] = total / matrix[b, b]
    for a in range(n):
        total = -right[a]
        for c in range(a):
            total -= matrix[a, c] * found[c]
        found[a] = total / matrix[a, a]
    for a in range(n - 1, -1, -1):
        total = found[a]
        for c in range(a + 1, n):
            total -= matrix[c, a] * found[c]
        found[a] = total / matrix[a, a]


class StageArrays(NamedTuple):
    """``PoseProblem`` of many poses: the same fields with poses first, but for ``law``, ``own``, ``bearing`` and
    ``arm``; of ``width`` the slopes alone.
    """

    law: CompiledLaw
    constant: FloatArray
    gap: FloatArray
    frame: FloatArray
    own: IntArray
    spring_stretch: FloatArray
    stretch: FloatArray
    bearing: CompiledBearing
    play: FloatArray
    torque: FloatArray
    rotation: FloatArray
    arm: FloatArray
    compliance: FloatArray
    width: SlicedWidth


@inner
def width_at(width: SlicedWidth, slope: FloatArray) -> SlicedWidth:  # pragma: no cover
    """The same slices where the discs have these slopes, shape (discs, 2)."""
    return SlicedWidth(width.height, width.weight, width.relief, width.tilt, slope, width.stiffness)


@inner
def pose_problem(stage: StageArrays, p: int) -> PoseProblem:  # pragma: no cover
    """Pose ``p`` of many."""
    return PoseProblem(
        stage.law, stage.constant[p], stage.gap[p], stage.frame[p], stage.own, stage.spring_stretch[p],
        stage.stretch[p], stage.bearing, stage.play[p], stage.torque[p], stage.rotation[p], stage.arm,
        stage.compliance[p], width_at(stage.width, stage.width.slope[p]),
    )  # fmt: skip


@kernel
def least_energies(
    stage: StageArrays, tolerance: float, step: FloatArray, load: FloatArray
) -> None:  # pragma: no cover
    """``least_energy`` of every pose; ``step`` shape (poses, unknowns), ``load`` (poses, forces or 0)."""
    poses, discs, pins = stage.gap.shape
    work = workspace(discs, pins, stage.stretch.shape[1], step.shape[1], load.shape[1] > 0)
    for p in range(poses):
        least_energy(pose_problem(stage, p), tolerance, step[p], load[p], work)


@kernel
def elastic_stiffness_times(  # pragma: no cover
    stage: StageArrays, load: FloatArray, deformation: FloatArray, force: FloatArray, begin: int, end: int
) -> None:
    """Fill ``force`` K (I + C K)⁻¹ ``deformation``, shape (poses, forces, columns), of elastic discs under ``load``, of
    the poses from ``begin`` to ``end``.
    """
    _, discs, pins = stage.gap.shape
    unknowns, columns = stage.arm.size, deformation.shape[2]
    work = workspace(discs, pins, stage.stretch.shape[1], max(unknowns, columns), True)
    still, gradient = np.zeros(unknowns), np.zeros(unknowns)
    change, added = work.forces[0], work.forces[2]
    for p in range(begin, end):
        problem = pose_problem(stage, p)
        times(problem.compliance, load[p], work.forces[1])
        energy_at(problem, still, work.forces[1], gradient, work)
        for i in range(len(work.full)):
            for c in range(columns):
                work.full[i, c] = deformation[p, i, c]
        count = eliminated(problem, work, columns)
        for c in range(columns):
            for i in range(count):
                change[i] = work.wide[i, c]
            added[:] = 0.0
            back(work, count, change, added)
            for i in range(len(added)):
                force[p, i, c] = added[i]
