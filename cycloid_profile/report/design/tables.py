"""Tables of the key figures of a design, for the terminal and the report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from cycloid_profile._display import FigureRow, figure_text
from cycloid_profile.articles import PlainTable
from cycloid_profile.design import ACCURACY, AS_BUILT, CheckStatus
from cycloid_profile.export import file_names
from cycloid_profile.report.page import figure_table, merged_columns
from cycloid_profile.spec.model import Spec

LOAD = (
    FigureRow("max_force_n", "largest pin force", "N"),
    FigureRow("delta_max_um", "deformation δmax", "µm"),
    FigureRow("loaded_pins", "loaded pins"),
    FigureRow("max_pressure_mpa", "peak pressure", "MPa"),
    FigureRow("iterations", "iterations", report_only=True),
)
COMPENSATION = (
    FigureRow("delta_max_um", "deformation δmax added to the tooth", "µm"),
    FigureRow("delta_max_least_um", "least δmax of the poses", "µm"),
    FigureRow("delta_max_largest_um", "largest δmax of the poses", "µm"),
    FigureRow("backlash_change_arcmin", "change of the backlash", "′"),
)
STAGE = (
    FigureRow("max_force_n", "largest pin force", "N"),
    FigureRow("max_pressure_mpa", "peak pressure", "MPa"),
    FigureRow("max_subsurface_shear_mpa", "shear under the surface", "MPa"),
    FigureRow("shear_depth_um", "depth of the largest shear, up to", "µm", report_only=True),
    FigureRow("loaded_pins", "most loaded pins of a disc", report_only=True),
    FigureRow("fewest_loaded_pins", "fewest loaded pins of a disc"),
    FigureRow("twist_arcmin", "twist beyond first contact", "′", report_only=True),
    FigureRow("max_bearing_force_n", "largest crank bearing force", "N"),
    FigureRow("crank_bearing_clearance_um", "radial clearance of a crank bearing", "µm"),
    FigureRow("crank_bearing_stiffness_n_per_mm", "radial stiffness of a crank bearing at it", "N/mm"),
    FigureRow("torsional_stiffness_nm_per_arcmin", "tangent torsional stiffness", "N·m/′"),
    FigureRow("max_sliding_speed_mm_per_s", "fastest sliding of a loaded pin", "mm/s"),
)
OVER_WIDTH = (
    FigureRow("max_edge_pressure_mpa", "peak pressure over the face width", "MPa"),
    FigureRow("max_tilt_mrad", "largest tilt of a disc", "mrad"),
    FigureRow("width_slices", "slices over the face width", report_only=True),
)
_MEASURED_FILE = ("tolerance_um", "deviation_um")
LOSS_CASES = ("low", "likely", "high")
LOSSES = (
    FigureRow("friction_coefficient", "friction of tooth and pin"),
    FigureRow("bearing_friction_coefficient", "friction of the crank bearings"),
    FigureRow("mesh_loss_w", "mesh loss", "W"),
    FigureRow("bearing_loss_w", "crank bearing loss", "W"),
    FigureRow("heat_w", "heat of this stage", "W"),
    FigureRow("efficiency", "efficiency of this stage"),
)
STRENGTH = (
    FigureRow("pin_force_n", "largest force on a pin, all discs", "N"),
    FigureRow("pin_shear_mpa", "shear of that pin, at most", "MPa"),
    FigureRow("pin_bending_mpa", "bending of that pin", "MPa"),
    FigureRow("dynamic_load_rating_n", "dynamic load rating of a crank bearing", "N"),
    FigureRow("equivalent_load_n", "equivalent load of a crank bearing", "N"),
    FigureRow("crank_speed_rpm", "crank against disc", "rpm"),
    FigureRow("crank_bearing_life_h", "basic rating life L10 of a crank bearing", "h"),
    FigureRow("all_crank_bearings_life_h", "L10 of all crank bearings together", "h"),
    FigureRow("viscosity_ratio", "viscosity ratio κ"),
    FigureRow("crank_bearing_modified_life_h", "modified rating life L10m of a crank bearing", "h"),
)
GEOMETRY = (
    FigureRow("root_radius_mm", "root radius", "mm"),
    FigureRow("tip_radius_mm", "tip radius", "mm"),
    FigureRow("undercut_limit_mm", "undercut limit of the pin radius", "mm"),
    FigureRow("least_convex_radius_mm", "least convex radius, theoretical tooth", "mm"),
    FigureRow("least_concave_radius_mm", "least concave radius, theoretical tooth", "mm"),
    FigureRow("largest_wheel_radius_mm", "largest grinding wheel radius, final tooth", "mm"),
    FigureRow("corner_mrad", "turn of the tangent at root or tip", "mrad"),
    FigureRow("radial_clearance_um", "radial clearance", "µm"),
    FigureRow("reduction_ratio", "reduction ratio"),
)

_MARKS = {
    CheckStatus.PASSED: "✓",
    CheckStatus.ESTIMATED: "✓",
    CheckStatus.ADVISED_AGAINST: "!",
    CheckStatus.FAILED: "✗",
    CheckStatus.NOT_CHECKED: "–",
}


def stage_rows(under_load: Mapping[str, Any]) -> tuple[FigureRow, ...]:
    """Rows of the whole stage, with those of slices over the face width where there are any."""
    return STAGE + (OVER_WIDTH if "width_slices" in under_load else ())


def accuracy_table(figures: Mapping[str, Any]) -> PlainTable:
    """Accuracy of the conventional and the compensated tooth; one column where they are the same."""
    names = ("conventional", "compensated")
    return figure_table("", ACCURACY, [figures[name] for name in names], names)


def checks_table(figures: Mapping[str, Any]) -> PlainTable:
    """Every check with its value, limit, status and remedy."""
    rows = tuple(
        (
            _MARKS[CheckStatus(one["status"])],
            one["name"],
            one["value"],
            one["limit"],
            f"{one['status']}: {one['assumed']}" if one["assumed"] else one["status"],
            "" if one["passed"] else one["remedy"],
        )
        for one in figures["checks"]
    )
    return PlainTable("", ("", "check", "value", "limit", "status", "remedy"), rows)


def terminal_tables(figures: Mapping[str, Any], loads: bool = False) -> list[PlainTable]:
    """Accuracy, load on the conventional tooth and compensation if ``loads``, stage, losses, strength, reducer with
    any effects.
    """
    found = [_table(f"{figures['name']}: accuracy", ACCURACY, figures, ("conventional", "compensated"))]
    if loads:
        found.append(_table("load on the conventional tooth", LOAD, figures, ("classical", "equilibrium")))
        if figures["compensation"]["applied"]:
            found.append(_table("deformation compensation", COMPENSATION, figures, ("compensation",)))
    rows = stage_rows(figures["under_load"])
    found.append(_table("whole stage, final tooth, rated torque", rows, figures, ("under_load",)))
    found.append(_losses_table(figures))
    found.append(_strength_table(figures))
    if figures["as_built"]:
        found.append(_table(f"as built, with {', '.join(figures['effects'])}", AS_BUILT, figures, ("as_built",)))
    return found


def drive_table(drives: Mapping[str, Spec]) -> PlainTable:
    """Drives of the catalogue by name."""
    head = ("drive", "pins", "pin circle radius [mm]", "eccentricity [mm]", "rated torque [N·m]", "assumed keys")
    rows = tuple(
        (name, str(spec.drive.pins), f"{spec.drive.pin_circle_radius_mm:g}", f"{spec.drive.eccentricity_mm:g}",
         f"{spec.load.rated_torque_nm:g}", str(len(spec.source.assumed)))
        for name, spec in drives.items()
    )  # fmt: skip
    return PlainTable("catalogue", head, rows)


def planned_files_table(formats: Sequence[str], folder: Path, discs: Sequence[int] = (1,)) -> PlainTable:
    """Files that an export of ``formats`` would write into ``folder``; ``discs`` as in ``file_names``."""
    rows = tuple((str(folder / file), name) for name in formats for file in file_names(name, discs))
    return PlainTable("would be written", ("file", "format"), rows)


def written_files_table(entries: Sequence[Mapping[str, Any]], folder: Path) -> PlainTable:
    """Manifest ``entries`` of files in ``folder``, with promised tolerance and measured deviation."""
    rows = tuple(
        (str(folder / one["path"]), f"{one['bytes']:,}", *(figure_text(one[key]) for key in _MEASURED_FILE))
        for one in entries
    )
    return PlainTable("written", ("file", "bytes", "tolerance [µm]", "measured [µm]"), rows)


def warnings(figures: Mapping[str, Any]) -> list[str]:
    """Assumed torque, failed checks that are not severe, checks without data, and failures, one sentence each."""
    assumed = figures["rated_torque_assumed"]
    torque = (
        f"load.rated_torque_nm is not given: {figure_text(figures['rated_torque_nm'])} N·m is assumed from the size"
    )
    advised, missing = CheckStatus.ADVISED_AGAINST.value, CheckStatus.NOT_CHECKED.value
    advice = [f"advice: {one['sentence']}" for one in figures["checks"] if one["status"] == advised]
    unknown = "; ".join(f"{one['name']}: {one['remedy']}" for one in figures["checks"] if one["status"] == missing)
    sentences = [*([torque] if assumed else []), *advice, *([f"{missing}: {unknown}"] if unknown else [])]
    return [*sentences, *figures["failures"]]


def _losses_table(figures: Mapping[str, Any]) -> PlainTable:
    speed = figure_text(figures["under_load"]["output_speed_rpm"])
    table = _table(f"losses, estimate at {speed} rpm output", LOSSES, figures["losses"], LOSS_CASES)
    return replace(table, note=figures["losses"]["assumption"])


def _strength_table(figures: Mapping[str, Any]) -> PlainTable:
    """The checks of stresses and life, with the keys to give where data are missing, and what was assumed."""
    missing = CheckStatus.NOT_CHECKED.value
    checks = [one for one in figures["checks"] if one["name"] in figures["strength"]["checks"]]
    rows = [
        (
            one["name"],
            one["value"],
            f"{missing}: {one['remedy']}" if one["status"] == missing else f"{one['limit']}: {one['status']}",
        )
        for one in checks
    ]
    note = "; ".join(f"{one['name']}: {one['assumed']}" for one in checks if one["assumed"])
    return PlainTable("strength and life, nominal parts", ("", "", ""), tuple(rows), f"assumed: {note}" if note else "")


def _table(title: str, rows: Sequence[FigureRow], figures: Mapping[str, Any], columns: Sequence[str]) -> PlainTable:
    """The rows of the terminal; a single column has no head."""
    shown = [row for row in rows if not row.report_only]
    merged = merged_columns(shown, [figures[column] for column in columns], columns)
    labels = [f"{row.label} [{row.unit}]" if row.unit else row.label for row in shown]
    heads = tuple(head for head, _ in merged) if len(columns) > 1 else ("",)
    return PlainTable(title, ("", *heads), tuple(zip(labels, *(found for _, found in merged), strict=True)))
