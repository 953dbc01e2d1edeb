"""How well the generator's own files separate a hidden effect from every other: nothing of the package is asked.

λ is the length of what an effect changes in noiseless files, whitened by their true noise, with rotation, datum, zero
and drift projected out. φ is the angle between its derivative and the span of the other hidden effects and the nearest
effect of another name; λ_sep = λ sin φ. Derivatives are finite differences. Effects parallel to 0.999 are aliases, not
rivals.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from tests.diagnosis.blind import KINDS, Body, Case, Hidden, Law, Noise, PowerLaw, Reducer, ReferenceDepth, Roark
from tests.diagnosis.blind.cases import FILES, NOISE, measured
from tests.diagnosis.blind.contact import at_rated
from tests.diagnosis.blind.effects import ONE_DISC, Kind

Array = np.ndarray
ALIAS = 0.999
_TOO_CLOSE = math.sqrt(1.0 - ALIAS**2)
_STEP = 0.1  # of the typical size, for a finite difference
_LARGEST, _LARGEST_UM = 4.0, 5.0  # typical sizes; a larger effect is a scrapped part
_SEEN = 1e-3  # standard deviations of the typical size
_TRIES, _NEAR = 6, 0.05
# Rows that are simulated instead of all of them, and every how many-th pin or lobe is tried as a rival on a bench.
_ROWS = {"scan": 5000, "loop": 61, "te": 101, "lost_motion": 61}
_FULL = {"scan": 5000, "loop": 251, "te": 3000, "lost_motion": 600}
_EVERY = 5
# A bore is found to 0.1 µm [mm]; what is free is wider than any reading, in its unit.
_BORE, _FREE = 1e-4, 1e3
_DRIFTS = 2.0  # standard deviations of the noise: the largest that ``draw_wide`` draws
_NEAR_ZERO = 0.05  # of the largest torque: either flank may touch, and one such row of sixty would decide
_DISTINGUISHED = 3.0  # standard deviations between two explanations
_WAVES = {"disc_oval": 2, "pin_ring_oval": 2}


@dataclass(frozen=True)
class View:
    """Files of a reducer under stated conditions, with their ``noise`` by kind of file and ``rows`` by file.

    ``may_be``: other contact laws and bodies that the reducer may have for all that a diagnosis knows. Rows of a loop
    below the ``least_torque``, a share of the largest, are not compared: inside the backlash the angle is undefined.
    """

    files: tuple[str, ...]
    reducer: Reducer = field(default_factory=Reducer)
    output_angle_deg: float = 0.0
    datum: str = "bore"
    noise: tuple[tuple[str, Noise], ...] = tuple(NOISE.items())
    rows: tuple[tuple[str, int], ...] = ()
    contact: Law = field(default_factory=Roark)
    body: Body = field(default_factory=Body)
    may_be: tuple[tuple[Law, Body], ...] = ()
    least_torque: float = 0.0

    @property
    def kinds(self) -> set[str]:
        """Kinds of the files."""
        return {FILES[name] for name in self.files}

    def columns(self, effects: Sequence[Hidden]) -> dict[str, Array]:
        """Readings without noise: complex points of a scan, else the column that is measured."""
        settings = {
            "turn_deg": 0.0,
            "offset_um": [0.0, 0.0],
            "output_angle_deg": self.output_angle_deg,
            "friction_form": "coulomb",
            "rows": {name: _ROWS[FILES[name]] for name in self.files},
        }
        silent = {kind: Noise() for kind in FILES.values()}
        texts = measured(
            self.reducer, effects, self.files, settings, silent, self.datum, contact=self.contact, body=self.body
        )
        found = {}
        for name, text in texts.items():
            rows = [line for line in text.splitlines() if line[:1] in set("-0123456789")]
            table = np.loadtxt(rows, delimiter=",")
            if FILES[name] == "loop":
                torque = np.abs(table[:, 0])
                table = table[torque >= self.least_torque * np.max(torque)]
            found[name] = table[:, 0] + 1j * table[:, 1] if FILES[name] == "scan" else table[:, 1]
        return found

    def change(self, effects: Sequence[Hidden]) -> Array:
        """What the effects change in all files, whitened, nuisances projected out: its length is λ."""
        before, after = _drawing(self), self.columns(effects)
        return np.concatenate([self._whitened(name, before[name], after[name]) for name in self.files])

    def _whitened(self, name: str, before: Array, after: Array) -> Array:
        kind = FILES[name]
        noise = dict(self.noise)[kind]
        unit = 1e-3 if kind == "scan" else 1.0
        # Rounding adds the variance of an even distribution; of rows left out, those simulated stand for several.
        sigma = unit * noise.sigma * math.sqrt(1.0 + noise.quantum**2 / 12.0)
        sigma *= math.sqrt(_ROWS[kind] / dict(self.rows).get(name, _FULL[kind]))
        free = [np.ones(before.size)] if kind in {"loop", "te"} else []
        changed, datum = after - before, []
        if kind == "scan":
            # Points slide along the tooth: what is seen is normal to it.
            along = np.roll(before, -1) - np.roll(before, 1)
            normal = 1j * along / np.abs(along)
            changed = (np.conj(normal) * changed).real
            free, datum = [(np.conj(normal) * 1j * before).real], [normal.real, normal.imag]
        known = [_FREE * column for column in free]
        known += [(_FREE if self.datum == "free" else _BORE) * column for column in datum]
        if kind != "scan":
            known += [
                _drawing(replace(self, contact=law, body=body, may_be=()))[name] - before for law, body in self.may_be
            ]
        if noise.drift:
            t = np.linspace(-1.0, 1.0, before.size)
            shapes = (t, np.cos(0.5 * math.pi * t), np.sin(0.5 * math.pi * t))
            wide = noise.drift * noise.sigma * unit
            known += [wide * shape * column for shape in shapes for column in datum or [np.ones(before.size)]]
        white = _uncoloured(changed, noise) / sigma
        if not known:
            return white
        # The root of I − A(I + AᵀA)⁻¹Aᵀ, its columns A scaled by how well each nuisance is known beforehand.
        basis, length, _ = np.linalg.svd(
            np.stack([_uncoloured(column, noise) / sigma for column in known], axis=1), full_matrices=False
        )
        return white - basis @ ((1.0 - 1.0 / np.hypot(1.0, length)) * (basis.T @ white))


def _uncoloured(column: Array, noise: Noise) -> Array:
    """The column filtered so that AR noise of unit variance becomes white of unit variance."""
    if noise.rho == noise.rho2 == 0.0:
        return column
    gain = math.sqrt((1.0 + noise.rho2) * ((1.0 - noise.rho2) ** 2 - noise.rho**2) / (1.0 - noise.rho2))
    padded = np.concatenate([column[:1], column[:1], column])
    return (column - noise.rho * padded[1:-1] - noise.rho2 * padded[:-2]) / gain


@lru_cache(maxsize=8)
def _drawing(view: View) -> dict[str, Array]:
    return view.columns([])


def at_size(one: Hidden, coordinate: float) -> Hidden:
    """The effect with the size of a ``coordinate``: the size with its sign, or the compliance of a stiffness."""
    key = KINDS[one.name].key
    size = 1.0 / coordinate if KINDS[one.name].inverse else math.copysign(coordinate, one[key])
    return Hidden(one.name, one.parameters | {key: size})


def derivative(view: View, one: Hidden) -> Array:
    """Change by the typical size, from a small one of the sign of the effect."""
    return _derivative(view, json.dumps(one.table(), sort_keys=True))


@lru_cache(maxsize=4096)
def _derivative(view: View, table: str) -> Array:
    values: dict[str, Any] = json.loads(table)
    one = Hidden(values.pop("name"), values)
    return view.change([at_size(one, _STEP * _typical(KINDS[one.name]))]) / _STEP


def _typical(kind: Kind) -> float:
    return 1.0 / kind.typical if kind.inverse else kind.typical


def rivals(view: View) -> Iterator[tuple[str, list[Hidden]]]:
    """Every effect of the library at its places, with the one or two coordinates of each."""
    curves = bool(view.kinds - {"scan"})
    r = view.reducer
    every = _EVERY if curves else 1
    numbers: dict[str, Sequence[Any]] = {
        "lobe": range(1, r.lobes + 1, every),
        "first_lobe": range(1, r.lobes + 1, every),
        "pin": range(1, r.pins + 1, every),
        "crank": range(1, r.cranks + 1),
        "planet": range(1, r.cranks + 1),
        "form": (1, 2),
        "flank": (1, 2),
    }
    scanned = [disc for disc, name in ((1, "scan"), (2, "scan2")) if name in view.files]
    discs = list(range(1, r.discs + 1)) if curves else scanned
    for name, kind in KINDS.items():
        # Chatter of any number of waves would be a rival of nothing else.
        if name == "grinding_chatter" or (kind.of_cranks and not r.cranks):
            continue
        shown = kind.shows & view.kinds or (name in {"single_tooth_error", "single_pin_error"} and curves)
        if not shown:
            continue
        parts = {part: numbers[part] for part in kind.parts}
        if kind.on_disc:
            parts["disc"] = [None, *discs] if curves and name not in ONE_DISC else discs
        quarter = 90.0 / _WAVES.get(name, 1)
        for chosen in product(*parts.values()):
            values = {kind.key: kind.typical} | dict(zip(parts, chosen, strict=True))
            angles = [{angle: at} for angle in kind.angles for at in (0.0, quarter)] or [{}]
            yield name, [Hidden(name, values | angle) for angle in angles]


@dataclass(frozen=True)
class Seen:
    """Visibility of one hidden effect: λ of the typical size, sine of the angle to the nearest rival, aliases."""

    strength: float
    sine: float
    aliases: frozenset[str]


def seen(hidden: Sequence[Hidden], view: View) -> list[Seen]:
    """Visibility of each hidden effect, given the others."""
    own = [derivative(view, one) if one.name in KINDS else view.change([one]) for one in hidden]
    found = []
    for i, (one, pattern) in enumerate(zip(hidden, own, strict=True)):
        whole = float(np.linalg.norm(pattern))
        others = [own[j] for j in range(len(own)) if j != i]
        sine, aliases = 1.0, set()
        for name, coordinates in rivals(view) if whole > _SEEN else ():
            if name == one.name:
                continue
            span = [derivative(view, rival) for rival in coordinates]
            if _left(pattern, span) < _TOO_CLOSE * whole:
                aliases.add(name)
            elif name not in {other.name for other in hidden}:
                sine = min(sine, _left(pattern, span + others) / whole)
        found.append(Seen(whole, sine, frozenset(aliases)))
    return found


def _left(pattern: Array, span: Sequence[Array]) -> float:
    """Length that a span leaves of a pattern."""
    matrix = np.stack(span, axis=1)
    length = np.linalg.norm(matrix, axis=0)
    matrix = matrix[:, length > _SEEN] / length[length > _SEEN]
    u, values, _ = np.linalg.svd(matrix, full_matrices=False)
    basis = u[:, values > 1e-6]
    return float(np.linalg.norm(pattern - basis @ (basis.T @ pattern)))


@dataclass(frozen=True)
class Scaled:
    """For ``draw_case``: hidden effects with λ_sep from ``least`` to ``most``; None if impossible."""

    files: tuple[str, ...]
    least: float
    most: float

    def __call__(
        self, hidden: Sequence[Hidden], settings: Mapping[str, object], draw: np.random.Generator
    ) -> list[Hidden] | None:
        view = view_of(self.files, settings)
        found = []
        for one, shown in zip(hidden, seen(hidden, view), strict=True):
            sized = self._sized(one, shown, view, draw)
            if sized is None:
                return None
            found.append(sized)
        return found

    def _sized(self, one: Hidden, shown: Seen, view: View, draw: np.random.Generator) -> Hidden | None:
        """The effect with the size of the wanted λ_sep; None if impossible. The linear size is only the first try."""
        wanted = aim = float(np.exp(draw.uniform(*np.log([self.least, self.most]))))
        kind = KINDS[one.name]
        most = _LARGEST * _typical(kind)
        if kind.key.endswith("_um"):
            most = min(most, _LARGEST_UM)
        for _ in range(_TRIES):
            if shown.strength * shown.sine < _SEEN:
                return None
            size = _typical(kind) * aim / (shown.strength * shown.sine)
            if not size < most:
                return None
            sized = at_size(one, size)
            scale = shown.sine * float(np.linalg.norm(view.change([sized])))
            if not scale > 0.0:
                return None
            if abs(scale / wanted - 1.0) < _NEAR:
                return sized
            aim *= wanted / scale
        return sized if self.least <= scale <= self.most else None


def view_of(files: Sequence[str], settings: Mapping[str, object]) -> View:
    """Files of the RV-40E as ``draw_case`` draws them."""
    angle = settings["output_angle_deg"] if "loop" in files else 0.0
    return View(tuple(files), output_angle_deg=float(str(angle)))


def strength(case: Case, one: Hidden) -> float:
    """λ of a hidden effect in the files of a case: below about 4 no test of them finds it four times of five."""
    return float(np.linalg.norm(view_of_case(case).change([one])))


def view_of_case(case: Case) -> View:
    """Files of a case as a diagnosis may know them: of a foreign reducer neither law nor body nor drift is known."""
    plain = view_of(tuple(case.files), case.hidden_settings)
    rows = dict(case.hidden_settings.get("rows", {}))  # type: ignore[call-overload]
    foreign = "contact" in case.forms
    noise = {kind: replace(one, drift=_DRIFTS) if foreign else one for kind, one in case.noise.items()}
    return replace(
        plain,
        reducer=case.reducer,
        datum=str(case.hidden_settings.get("datum", "bore")),
        noise=tuple(noise.items()),
        rows=tuple(rows.items()),
        may_be=_foreign(case.reducer) if foreign else (),
        least_torque=_NEAR_ZERO if foreign else 0.0,
    )


def _foreign(reducer: Reducer) -> tuple[tuple[Law, Body], ...]:
    """Laws and bodies at the ends of what ``draw_wide`` draws."""
    load, approach = at_rated(reducer)
    laws = (PowerLaw(1.25), PowerLaw(1.0, 1.1), ReferenceDepth(3.0), ReferenceDepth(15.0))
    bodies = (Body(0.25 * approach / load, 1.0), Body(0.25 * approach / load, 3.0))
    return (*((law, Body()) for law in laws), *((Roark(), body) for body in bodies))


def inseparable(case: Case, one: Hidden, names: Iterable[str]) -> set[str]:
    """Those of ``names`` that at some place and size change the files as ``one`` does.

    Within three standard deviations; sizes are fitted exactly, from the linear ones.
    """
    view = view_of_case(case)
    pattern = view.change([one])
    found: set[str] = set()
    for name, coordinates in rivals(view):
        if name in names and name not in found and _imitates(view, coordinates, pattern):
            found.add(name)
    return found


def _imitates(view: View, coordinates: Sequence[Hidden], pattern: Array) -> bool:
    kind = KINDS[coordinates[0].name]
    typical = _typical(kind)
    span = np.stack([derivative(view, one) for one in coordinates], axis=1) / typical
    start, *_ = np.linalg.lstsq(span, pattern, rcond=1e-6)

    def left(x: Array) -> Array:
        size = float(np.hypot(*x)) if x.size == 2 else abs(float(x[0]))
        sized = at_size(coordinates[0], max(size, 1e-6 * typical))
        if x.size == 2:
            (angle,) = kind.angles
            degrees = math.degrees(math.atan2(x[1], x[0])) / _WAVES.get(sized.name, 1)
            sized = Hidden(sized.name, sized.parameters | {angle: degrees})
        elif x[0] < 0.0:
            if not kind.signed:
                return pattern
            sized = Hidden(sized.name, sized.parameters | {kind.key: -sized[kind.key]})
        return pattern - view.change([sized])

    bound = _LARGEST * typical
    fit = least_squares(
        left, np.clip(start, -bound, bound), bounds=(-1.01 * bound, 1.01 * bound), x_scale=typical, max_nfev=8
    )
    return float(np.linalg.norm(fit.fun)) < _DISTINGUISHED
