"""From the ``[tolerance]`` table of a spec to studies: what scatters, what passes, designs side by side."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import msgspec

from cycloid_profile.design.ground import built_reducer
from cycloid_profile.effects.built import Built
from cycloid_profile.spec.model import Spec
from cycloid_profile.spec.read import parse_spec
from cycloid_profile.spec.write import format_spec
from cycloid_profile.tolerance.draws import Draws
from cycloid_profile.tolerance.limits import Limit, limits_of
from cycloid_profile.tolerance.quantities import QUANTITIES
from cycloid_profile.tolerance.scatter import Tolerances
from cycloid_profile.tolerance.scatter_tables import tolerances_of
from cycloid_profile.tolerance.sequence import SEQUENCES
from cycloid_profile.tolerance.study import Study
from cycloid_profile.tolerance.workshop import workshop_tolerances

BACKLASH = ("backlash_arcmin",)
_FROM_BELOW = ("least_backlash_arcmin",)


def tolerances_in(spec: Spec, built: Built) -> Tolerances:
    """What scatters, as the spec has it; what a good workshop holds where it says nothing.

    Raises ``SpecError`` for a table that cannot be.
    """
    if not spec.tolerance.effects and not spec.tolerance.correlations:
        return workshop_tolerances(built)
    return tolerances_of(spec.tolerance.effects, spec.tolerance.correlations, built)


def limits_in(spec: Spec) -> tuple[Limit, ...]:
    """Limits of the spec in the order of the quantities: the least backlash from below, all others from above."""
    given = msgspec.structs.asdict(spec.tolerance.limits)
    ends = {name: (value, None) if name in _FROM_BELOW else value for name, value in given.items() if value is not None}
    ordered = {name: ends[name] for name in QUANTITIES if name in ends}
    return limits_of(ordered, tuple(QUANTITIES)) if ordered else ()


def backlash_study(spec: Spec, built: Built, tolerances: Tolerances) -> Study:
    """Backlash of many reducers."""
    return Study(built, _draws(spec, tolerances), BACKLASH, spec.tolerance.samples)


def loaded_study(spec: Spec, built: Built, tolerances: Tolerances, chunk: int = 256) -> Study:
    """All quantities of fewer reducers; the first of them are those of the backlash study's own kind, drawn alike."""
    return Study(built, _draws(spec, tolerances), tuple(QUANTITIES), spec.tolerance.loaded_samples, chunk)


def without_compensation(spec: Spec) -> Built | None:
    """The reducer ground without deformation compensation, None where the spec has none."""
    if spec.modification.deformation_compensation in (False, 0.0):
        return None
    plain = msgspec.structs.replace(spec.modification, deformation_compensation=False)
    return built_reducer(msgspec.structs.replace(spec, modification=plain))


def with_tolerance_values(spec: Spec, changed: Mapping[str, object]) -> Spec:
    """The spec with some values of ``[tolerance]`` replaced, those given as None left as they are.

    Raises ``SpecError`` where a value is out of its limits.
    """
    given = {key: value for key, value in changed.items() if value is not None}
    if not given:
        return spec
    grown = msgspec.structs.replace(spec, tolerance=msgspec.structs.replace(spec.tolerance, **given))
    return parse_spec(format_spec(grown))


def beside(study: Study, built: Built) -> Study:
    """The same reducers, error by error, of another design."""
    return replace(study, built=built)


def _draws(spec: Spec, tolerances: Tolerances) -> Draws:
    t = spec.tolerance
    return Draws(tolerances, t.seed, SEQUENCES[t.sequence], t.batch_size)
