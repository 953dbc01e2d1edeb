"""docs/rig.md: its effects are those of the registry, its signatures what the rig shows, its examples files and specs.

``python tests/test_rig_page.py`` prints the two tables that the page takes from here.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np
import pytest

from cycloid_profile.contact.case import LoadCase
from cycloid_profile.design.ground import built_reducer
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.effect import Effect, Parameter, parameters
from cycloid_profile.effects.registry import EFFECTS, build, effect
from cycloid_profile.measurement.files import COLUMNS, FORMAT, Measurement, parse_measurement
from cycloid_profile.rig.evaluation import evaluate_loop
from cycloid_profile.rig.gap import gap
from cycloid_profile.rig.hysteresis import hysteresis_loop
from cycloid_profile.rig.maps import LOST_MOTION_SHARE
from cycloid_profile.rig.scan import profile_scan
from cycloid_profile.rig.transmission import POSES, carrier_rotation, spectrum
from cycloid_profile.spec.read import read_spec
from cycloid_profile.units import ARCMIN, ARCSEC, NEWTON_METRE

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "rig.md"
DRAWN = "as drawn"
# What an effect of one part shows beside that of all parts.
SINGLE: dict[str, tuple[dict[str, int], ...]] = {
    "disc_runout": ({"disc": 1},),
    "disc_oval": ({"disc": 1},),
    "cumulative_pitch_error": ({"disc": 1},),
    "crank_eccentricity_error": ({"crank": 1}, {"crank": 1, "disc": 1}),
    "crank_phase_error": ({"crank": 1},),
}


def parameter_table() -> str:
    """Size, unit, bounds and workshop tolerance of every effect, and its angles and parts, from the registry."""
    head = ("effect", "acts on", "size", "what it is", "unit", "bounds", "workshop tolerance", "angles, 0 if absent")
    rows = [row for name, kind in EFFECTS.items() for row in _sizes_of(name, kind)]
    return _table((*head, "parts (if absent)"), rows)


def _sizes_of(name: str, kind: type[Effect]) -> Iterator[tuple[str, ...]]:
    known = parameters(kind)
    sizes = [p for p in known if p.tolerance is not None]
    parts = [p for p in known if p.whole]
    angles = [p for p in known if p not in sizes and p not in parts]
    around = (
        ", ".join(f"`{p.name}`" for p in angles),
        ", ".join(f"`{p.name}` ({_default(kind, p)})" for p in parts),
    )
    title = (f"`{name}`", kind.place.value)
    for p in sizes:
        found = re.fullmatch(r"(.*?)(?: \[(.+)\])?", p.text)
        assert found is not None
        bounds = f"{p.low:g} to {p.high:g}".replace("-", "−")
        yield (*title, f"`{p.name}`", found[1], found[2] or "–", bounds, f"{p.tolerance:g}", *around)
        title, around = ("", ""), ("", "")


def _default(kind: type[Effect], parameter: Parameter) -> str:
    value = getattr(kind, parameter.name)
    return "all" if value is None else str(value)


def _table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    lines = [head, ("---",) * len(head), *rows]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)


def conventional_case() -> LoadCase:
    """The RV-40E of examples/rv40e.toml without deformation compensation."""
    spec = read_spec(ROOT / "examples" / "rv40e.toml")
    plain = msgspec.structs.replace(spec.modification, deformation_compensation=False)
    return built_reducer(msgspec.structs.replace(spec, modification=plain)).case


def at_tolerance(case: LoadCase, name: str, parts: dict[str, int]) -> Built:
    """The reducer with one effect, its sizes at the workshop tolerance and all else as it is if absent."""
    sizes = {p.name: p.tolerance for p in parameters(EFFECTS[name]) if p.required}
    return build(case, [effect({"name": name} | sizes | parts)])


def signature(built: Built) -> tuple[str, ...]:
    """What the rig shows, as cells of the table."""
    scan = profile_scan(built).points
    seen = Measurement("profile_scan", {"x_mm": scan.real, "y_mm": scan.imag}, {"datum": "bore"})
    T = built.case.torque
    light, back, full = carrier_rotation(built, np.array([LOST_MOTION_SHARE, -LOST_MOTION_SHARE, 1.0]) * T, POSES)
    lost = (light - back) / ARCMIN
    loop = hysteresis_loop(built)
    figures = evaluate_loop(loop.torque, loop.angle)
    return (
        f"{gap(build(built.case, []), seen).rms + 0.0:.2f}" if built.case.profile is not built.teeth[0] else "0",
        *(f"{np.ptp(error) / ARCSEC:.2f} ({int(np.argmax(spectrum(error)[1:])) + 1})" for error in (light, full)),
        f"{np.mean(lost):.3f}",
        f"{np.ptp(lost):.3f}",
        f"{figures.hysteresis_loss / ARCMIN:.3f}",
        f"{figures.torsional_rigidity * ARCMIN / NEWTON_METRE:.1f}",
    )


SIGNATURE_HEAD = (
    "effect",
    "scan, rms [µm]",
    "TE at 3 % [″] (order)",
    "TE at 100 % [″] (order)",
    "lost motion [′]",
    "its p-p [′]",
    "hysteresis loss [′]",
    "rigidity [N·m/′]",
)


def drawn_row(case: LoadCase) -> tuple[str, ...]:
    """The row of the drawing."""
    return (DRAWN, *signature(build(case, [])))


def effect_rows(case: LoadCase, name: str) -> Iterator[tuple[str, ...]]:
    """The rows of one effect."""
    for parts in ({}, *SINGLE.get(name, ())):
        title = ", ".join([f"`{name}`", *(f"`{part} = {number}`" for part, number in parts.items())])
        yield (title, *signature(at_tolerance(case, name, parts)))


def between(page: str, what: str) -> str:
    begin, end = (f"<!-- {edge} {what} -->" for edge in ("begin", "end"))
    return page.split(begin)[1].split(end)[0].strip()


def rows_of(table: str) -> dict[str, list[str]]:
    """Cells of the rows by their first cell."""
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()[2:]]
    return {row[0]: row[1:] for row in rows}


@pytest.fixture(scope="module")
def page() -> str:
    return PAGE.read_text(encoding="utf-8")


def test_parameters_are_those_of_the_registry(page: str) -> None:
    assert between(page, "parameters") == parameter_table()


def test_every_effect_has_its_pattern_cause_and_cure(page: str) -> None:
    rows = rows_of(between(page, "patterns"))
    assert list(rows) == [f"`{name}`" for name in EFFECTS]
    assert all(len(row) == 3 and all(row) for row in rows.values())


def test_every_effect_has_its_signature(page: str) -> None:
    titles = list(rows_of(between(page, "signatures")))
    assert titles[0] == DRAWN
    assert [title for title in titles[1:] if title.count("`") == 2] == [f"`{name}`" for name in EFFECTS]


def check_rows(page: str, found: list[tuple[str, ...]]) -> None:
    printed = rows_of(between(page, "signatures"))
    for title, *cells in found:
        for told, cell in zip(printed[title], cells, strict=True):
            value, digits = told.split(" ")[0], len(told.split(" ")[0].partition(".")[2])
            # One unit of the last digit: a sum in another order may round the other way.
            assert float(value) == pytest.approx(float(cell.split(" ")[0]), abs=1.01 * 10.0**-digits), (title, told)
            assert told.split(" ")[1:] == cell.split(" ")[1:], (title, told)


@pytest.fixture(scope="module")
def case() -> LoadCase:
    return conventional_case()


@pytest.mark.slow
@pytest.mark.parametrize("name", EFFECTS)
def test_signatures_are_those_of_the_rig(page: str, case: LoadCase, name: str) -> None:
    check_rows(page, list(effect_rows(case, name)))


@pytest.mark.slow
def test_the_signature_of_the_drawing_is_that_of_the_rig(page: str, case: LoadCase) -> None:
    check_rows(page, [drawn_row(case)])


def test_example_files_are_read(page: str) -> None:
    files = [block for block in re.findall(r"```text\n(.*?)```", page, re.DOTALL) if block.startswith("# format")]
    assert {parse_measurement(file).kind for file in files} == set(COLUMNS)
    assert all(file.startswith(f"# format: {FORMAT}\n") for file in files)


def test_example_effects_are_effects(page: str) -> None:
    tables = [table for block in re.findall(r"```toml\n(.*?)```", page, re.DOTALL) for table in _effects_in(block)]
    assert len(tables) > 1
    for table in tables:
        assert effect(table).name in EFFECTS


def test_python_of_the_page_runs(
    page: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    monkeypatch.chdir(ROOT)
    exec(compile(code, "docs/rig.md", "exec"), {})
    # 2·5 µm/36 mm of play on top of the compensated drive's 0.597′, to first order.
    assert float(capsys.readouterr().out.split("′")[0]) == pytest.approx(0.597 + 2 * 0.005 / 36.0 / ARCMIN, abs=0.02)


def _effects_in(block: str) -> list[dict[str, object]]:
    tables: list[dict[str, object]] = tomllib.loads(block)["effects"]
    return tables


if __name__ == "__main__":
    print(parameter_table(), "", sep="\n")
    drawing = conventional_case()
    print(
        _table(SIGNATURE_HEAD, [drawn_row(drawing), *(row for name in EFFECTS for row in effect_rows(drawing, name))])
    )
