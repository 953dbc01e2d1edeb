"""Changes of amounts between two diagnoses of one specimen, with uncertainty (docs/diagnosis.md, "Two measurements").

Both measurements share the error of the model, which cancels in the difference to first order: a change is known better
than an amount.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.change._joint_model import Hypothesis, JointFit, JointModel
from cycloid_profile.diagnosis.change._joint_search import JointSearch, starting_sets
from cycloid_profile.diagnosis.change.amounts import AmountChange, amount_to_json, number_or_none
from cycloid_profile.diagnosis.change.loop_figures import FigureChange, figures_of_loop
from cycloid_profile.diagnosis.data.recording import use_all_rows
from cycloid_profile.diagnosis.model.candidate import Candidate, candidates
from cycloid_profile.diagnosis.model.evidence import Library
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.residuals import Residuals, fitted_rms
from cycloid_profile.diagnosis.verdict.json_output import rounded_number
from cycloid_profile.diagnosis.verdict.result import Diagnosis, FileGap
from cycloid_profile.effects import EffectLocation
from cycloid_profile.measurement import HYSTERESIS, PROFILE_SCAN

SIGNIFICANT = 3.0  # standard deviations: smaller changes are reported as none
_DISTINGUISHED = 9.0  # of the misfit: three standard deviations between two explanations
_ALTERNATIVES = 4  # other changes fitted in place of each
_LEADING = 3  # hypotheses of the search without smooth errors that are fitted with them


@dataclass(frozen=True, eq=False)
class FilePair:
    """A file after with its counterpart before, None without one; root mean square of measured minus predicted.

    ``unchanged``: residuals of the file after on the reducer before. ``after``, ``before``: on their own reducers.
    """

    before: Residuals | None
    unchanged: Residuals
    after: Residuals

    @property
    def rms(self) -> tuple[float | None, float, float]:
        """Of the file before, of the file after without and with the changes; zero and datum fitted."""
        before = None if self.before is None else _rms_of_all(self.before)
        return before, _rms_of_all(self.unchanged), _rms_of_all(self.after)


@dataclass(frozen=True, eq=False)
class Comparison:
    """What changed from the diagnosis ``before`` to the diagnosis ``after``.

    ``changes``: significant ones, the largest in standard deviations first. ``unchanged``: effects at both times whose
    change is not significant. ``figures``: of the loop at both times. ``files``: pairs.
    """

    before: Diagnosis
    after: Diagnosis
    changes: tuple[AmountChange, ...]
    unchanged: tuple[AmountChange, ...]
    figures: tuple[FigureChange, ...]
    files: tuple[FilePair, ...]
    notes: tuple[str, ...]


def compare_diagnoses(
    before: Diagnosis, after: Diagnosis, progress: Callable[[str], None] = lambda _: None
) -> Comparison:
    """What changed between two diagnoses of one specimen on the same reducer of the spec."""
    progress("comparing both times")
    first, second = _model(before), _model(after)
    model = JointModel(first, second)
    named = [_effects(one, model.only_loops) for one in (before, after)]
    library = _library(model, [one for some in named for one in some])
    # Smooth errors hide friction and compliance from a search that begins with nothing.
    first_search = JointSearch(model, library, progress, smooth=False)
    first_search.search(starting_sets(model, *named))
    search = JointSearch(model, library, progress)
    # With smooth errors a leading hypothesis may become implausible; that of no effect never does.
    leading = sorted(first_search.fits.values(), key=lambda one: -one.log_evidence)[:_LEADING]
    nothing = Hypothesis(frozenset(), frozenset())
    search.search([[*((one.state.hypothesis, one.state.theta) for one in leading), (nothing, np.zeros(0))]])
    search.fit_alternatives(_ALTERNATIVES)
    best = search.best
    every = _amounts(search, best)
    changes = [
        one for one in every if one.significance >= SIGNIFICANT and one.candidate in best.state.hypothesis.changed
    ]
    return Comparison(
        before,
        after,
        tuple(sorted(changes, key=lambda one: -one.significance)),
        tuple(one for one in every if one not in changes and np.any(one.before)),
        _figures(model, search, best),
        _files(model, best),
        _notes(model, search),
    )


def _model(diagnosis: Diagnosis) -> ExactModel:
    """The files to explain with all their rows, on the reducer of the spec."""
    gaps = _explained(diagnosis)
    recordings = [use_all_rows(gap.recording) for gap in gaps]
    return ExactModel(diagnosis.reducer, recordings, gaps[0].before.flank_grid, [gap.before for gap in gaps])


def _explained(diagnosis: Diagnosis) -> list[FileGap]:
    return [gap for gap in diagnosis.gaps if not np.all(gap.recording.held_out)]


def _effects(diagnosis: Diagnosis, only_loops: bool) -> dict[Candidate, FloatArray]:
    """Named effects with their coordinates in prior widths, without those that loops do not show."""
    return {
        one.candidate: _padded(one.coordinates) / one.candidate.width
        for one in diagnosis.effects
        if not (only_loops and _is_hidden_in_loops(one.candidate))
    }


def _padded(x: FloatArray) -> FloatArray:
    return np.pad(np.asarray(x, dtype=np.float64), (0, 2 - len(x)))


def _library(model: JointModel, named: Sequence[Candidate]) -> Library:
    """Hypotheses that the files can show, and those named already."""
    recordings = (*model.before.recordings, *model.after.recordings)
    scanned = frozenset(r.disc for r in recordings if r.kind is PROFILE_SCAN)
    found = candidates(model.before.reducer, scanned, any(r.kind.is_curve for r in recordings))
    if model.only_loops:
        found = tuple(one for one in found if not _is_hidden_in_loops(one))
    most = max((r.rows.size for r in recordings if r.kind is not HYSTERESIS), default=2)
    return Library(found, most).with_more(named)


def _is_hidden_in_loops(candidate: Candidate) -> bool:
    """Whether a loop, which has one angle of the output, cannot show the direction or the part of an effect."""
    single = any(candidate.choice.get(key) is not None for key in ("lobe", "first_lobe", "pin", "crank", "planet"))
    one_disc = candidate.kind.location is EffectLocation.FLANK and candidate.choice.get("disc") is not None
    return candidate.angle is not None or single or one_disc


def _amounts(search: JointSearch, best: JointFit) -> list[AmountChange]:
    """Every effect of a fit with its change; an effect without one gets the change that the data allow."""
    hypothesis = best.state.hypothesis
    found = []
    for member in hypothesis.after:
        theta, covariance, owner = best.state.theta, best.covariance, hypothesis
        if member not in hypothesis.changed:
            owner = Hypothesis(hypothesis.common, hypothesis.changed | {member})
            theta, covariance = search.estimate(best, owner)
        where = _places(owner, member)
        full, x = np.zeros((4, 4)), np.zeros(4)
        used = [k for k, i in enumerate(where) if i is not None]
        rows = [i for i in where if i is not None]
        x[used] = theta[rows] * member.width
        full[np.ix_(used, used)] = covariance[np.ix_(rows, rows)] * member.width**2
        if not search.model.only_scans:
            # What changed may respond in another form than the library's. A scan shows the size itself.
            full[2:, 2:] += tuned.FORM**2 * np.outer(x[2:], x[2:])
        changed = member in hypothesis.changed
        group = search.alternatives(best, member, _DISTINGUISHED) if changed else (member.name,)
        evidence = search.evidence_of_change(best, member) if changed else 0.0
        found.append(AmountChange(member, x[:2], x[2:], full, group, evidence))
    return found


def _places(hypothesis: Hypothesis, member: Candidate) -> list[int | None]:
    """Index of each coordinate before and of the change; None before of a new effect."""
    n = len(hypothesis.before)
    first: list[int | None] = [None, None]
    if member in hypothesis.common:
        i = 2 * hypothesis.before.index(member)
        first = [i, i + 1]
    k = 2 * (n + hypothesis.changes.index(member))
    return [*first, k, k + 1]


def _figures(model: JointModel, search: JointSearch, best: JointFit) -> tuple[FigureChange, ...]:
    """Figures of the loop, with all effects free to change."""
    hypothesis = best.state.hypothesis
    every = Hypothesis(hypothesis.common, hypothesis.changed | hypothesis.common)
    theta, covariance = search.estimate(best, every)
    state = model.state(every, theta)
    return () if state is None else figures_of_loop(model, state, covariance)


def _files(model: JointModel, best: JointFit) -> tuple[FilePair, ...]:
    state = best.state
    without = model.after.state(state.hypothesis.before, state.u)
    unchanged = (without or model.after.baseline).residuals
    return tuple(
        FilePair(
            None if pair.before is None else state.before.residuals[pair.before],
            unchanged[pair.after],
            state.after.residuals[pair.after],
        )
        for pair in model.pairs
        if pair.after is not None
    )


def _notes(model: JointModel, search: JointSearch) -> tuple[str, ...]:
    alone = [model.before.recordings[p.before].name for p in model.pairs if p.before is not None and p.after is None]
    alone += [model.after.recordings[p.after].name for p in model.pairs if p.after is not None and p.before is None]
    notes = [
        f"{name} has no counterpart measured in the same way: its error of the model does not cancel" for name in alone
    ]
    if search.limited:
        notes.append("the comparison reached its limit of fits: other changes may explain more")
    return tuple(notes)


def _rms_of_all(residuals: Residuals) -> float:
    return fitted_rms(residuals, np.ones(residuals.residual.size, dtype=bool))


def comparison_to_json(comparison: Comparison) -> dict[str, Any]:
    """JSON object ``against`` of a diagnosis (docs/diagnosis.md, "JSON")."""
    return {
        "verdict_before": comparison.before.verdict,
        "files": [_pair_to_json(pair) for pair in comparison.files],
        "changes": [row for one in comparison.changes for row in amount_to_json(one)],
        "unchanged": [row for one in comparison.unchanged for row in amount_to_json(one)],
        "figures": [
            {
                "name": one.name,
                "before": rounded_number(one.before),
                "after": rounded_number(one.after),
                "change": rounded_number(one.change),
                "uncertainty": rounded_number(one.uncertainty),
                "significance": rounded_number(one.significance),
            }
            for one in comparison.figures
        ],
        "notes": list(comparison.notes),
    }


def _pair_to_json(pair: FilePair) -> dict[str, Any]:
    before, unchanged, after = pair.rms
    return {
        "before": None if pair.before is None else pair.before.recording.name,
        "after": pair.after.recording.name,
        "unit": pair.after.recording.unit,
        "rms_before": number_or_none(before),
        "rms_without_changes": number_or_none(unchanged),
        "rms_after": number_or_none(after),
    }
