"""Detection limits: smallest size of each effect detected 19 times out of 20, and the Cramér–Rao limit.

``python -m tests.diagnosis.limits --runs 40`` prints the tables of docs/diagnosis-validation.md.
"""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import lru_cache
from multiprocessing import get_context

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import FALSE_ALARM
from cycloid_profile.diagnosis.data.recording import record, use_all_rows
from cycloid_profile.diagnosis.model.candidate import Candidate, candidates
from cycloid_profile.diagnosis.model.detection import detect
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.whitened import NormalEquations, normal_equations
from cycloid_profile.diagnosis.planning.detectable import detectable, exact_size, noncentrality, noncentrality_of
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.measurement import PROFILE_SCAN, parse_measurement
from cycloid_profile.spec import parse_spec
from cycloid_profile.units import sign_of
from tests.diagnosis.blind import Hidden, Reducer, spec_text
from tests.diagnosis.blind.cases import measured
from tests.diagnosis.workers import one_core

POWER = 0.95
_SETTINGS = {"turn_deg": 2.0, "offset_um": [0.0, 0.0], "output_angle_deg": 5.73, "friction_form": "coulomb"}


@lru_cache(maxsize=1)
def _built() -> AsBuiltReducer:
    return as_built_reducer(parse_spec(spec_text(Reducer())))


def equations_of(file: str, effects: list[Hidden], seed: int) -> tuple[NormalEquations, ExactModel]:
    """Normal equations of one file of the generator with these effects."""
    reducer = _built()
    text = measured(Reducer(), effects, (file,), _SETTINGS, seed=seed)[file]
    recording = use_all_rows(record(reducer, parse_measurement(text, file), 0))
    scanned = frozenset({0}) if recording.kind is PROFILE_SCAN else frozenset()
    library = candidates(reducer, scanned, recording.kind.is_curve)
    model = ExactModel(reducer, [recording])
    return normal_equations(model.baseline.blocks, library), model


def found(asked: tuple[str, Candidate, float, int]) -> bool:
    """Whether an effect of this size is detected."""
    file, candidate, size, seed = asked
    angle = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi) if candidate.coordinates == 2 else 0.0
    hidden = Hidden(candidate.name, candidate.parameters([size * np.cos(angle), size * np.sin(angle)]))
    equations, model = equations_of(file, [hidden], seed)
    return detect(model.baseline.blocks, equations).significant


def _size(model: ExactModel, candidate: Candidate, R: FloatArray, looks: int, power: float) -> float:
    """Size detected with ``power`` among ``looks`` tests; bench sizes from the exact model where they are not small."""
    size = detectable(candidate, R, looks, power)
    if model.only_scans or not size < candidate.implausible:
        return size
    return exact_size(
        model.baseline.residuals, candidate, size, noncentrality(candidate.coordinates, looks, power), 1.0
    )


def _shows(model: ExactModel, candidate: Candidate, size: float) -> bool:
    """Whether the effect is visible with its sign by three standard deviations; scans are symmetric in the sign."""
    return model.only_scans or noncentrality_of(model.baseline.residuals, candidate, size) > 9.0


def table(file: str, runs: int, workers: int, power: float = POWER) -> list[str]:
    """Rows of the table of one file: sizes detectable with ``power``, and the detection rate."""
    equations, model = equations_of(file, [], 1)
    families = detect(model.baseline.blocks, equations).families
    chosen: dict[str, tuple[Candidate, float, float]] = {}
    for i, candidate in enumerate(equations.candidates):
        if candidate.name in chosen:
            continue
        places = sum(c.name == candidate.name for c in equations.candidates)
        R = equations.R[2 * i : 2 * i + 2, 2 * i : 2 * i + 2]
        least, ours = (_size(model, candidate, R, looks, power) for looks in (1, families * places))
        if np.isfinite(ours) and ours < 3.0 * candidate.width and not candidate.inverse:
            chosen[candidate.name] = (candidate, least, ours)
    lines = []
    # A fork after the first compiled call would end the process: OpenMP does not survive it.
    with ProcessPoolExecutor(workers, get_context("spawn"), one_core) as pool:
        for name, (candidate, least, ours) in chosen.items():
            hidden = ours if _shows(model, candidate, ours) else -ours
            asked = [(file, candidate, hidden, 7000 + k) for k in range(runs)]
            hits = sum(pool.map(found, asked))
            row = (
                f"`{name}`",
                file,
                f"{least:.3g}",
                f"{ours:.3g} {sign_of(candidate.size)}",
                f"{ours / least:.2f}",
                f"{hits} of {runs}",
            )
            lines.append(f"| {' | '.join(row)} |")
            print(lines[-1], file=sys.stderr, flush=True)
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=40)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--power", type=float, default=POWER, help="share that should be found")
    parser.add_argument("--files", default="scan,loop,te_light,te,lost_motion")
    arguments = parser.parse_args()
    print("| effect | file | one look, known shape | ours | ratio | found |")
    print("|---|---|---|---|---|---|")
    print(f"(false alarms {FALSE_ALARM:g}, found {arguments.power:.0%})", file=sys.stderr)
    for file in arguments.files.split(","):
        print("\n".join(table(file, arguments.runs, arguments.workers, arguments.power)))


if __name__ == "__main__":
    main()
