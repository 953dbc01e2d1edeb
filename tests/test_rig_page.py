"""docs/effects.md holds the effects of the registry with the readings of the rig; examples of docs/rig.md are valid.

``python tests/test_rig_page.py`` prints two tables of docs/effects.md.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from cycloid_profile.contact import LoadCase
from cycloid_profile.design import as_built_reducer
from cycloid_profile.effects import (
    EFFECTS,
    AsBuiltReducer,
    Effect,
    Parameter,
    apply_effects,
    effect_from_table,
    parameters,
)
from cycloid_profile.measurement import FORMAT, KINDS, PROFILE_SCAN, Measurement, parse_measurement
from cycloid_profile.rig import (
    LOST_MOTION_SHARE,
    evaluate_loop,
    hysteresis_loop,
    measurement_residual,
    profile_scan,
    spectrum,
)
from cycloid_profile.rig.curves_over_turn import TRANSMISSION_POSES, encoder_readings
from cycloid_profile.spec import read_spec
from cycloid_profile.units import ARCMIN, ARCSEC, NEWTON_METRE

ROOT = Path(__file__).parents[1]
RIG_PAGE = ROOT / "docs" / "rig.md"
EFFECTS_PAGE = ROOT / "docs" / "effects.md"
DRAWN = "as drawn"
# Effects that get further rows, for one part only or of another shape.
SINGLE: dict[str, tuple[dict[str, Any], ...]] = {
    "equidistant_error": ({"flank": 1},),
    "wheel_wear_drift": ({"start_in_lobe": 0.5},),
    "grinding_chatter": ({"constant_speed": "c_axis"}, {"constant_speed": "surface"}),
    "flank_wear": ({"by": "lever"}, {"exponent": 2.0}),
    "disc_runout": ({"disc": 1},),
    "disc_oval": ({"disc": 1},),
    "cumulative_pitch_error": ({"disc": 1},),
    "crank_eccentricity_error": ({"crank": 1}, {"crank": 1, "disc": 1}),
    "crank_phase_error": ({"crank": 1},),
    "tooth_form_error": ({"flank": 1},),
    "ring_mounting_ovality": ({"waves": 3},),
    "common_planet_runout": ({"form": 2},),
}


def parameter_table() -> str:
    """Size, unit, bounds and manufacturing tolerance of every effect, and its angles and parts, from the registry."""
    head = ("effect", "acts on", "size", "meaning", "unit", "bounds", "manufacturing tolerance")
    rows = [row for name, kind in EFFECTS.items() for row in _sizes_of(name, kind)]
    return _table((*head, "angles, 0 if absent", "parts and shapes (if absent)"), rows)


def _sizes_of(name: str, kind: type[Effect]) -> Iterator[tuple[str, ...]]:
    known = parameters(kind)
    sizes = [p for p in known if p.tolerance is not None]
    choices = [p for p in known if p not in sizes and not p.is_angle]
    around = (
        ", ".join(f"`{p.name}`" for p in known if p.is_angle),
        ", ".join(f"`{p.name}` ({_default(kind, p)})" for p in choices),
    )
    title = (f"`{name}`", kind.location.value)
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
    return as_built_reducer(msgspec.structs.replace(spec, modification=plain)).case


def at_tolerance(case: LoadCase, name: str, parts: dict[str, Any]) -> AsBuiltReducer:
    """The reducer with one effect, its sizes at the manufacturing tolerance, other parameters at their defaults."""
    sizes = {p.name: p.tolerance for p in parameters(EFFECTS[name]) if p.required}
    return apply_effects(case, [effect_from_table({"name": name} | sizes | parts)])


def signature(reducer: AsBuiltReducer) -> tuple[str, ...]:
    """Readings of the rig, as cells of the table."""
    scan = profile_scan(reducer)
    seen = Measurement(PROFILE_SCAN, {"x_mm": scan.real, "y_mm": scan.imag}, {"datum": "bore"})
    T = reducer.case.torque
    light, back, full = encoder_readings(
        reducer, np.array([LOST_MOTION_SHARE, -LOST_MOTION_SHARE, 1.0]) * T, TRANSMISSION_POSES
    )
    lost = (light - back) / ARCMIN
    loop = hysteresis_loop(reducer)
    figures = evaluate_loop(loop.torque, loop.angle)
    return (
        f"{measurement_residual(apply_effects(reducer.case, []), seen).rms + 0.0:.2f}"
        if reducer.case.profile is not reducer.teeth[0]
        else "0",
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
    return (DRAWN, *signature(apply_effects(case, [])))


def effect_rows(case: LoadCase, name: str) -> Iterator[tuple[str, ...]]:
    """The rows of one effect."""
    for parts in ({}, *SINGLE.get(name, ())):
        title = ", ".join([f"`{name}`", *(f"`{part} = {number!r}`" for part, number in parts.items())])
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
    return EFFECTS_PAGE.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def rig_page() -> str:
    return RIG_PAGE.read_text(encoding="utf-8")


def test_parameters_are_those_of_the_registry(page: str) -> None:
    assert between(page, "parameters") == parameter_table()


def test_every_effect_has_its_pattern_cause_and_remedy(page: str) -> None:
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
        for shown, cell in zip(printed[title], cells, strict=True):
            value, digits = shown.split(" ")[0], len(shown.split(" ")[0].partition(".")[2])
            # One unit of the last digit: a sum in another order may round the other way.
            assert float(value) == pytest.approx(float(cell.split(" ")[0]), abs=1.01 * 10.0**-digits), (title, shown)
            assert shown.split(" ")[1:] == cell.split(" ")[1:], (title, shown)


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


def test_example_files_are_read(rig_page: str) -> None:
    files = [block for block in re.findall(r"```text\n(.*?)```", rig_page, re.DOTALL) if block.startswith("# format")]
    assert {parse_measurement(file).kind.name for file in files} == set(KINDS)
    assert all(file.startswith(f"# format: {FORMAT}\n") for file in files)


def test_example_effects_are_effects(page: str) -> None:
    tables = [table for block in re.findall(r"```toml\n(.*?)```", page, re.DOTALL) for table in _effects_in(block)]
    assert len(tables) > 1
    for table in tables:
        assert effect_from_table(table).name in EFFECTS


def test_python_of_the_page_runs(
    rig_page: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", rig_page, re.DOTALL)
    monkeypatch.chdir(ROOT)
    exec(compile(code, "docs/rig.md", "exec"), {})
    # 2·5 µm/36 mm of play on top of the compensated drive's 0.327′, to first order.
    assert float(capsys.readouterr().out.split("′")[0]) == pytest.approx(0.327 + 2 * 0.005 / 36.0 / ARCMIN, abs=0.02)


def _effects_in(block: str) -> list[dict[str, object]]:
    tables: list[dict[str, object]] = tomllib.loads(block).get("effects", [])
    return tables


if __name__ == "__main__":
    print(parameter_table(), "", sep="\n")
    drawing = conventional_case()
    print(
        _table(SIGNATURE_HEAD, [drawn_row(drawing), *(row for name in EFFECTS for row in effect_rows(drawing, name))])
    )
