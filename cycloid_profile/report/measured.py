"""Simulated files and comparisons of measured files: pictures, tables and JSON."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, singledispatch
from itertools import starmap
from pathlib import Path
from typing import Any

from cycloid_profile import plot
from cycloid_profile._display import finite
from cycloid_profile.articles import PlainTable
from cycloid_profile.articles.tables import ABSENT
from cycloid_profile.design import DesignRecord, design_disc
from cycloid_profile.diagnosis import screen_files
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.errors import MeasurementError
from cycloid_profile.export.inspection import CheckResult, inspect_scan
from cycloid_profile.export.writing import PROTECTED, Protection, atomic_folder
from cycloid_profile.measurement import PROFILE_SCAN, Measurement, MeasurementKind, ProfileScan, format_measurement
from cycloid_profile.rig import (
    ComparedFigure,
    ComparedFigures,
    FigureName,
    MeasurementResidual,
    Settings,
    compared_figures,
    measurement_residual,
    simulate,
)
from cycloid_profile.spec import Spec
from cycloid_profile.units import SIGNS, UM, sign_of


@dataclass(frozen=True)
class ComparedFile:
    """Residual of one measured file, its figures compared with the prediction, and the path of its picture."""

    residual: MeasurementResidual
    compared: ComparedFigures
    picture: Path


def write_comparison(
    reducer: AsBuiltReducer,
    spec: Spec,
    measurements: Sequence[Measurement],
    folder: Path,
    disc: int = 0,
    progress: Callable[[str], None] = lambda _: None,
    protection: Protection = PROTECTED,
) -> list[ComparedFile]:
    """Compare each file with the prediction of the ``reducer`` of a spec and draw it into ``folder``.

    ``disc`` that was scanned, counted from 0. Raises as ``screen_files`` and ``measurement_residual`` do, for all files
    before the first is drawn.
    """
    progress("checking the files")
    measurements, _ = screen_files(reducer, measurements)
    expected = _Expected(reducer, spec, disc)
    compared = []
    with atomic_folder(folder, protection) as scratch:
        for number, measurement in enumerate(measurements, 1):
            progress(f"comparing {measurement.name}")
            residual = measurement_residual(reducer, measurement, disc)
            figures = _figures(measurement.kind, residual, expected)
            picture = f"{number}_{Path(measurement.name).stem}.png"
            plot.save_png(plot.comparison(residual, name=spec.name), scratch / picture)
            compared.append(ComparedFile(residual, figures, folder / picture))
    return compared


@dataclass(frozen=True)
class _Expected:
    """What the files are compared with; the design and the checks of the ``disc`` serve all scans."""

    reducer: AsBuiltReducer
    spec: Spec
    disc: int

    @cached_property
    def record(self) -> DesignRecord:
        """The design that the spec states."""
        return design_disc(self.spec)

    @cached_property
    def checks(self) -> tuple[CheckResult, ...]:
        """Checks of an inspection of the predicted tooth."""
        return self.inspected(simulate(self.reducer, PROFILE_SCAN, Settings(disc=self.disc)))

    def inspected(self, scan: Measurement) -> tuple[CheckResult, ...]:
        """Checks of an inspection of a scan; raises as ``inspect_scan``."""
        return inspect_scan(self.record, scan).checks


@singledispatch
def _figures(kind: MeasurementKind, residual: MeasurementResidual, expected: _Expected) -> ComparedFigures:  # noqa: ARG001
    """Figures of a curve of this ``kind``, with the limits of the spec as tolerances."""
    found, limits = compared_figures(residual), expected.spec.tolerance.limits
    within = tuple(replace(each, tolerance=getattr(limits, each.name.limit, None)) for each in found.figures)
    return replace(found, figures=within)


@_figures.register
def _(_: ProfileScan, residual: MeasurementResidual, expected: _Expected) -> ComparedFigures:
    """Checks of an inspection, of the scan and of the predicted tooth, with their tolerances."""
    try:
        of_scan = expected.inspected(residual.measurement)
    except MeasurementError as error:
        return ComparedFigures((), (f"no figures: {error}",))
    return ComparedFigures(tuple(starmap(_of_check, zip(of_scan, expected.checks, strict=True))))


def _of_check(measured: CheckResult, predicted: CheckResult) -> ComparedFigure:
    """A check of an inspection as a figure; a deviation that the noise alone would show counts as noise."""
    name = FigureName(f"{measured.name.replace(' ', '_')}_um", f"{measured.name} {measured.symbol}")
    value, nominal = (math.nan if check.value is None else check.value / UM for check in (measured, predicted))
    return ComparedFigure(name, value, nominal, measured.noise_alone / UM, measured.tolerance / UM)


def comparison_table(name: str, compared: Sequence[ComparedFile]) -> PlainTable:
    """RMS residual and noise of each file."""
    rows = tuple(
        (one.measurement.name, one.measurement.kind.name, f"{one.rms:.4g}", f"{one.noise:.4g}", SIGNS[one.unit])
        for one in (file.residual for file in compared)
    )
    return PlainTable(f"{name}: measured minus predicted", ("file", "kind", "rms", "noise", "unit"), rows)


def figure_tables(compared: Sequence[ComparedFile]) -> list[PlainTable]:
    """Figures of each file: measured, predicted, difference, effect of the noise, tolerance of the spec."""
    head = ("figure", "measured", "predicted", "difference", "noise", "tolerance")
    tables = []
    for file in compared:
        rows = tuple(_figure_row(figure) for figure in file.compared.figures)
        kind = file.residual.measurement.kind.title
        note = "; ".join(file.compared.notes)
        tables.append(PlainTable(f"{file.residual.measurement.name}: {kind}", head, rows, note))
    return tables


def _figure_row(figure: ComparedFigure) -> tuple[str, ...]:
    name = f"{figure.name.title} [{sign_of(figure.name.key)}]"
    places = _decimals(figure)
    values = (
        _cell(figure.measured, f"z.{places}f"),
        _cell(figure.predicted, f"z.{places}f"),
        _cell(figure.difference, f"+z.{places}f"),
        _cell(figure.noise, f".{places}f"),
        _cell(figure.tolerance, ".4g"),
    )
    return (name, *values)


def _cell(value: float | None, form: str) -> str:
    return ABSENT if value is None or not math.isfinite(value) else f"{value:{form}}"


def _decimals(figure: ComparedFigure) -> int:
    """Decimal places that show two digits of the noise, and no more than four of the figure."""
    sizes = [abs(value) for value in (figure.measured, figure.predicted) if math.isfinite(value)]
    size, noise = max(sizes, default=0.0), figure.noise
    of_figure = 3 - math.floor(math.log10(size)) if size > 0.0 else 0
    of_noise = 1 - math.floor(math.log10(noise)) if math.isfinite(noise) and noise > 0.0 else of_figure
    return max(0, min(of_figure, of_noise))


def comparison_to_json(name: str, compared: Sequence[ComparedFile]) -> dict[str, Any]:
    """JSON object of a comparison; the ``figures`` of a file have their units in their keys."""
    rows = [
        {
            "file": file.residual.measurement.name,
            "kind": file.residual.measurement.kind.name,
            "unit": file.residual.unit,
            "rms": file.residual.rms,
            "noise": file.residual.noise,
            "registration": file.residual.registration,
            "figures": {figure.name.key: _figure_to_json(figure) for figure in file.compared.figures},
            "picture": str(file.picture),
            "notes": [*file.residual.measurement.notes, *file.compared.notes],
        }
        for file in compared
    ]
    return {"schema": 1, "name": name, "gap": rows}


def _figure_to_json(figure: ComparedFigure) -> dict[str, Any]:
    values = {
        "measured": figure.measured,
        "predicted": figure.predicted,
        "difference": figure.difference,
        "noise": figure.noise,
        "tolerance": figure.tolerance,
    }
    numbers = {key: None if value is None else finite(value) for key, value in values.items()}
    return {"name": figure.name.title} | numbers


def write_measurement(
    measured: Measurement, reducer: AsBuiltReducer, name: str, file: Path, protection: Protection = PROTECTED
) -> Path:
    """Write a simulated file with its picture next to it; returns the path of the picture."""
    picture = file.with_suffix(".png")
    with atomic_folder(file.parent, protection, shared=True) as scratch:
        (scratch / file.name).write_text(format_measurement(measured), encoding="utf-8", newline="\n")
        plot.save_png(plot.measurement(measured, reducer=reducer, name=name), scratch / picture.name)
    return picture


def key_figure_table(title: str, figures: Mapping[str, float]) -> PlainTable:
    """Key figures of a measured or simulated file."""
    return PlainTable(title, ("", ""), tuple((key, f"{value:.5g}") for key, value in figures.items()))
