"""What the package leaves of foreign files at the effects that they hide, and the sizes that it fits to them.

``python -m tests.diagnosis.at_truth loop`` prints the tables from which widths in ``_tuned`` follow; no search is made.
Left is the rms of files without noise, whitened by the noise of the same files with it, errors of the model fitted.
"""

from __future__ import annotations

import argparse
import itertools
from collections import defaultdict
from collections.abc import Iterator, Sequence

import numpy as np

from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.evidence import Library
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.optimum import Attempt, Optimum
from cycloid_profile.diagnosis.verdict import workflow
from tests.diagnosis.blind import Case, Hidden, spec_text
from tests.diagnosis.protocol import _read, _reducer, questions

Array = np.ndarray
_MOST_SHAPES = 8
_WELL_SEEN = 0.02  # standard deviation over size
_PLACES = ("disc", "crank", "planet", "lobe", "first_lobe", "pin", "form", "flank")


def model_of(case: Case) -> tuple[ExactModel, list[Candidate]]:
    """The package's model of the files, and its library."""
    reducer = _reducer(spec_text(case.reducer))
    return workflow._exact_model(reducer, workflow._read(reducer, *_read(case.files), ()))


def hypotheses(one: Hidden, library: Sequence[Candidate]) -> Iterator[tuple[Candidate, Array]]:
    """The hidden effect in the library, in each of its shapes, with its coordinates."""
    for candidate in library:
        places = {key: candidate.choice.get(key) for key in _PLACES if key in candidate.choice or key in one.parameters}
        if candidate.name == one.name and all(one.parameters.get(key) == value for key, value in places.items()):
            size = float(one[candidate.size])
            size = (1.0 / size if candidate.inverse else size) / candidate.width
            turn = np.deg2rad(float(one[candidate.angle])) * candidate.waves if candidate.angle else 0.0
            yield candidate, size * np.array([np.cos(turn), np.sin(turn)])


def at_truth(case: Case, model: ExactModel, library: Sequence[Candidate]) -> tuple[Optimum, Array] | None:
    """The set of hidden effects fitted from the truth, in its best shapes, and its true coordinates."""
    best: tuple[Optimum, Array] | None = None
    options = [list(hypotheses(one, library)) for one in case.truth]
    for some in itertools.islice(itertools.product(*options), _MOST_SHAPES):
        members, u = tuple(one for one, _ in some), np.concatenate([np.zeros(0), *(x for _, x in some)])
        fit = model.optimum(Attempt(members, u), Library(tuple(library), 2).prior(members))
        if fit is not None and (best is None or fit.log_evidence > best[0].log_evidence):
            best = fit, u
    return best


def left(case: Case, model: ExactModel, members: Sequence[Candidate], u: Array) -> float:
    """Rms that effects of coordinates ``u`` leave of the files without noise, in standard deviations of the noise."""
    noisy, silent = (_read(files)[0] for files in (case.files, case.silent()))
    total, rows = 0.0, 0
    state = model.state(members, u, np.inf)
    assert state is not None
    for block, before, after in zip(state.blocks, noisy, silent, strict=True):
        recording = block.residuals.recording
        column = recording.kind.columns[1]
        values = block.residuals.residual - (before[column] - after[column])[recording.rows]
        white = block.white(np.nan_to_num(values))
        total += float(block.product(white, white))
        rows += white.size
    return float(np.sqrt(total / rows))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", choices=("loop", "bench"))
    parser.add_argument("--seed", type=int, default=9960000)
    parser.add_argument("--cases", type=int, default=75)
    asked = parser.parse_args()
    rms, errors = defaultdict(list), defaultdict(list)
    for question in [q for q in questions(asked.seed) if q.section == f"wide, one, {asked.files}"][: asked.cases]:
        case = question.case()
        model, library = model_of(case)
        found = at_truth(case, model, library)
        if found is None:
            continue
        optimum, u = found
        form = (case.forms["contact"], case.forms["disc"])
        rms[form].append(left(case, model, optimum.members, u))
        true, size = (float(np.hypot(*x)) for x in (u, optimum.u))
        direction = optimum.u / size
        errors[form].append((size / true - 1.0, float(np.sqrt(direction @ optimum.covariance @ direction)) / true))
        print(question.seed, *form, case.truth[0].name, f"left {rms[form][-1]:.2f}",
              "size {:+.2%} ± {:.2%}".format(*errors[form][-1]), flush=True)  # fmt: skip
    print("| contact | disc | files | left, median | largest |\n" + "|---" * 5 + "|")
    for form, some in sorted(rms.items()):
        print(f"| {form[0]} | {form[1]} | {len(some)} | {np.median(some):.2f} | {max(some):.2f} |")
    z = [error / sd for some in errors.values() for error, sd in some if sd < _WELL_SEEN]
    if z:
        print(f"{len(z)} sizes seen to {_WELL_SEEN:.0%}: error in units of ± {np.sqrt(np.mean(np.square(z))):.2f} rms")


if __name__ == "__main__":
    main()
