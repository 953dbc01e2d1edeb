"""Cases for a blind test: files of one reducer with hidden effects."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .contact import Body, Law, Roark
from .effects import KINDS, OUTSIDE, Kind
from .hidden import Hidden
from .loop import loop
from .noise import Noise
from .reducer import Reducer, spec_text
from .scan import scan
from .stage import Stage
from .turn import lost_motion, transmission_error

# What each file shows: a scan of disc 1 or 2, a loop, transmission error at rated and light torque, lost motion.
FILES = {"scan": "scan", "scan2": "scan", "loop": "loop", "te": "te", "te_light": "te", "lost_motion": "lost_motion"}
NOISE = {"scan": Noise(0.3), "loop": Noise(0.004), "te": Noise(0.15), "lost_motion": Noise(0.004)}
_TRIES = 50
_LIGHT = 0.03  # of the rated torque

# Gives drawn effects other sizes under some settings, or None to have others drawn.
Resize = Callable[[Sequence[Hidden], Mapping[str, object], np.random.Generator], list[Hidden] | None]


@dataclass(frozen=True)
class Case:
    """``files`` by name, without their ending; the ``truth``; ``hidden_settings`` that are no effects.

    ``noise`` by kind of file. ``forms``: class of the case by kind of class, as "noise" or "contact", for the tables
    of the score. ``contact`` and ``body`` of its discs.
    """

    seed: int
    reducer: Reducer
    files: dict[str, str]
    truth: list[Hidden]
    hidden_settings: dict[str, object]
    noise: dict[str, Noise] = field(default_factory=dict)
    forms: dict[str, str] = field(default_factory=dict)
    contact: Law = field(default_factory=Roark)
    body: Body = field(default_factory=Body)

    def silent(self) -> dict[str, str]:
        """The same files without noise."""
        none = {kind: Noise() for kind in FILES.values()}
        datum = str(self.hidden_settings.get("datum", "bore"))
        return measured(
            self.reducer, self.truth, tuple(self.files), self.hidden_settings, none, datum, self.seed, self.contact,
            self.body,
        )  # fmt: skip

    def write(self, folder: Path, truth: bool = False) -> None:
        """Spec and files into a folder; the truth only if wanted."""
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "spec.toml").write_text(spec_text(self.reducer), encoding="utf-8")
        for name, content in self.files.items():
            (folder / f"{name}.csv").write_text(content, encoding="utf-8")
        if truth:
            truth_table = {"seed": self.seed, "effects": [one.table() for one in self.truth], **self.hidden_settings}
            (folder / "truth.json").write_text(json.dumps(truth_table, indent=1), encoding="utf-8")


def draw_case(
    seed: int,
    *,
    files: Sequence[str] = ("scan",),
    effects: int = 1,
    sizes: tuple[float, float] = (1.0, 3.0),
    outside: int = 0,
    names: Sequence[str] = (),
    noise: Mapping[str, Noise] | None = None,
    friction_forms: Sequence[str] = ("coulomb",),
    datum: str = "bore",
    turn_deg: float = 4.0,
    may_bind: bool = False,
    reducer: Reducer | None = None,
    resize: Resize | None = None,
) -> Case:
    """A case that the seed determines.

    ``effects`` of the library and ``outside`` of it, all of distinct names, among those that at least one of the
    files shows; ``sizes`` in multiples of the typical one, drawn evenly on a logarithmic scale. ``names`` narrows
    the choice. A scan is turned by up to ``turn_deg`` to either side (half a lobe of 39 is 4.6°: beyond it the
    number of a lobe is lost), and shifted by up to 20 µm if its datum is free. ``noise`` by kind of file, in its unit.
    A reducer that would bind is not put on a bench, and drawn again, unless it ``may_bind``. ``resize`` gives what was
    drawn other sizes.

    Raises
    ------
    ValueError
        If the files do not show so many effects, or ``resize`` likes none.
    """
    r = reducer or Reducer()
    draw = np.random.default_rng([seed, 1])
    kinds = {FILES[name] for name in files}
    other = np.random.default_rng([seed, 2])
    settings: dict[str, object] = {
        "turn_deg": float(other.uniform(-turn_deg, turn_deg)),
        "offset_um": [float(v) for v in other.uniform(-20.0, 20.0, 2)] if datum == "free" else [0.0, 0.0],
        "output_angle_deg": round(float(other.uniform(0.0, 360.0)), 3),
        "friction_form": str(other.choice(list(friction_forms))),
    }
    truth = None
    for _ in range(_TRIES):
        drawn = [
            one
            for pool, count in ((KINDS, effects), (OUTSIDE, outside))
            for one in _drawn(r, pool, count, kinds, files, sizes, names, draw)
        ]
        sized = drawn if resize is None else resize(drawn, settings, draw)
        if sized is None:
            continue
        truth = sized
        if may_bind or not kinds - {"scan"} or not Stage(r, tuple(truth)).binds():
            break
    if truth is None:
        raise ValueError(f"none of {_TRIES} draws has the sizes wanted")
    written = measured(r, truth, files, settings, noise, datum, seed)
    return Case(seed, r, written, truth, settings, {**NOISE, **(noise or {})})


def measured(
    reducer: Reducer,
    effects: Sequence[Hidden],
    files: Sequence[str],
    settings: Mapping[str, object],
    noise: Mapping[str, Noise] | None = None,
    datum: str = "bore",
    seed: int = 0,
    contact: Law | None = None,
    body: Body | None = None,
) -> dict[str, str]:
    """The files of one reducer, clearances found once for all of them.

    ``settings`` may hold ``missing_lobes``, ``anticlockwise`` and, by name of the file, ``rows``.
    """
    stage = Stage(reducer, tuple(effects), contact or Roark(), body or Body())
    heard = {**NOISE, **(noise or {})}
    rows: Mapping[str, int] = dict(settings.get("rows", {}))  # type: ignore[call-overload]
    written = {}
    for name in files:
        kind, rated = FILES[name], reducer.rated_torque_nm
        length = {"points" if kind == "scan" else "rows": rows[name]} if name in rows else {}
        drawn = seed * len(FILES) + list(FILES).index(name)
        if kind == "scan":
            turn, offset = float(settings["turn_deg"]), tuple(settings["offset_um"])
            disc = 2 if name == "scan2" else 1
            written[name] = scan(
                reducer,
                effects,
                disc=disc,
                noise=heard[kind],
                turn_deg=turn,
                offset_um=offset,
                datum=datum,
                missing_lobes=tuple(settings.get("missing_lobes", ())),  # type: ignore[call-overload]
                anticlockwise=bool(settings.get("anticlockwise", False)),
                seed=drawn,
                **length,
            )
        elif kind == "loop":
            written[name] = loop(
                reducer,
                effects,
                output_angle_deg=float(settings["output_angle_deg"]),
                friction_form=str(settings["friction_form"]),
                noise=heard[kind],
                seed=drawn,
                stage=stage,
                **length,
            )
        else:
            bench = transmission_error if kind == "te" else lost_motion
            torque = rated if name == "te" else _LIGHT * rated
            written[name] = bench(
                reducer, effects, torque_nm=torque, noise=heard[kind], seed=drawn, stage=stage, **length
            )
    return written


def _drawn(
    reducer: Reducer,
    pool: Mapping[str, Kind],
    count: int,
    kinds: set[str],
    files: Sequence[str],
    sizes: tuple[float, float],
    names: Sequence[str],
    draw: np.random.Generator,
) -> list[Hidden]:
    """Effects of distinct names that the files show."""
    seen = [
        name
        for name, kind in pool.items()
        if kind.shows & kinds and (not names or name in names) and (reducer.cranks or not kind.of_cranks)
    ]
    if count > len(seen):
        raise ValueError(f"{count} effects wanted, but these files show only {', '.join(seen) or 'none'}")
    found = []
    for name in draw.choice(seen, size=count, replace=False) if count else []:
        multiple = float(np.exp(draw.uniform(*np.log(sizes))))
        found.append(pool[name].draw(str(name), reducer, multiple, _discs(pool[name], reducer, kinds, files), draw))
    return found


def _discs(kind: Kind, reducer: Reducer, kinds: set[str], files: Sequence[str]) -> tuple[int, ...]:
    """Discs on which the effect alone would still be seen."""
    if kind.shows & (kinds - {"scan"}):
        return tuple(range(1, reducer.discs + 1))
    return tuple(disc for disc, name in ((1, "scan"), (2, "scan2")) if name in files)
