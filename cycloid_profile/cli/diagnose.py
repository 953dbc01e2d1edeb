"""``cycloid-profile diagnose``: where measured files and simulation disagree, and which effect is missing."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from cycloid_profile.cli.options import OutFolder
from cycloid_profile.cli.terminal import output_folder, print_json, print_table, progress
from cycloid_profile.units import SIGNS

if TYPE_CHECKING:
    from cycloid_profile.effects.built import Built

_VERDICTS = {
    "agrees": "measurement and simulation agree",
    "effects_found": "the missing effect has been found",
    "unknown_effect": "something differs that is in no library of effects",
}


def diagnose(
    spec: Path,
    /,
    *data: Path,
    out: OutFolder = None,
    json: Annotated[
        Path | None,
        Parameter(
            allow_leading_hyphen=True, help="File for the result as one JSON object; - prints it instead of the tables."
        ),
    ] = None,
    disc: Annotated[int | None, Parameter(help="Disc that was scanned, default as `specimen` says, else 1.")] = None,
    held_out: Annotated[
        tuple[Path, ...], Parameter(help="A measured file only to check with, such as one of a second specimen.")
    ] = (),
    plan: Annotated[
        bool, Parameter(negative=(), help="Print what each measurement could tell, before any is made.")
    ] = False,
) -> int:
    """Find where measured files and simulation disagree, name the missing effect and show the gap shrink.

    Example: cycloid-profile diagnose examples/rv40e.toml scan.csv te_rated.csv loop.csv

    Parameters
    ----------
    spec
        Spec file (TOML); it is left as it is.
    data
        Measured files (CSV), explained together.
    """
    from cycloid_profile.design.ground import built_reducer
    from cycloid_profile.errors import MeasurementError
    from cycloid_profile.measurement.files import read_measurement
    from cycloid_profile.spec.read import read_spec

    wanted = read_spec(spec)
    if plan:
        return _plan(wanted.name, built_reducer(wanted), output_folder(out, spec) / "diagnosis")
    if not data:
        raise MeasurementError("measured files", "none", "were given", "name at least one CSV file after the spec", " ")
    from cycloid_profile.discrepancy.diagnosis import diagnose as found_in
    from cycloid_profile.discrepancy.told import told
    from cycloid_profile.report.diagnosis_package import write_diagnosis

    folder = output_folder(out, spec) / "diagnosis" if out is None else out
    with progress() as tell:
        measured = [read_measurement(file) for file in data]
        checks = [read_measurement(file) for file in held_out]
        tell("building the reducer")
        built = built_reducer(wanted)
        discs = None if disc is None else [disc - 1] * len(measured)
        result = found_in(built, measured, discs, checks, tell)
        files = {file.name: file.read_bytes() for file in data}
        written = write_diagnosis(result, wanted.name, spec, files, folder, tell)
    values = told(result, wanted.name)
    if json is not None and str(json) != "-":
        _write_json(json, values)
    if json is not None and str(json) == "-":
        print_json(values)
        return 0
    _print(values, result.verdict)
    print(f"\nreport: {written.report}")
    if written.spec is not None:
        print(f"spec with the effects: {written.spec}")
    return 0


def _write_json(path: Path, values: dict[str, object]) -> None:
    import json

    from cycloid_profile.export.folder import whole_or_nothing

    text = json.dumps(values, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    with whole_or_nothing(path.parent) as scratch:
        (scratch / path.name).write_text(text, encoding="utf-8", newline="\n")


def _print(values: dict[str, object], verdict: str) -> None:
    from cycloid_profile.discrepancy.told import chance

    print(f"{values['name']}: {_VERDICTS[verdict]}\n")
    effects = values["effects"]
    assert isinstance(effects, list)
    if effects:
        rows = []
        for one in effects:
            sizes = ", ".join(
                f"{key} = {value:.4g}" + (f" ± {one['uncertainty'][key]:.2g}" if key in one["uncertainty"] else "")
                for key, value in one["parameters"].items()
            )
            others = ", ".join([*one["group"][1:], *(["other places"] if one["elsewhere"] else [])]) or "–"
            rows.append((one["name"], sizes, others, one["separate_by"] or "–"))
        print_table("missing effects", ("effect", "parameters", "not told from", "told apart by"), rows)
        print()
    places = values["where"] if verdict != "unknown_effect" else [values["remainder"]]
    assert isinstance(places, list)
    found = [(p["file"], p["coordinate"], _range(p), _size(p), chance(p["p_value"])) for p in places if p is not None]
    if found:
        print_table("where", ("file", "coordinate", "at", "size", "p"), found[:8])
        print()
    near = values["nearest"]
    assert isinstance(near, list)
    if near:
        shares = [(n["name"], f"{100.0 * n['share_explained']:.0f} %", n["why_not"]) for n in near]
        print_table("what comes nearest", ("effect", "explains", "why not"), shares)
        print()
    gaps = values["gap"]
    assert isinstance(gaps, list)
    columns = ("file", "noise", "fitted before", "after", "held out before", "after", "unit")
    keys = ("noise", "fit_before", "fit_after", "held_out_before", "held_out_after")
    table = [(g["file"], *("–" if g[k] is None else f"{g[k]:.4g}" for k in keys), SIGNS[g["unit"]]) for g in gaps]
    print_table("measured minus predicted, rms", columns, table)
    if verdict == "agrees":
        hidden = values["not_seen"]
        assert isinstance(hidden, list)
        print()
        print_table(
            "what would not have been seen: anything smaller than",
            ("effect", "size"),
            [(n["name"], _symbols(n["smallest_detectable"])) for n in hidden],
        )
    notes = values["notes"]
    assert isinstance(notes, list)
    for note in notes:
        print(f"note: {note}")


def _symbols(size: str) -> str:
    number, _, unit = size.rpartition(" ")
    return f"{number} {SIGNS[unit]}" if unit in SIGNS else size


def _range(place: dict[str, object]) -> str:
    start, end = place["from"], place["to"]
    return f"{start:.4g}" if start == end else f"{start:.4g} to {end:.4g}"


def _size(place: dict[str, object]) -> str:
    key = next(k for k in place if k.startswith("rms_"))
    return f"{place[key]:.3g} {SIGNS[key[4:]]}"


def _plan(name: str, built: Built, folder: Path) -> int:
    from cycloid_profile.discrepancy.plan import visibility
    from cycloid_profile.discrepancy.told import smallest
    from cycloid_profile.export.folder import whole_or_nothing
    from cycloid_profile.plot.plan import plan_plot
    from cycloid_profile.plot.style import save_png

    with progress() as tell:
        rows = visibility(built, tell)
        with whole_or_nothing(folder) as scratch:
            save_png(plan_plot(rows, name), scratch / "plan.png")
    names = list(dict.fromkeys(row.measurements for row in rows))
    effects = list(dict.fromkeys(row.effect for row in rows))
    by = {(row.effect, row.measurements): row for row in rows}
    detectable, identifiable = [], []
    for effect in effects:
        cells = [by[effect, n] for n in names]
        seen = ["–" if c.detectable == float("inf") else smallest(c.detectable, c.size, symbols=True) for c in cells]
        told = [
            "–"
            if c.detectable == float("inf")
            else f"as {c.rival}"
            if c.identifiable == float("inf")
            else smallest(c.identifiable, c.size, symbols=True)
            for c in cells
        ]
        detectable.append((effect, *seen))
        identifiable.append((effect, *told))
    columns = ("effect", *names)
    print_table(f"{name}: smallest size that would be detected, 80 % of the time", columns, detectable)
    print()
    print_table("smallest size that could also be named, or what it looks like", columns, identifiable)
    print(f"\npicture: {folder / 'plan.png'}")
    return 0
