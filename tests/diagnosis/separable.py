"""Sizes drawn for a given separation of a hidden effect from the nearest alternative explanation.

λ² is the noncentrality of an effect in the files, nuisances marginalised. φ is the angle between its pattern and the
span of nuisances, the other hidden effects and the nearest effect of another name; λ_sep = λ sin φ. φ is linear, λ is
exact: a disc out of contact, or one crank of three, changes less than its derivative predicts. Effects parallel to
0.999 are aliases, not rivals.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis.data.recording import record, use_all_rows
from cycloid_profile.diagnosis.model.candidate import Candidate, candidates, chatter
from cycloid_profile.diagnosis.model.evidence import ALIAS
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.priors import priors_of
from cycloid_profile.diagnosis.model.whitened import NormalEquations, coordinates, normal_equations
from cycloid_profile.measurement import PROFILE_SCAN, parse_measurement
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Hidden, Reducer, spec_text
from tests.diagnosis.blind.cases import measured

_LARGEST = 2.0  # prior widths, that is four manufacturing tolerances
_LARGEST_UM = 5.0
_SEEN = 1e-6
_TRIES, _NEAR = 5, 0.05
_TOO_CLOSE = math.sqrt(1.0 - ALIAS**2)


@dataclass(frozen=True)
class Seen:
    """Visibility of one hidden effect: standard deviations per unit of its coordinate, sine of the angle to the nearest
    rival, aliases.
    """

    candidate: Candidate
    strength: float
    sine: float
    aliases: frozenset[str]

    def size(self, scale: float) -> float:
        """The size at which λ_sep is ``scale``; infinite above four workshop tolerances or 5 µm."""
        if self.strength * self.sine < _SEEN:
            return math.inf
        coordinate = scale / (self.strength * self.sine)
        most = _LARGEST * self.candidate.width
        if self.candidate.size.endswith("_um"):
            most = min(most, _LARGEST_UM)
        if coordinate > most:
            return math.inf
        return 1.0 / coordinate if self.candidate.inverse else coordinate


@dataclass(frozen=True)
class Scaled:
    """For ``draw_case``: hidden effects with λ_sep from ``least`` to ``most``; None if impossible."""

    files: tuple[str, ...]
    least: float
    most: float

    def __call__(
        self, hidden: Sequence[Hidden], settings: Mapping[str, object], draw: np.random.Generator
    ) -> list[Hidden] | None:
        found = []
        for one, shown in zip(hidden, seen(hidden, self.files, settings), strict=True):
            sized = self._sized(one, shown, _model(self.files, settings), draw)
            if sized is None:
                return None
            found.append(sized)
        return found

    def _sized(self, one: Hidden, shown: Seen, model: ExactModel, draw: np.random.Generator) -> Hidden | None:
        """The effect with the size of the wanted λ_sep on the exact model; None if impossible."""
        wanted = aim = float(np.exp(draw.uniform(*np.log([self.least, self.most]))))
        for _ in range(_TRIES):
            size = shown.size(aim)
            if not math.isfinite(size):
                return None
            key = shown.candidate.size
            sized = Hidden(one.name, one.parameters | {key: math.copysign(size, one[key])})
            scale = shown.sine * _changed(model, shown.candidate, sized)
            if not scale > 0.0:
                return None
            if abs(scale / wanted - 1.0) < _NEAR:
                return sized
            aim *= wanted / scale
        return sized if self.least <= scale <= self.most else None


def seen(hidden: Sequence[Hidden], files: Sequence[str], settings: Mapping[str, object]) -> list[Seen]:
    """Visibility of each hidden effect, given the others."""
    model = _model(files, settings)
    scanned = frozenset(r.disc for r in model.recordings if r.kind is PROFILE_SCAN)
    library = list(candidates(model.reducer, scanned, any(r.kind.is_curve for r in model.recordings)))
    own = []
    for one in hidden:
        wave = one.name == "grinding_chatter"
        candidate = chatter(one["waves_per_turn"], one.number("disc"), priors_of(model.reducer)) if wave else None
        if candidate is not None:
            library.append(candidate)
        own.append(_place(library, one) if candidate is None else len(library) - 1)
    equations = normal_equations(model.baseline.blocks, library)
    return [_seen(equations, one, i, [j for j in own if j != i]) for one, i in zip(hidden, own, strict=True)]


def _changed(model: ExactModel, candidate: Candidate, one: Hidden) -> float:
    """λ of a hidden effect on the exact model; 0 without equilibrium."""
    size, turn = one[candidate.size], 0.0
    if candidate.angle is not None:
        turn = candidate.waves * math.radians(one[candidate.angle])
    x = np.array([1.0 / size, 0.0]) if candidate.inverse else size * np.array([math.cos(turn), math.sin(turn)])
    state = model.state([candidate], x / candidate.width, farthest=math.inf)
    if state is None:
        return 0.0
    blocks = zip(model.baseline.blocks, model.baseline.residuals, state.residuals, strict=True)
    changes = (block.white(np.nan_to_num(after.residual - before.residual)) for block, before, after in blocks)
    return math.sqrt(
        sum(block.product(change, change) for block, change in zip(model.baseline.blocks, changes, strict=True))
    )


def _place(library: Sequence[Candidate], one: Hidden) -> int:
    """Index of the hypothesis of the hidden effect; for a disc without a scan, the hypothesis of that disc."""
    fits = [i for i, c in enumerate(library) if c.name == one.name]
    alike = [i for i in fits if all(one.number(k) == v for k, v in library[i].choice.items() if k != "disc")]
    with_disc = [i for i in alike if library[i].choice.get("disc") == one.number("disc")]
    return (with_disc or alike or fits)[0]


def _seen(equations: NormalEquations, one: Hidden, i: int, others: list[int]) -> Seen:
    candidate = equations.candidates[i]
    u = np.array([1.0, 0.0])
    if candidate.angle is not None:
        turn = candidate.waves * math.radians(one[candidate.angle])
        u = np.array([math.cos(turn), math.sin(turn)])
    R, own = equations.R, coordinates([i])
    whole = float(u @ R[np.ix_(own, own)] @ u)
    sine, aliases = 1.0, set()
    for j, rival in enumerate(equations.candidates):
        if whole < _SEEN or rival.name == candidate.name or j in others or R[2 * j, 2 * j] < _SEEN:
            continue
        if _left(R, own, u, [j]) < _TOO_CLOSE**2 * whole:
            aliases.add(rival.name)
            continue
        sine = min(sine, math.sqrt(_left(R, own, u, [j, *others]) / whole))
    return Seen(candidate, math.sqrt(whole) / candidate.width, sine, frozenset(aliases))


def _left(R: np.ndarray, own: Any, u: np.ndarray, others: list[int]) -> float:
    """Residual of a pattern after projection on the span of others."""
    span = coordinates(others)
    cross = u @ R[np.ix_(own, span)]
    inverse = np.linalg.pinv(R[np.ix_(span, span)], rcond=1e-9, hermitian=True)
    return max(float(u @ R[np.ix_(own, own)] @ u - cross @ inverse @ cross), 0.0)


def _model(files: Sequence[str], settings: Mapping[str, object]) -> ExactModel:
    return _drawing(tuple(files), float(settings["output_angle_deg"]) if "loop" in files else 0.0)  # type: ignore[arg-type]


@lru_cache(maxsize=8)
def _drawing(files: tuple[str, ...], output_angle_deg: float) -> ExactModel:
    """Files of the nominal reducer, all rows."""
    reducer = as_built_reducer(parse_spec(spec_text(Reducer())))
    settings = {
        "turn_deg": 2.0, "offset_um": [0.0, 0.0], "output_angle_deg": output_angle_deg, "friction_form": "coulomb",
    }  # fmt: skip
    texts = measured(Reducer(), [], files, settings)
    rows = [record(reducer, parse_measurement(text, name), int(name == "scan2")) for name, text in texts.items()]
    return ExactModel(reducer, [use_all_rows(one) for one in rows])
