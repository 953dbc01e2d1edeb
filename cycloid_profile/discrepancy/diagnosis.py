"""Where measured files and simulation disagree, what effect is missing, how sure that is (docs/diagnosis.md)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.discrepancy.candidates import Candidate, candidates
from cycloid_profile.discrepancy.detectable import smallest_detectable
from cycloid_profile.discrepancy.detection import Detection, Finding, detect
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.laid import Laid, settled
from cycloid_profile.discrepancy.left_over import detect_beside, most_striking, worst_left
from cycloid_profile.discrepancy.lobes import counted_alike
from cycloid_profile.discrepancy.naming import Named, named
from cycloid_profile.discrepancy.nearest import nearest
from cycloid_profile.discrepancy.normal import Normal, Whitened, normal
from cycloid_profile.discrepancy.optimum import Attempt, Optimum
from cycloid_profile.discrepancy.outcome import Diagnosis, FileGap, NamedEffect
from cycloid_profile.discrepancy.probes import Probes
from cycloid_profile.discrepancy.recording import Recording, hold_all_out, hold_nothing_out, record
from cycloid_profile.discrepancy.repeats import with_noise_of_repeats
from cycloid_profile.discrepancy.rivals import elsewhere_told, named_effects, turned_round
from cycloid_profile.discrepancy.screening import screen
from cycloid_profile.discrepancy.seam import seams_told
from cycloid_profile.effects.built import Built
from cycloid_profile.measurement.files import Measurement, scanned_disc

_LEAST_EVIDENCE = 5.0
_EXPLAINED = 0.9  # of the gap, for a name beside a remainder
_HELD_OUT = 1.5  # times the noise: of 436 right names none left more than 1.25 on rows that were held out
_SPOILT = 25.0  # of chi²

NotSeen = dict[str, tuple[float, str]]


def diagnose(
    built: Built,
    measurements: Sequence[Measurement],
    discs: Sequence[int] | None = None,
    held_out: Sequence[Measurement] = (),
    tell: Callable[[str], None] = lambda _: None,
) -> Diagnosis:
    """Compare measured files with what the rig predicts, and name what is missing.

    Parameters
    ----------
    built : the reducer of the spec, with the effects it already holds
    measurements : files to explain, jointly; one fifth of the rows of each is kept for the check
    discs : disc of each scan, counted from 0; told from ``specimen`` where None
    held_out : files that are only used for the check
    tell : is told of each step

    Raises
    ------
    MeasurementError
        If a file cannot be of this reducer.
    """
    tell("reading the files against the simulation")
    files = _read(built, measurements, discs, held_out)
    library = list(candidates(built, files.scanned, files.curves))
    probes = Probes(built)
    tell("looking for what is beyond the noise")
    laid = counted_alike(built, [Laid(r, built, probes) for r in files.recordings], library, probes)
    model = ExactModel(built, [one.recording for one in laid], probes, laid)
    looked = _looked_at(model, library)
    not_seen = smallest_detectable(looked.equations, looked.detection.families)
    if not looked.detection.striking:
        return _agreement(looked, files, not_seen)
    account = _account(named(model, library, tell), looked, library, tell)
    if account.worst is not None and files.curves:
        tell("something is left: every place of an effect by itself")
        again = _account(named(account.found.model, library, tell, thorough=True), account.looked, library, tell)
        if again.final.log_evidence > account.final.log_evidence:
            account = again
    return _answer(account, files, not_seen, tell)


@dataclass(frozen=True, eq=False)
class _Files:
    """What was measured, made ready: ``recordings`` to explain, ``checks`` to be looked at in the end."""

    recordings: tuple[Recording, ...]
    checks: tuple[Recording, ...]

    @property
    def notes(self) -> list[str]:
        return [f"{r.name}: {note}" for r in self.recordings for note in r.notes]

    @property
    def scanned(self) -> frozenset[int]:
        return frozenset(r.disc for r in self.recordings if r.kind == "profile_scan")

    @property
    def curves(self) -> bool:
        return any(r.kind != "profile_scan" for r in self.recordings)


def _read(
    built: Built, measurements: Sequence[Measurement], discs: Sequence[int] | None, held_out: Sequence[Measurement]
) -> _Files:
    for measurement in (*measurements, *held_out):
        screen(built, measurement)
    ready = [record(built, m, _disc(built, m, discs, i)) for i, m in enumerate(measurements)]
    checks = tuple(hold_all_out(record(built, m, _disc(built, m, None, 0))) for m in held_out)
    return _Files(tuple(with_noise_of_repeats(ready)), checks)


def _disc(built: Built, measurement: Measurement, discs: Sequence[int] | None, number: int) -> int:
    if discs is not None:
        return discs[number]
    return scanned_disc(measurement, built.discs)


@dataclass(frozen=True, eq=False)
class _Looked:
    """A model with ``everything``, all rows to fit, their equations and what strikes."""

    model: ExactModel
    everything: ExactModel
    equations: Normal
    detection: Detection


@dataclass(frozen=True, eq=False)
class _Account:
    """What the best set that was ``found`` explains of all rows: ``final``, what is ``left``, the ``worst`` of it."""

    found: Named
    looked: _Looked
    final: Optimum
    left: Detection
    worst: Finding | None


def _account(found: Named, looked: _Looked, library: Sequence[Candidate], tell: Callable[[str], None]) -> _Account:
    """Of a set that may have been found with the lobes of a scan counted otherwise, so that its places are others."""
    if found.model is not looked.model:
        looked = _looked_at(found.model, library)
    tell("checking what is left")
    everything, best = looked.everything, found.best
    final = everything.optimum(Attempt(best.members, best.u, steps=3), found.library.prior(best.members)) or best
    left = detect_beside(everything.at(final).blocks, final.members)
    return _Account(found, looked, final, left, worst_left(left, everything.nothing.blocks))


def _looked_at(model: ExactModel, library: Sequence[Candidate]) -> _Looked:
    everything = model.with_rows([hold_nothing_out(r) for r in model.recordings])
    equations = normal(everything.nothing.blocks, library)
    return _Looked(model, everything, equations, detect(everything.nothing.blocks, equations))


def _agreement(looked: _Looked, files: _Files, not_seen: NotSeen) -> Diagnosis:
    """The answer where nothing is beyond the noise and the accuracy of the simulation."""
    model, detection, notes = looked.model, looked.detection, files.notes
    if detection.significant:
        notes.append("what differs is significant but smaller than the simulation can be trusted for")
    laid = [*model.nothing.laid, *(Laid(r, model.built, model.probes) for r in files.checks)]
    gaps = tuple(_gap(one.recording, one, one) for one in laid)
    return Diagnosis(
        model.built, model.built, "agrees", (), detection, detection, (), None, (), not_seen, gaps, tuple(notes), 0.0
    )


def _answer(account: _Account, files: _Files, not_seen: NotSeen, tell: Callable[[str], None]) -> Diagnosis:
    """The names where they stand, else what is unknown and where."""
    looked, best = account.looked, account.found.best
    built, notes = looked.model.built, files.notes
    notes += seams_told(files.recordings, looked.everything.recordings, built.case.drive.trochoid.lobes)
    effects: tuple[NamedEffect, ...] = ()
    if _stands(account):
        effects = named_effects(account.found, looked.everything, account.final, tell)
        notes += [*elsewhere_told(effects), *turned_round(looked.everything, account.final)]
    corrected = _with(built, effects)
    where = _places(looked.detection) or _places(detect(looked.everything.nothing.blocks, None, settle=True))
    near = () if effects else nearest(looked.everything, looked.equations)
    notes += [one.sentence for one in near if one.too_large]
    return Diagnosis(
        built,
        corrected,
        "effects_found" if effects else "unknown_effect",
        effects,
        looked.detection,
        account.left,
        where,
        account.worst if effects else most_striking(looked.detection),
        near,
        not_seen,
        _gaps(account, files, corrected, bool(effects)),
        tuple(notes),
        best.log_evidence,
    )


def _stands(account: _Account) -> bool:
    """Whether the best set may be told: likely enough, right for rows that did not choose it, and with a remainder only
    if it explains nearly all.
    """
    best, looked = account.found.best, account.looked
    if not best.members or best.log_evidence < _LEAST_EVIDENCE or not _holds(account.found):
        return False
    first, rows = looked.everything.nothing.chi2, looked.equations.rows
    explained = (first - account.final.chi2) / max(first - rows, 1e-9)
    return account.worst is None or (explained > _EXPLAINED and not _spoils(looked.everything, account.final))


def _holds(found: Named) -> bool:
    """Whether the rows that were held out of every file agree with the best set, or nearly all of their gap is gone."""
    after = found.model.at(found.best).laid
    gaps = [_gap(a.recording, a, b) for a, b in zip(found.model.nothing.laid, after, strict=True)]
    return not any(
        gap.held_out_after > _HELD_OUT * gap.noise and not (gap.closure is not None and gap.closure > _EXPLAINED)
        for gap in gaps
    )


def _gaps(account: _Account, files: _Files, corrected: Built, named: bool) -> tuple[FileGap, ...]:
    """Each file before and after, sizes of the rows to fit only: what was held out is held out."""
    found = account.found
    probes = found.model.probes
    before = [*found.model.nothing.laid, *(Laid(r, found.model.built, probes) for r in files.checks)]
    after = before
    if named:
        # Which lobe is the first shows only now, on teeth whose lobes differ.
        checked = [Laid(replace(r, placed=None), corrected, probes) for r in files.checks]
        after = [*found.model.at(found.best).laid, *checked]
    return tuple(_gap(a.recording, a, b) for a, b in zip(before, after, strict=True))


def _spoils(everything: ExactModel, final: Optimum) -> bool:
    """Whether some file fits worse with the effects than without: what explains one must not contradict another."""
    blocks = zip(everything.nothing.blocks, everything.at(final).blocks, strict=True)
    return any(after.chi2 > before.chi2 + _SPOILT for before, after in blocks)


def _with(built: Built, effects: Sequence[NamedEffect]) -> Built:
    for one in effects:
        built = one.effect.apply(built)
    return built


def _places(detection: Detection) -> tuple[Finding, ...]:
    """One finding for each file and coordinate, effects of the library left out."""
    seen: set[tuple[str, str]] = set()
    found = []
    for finding in detection.striking:
        key = (finding.file, finding.coordinate)
        if finding.file and finding.coordinate != "file" and key not in seen:
            seen.add(key)
            found.append(finding)
    return tuple(found)


def _gap(recording: Recording, before: Laid, after: Laid) -> FileGap:
    values = [_rms(laid, held) for held in (False, True) for laid in (before, after)]
    fit_before, fit_after, held_before, held_after = values
    block = Whitened(after, held_out=bool(np.all(recording.held_out)))
    chi2 = block.chi2 / max(block.z.size, 1)
    return FileGap(recording, before, after, fit_before, fit_after, held_before, held_after, chi2)


def _rms(laid: Laid, held_out: bool) -> float:
    """Root mean square of the residual once the nuisances are settled on these very rows; NaN without rows."""
    rows = (laid.recording.held_out == held_out) & np.isfinite(laid.residual)
    if not np.any(rows):
        return float("nan")
    return float(np.sqrt(np.mean(settled(laid, held_out)[rows] ** 2)))
