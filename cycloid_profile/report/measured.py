"""Simulated files and comparisons of measured files: pictures, tables and JSON."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cycloid_profile import plot
from cycloid_profile.articles import PlainTable
from cycloid_profile.diagnosis import screen_files
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.export.writing import PROTECTED, Protection, atomic_folder
from cycloid_profile.measurement import Measurement, format_measurement
from cycloid_profile.rig import MeasurementResidual, measurement_residual
from cycloid_profile.units import SIGNS


@dataclass(frozen=True)
class ComparedFile:
    """Residual of one measured file, and the path of its picture."""

    residual: MeasurementResidual
    picture: Path


def write_comparison(
    reducer: AsBuiltReducer,
    name: str,
    measurements: Sequence[Measurement],
    folder: Path,
    disc: int = 0,
    progress: Callable[[str], None] = lambda _: None,
    protection: Protection = PROTECTED,
) -> list[ComparedFile]:
    """Subtract the prediction of ``reducer`` from each file and draw the residuals into ``folder``.

    ``name`` of the drive; ``disc`` that was scanned, counted from 0. Raises as ``screen_files`` and
    ``measurement_residual`` do, for all files before the first is drawn.
    """
    progress("checking the files")
    measurements, _ = screen_files(reducer, measurements)
    compared = []
    with atomic_folder(folder, protection) as scratch:
        for number, measurement in enumerate(measurements, 1):
            progress(f"comparing {measurement.name}")
            residual = measurement_residual(reducer, measurement, disc)
            picture = f"{number}_{Path(measurement.name).stem}.png"
            plot.save_png(plot.measurement_residual(residual, name=name), scratch / picture)
            compared.append(ComparedFile(residual, folder / picture))
    return compared


def comparison_table(name: str, compared: Sequence[ComparedFile]) -> PlainTable:
    """RMS residual and noise of each file."""
    rows = tuple(
        (one.measurement.name, one.measurement.kind.name, f"{one.rms:.4g}", f"{one.noise:.4g}", SIGNS[one.unit])
        for one in (file.residual for file in compared)
    )
    return PlainTable(f"{name}: measured minus predicted", ("file", "kind", "rms", "noise", "unit"), rows)


def comparison_to_json(name: str, compared: Sequence[ComparedFile]) -> dict[str, Any]:
    """JSON object of a comparison."""
    rows = [
        {
            "file": file.residual.measurement.name,
            "kind": file.residual.measurement.kind.name,
            "unit": file.residual.unit,
            "rms": file.residual.rms,
            "noise": file.residual.noise,
            "registration": file.residual.registration,
            "picture": str(file.picture),
            "notes": list(file.residual.measurement.notes),
        }
        for file in compared
    ]
    return {"schema": 1, "name": name, "gap": rows}


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
