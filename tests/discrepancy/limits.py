"""Detection limits: the smallest size of each effect that is found 19 times out of 20, beside the theoretical limit.

``python -m tests.discrepancy.limits --runs 40`` prints the table of docs/diagnosis.md.
"""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import lru_cache

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.design.ground import built_reducer
from cycloid_profile.discrepancy.candidates import Candidate, candidates
from cycloid_profile.discrepancy.detectable import detectable, noncentrality
from cycloid_profile.discrepancy.detection import FALSE_ALARM, detect
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.normal import Normal, normal
from cycloid_profile.discrepancy.recording import hold_nothing_out, record
from cycloid_profile.discrepancy.seen_on_exact import exact_size, shown
from cycloid_profile.effects.built import Built
from cycloid_profile.measurement.files import parse_measurement
from cycloid_profile.spec.read import parse_spec
from cycloid_profile.units import sign_of
from tests.discrepancy.blind import Hidden, Reducer, spec_text
from tests.discrepancy.blind.cases import measured
from tests.discrepancy.workers import one_core

POWER = 0.95
_SETTINGS = {"turn_deg": 2.0, "offset_um": [0.0, 0.0], "output_angle_deg": 5.73, "friction_form": "coulomb"}


@lru_cache(maxsize=1)
def _built() -> Built:
    return built_reducer(parse_spec(spec_text(Reducer())))


def equations_of(file: str, effects: list[Hidden], seed: int) -> tuple[Normal, ExactModel]:
    """Normal equations of one file of the generator with these effects."""
    built = _built()
    text = measured(Reducer(), effects, (file,), _SETTINGS, seed=seed)[file]
    recording = hold_nothing_out(record(built, parse_measurement(text, file), 0))
    scanned = frozenset({0}) if recording.kind == "profile_scan" else frozenset()
    library = candidates(built, scanned, recording.kind != "profile_scan")
    model = ExactModel(built, [recording])
    return normal(model.nothing.blocks, library), model


def found(asked: tuple[str, Candidate, float, int]) -> bool:
    """Whether an effect of this size is detected."""
    file, candidate, size, seed = asked
    angle = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi) if candidate.coordinates == 2 else 0.0
    hidden = Hidden(candidate.name, candidate.parameters([size * np.cos(angle), size * np.sin(angle)]))
    equations, model = equations_of(file, [hidden], seed)
    return detect(model.nothing.blocks, equations).significant


def _size(model: ExactModel, candidate: Candidate, R: FloatArray, looks: int, power: float) -> float:
    """Size that is found with ``power`` among so many looks: of a bench on the exact model, if it is much of a size."""
    size = detectable(candidate, R, looks, power)
    if model.only_scans or not size < candidate.implausible:
        return size
    return exact_size(model.nothing.laid, candidate, size, noncentrality(candidate.coordinates, looks, power), 1.0)


def _shows(model: ExactModel, candidate: Candidate, size: float) -> bool:
    """Whether an amount shows as it is, by three deviations, not only with the other sign; a scan knows neither."""
    return model.only_scans or shown(model.nothing.laid, candidate, size) > 9.0


def table(file: str, runs: int, workers: int, power: float = POWER) -> list[str]:
    """Rows of the table for one file: sizes that should be found with ``power``, and how often they are."""
    equations, model = equations_of(file, [], 1)
    families = detect(model.nothing.blocks, equations).families
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
    with ProcessPoolExecutor(workers, initializer=one_core) as pool:
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
