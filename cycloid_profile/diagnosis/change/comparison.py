"""Changes of amounts between two diagnoses of one specimen, with uncertainty (docs/diagnosis.md, "Two measurements").

Both measurements share the error of the model, which cancels in the difference to first order: a change is known better
than an amount.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.change.amounts import AmountChange, amount_to_json, number_or_none
from cycloid_profile.diagnosis.change.loop_figures import FigureChange, figures_of_loop
from cycloid_profile.diagnosis.data.recording import Recording, use_all_rows
from cycloid_profile.diagnosis.data.screening import require_new_rows
from cycloid_profile.diagnosis.model.candidate import Candidate, candidates
from cycloid_profile.diagnosis.model.detection import largest_gain
from cycloid_profile.diagnosis.model.evidence import estimate
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.residuals import Residuals, fitted_rms
from cycloid_profile.diagnosis.model.whitened import normal_equations
from cycloid_profile.diagnosis.search.search import SearchResult, search_effects
from cycloid_profile.diagnosis.verdict._alternatives import ambiguity_group
from cycloid_profile.diagnosis.verdict.json_output import rounded_number
from cycloid_profile.diagnosis.verdict.result import Diagnosis
from cycloid_profile.effects import EffectLocation
from cycloid_profile.measurement import PROFILE_SCAN

SIGNIFICANT = 3.0  # standard deviations: smaller changes are reported as none
_LEFT = 1.2  # variance that the best set leaves, in units of the noise: more is a form without a name
_SAME = 1e-3  # of torque and angle: files with keys this close were measured in the same way


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
    """What changed between two diagnoses of one specimen on the same reducer of the spec.

    Raises ``MeasurementError`` where both explain the same file.
    """
    require_new_rows(*([gap.recording.measurement for gap in one.gaps] for one in (before, after)))
    progress("comparing both times")
    model = _both_times(before, after)
    named = [_effects(one, model.only_loops) for one in (before, after)]
    amounts = _amounts_to_ask(model, [one for some in named for one in some])
    library = [*amounts, *(one.change for one in amounts)]
    gain = largest_gain(normal_equations(model.baseline.blocks, library))
    found = search_effects(model, library, gain, progress, _starts(*named))
    if _excess(found) > _LEFT and not model.only_loops:
        # A form that no effect has would pass for one that changed. Loops have an error of their path already.
        best = found.best
        found = search_effects(_with_unnamed_error(found), library, gain, progress, [(best.members, best.u)])
    every = _amounts(found, progress)
    changed = [one for one in found.best.members if one.is_change]
    changes = [one for one in every if one.significance >= SIGNIFICANT and one.candidate.change in changed]
    return Comparison(
        before,
        after,
        tuple(sorted(changes, key=lambda one: -one.significance)),
        tuple(one for one in every if one not in changes and np.any(one.before)),
        _figures(found),
        _files(found),
        _notes(found),
    )


def pairs_of(before: Sequence[Recording], after: Sequence[Recording]) -> tuple[tuple[int, int], ...]:
    """Numbers of the files before and after that were measured in the same way; each file once."""
    free = list(range(len(after)))
    found = []
    for i, one in enumerate(before):
        same = next((j for j in free if _comparable(one, after[j])), None)
        if same is not None:
            free.remove(same)
            found.append((i, same))
    return tuple(found)


def _comparable(one: Recording, other: Recording) -> bool:
    """Whether two files have the same kind, disc, torque and output angle."""
    if one.kind is not other.kind or one.disc != other.disc:
        return False
    for key in ("torque_nm", "output_angle_deg"):
        a, b = one.measurement.number(key), other.measurement.number(key)
        if (a is None) != (b is None) or (a is not None and b is not None and abs(a - b) > _SAME * max(abs(a), 1.0)):
            return False
    return True


def _both_times(before: Diagnosis, after: Diagnosis) -> ExactModel:
    """The files that were explained at both times with all their rows, on the reducer of the spec."""
    gaps = [[gap for gap in one.gaps if not np.all(gap.recording.held_out)] for one in (before, after)]
    pairs = pairs_of(*([gap.recording for gap in some] for some in gaps))
    residuals = []
    for time, some in enumerate(gaps):
        pair = {one[time]: number for number, one in enumerate(pairs)}
        for i, gap in enumerate(some):
            recording = replace(use_all_rows(gap.recording), later=bool(time), pair=pair.get(i))
            residuals.append(gap.before.under(recording))
    return ExactModel(before.reducer, [r.recording for r in residuals], residuals[0].flank_grid, residuals)


def _effects(diagnosis: Diagnosis, only_loops: bool) -> dict[Candidate, FloatArray]:
    """Named effects with their coordinates in prior widths, without those that loops do not show."""
    return {
        one.candidate: np.pad(np.asarray(one.coordinates), (0, 2 - len(one.coordinates))) / one.candidate.width
        for one in diagnosis.effects
        if not (only_loops and _is_hidden_in_loops(one.candidate))
    }


def _amounts_to_ask(model: ExactModel, named: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """Hypotheses that the files can show, and those named already."""
    scanned = frozenset(r.disc for r in model.recordings if r.kind is PROFILE_SCAN)
    found = candidates(model.reducer, scanned, any(r.kind.is_curve for r in model.recordings))
    if model.only_loops:
        found = tuple(one for one in found if not _is_hidden_in_loops(one))
    return tuple(dict.fromkeys([*found, *named]))


def _is_hidden_in_loops(candidate: Candidate) -> bool:
    """Whether a loop, which has one angle of the output, cannot show the direction or the part of an effect."""
    single = any(candidate.choice.get(key) is not None for key in ("lobe", "first_lobe", "pin", "crank", "planet"))
    one_disc = candidate.kind.location is EffectLocation.FLANK and candidate.choice.get("disc") is not None
    return candidate.angle is not None or single or one_disc


def _starts(
    before: Mapping[Candidate, FloatArray], after: Mapping[Candidate, FloatArray]
) -> list[tuple[list[Candidate], FloatArray]]:
    """The effects of either diagnosis and of both, unchanged and all changed."""
    none, found = np.zeros(2), []
    for known in (before, after, {**after, **before}):
        # Of two places of one effect the first stays.
        common = list({one.name: one for one in reversed(list(known))}.values())
        u = [before.get(one, after.get(one, none)) for one in common]
        rise = [after[one] - before[one] if one in before and one in after else none for one in common]
        if common:
            found.append((common, np.concatenate(u)))
            found.append(([*common, *(one.change for one in common)], np.concatenate([*u, *rise])))
    return found


def _with_unnamed_error(found: SearchResult) -> ExactModel:
    """The model with a smooth error of any form, as large as what the best set leaves, in both files of a pair."""
    size: dict[int | None, float] = {}
    for one in found.model.at(found.best).residuals:
        left = fitted_rms(one, np.ones(one.residual.size, dtype=bool))
        size[one.recording.pair] = max(left, size.get(one.recording.pair, 0.0))
    shared = [
        one.under(replace(one.recording, unnamed=size[one.recording.pair])) for one in found.model.baseline.residuals
    ]
    return found.model.with_recordings([one.recording for one in shared], shared)


def _amounts(found: SearchResult, progress: Callable[[str], None]) -> list[AmountChange]:
    """Every effect of the best set with its change; an effect without one gets the change that the data allow."""
    members, scale = list(found.best.members), _excess(found)
    about_best = normal_equations(found.model.at(found.best).blocks, found.library.candidates)
    described = []
    for one in dict.fromkeys(member.amount for member in members):
        some = members if one.change in members else [*members, one.change]
        u, covariance = estimate(found.equations, found.library.places(some))
        if some is members:
            u = found.best.u
        where = [some.index(part) if part in some else None for part in (one, one.change)]
        full, x = np.zeros((4, 4)), np.zeros(4)
        used = np.array([2 * k + c for k, i in enumerate(where) if i is not None for c in range(2)])
        rows = np.array([2 * i + c for i in where if i is not None for c in range(2)])
        x[used] = u[rows] * one.width
        if one.one_sided:
            x[2] = max(x[2], -x[0])
        full[np.ix_(used, used)] = scale * covariance[np.ix_(rows, rows)] * one.width**2
        if not found.model.only_scans:
            # What changed may respond in another form than the library's. A scan shows the size itself.
            full[2:, 2:] += tuned.FORM**2 * np.outer(x[2:], x[2:])
        group: tuple[str, ...] = (one.name,)
        gain = 0.0
        if some is members:
            i = members.index(one.change)
            others = ambiguity_group(found, about_best, i, progress)
            group = tuple(dict.fromkeys([one.name, *(other.name for other in others)]))
            gain = found.best.log_evidence - found.evidence([*members[:i], *members[i + 1 :]])
        described.append(AmountChange(one, x[:2], x[2:], full, group, gain))
    return described


def _excess(found: SearchResult) -> float:
    """Variance that the best set leaves, in units of that of the noise, at least 1."""
    return max(found.best.chi2 / max(found.best.rows, 1), 1.0)


def _figures(found: SearchResult) -> tuple[FigureChange, ...]:
    """Figures of the loop, with all effects free to change."""
    members = list(found.best.members)
    every = [*members, *(one.change for one in members if not one.is_change and one.change not in members)]
    u, covariance = estimate(found.equations, found.library.places(every))
    return figures_of_loop(found.model, every, u, _excess(found) * covariance)


def _files(found: SearchResult) -> tuple[FilePair, ...]:
    best, model = found.best, found.model
    lasting = [i for i, one in enumerate(best.members) if not one.is_change]
    u = np.concatenate([np.zeros(0), *(best.u[2 * i : 2 * i + 2] for i in lasting)])
    unchanged = model.state([best.members[i] for i in lasting], u) or model.baseline
    fitted = model.at(best).residuals
    earlier = {one.recording.pair: one for one in fitted if not one.recording.later}
    return tuple(
        FilePair(None if one.recording.pair is None else earlier[one.recording.pair], still, one)
        for one, still in zip(fitted, unchanged.residuals, strict=True)
        if one.recording.later
    )


def _notes(found: SearchResult) -> tuple[str, ...]:
    notes = [
        f"{r.name} has no counterpart measured in the same way: its error of the model does not cancel"
        for r in found.model.recordings
        if r.pair is None
    ]
    if found.limited:
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
