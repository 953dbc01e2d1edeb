"""Diagnosis of measured files: detection, search, acceptance and result (docs/diagnosis.md)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.data._loops import path_error_share
from cycloid_profile.diagnosis.data.recording import Recording, for_validation_only, record, use_all_rows
from cycloid_profile.diagnosis.data.repeats import with_drift_of_instrument, with_noise_of_repeats
from cycloid_profile.diagnosis.data.screening import screen_files
from cycloid_profile.diagnosis.model.candidate import Candidate, candidates
from cycloid_profile.diagnosis.model.detection import (
    Detection,
    Finding,
    detect,
    detect_given,
    largest_finding,
    largest_gain,
)
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.flank_grid import FlankGrid
from cycloid_profile.diagnosis.model.optimum import Attempt, Optimum
from cycloid_profile.diagnosis.model.residuals import Residuals, fitted_rms
from cycloid_profile.diagnosis.model.whitened import NormalEquations, Whitened, coordinates, normal_equations
from cycloid_profile.diagnosis.planning.detectable import smallest_detectable
from cycloid_profile.diagnosis.search.lobe_index import index_lobes
from cycloid_profile.diagnosis.search.seam import seam_notes
from cycloid_profile.diagnosis.search.search import SearchResult, search_effects
from cycloid_profile.diagnosis.verdict._alternatives import (
    clear_effects,
    group_note,
    location_notes,
    named_effects,
    rotation_notes,
    sign_notes,
)
from cycloid_profile.diagnosis.verdict.nearest_effects import NearestEffect, nearest
from cycloid_profile.diagnosis.verdict.rest_curves import EmpiricalFit, empirical_fits, exceeds_noise
from cycloid_profile.diagnosis.verdict.result import Diagnosis, FileGap, NamedEffect
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.measurement import PROFILE_SCAN, Measurement, scanned_disc

_LEAST_EVIDENCE = 5.0  # odds of 150 to 1 against no effect
_EXPLAINED = 0.9  # share of the initial residual that accepted effects explain if a residual remains

NotSeen = dict[str, tuple[float, str]]


def diagnose(
    reducer: AsBuiltReducer,
    measurements: Sequence[Measurement],
    discs: Sequence[int] | None = None,
    held_out: Sequence[Measurement] = (),
    progress: Callable[[str], None] = lambda _: None,
) -> Diagnosis:
    """Compare measured files with the simulation and name the missing effects.

    Parameters
    ----------
    reducer : reducer of the spec, with the effects it already has
    measurements : files to explain together; a fifth of the rows of each is held out
    discs : disc of each scan, counted from 0; from the key ``specimen`` if None
    held_out : files used for the check only
    progress : receives one sentence for each step

    Raises
    ------
    MeasurementError
        If a file cannot belong to this reducer.
    """
    progress("comparing the files with the simulation")
    files = _read(reducer, measurements, discs, held_out)
    progress("testing the residual against the noise")
    model, library = _exact_model(reducer, files)
    detected = _detect_all_rows(model, library)
    not_seen = smallest_detectable(detected.equations, detected.detection.families)
    if not detected.detection.significant_findings:
        return _agreement(detected, files, not_seen)
    gain = largest_gain(detected.equations)
    explanation = _explain(search_effects(model, library, gain, progress), detected, library, progress)
    return _result(explanation, files, not_seen, progress)


@dataclass(frozen=True, eq=False)
class _Files:
    """Prepared files: ``recordings`` to explain, ``checks`` for the final check."""

    recordings: tuple[Recording, ...]
    checks: tuple[Recording, ...]

    @property
    def notes(self) -> list[str]:
        files = (*self.recordings, *self.checks)
        understood = [f"{r.name}: {note}" for r in files for note in r.measurement.notes]
        return understood + [f"{r.name}: {note}" for r in self.recordings for note in r.notes]

    @property
    def scanned(self) -> frozenset[int]:
        return frozenset(r.disc for r in self.recordings if r.kind is PROFILE_SCAN)

    @property
    def curves(self) -> bool:
        return any(r.kind.is_curve for r in self.recordings)


def _read(
    reducer: AsBuiltReducer,
    measurements: Sequence[Measurement],
    discs: Sequence[int] | None,
    held_out: Sequence[Measurement],
) -> _Files:
    measurements, held_out = screen_files(reducer, measurements, held_out)
    ready = [record(reducer, m, _disc(reducer, m, discs, i)) for i, m in enumerate(measurements)]
    checks = [for_validation_only(record(reducer, m, _disc(reducer, m, None, 0))) for m in held_out]
    both = with_drift_of_instrument([*with_noise_of_repeats(ready), *checks])
    return _Files(tuple(both[: len(ready)]), tuple(both[len(ready) :]))


def _disc(reducer: AsBuiltReducer, measurement: Measurement, discs: Sequence[int] | None, number: int) -> int:
    if discs is not None:
        return discs[number]
    return scanned_disc(measurement, reducer.discs)


@dataclass(frozen=True, eq=False)
class _Detected:
    """A model, the same with all rows to fit (``everything``), their equations and detection."""

    model: ExactModel
    everything: ExactModel
    equations: NormalEquations
    detection: Detection


@dataclass(frozen=True, eq=False)
class _Explanation:
    """Search result on all rows: its optimum ``final``, the tests ``after_effects``, and the ``worst`` finding in the
    residual."""

    found: SearchResult
    detected: _Detected
    final: Optimum
    after_effects: Detection
    worst: Finding | None

    @cached_property
    def nearest(self) -> tuple[NearestEffect, ...]:
        """The effects that explain most alone, whatever their size."""
        return nearest(self.detected.everything, self.detected.equations)

    @property
    def rest(self) -> Finding | None:
        """The largest place that is left; of printed reducers also one that the error of the path may explain."""
        if self.worst is not None or not path_error_share(self.detected.model.reducer):
            return self.worst
        beyond = [one for one in self.detected.everything.at(self.final).blocks if exceeds_noise(one.residuals)]
        found = detect(beyond, None, within_accuracy=True)
        return largest_finding(found) if found.significant_findings else None

    def part(self, some: Sequence[int]) -> _Explanation | None:
        """Explanation by some members alone, None if they fit at no plausible size."""
        whole = self.found.best
        members = tuple(whole.members[i] for i in some)
        attempt = Attempt(members, whole.u[coordinates(some)])
        best = self.found.model.optimum(attempt, self.found.library.prior(members))
        if best is None or best.implausible:
            return None
        return _final(replace(self.found, best=best), self.detected)


def _explain(
    found: SearchResult, detected: _Detected, library: Sequence[Candidate], progress: Callable[[str], None]
) -> _Explanation:
    """Explanation by a search result, whose lobe index may differ from that of ``detected``."""
    if found.model is not detected.model:
        detected = _detect_all_rows(found.model, library)
    progress("testing the residual after the effects")
    return _final(found, detected)


def _final(found: SearchResult, detected: _Detected) -> _Explanation:
    everything, best = detected.everything, found.best
    final = everything.optimum(Attempt(best.members, best.u), found.library.prior(best.members)) or best
    after_effects = detect_given(everything.at(final).blocks, final.members)
    worst = largest_finding(after_effects) if after_effects.significant_findings else None
    return _Explanation(found, detected, final, after_effects, worst)


def _detect_all_rows(model: ExactModel, library: Sequence[Candidate]) -> _Detected:
    everything = model.with_held_out([use_all_rows(r) for r in model.recordings])
    equations = normal_equations(everything.baseline.blocks, library)
    return _Detected(model, everything, equations, detect(everything.baseline.blocks, equations))


def _agreement(detected: _Detected, files: _Files, not_seen: NotSeen) -> Diagnosis:
    """Result where nothing exceeds the noise and the accuracy of the simulation."""
    model, detection, notes = detected.model, detected.detection, files.notes
    if detection.significant:
        notes.append("the difference is significant but below the accuracy of the simulation")
    residuals = [*model.baseline.residuals, *(Residuals(r, model.reducer, model.flank_grid) for r in files.checks)]
    gaps = tuple(_gap(one.recording, one, one) for one in residuals)
    return Diagnosis(
        model.reducer,
        model.reducer,
        "agrees",
        (),
        detection,
        detection,
        (),
        None,
        (),
        not_seen,
        gaps,
        tuple(notes),
        0.0,
    )


def _exact_model(reducer: AsBuiltReducer, files: _Files) -> tuple[ExactModel, list[Candidate]]:
    """Model of the files, the lobe index of scans found, and the hypotheses that they can show."""
    library = list(candidates(reducer, files.scanned, files.curves))
    flank_grid = FlankGrid(reducer)
    residuals = index_lobes(reducer, [Residuals(r, reducer, flank_grid) for r in files.recordings], library, flank_grid)
    return ExactModel(reducer, [one.recording for one in residuals], flank_grid, residuals), library


def _result(explanation: _Explanation, files: _Files, not_seen: NotSeen, progress: Callable[[str], None]) -> Diagnosis:
    """Result with the accepted effects, else with an unknown effect and its place."""
    detected, best = explanation.detected, explanation.found.best
    reducer, notes = detected.model.reducer, files.notes
    notes += seam_notes(files.recordings, detected.everything.recordings, reducer.case.drive.trochoid.lobes)
    if explanation.found.limited:
        notes.append("the search reached its limit of fits: another set of effects may explain more")
    effects: tuple[NamedEffect, ...] = ()
    if _is_accepted(explanation):
        effects = named_effects(explanation.found, detected.everything, explanation.final, progress)
        explanation, effects, left_out = _without_ambiguous(explanation, effects)
        best = explanation.found.best
        everything, final = detected.everything, explanation.final
        notes += [*left_out, *location_notes(effects)]
        notes += [*rotation_notes(everything, final), *sign_notes(everything, final)]
    corrected = _reducer_with(reducer, effects)
    # The error of the path of printed reducers would take most of what is there.
    where = () if path_error_share(reducer) else _places(detected.detection)
    where = where or _places(detect(detected.everything.baseline.blocks, None, within_accuracy=True))
    near = () if effects else explanation.nearest
    notes += [one.sentence for one in near if one.too_large]
    empirical: tuple[EmpiricalFit, ...] = ()
    model = explanation.found.model
    left = (model.at(best) if effects else model.baseline).residuals
    if explanation.worst is not None or not effects or any(exceeds_noise(one) for one in left):
        progress("fitting smooth curves to what is left")
        empirical = empirical_fits(left)
        notes += [one.sentence for one in empirical]
    return Diagnosis(
        reducer,
        corrected,
        "effects_found" if effects else "unknown_effect",
        effects,
        detected.detection,
        explanation.after_effects,
        where,
        explanation.rest if effects else largest_finding(detected.detection),
        near,
        not_seen,
        _gaps(explanation, files, corrected, bool(effects)),
        tuple(notes),
        best.log_evidence,
        empirical,
    )


def _without_ambiguous(
    explanation: _Explanation, effects: tuple[NamedEffect, ...]
) -> tuple[_Explanation, tuple[NamedEffect, ...], list[str]]:
    """The explanation by clear effects alone, if they close the gap, and notes on those left out."""
    clear = clear_effects(effects)
    part = explanation.part(clear) if len(clear) < len(effects) else None
    if part is None or not _closes(part):
        return explanation, effects, []
    sizes = part.detected.everything.with_residual_noise(part.final)
    named = tuple(
        replace(effects[i], coordinates=sizes.coordinates(k), covariance=sizes.covariance_of(k))
        for k, i in enumerate(clear)
    )
    return part, named, [group_note(one) for i, one in enumerate(effects) if i not in clear]


def _closes(explanation: _Explanation) -> bool:
    """Whether the best set closes four fifths of the rms of each file, beyond noise, on the rows to fit."""
    model = explanation.found.model
    for before, after in zip(model.baseline.residuals, model.at(explanation.found.best).residuals, strict=True):
        fitted, noise2 = ~before.recording.held_out, before.recording.noise.sigma**2
        gap, left = (fitted_rms(one, fitted) ** 2 - noise2 for one in (before, after))
        if gap > noise2 and left > (1.0 - tuned.CLOSED) ** 2 * gap:
            return False
    return True


def _is_accepted(explanation: _Explanation) -> bool:
    """Whether the best set is accepted: by evidence, and if a residual remains by the share that it explains."""
    best, detected = explanation.found.best, explanation.detected
    if not best.members or best.log_evidence < _LEAST_EVIDENCE:
        return False
    if explanation.worst is None:
        return True
    first, rows = detected.everything.baseline.chi2, detected.equations.rows
    explained = (first - explanation.final.chi2) / max(first - rows, 1e-9)
    # One effect that explains more but would be implausibly large is nearer to what is there.
    too_large = [one.share for one in explanation.nearest if one.too_large]
    return explained > max([_EXPLAINED, *too_large])


def _gaps(
    explanation: _Explanation, files: _Files, corrected: AsBuiltReducer, search_effects: bool
) -> tuple[FileGap, ...]:
    """Each file before and after, with sizes from the rows to fit only."""
    found = explanation.found
    flank_grid = found.model.flank_grid
    before = [*found.model.baseline.residuals, *(Residuals(r, found.model.reducer, flank_grid) for r in files.checks)]
    after = before
    if search_effects:
        # The effects make the lobes differ, so the lobe index of a check scan is free again.
        checked = [Residuals(replace(r, placed=None), corrected, flank_grid) for r in files.checks]
        after = [*found.model.at(found.best).residuals, *checked]
    return tuple(_gap(a.recording, a, b) for a, b in zip(before, after, strict=True))


def _reducer_with(reducer: AsBuiltReducer, effects: Sequence[NamedEffect]) -> AsBuiltReducer:
    for one in effects:
        reducer = one.effect.apply(reducer)
    return reducer


def _places(detection: Detection) -> tuple[Finding, ...]:
    """First finding of each file and coordinate, without those of the library."""
    seen: set[tuple[str, str]] = set()
    found = []
    for finding in detection.significant_findings:
        key = (finding.file, finding.coordinate)
        if finding.file and finding.coordinate != "file" and key not in seen:
            seen.add(key)
            found.append(finding)
    return tuple(found)


def _gap(recording: Recording, before: Residuals, after: Residuals) -> FileGap:
    values = [
        fitted_rms(residuals, recording.held_out == held, held)
        for held in (False, True)
        for residuals in (before, after)
    ]
    fit_before, fit_after, held_before, held_after = values
    block = Whitened(after, held_out=bool(np.all(recording.held_out)))
    chi2 = block.chi2 / max(block.z.size, 1)
    return FileGap(recording, before, after, fit_before, fit_after, held_before, held_after, chi2)
