"""Files of a diagnosis in one folder: report, pictures, JSON, and the spec with the effects added; also the plot of a
measurement plan."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from cycloid_profile import plot
from cycloid_profile._display import with_unit
from cycloid_profile.articles import PlainTable
from cycloid_profile.diagnosis import (
    Comparison,
    Detectability,
    Diagnosis,
    NamedEffect,
    comparison_to_json,
    effect_tables,
    empirical_tables,
)
from cycloid_profile.diagnosis import diagnosis_to_json as diagnosis_json
from cycloid_profile.effects import EFFECTS, parameters
from cycloid_profile.errors import CycloidError
from cycloid_profile.export.writing import PROTECTED, Protection, atomic_folder
from cycloid_profile.plot import save, save_png
from cycloid_profile.plot.diagnosis import change_pictures
from cycloid_profile.plot.diagnosis import pictures as pictures_of
from cycloid_profile.report.diagnosis import text
from cycloid_profile.report.diagnosis.tables import change_tables, gap_table, nearest_table
from cycloid_profile.report.page import PLOTS, REPORT, json_text, pdf_name, picture, render, write_report, write_text
from cycloid_profile.spec import format_spec, parse_spec, validated
from cycloid_profile.spec.model import EmpiricalSpec
from cycloid_profile.units import sign_of


class WrittenDiagnosis(NamedTuple):
    """Paths of the report and, if effects were found, of the new spec file; ``values``: content of the JSON file."""

    report: Path
    spec: Path | None
    values: dict[str, Any]


def write_diagnosis(
    diagnosis: Diagnosis,
    name: str,
    spec: Path,
    files: Mapping[str, bytes],
    folder: Path,
    progress: Callable[[str], None] = lambda _: None,
    changes: Comparison | None = None,
    protection: Protection = PROTECTED,
    pdf: bool = False,
) -> WrittenDiagnosis:
    """Write report, plots and JSON into ``folder``, and SPEC_diagnosed.toml where effects were found.

    ``files``: name and content of each measured file. ``changes`` against an earlier diagnosis go into the report;
    ``pdf``: write it as PDF, too. The spec file itself is not changed.
    """
    new_spec = f"{spec.stem}_diagnosed.toml" if diagnosis.effects or diagnosis.empirical else None
    with atomic_folder(folder, protection) as scratch:
        plots = scratch / PLOTS
        plots.mkdir()
        drawn = []
        every = [*pictures_of(diagnosis, name), *([] if changes is None else change_pictures(changes, name))]
        for number, (stem, caption, figure) in enumerate(every, 1):
            progress(f"drawing picture {number} of {len(every)}")
            save(figure, plots, stem)
            drawn.append((stem, caption))
        values = diagnosis_json(diagnosis, name)
        if changes is not None:
            values["against"] = comparison_to_json(changes)
        write_text(scratch / "diagnosis.json", json_text(values))
        if new_spec is not None:
            text = spec.read_text(encoding="utf-8-sig")
            grown = spec_with_effects(text, effect_tables(diagnosis, files), empirical_tables(diagnosis, files))
            write_text(scratch / new_spec, grown)
        page = diagnosis_report(diagnosis, name, scratch, drawn, new_spec, changes, pdf)
        write_report(scratch, REPORT, page, pdf)
    return WrittenDiagnosis(folder / REPORT, None if new_spec is None else folder / new_spec, values)


def save_plan_plot(rows: Sequence[Detectability], name: str, folder: Path, protection: Protection = PROTECTED) -> Path:
    """Draw the smallest size of each effect by measurement; returns the path of the PNG file."""
    with atomic_folder(folder, protection) as scratch:
        save_png(plot.measurement_plan(rows, name=name), scratch / "plan.png")
    return folder / "plan.png"


def write_json(file: Path, values: Mapping[str, Any], protection: Protection = PROTECTED) -> None:
    """Write the JSON object of a diagnosis into ``file``."""
    with atomic_folder(file.parent, protection, shared=True) as scratch:
        write_text(scratch / file.name, json_text(values))


def spec_with_effects(
    spec_text: str, tables: list[dict[str, object]], empirical: Sequence[Mapping[str, object]] = ()
) -> str:
    """The text of a spec file with ``[[effects]]`` and ``[[empirical]]`` added at its end and nothing else changed."""
    import tomli_w

    added = "\n".join(f"\n[[effects]]\n{tomli_w.dumps(table)}" for table in tables)
    # tomli_w writes the uncertainty as a table of its own; it belongs to the effect above it.
    added = added.replace("\n[uncertainty]", "\n[effects.uncertainty]")
    added += "".join(f"\n[[empirical]]\n{tomli_w.dumps(table)}" for table in empirical).replace(
        "\n[[data]]", "\n[[empirical.data]]"
    )
    grown = spec_text.rstrip() + "\n" + added
    try:
        parse_spec(grown)
    except CycloidError:
        # The effects are an inline list, to which no table can be added.
        import msgspec

        spec = parse_spec(spec_text)
        curves = (*spec.empirical, *(validated(dict(one), EmpiricalSpec, "empirical") for one in empirical))
        grown = format_spec(msgspec.structs.replace(spec, effects=(*spec.effects, *tables), empirical=curves))
    return grown


def diagnosis_report(
    diagnosis: Diagnosis,
    name: str,
    folder: Path,
    pictures: Sequence[tuple[str, str]],
    new_spec: str | None,
    changes: Comparison | None = None,
    pdf: bool = False,
) -> str:
    """HTML text of the report with links of the files in ``folder``; ``pictures``, stem and caption of the SVG files in
    its folder of plots; ``new_spec``, file name of the spec with the effects added; ``changes`` against an earlier
    diagnosis; ``pdf``: one is written next to it.
    """
    compared = ", ".join(f"{one.recording.name} ({text.readable(one.recording.kind)})" for one in diagnosis.gaps)
    not_seen = tuple((text.readable(n), _detection_limit_text(n, *limit)) for n, limit in diagnosis.not_seen.items())
    return render(
        "diagnosis.html.j2",
        folder,
        name,
        title="measurement and simulation",
        verdict=text.diagnosis_verdict(diagnosis),
        subject=f"Measured files compared with the simulation: {compared}.",
        meaning=text.diagnosis_meaning(diagnosis),
        also=[pdf_name(REPORT)] if pdf else [],
        notes={
            "diagnosis.json": "all values",
            pdf_name(REPORT): "this report",
            **({} if new_spec is None else {new_spec: "the spec with the effects added"}),
        },
        pictures=[picture(folder, f"{PLOTS}/{stem}", caption) for stem, caption in pictures],
        d=diagnosis,
        text=text,
        effects=[(one, _parameters(one)) for one in diagnosis.effects],
        kinds=EFFECTS,
        gaps=gap_table(diagnosis),
        nearest=nearest_table(diagnosis),
        not_seen=PlainTable("", ("", ""), not_seen),
        new_spec=new_spec,
        changes=[] if changes is None else list(change_tables(comparison_to_json(changes))),
    )


def _parameters(one: NamedEffect) -> list[tuple[str, str]]:
    """Description and value of each parameter of an effect, except those that select a part."""
    values = []
    for parameter in parameters(one.candidate.kind):
        value = one.parameters.get(parameter.name)
        if value is not None and parameter.name not in text.PARTS:
            error = one.uncertainty.get(parameter.name)
            of_a_word = text.readable(value) if isinstance(value, str) else None
            shown = of_a_word or text.with_uncertainty(value, error, sign_of(parameter.name))
            values.append((re.sub(r" \[.*\]$", "", parameter.text), shown))
    return values


def _detection_limit_text(name: str, size: float, parameter: str) -> str:
    """Size below which the files do not detect an effect, as text."""
    known = next(p for p in parameters(EFFECTS[name]) if p.name == parameter)
    unit = sign_of(parameter)
    if parameter == "stiffness_nm_per_arcmin":
        # Compliance is detected, hence a largest stiffness.
        if math.isfinite(size) and size > 0.0 and 1.0 / size > known.low:
            return f"anything stiffer than {float(f'{1.0 / size:.2g}'):,.0f} {unit}"
    elif math.isfinite(size) and size <= known.high:
        return f"anything below {with_unit(f'{size:.2g}', unit)}"
    return "these files do not show it"
