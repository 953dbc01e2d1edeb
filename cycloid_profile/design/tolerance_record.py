"""A whole tolerance study of a spec, from what scatters to which tolerance to tighten: plain calls of the steps."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cycloid_profile.design.ground import built_reducer
from cycloid_profile.design.tolerancing import (
    backlash_study,
    beside,
    limits_in,
    loaded_study,
    tolerances_in,
    without_compensation,
)
from cycloid_profile.effects.built import Built
from cycloid_profile.spec.model import Spec
from cycloid_profile.tolerance.comparison import Comparison, compare_designs
from cycloid_profile.tolerance.run import run
from cycloid_profile.tolerance.scatter import Tolerances
from cycloid_profile.tolerance.study import Study
from cycloid_profile.tolerance.summary import StudySummary, summarise
from cycloid_profile.tolerance.workers import Workers

Tell = Callable[[str], None]
# Reducers that two designs are compared by: a ratio of deviations to a hundredth.
_COMPARED_BACKLASH, _COMPARED_LOADED = 16_384, 512


@dataclass(frozen=True)
class ToleranceRecord:
    """All that a study found.

    ``backlash`` of many reducers; ``loaded``, all quantities of fewer, None where none were asked for; ``drawn``, each
    quantity of the drawing; ``compared``, the same reducers ground without and with deformation compensation, empty
    without one.
    """

    spec: Spec
    built: Built
    tolerances: Tolerances
    limits: Mapping[str, float]
    backlash: StudySummary
    loaded: StudySummary | None
    drawn: Mapping[str, float]
    compared: tuple[Comparison, ...]

    @property
    def summaries(self) -> tuple[StudySummary, ...]:
        """Both studies, where there are two."""
        return (self.backlash,) if self.loaded is None else (self.backlash, self.loaded)


def tolerance_record(spec: Spec, folder: Path, workers: Workers, tell: Tell = lambda _: None) -> ToleranceRecord:
    """Run the study of a spec; its samples are kept in ``folder``, and found again after a break.

    Raises
    ------
    SpecError, GeometryError, LoadError
        If the drive or a tolerance cannot be.
    ToleranceError
        If the folder cannot be written to, or the workers cannot compute.
    """
    tell("building the reducer")
    built = built_reducer(spec)
    tolerances, limits = tolerances_in(spec, built), limits_in(spec)
    many = backlash_study(spec, built, tolerances)
    backlash = summarise(run(many, folder / "backlash", workers, _titled(tell, "backlash")), limits)
    loaded, fewer = None, None
    if spec.tolerance.loaded_samples:
        fewer = loaded_study(spec, built, tolerances)
        loaded = summarise(run(fewer, folder / "loaded", workers, _titled(tell, "under load")), limits)
    study = many if fewer is None else fewer
    nothing = np.zeros((1, len(study.changes)))
    drawn = dict(zip(study.measures.names, study.measures.of(nothing)[0].tolist(), strict=True))
    return ToleranceRecord(spec, built, tolerances, limits, backlash, loaded, drawn, _compared(spec, many, fewer, tell))


def _compared(spec: Spec, many: Study, fewer: Study | None, tell: Tell) -> tuple[Comparison, ...]:
    plain = without_compensation(spec)
    if plain is None:
        return ()
    tell("the same reducers without deformation compensation")
    found = list(compare_designs(beside(many, plain), many, _first(many, _COMPARED_BACKLASH)))
    if fewer is not None:
        loaded = compare_designs(beside(fewer, plain), fewer, _first(fewer, _COMPARED_LOADED))
        found += [one for one in loaded if one.quantity != "backlash_arcmin"]
    return tuple(found)


def _first(study: Study, reducers: int) -> range:
    """Chunks that hold the first reducers of a study."""
    return range(min(study.chunks, -(-reducers // study.chunk)))


def _titled(tell: Tell, title: str) -> Tell:
    return lambda text: tell(f"{title}: {text}")
