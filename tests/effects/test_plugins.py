"""Effects of a user: how they are found, what is refused, and where they take part.

The form of the example is h = A cos 3(θ − φ) with the polar angle θ = −ψ/z_c, so its values are written here again.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cycloid_profile.cli.main import run
from cycloid_profile.contact import LoadCase
from cycloid_profile.diagnosis.model.candidate import candidates
from cycloid_profile.effects import (
    EFFECTS,
    AsBuiltReducer,
    Effect,
    EffectLocation,
    EffectRegistry,
    as_drawn,
    effect_from_table,
    effect_to_table,
    load_plugins,
    plugin_sources,
    register,
    removal_between,
    size_field,
)
from cycloid_profile.effects import registry as registry_module
from cycloid_profile.errors import PluginError, SpecError
from cycloid_profile.measurement import read_measurement
from cycloid_profile.spec import format_spec, parse_spec
from cycloid_profile.tolerance.inputs import tolerances_of
from cycloid_profile.tolerance.study import Draws, Study, chunk_values, portable
from tests.plugins import NAME, THREE_JAW, forget, three_jaw
from tests.spec_texts import PLAIN, RV40E

TABLE = {"name": NAME, "amplitude_um": 2.0, "phase_deg": 20.0, "disc": 1}
USED = f"[[effects]]\nname = '{NAME}'\namplitude_um = 2.0\nphase_deg = 20.0\ndisc = 1\n"
OWN = """
from dataclasses import dataclass, replace
import cycloid_profile as cp

@cp.effects.register
@dataclass(frozen=True)
class OwnSpring(cp.effects.Effect):
    location = cp.effects.EffectLocation.COMPLIANCE
    remedy = "none"
    linear_in_reciprocal = True
    stiffness: float = cp.effects.size_field("stiffness", 1.0, 0.1, 1e6)

    def apply(self, reducer):
        return replace(reducer, series_compliance=1e-9 / self.stiffness)
