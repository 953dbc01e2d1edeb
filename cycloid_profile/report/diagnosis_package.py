"""Everything a diagnosis yields, in one folder: report, pictures, result, spec with the effects added."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

from cycloid_profile.discrepancy.outcome import Diagnosis
from cycloid_profile.discrepancy.told import effect_tables, told
from cycloid_profile.errors import CycloidError
from cycloid_profile.export.folder import whole_or_nothing
from cycloid_profile.plot.diagnosis import pictures
from cycloid_profile.plot.style import save
from cycloid_profile.report.diagnosis import diagnosis_report
from cycloid_profile.spec.read import parse_spec
from cycloid_profile.spec.write import format_spec

PLOTS = "plots"


class WrittenDiagnosis(NamedTuple):
    """Where the report is, and the new spec file if effects were found."""

    report: Path
    spec: Path | None


def write_diagnosis(
    diagnosis: Diagnosis,
    name: str,
    spec: Path,
    files: Mapping[str, bytes],
    folder: Path,
    tell: Callable[[str], None] = lambda _: None,
) -> WrittenDiagnosis:
    """Write report, plots and result into ``folder``, and SPEC_diagnosed.toml where effects were found.

    The spec file itself is left as it is.
    """
    new_spec = f"{spec.stem}_diagnosed.toml" if diagnosis.effects else None
    with whole_or_nothing(folder) as scratch:
        plots = scratch / PLOTS
        plots.mkdir()
        drawn = []
        for stem, caption, figure in pictures(diagnosis, name):
            tell(f"drawing {stem}")
            save(figure, plots, stem)
            drawn.append((stem, caption))
        page = diagnosis_report(diagnosis, name, plots, drawn, new_spec)
        (scratch / "report.html").write_text(page, encoding="utf-8", newline="\n")
        result = json.dumps(told(diagnosis, name), indent=1, ensure_ascii=False, allow_nan=False)
        (scratch / "diagnosis.json").write_text(result + "\n", encoding="utf-8", newline="\n")
        if new_spec is not None:
            text = with_effects(spec.read_text(encoding="utf-8-sig"), effect_tables(diagnosis, files))
            (scratch / new_spec).write_text(text, encoding="utf-8", newline="\n")
    return WrittenDiagnosis(folder / "report.html", None if new_spec is None else folder / new_spec)


def with_effects(text: str, tables: list[dict[str, object]]) -> str:
    """The text of a spec file with ``[[effects]]`` added at its end, all else as it was."""
    import tomli_w

    added = "\n".join(f"\n[[effects]]\n{tomli_w.dumps(table)}" for table in tables)
    # tomli_w writes the uncertainty as a table of its own, which belongs to the effect above it.
    added = added.replace("\n[uncertainty]", "\n[effects.uncertainty]")
    grown = text.rstrip() + "\n" + added
    try:
        parse_spec(grown)
    except CycloidError:
        # The effects stood as an inline list, to which no table can be added.
        import msgspec

        spec = parse_spec(text)
        grown = format_spec(msgspec.structs.replace(spec, effects=(*spec.effects, *tables)))
    return grown
