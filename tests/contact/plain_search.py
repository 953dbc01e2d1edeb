"""Search for the least energy written once more, in numpy and without elastic discs: the oracle of the compiled one."""

from __future__ import annotations

import numpy as np

from cycloid_profile.contact.stage import StageEnergy


def plain_search(problem: StageEnergy, start: np.ndarray, tolerance: float, steps: int = 80) -> np.ndarray:
    """Step to the least energy, shape (poses, unknowns), by at most ``steps`` of Newton from ``start``."""
    step = start.copy()
    point = problem.at(step)
    for _ in range(steps):
        moving = problem.imbalance(point) >= tolerance
        if not np.any(moving):
            break
        hessian = problem.hessian(point)
        diagonal = np.einsum("puu->pu", hessian)
        diagonal += 1e-9 * np.max(diagonal, axis=-1, keepdims=True) / problem.arm**2
        direction = -np.linalg.solve(hessian, point.gradient[..., np.newaxis])[..., 0]
        direction[~moving] = 0.0
        slope = np.sum(point.gradient * direction, axis=-1)
        slack = 1e-13 * (np.abs(point.energy) + np.abs(problem.torque * problem.rotation))
        fraction = np.ones(len(step))
        for _ in range(40):
            trial = step + fraction[:, np.newaxis] * direction
            found = problem.at(trial)
            too_far = found.energy > point.energy + 1e-4 * fraction * slope + slack
            if not np.any(too_far):
                break
            fraction[too_far] *= 0.5
        step, point = trial, found
    return step