"""


@pytest.fixture
def plugin() -> Iterator[None]:
    with three_jaw():
        yield


@pytest.fixture(autouse=True)
def _clean() -> Iterator[None]:
    yield
    forget()


def removal(reducer: AsBuiltReducer, case: LoadCase, disc: int, t: np.ndarray) -> np.ndarray:
    """Removal at angles along the disc, at the roots of lobes [mm]."""
    lobe = np.round(t * 39.0 / (2.0 * np.pi))
    return removal_between(case.profile, reducer.teeth[disc], np.zeros_like(lobe), lobe)


@pytest.mark.usefixtures("plugin")
def test_the_example_removes_what_its_formula_says(case: LoadCase) -> None:
    built = effect_from_table(TABLE).apply(as_drawn(case))
    lobe = np.arange(39.0)
    expected = 0.002 * np.cos(3.0 * (-2.0 * np.pi * lobe / 39.0 - np.radians(20.0)))
    np.testing.assert_allclose(removal(built, case, 0, 2.0 * np.pi * lobe / 39.0), expected, atol=1e-12)
    assert built.teeth[1] is case.profile


@pytest.mark.usefixtures("plugin")
def test_derivatives_of_the_example_are_those_of_its_values(case: LoadCase) -> None:
    (removed,) = effect_from_table(TABLE).apply(as_drawn(case)).teeth[0].removals
    psi, step = np.linspace(0.0, 200.0, 31), 1e-4
    low, at, high = (removed.derivatives(psi + d, np.ones_like(psi), case.drive.trochoid) for d in (-step, 0.0, step))
    np.testing.assert_allclose(at.first, (high.value - low.value) / (2.0 * step), atol=1e-10)
    np.testing.assert_allclose(at.second, (high.first - low.first) / (2.0 * step), atol=1e-10)


@pytest.mark.usefixtures("plugin")
def test_without_a_disc_all_have_it_in_the_frame_of_the_carrier(case: LoadCase) -> None:
    built = effect_from_table({key: value for key, value in TABLE.items() if key != "disc"}).apply(as_drawn(case))
    oval = effect_from_table({"name": "disc_oval", "amplitude_um": 2.0, "phase_deg": 20.0}).apply(as_drawn(case))
    for turned, waves in ((built, 3.0), (oval, 2.0)):
        # Both turn by the same angle from disc to disc: that of the built-in effect.
        one, two = (
            np.angle(np.sum(removal(turned, case, j, t) * np.exp(1j * waves * t)))
            for j in (0, 1)
            for t in [2.0 * np.pi * np.arange(39) / 39.0]
        )
        assert np.angle(np.exp(1j * (one - two))) / waves == pytest.approx(2.0 * np.pi / (2 * 39), abs=1e-9)


def test_a_spec_uses_the_name_only_once_it_is_loaded() -> None:
    forget("three_jaw")
    with pytest.raises(SpecError, match=f"'?{NAME}\"? is not the name of an effect: .*--plugin"):
        parse_spec(RV40E + USED)
    with three_jaw():
        spec = parse_spec(RV40E + USED)
        assert parse_spec(format_spec(spec)) == spec
        assert effect_to_table(effect_from_table(spec.effects[0])) == TABLE
        with pytest.raises(SpecError, match="did you mean amplitude_um"):
            effect_from_table({"name": NAME, "amplitud_um": 1.0})
    with pytest.raises(SpecError, match="--plugin"):
        effect_from_table(TABLE)


@pytest.mark.parametrize("key", ["plugin = 'three_jaw'", "plugins = ['three_jaw.py']", "effects = ['three_jaw']"])
def test_a_spec_cannot_load_a_plugin(key: str) -> None:
    forget("three_jaw")
    with pytest.raises(SpecError):
        parse_spec(f"{key}\n{RV40E}")
    assert "three_jaw" not in sys.modules


def broken(**changes: Any) -> type[Effect]:
    """A class with one thing wrong."""
    body = {
        "__annotations__": {"amount_um": float},
        "__module__": __name__,
        "location": EffectLocation.FLANK,
        "remedy": "",
        "amount_um": size_field("amount [µm]", 1.0, 0.0, 9.0),
        "apply": lambda _, reducer: reducer,
    } | changes
    return type(body.pop("cls", "Broken"), (Effect,), {k: v for k, v in body.items() if v is not None})


def frozen(kind: type) -> type[Effect]:
    return dataclass(frozen=True)(kind)


REFUSED = {
    "is no effect": lambda: int,
    "is no frozen dataclass": lambda: broken(),
    "has no name of small letters": lambda: frozen(broken(cls="_Hidden")),
    "has no location": lambda: frozen(broken(location=None)),
    "has no remedy": lambda: frozen(broken(remedy=None)),
    "has no method 'apply'": lambda: frozen(broken(apply=None)),
    "has a plain field": lambda: frozen(broken(amount_um=1.0)),
    "has 0 sizes": lambda: frozen(broken(amount_um=None, __annotations__={})),
    "has 2 sizes": lambda: frozen(
        broken(more=size_field("more", 1.0, 0.0, 1.0), __annotations__={"amount_um": float, "more": float})
    ),
    "has a size that cannot be zero": lambda: frozen(broken(amount_um=size_field("x", 1.0, 0.1, 1.0))),
    "has a reserved parameter": lambda: frozen(
        broken(amount_um=None, origin=size_field("x", 1.0, 0.0, 1.0), __annotations__={"origin": float})
    ),
    "is the name of cycloid_profile.effects.process.DiscOval": lambda: frozen(broken(cls="DiscOval")),
    "is the name of an empirical effect": lambda: frozen(broken(cls="FormDeviation")),
}


@pytest.mark.parametrize("limit", REFUSED)
def test_an_incomplete_effect_is_refused_in_one_sentence(limit: str) -> None:
    before = set(EFFECTS)
    with pytest.raises(PluginError, match=re.escape(limit)):
        register(REFUSED[limit]())
    assert set(EFFECTS) == before


def test_a_name_is_given_once_and_a_class_defined_again_replaces_itself() -> None:
    first, again = frozen(broken(cls="Mine")), frozen(broken(cls="Mine"))
    assert register(first) is first
    register(again)
    assert EFFECTS["mine"] is again
    with pytest.raises(PluginError, match="is the name of"):
        register(frozen(broken(cls="Mine", __module__="elsewhere")))
    with pytest.raises(PluginError, match="is not one of a plug-in"):
        EFFECTS.remove("disc_oval")
    EFFECTS.remove("mine")
    assert "mine" not in EFFECTS
    assert len(EFFECTS) == len(list(EFFECTS))


@pytest.mark.parametrize(
    ("name", "code", "limit"),
    [
        ("no_such_module_anywhere", None, "cannot be imported (ModuleNotFoundError"),
        ("broken.py", "1/0", "cannot be imported (ZeroDivisionError"),
        ("missing.py", None, "cannot be imported (FileNotFoundError"),
        ("silent.py", "x = 1", "registers no effect"),
        ("json.py", "x = 1", "has the name of another module"),
    ],
)
def test_a_plugin_that_cannot_be_used_is_one_sentence(
    tmp_path: Path, name: str, code: str | None, limit: str, capsys: pytest.CaptureFixture[str]
) -> None:
    if code is not None:
        (tmp_path / name).write_text(code, encoding="utf-8")
    given = str(tmp_path / name) if name.endswith(".py") else name
    with pytest.raises(PluginError, match=re.escape(limit)) as refused:
        load_plugins([given])
    assert "\n" not in str(refused.value)
    (tmp_path / "mine.toml").write_text(RV40E, encoding="utf-8")
    assert run(["simulate", str(tmp_path / "mine.toml"), "--kind", "profile_scan", "--plugin", given]) == 2
    assert limit in capsys.readouterr().err
    forget("silent")


class Entry:
    """An entry point as installed packages have them."""

    value = "somewhere:Thing"

    def __init__(self, answer: Any) -> None:
        self.answer = answer

    def load(self) -> Any:
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


def test_effects_of_installed_packages_are_imported_when_needed(monkeypatch: pytest.MonkeyPatch) -> None:
    mine = frozen(broken(cls="Mine"))
    entries = {"mine": Entry(mine), "other": Entry(mine), "bad": Entry(ImportError("no such thing"))}
    monkeypatch.setattr(registry_module, "installed_effects", lambda: entries)
    fresh = EffectRegistry({"disc_oval": EFFECTS["disc_oval"]})
    assert fresh["disc_oval"] is EFFECTS["disc_oval"]
    assert fresh.of_plugins == ()
    with pytest.warns(UserWarning, match="is left out") as warned:
        assert fresh["mine"] is mine
    # The rest of the package works without them.
    assert sorted(str(one.message).split("'")[1] for one in warned) == ["bad", "other"]
    assert set(fresh) == {"disc_oval", "mine"}


def test_installed_names_come_from_metadata_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    from cycloid_profile.spec.model import effects as names

    monkeypatch.setattr(names, "installed_effects", lambda: {NAME: Entry(AssertionError("imported"))})
    assert parse_spec(RV40E + USED).effects[0]["name"] == NAME


INSTALLED = """
import sys
from cycloid_profile.spec import parse_spec
spec = parse_spec(sys.argv[1])
assert "workshop" not in sys.modules, "reading a spec imported it"
from cycloid_profile.design import as_built_reducer
assert as_built_reducer(spec).series_compliance > 0.0
assert "workshop" in sys.modules
"""


def test_an_installed_package_needs_no_option(tmp_path: Path) -> None:
    (tmp_path / "workshop.py").write_text(OWN, encoding="utf-8")
    info = tmp_path / "workshop-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: workshop\nVersion: 1.0\n", encoding="utf-8")
    entry = "[cycloid_profile.effects]\nown_spring = workshop:OwnSpring\n"
    (info / "entry_points.txt").write_text(entry, encoding="utf-8")
    paths = os.pathsep.join([str(tmp_path), str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH", "")])
    used = RV40E + "[[effects]]\nname = 'own_spring'\nstiffness = 2.0\n"
    subprocess.run([sys.executable, "-c", INSTALLED, used], check=True, env={**os.environ, "PYTHONPATH": paths})


@pytest.mark.usefixtures("plugin")
def test_the_diagnosis_has_it_in_its_library(case: LoadCase) -> None:
    own = [one for one in candidates(as_drawn(case), frozenset({0}), True) if one.name == NAME]
    assert [one.choice for one in own] == [{"disc": None}, {"disc": 1}, {"disc": 2}]
    assert all(one.angle == "phase_deg" and one.waves == 3 for one in own)


def small_study(table: dict[str, Any]) -> Study:
    from cycloid_profile.design import as_built_reducer

    reducer = as_built_reducer(parse_spec(PLAIN + "[load]\ndisc_body = 'rigid'\n"))
    return Study(reducer, Draws(tolerances_of([table], [], reducer)), ("backlash_arcmin",), 64, chunk=32)


SCATTER = {"name": NAME, "each": "disc", "amplitude_um": {"plus_minus": 5.0}}


@pytest.mark.usefixtures("plugin")
def test_its_size_scatters_in_a_study() -> None:
    values = small_study(SCATTER).values(0)
    assert np.std(values) > 1e-3
    with pytest.raises(SpecError, match="--plugin"):
        small_study({**SCATTER, "name": "three_jaws"})


@pytest.mark.usefixtures("plugin")
def test_a_process_of_its_own_computes_the_same() -> None:
    study = small_study(SCATTER)
    assert plugin_sources() == (str(THREE_JAW.resolve()),)
    # Spawned: it starts without the plug-in, as the worker of a cluster does.
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        number, values = pool.submit(chunk_values, portable(study), 1).result(timeout=300)
    assert number == 1
    np.testing.assert_array_equal(values, study.values(1))


@pytest.mark.usefixtures("plugin")
def test_an_effect_of_a_script_cannot_go_to_a_worker() -> None:
    register(frozen(broken(cls="Mine", __module__="__main__")))
    with pytest.raises(PluginError, match="workers cannot import"):
        plugin_sources()
    EFFECTS.remove("mine")  # ``forget`` would remove __main__ from the modules


def test_samples_of_other_code_are_not_reused(tmp_path: Path) -> None:
    def fingerprint(code: str) -> str:
        file = tmp_path / "own_spring.py"
        file.write_text(code, encoding="utf-8")
        load_plugins([str(file)])
        found = small_study({"name": "own_spring", "stiffness": {"plus_minus": 0.1, "mean": 1.0}}).fingerprint
        forget()
        return found

    assert fingerprint(OWN) == fingerprint(OWN)
    assert fingerprint(OWN) != fingerprint(OWN.replace("1e-9", "2e-9"))


def test_the_command_line_takes_it_by_its_option(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    forget("three_jaw")
    spec, scan = tmp_path / "mine.toml", tmp_path / "scan.csv"
    spec.write_text(RV40E + USED, encoding="utf-8")
    words = ["simulate", str(spec), "--kind", "profile_scan", "--points", "400", "--out", str(scan)]
    assert run(words) == 2
    assert "needs --plugin" in capsys.readouterr().err
    assert not scan.exists()
    assert run([*words, "--plugin", str(THREE_JAW)]) == 0
    radius = np.hypot(*(read_measurement(scan)[name] for name in ("x_mm", "y_mm")))
    plain = tmp_path / "plain.toml"
    plain.write_text(RV40E, encoding="utf-8")
    assert run(["simulate", str(plain), *words[2:-1], str(tmp_path / "plain.csv")]) == 0
    drawn = np.hypot(*(read_measurement(tmp_path / "plain.csv")[name] for name in ("x_mm", "y_mm")))
    # An amplitude of 2 µm along the normal.
    assert 0.0015 < np.max(np.abs(radius - drawn)) < 0.0025
    forget()


@pytest.mark.usefixtures("plugin")
def test_a_frozen_reducer_is_left_as_it_was(case: LoadCase) -> None:
    reducer = as_drawn(case)
    before = replace(reducer)
    effect_from_table(TABLE).apply(reducer)
    assert reducer.teeth == before.teeth
