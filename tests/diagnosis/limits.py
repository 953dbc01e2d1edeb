"""Detection limits that the diagnosis states, checked on files that hold effects of that size.

``python -m tests.diagnosis.limits --runs 20``: for each effect the limit of a test that knows its shape (noncentrality
of the generator's own files), the limit in ``Diagnosis.not_seen``, and how often an effect of that size is found.
"""

from __future__ import annotations

import argparse
import math
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import lru_cache
from multiprocessing import get_context

import numpy as np

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import diagnose
from cycloid_profile.measurement import parse_measurement
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import KINDS, Hidden, Reducer, spec_text
from tests.diagnosis.blind.cases import measured
from tests.diagnosis.separable import View, derivative
from tests.diagnosis.workers import one_core

# Noncentrality for a level of 0.001 and a power of 0.8, one coordinate.
_ONE_LOOK = 17.07
_SETTINGS = {"turn_deg": 2.0, "offset_um": [0.0, 0.0], "output_angle_deg": 5.73, "friction_form": "coulomb"}


@lru_cache(maxsize=8)
def _reported(file: str) -> dict[str, tuple[float, str]]:
    """What the diagnosis of a clean file says it would not have seen."""
    return _diagnosed(file, [], 1).not_seen


def _diagnosed(file: str, effects: list[Hidden], seed: int):
    reducer = as_built_reducer(parse_spec(spec_text(Reducer())))
    text = measured(Reducer(), effects, (file,), _SETTINGS, seed=seed)[file]
    return diagnose(reducer, [parse_measurement(text, f"{file}.csv")])


def drawn(name: str, size: float, seed: int) -> Hidden:
    """The effect of a size, at a place that the seed determines, on disc 1 where it is of one disc."""
    one = KINDS[name].draw(name, Reducer(), 1.0, (1,), np.random.default_rng(seed))
    return Hidden(name, one.parameters | {KINDS[name].key: math.copysign(size, one[KINDS[name].key])})


def found(asked: tuple[str, str, float, int]) -> bool:
    """Whether an effect of this size is detected."""
    file, name, size, seed = asked
    return _diagnosed(file, [drawn(name, size, seed)], seed).verdict != "agrees"


def table(file: str, runs: int, workers: int) -> list[str]:
    """Rows of the table of one file."""
    view = View((file,), output_angle_deg=_SETTINGS["output_angle_deg"] if file == "loop" else 0.0)
    lines = []
    # A fork after the first compiled call would end the process: OpenMP does not survive it.
    with ProcessPoolExecutor(workers, get_context("spawn"), one_core) as pool:
        for name, (limit, key) in _reported(file).items():
            kind = KINDS.get(name)
            if kind is None or name == "grinding_chatter" or kind.key != key or not math.isfinite(limit):
                continue
            typical = 1.0 / kind.typical if kind.inverse else kind.typical
            whole = float(np.linalg.norm(derivative(view, drawn(name, kind.typical, 1))))
            least = typical * math.sqrt(_ONE_LOOK) / whole if whole else math.inf
            hits = sum(pool.map(found, [(file, name, limit, 7000 + k) for k in range(runs)]))
            best = 1.0 / least if kind.inverse else least
            lines.append(f"| `{name}` | {file} | {best:.3g} | {limit:.3g} | {hits} of {runs} |")
            print(lines[-1], file=sys.stderr, flush=True)
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--files", default="scan,loop,te_light,te,lost_motion")
    arguments = parser.parse_args()
    print("| effect | file | one look, known shape | stated limit | found at that size |\n|---|---|---|---|---|")
    for file in arguments.files.split(","):
        print("\n".join(table(file, arguments.runs, arguments.workers)))


if __name__ == "__main__":
    main()
