"""``cycloid-profile correct``: the grinding path that cancels what scans of a disc show."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from cycloid_profile.cli.options import Json
from cycloid_profile.cli.terminal import output_folder, print_json, print_table, progress, warn

if TYPE_CHECKING:
    from cycloid_profile.discrepancy.correction import Correction
    from cycloid_profile.discrepancy.diagnosis import Diagnosis
    from cycloid_profile.effects.built import Built
    from cycloid_profile.effects.effect import Effect
    from cycloid_profile.measurement.files import Measurement
    from cycloid_profile.spec.model import Spec

_UNKNOWN = (
    "the scan differs in a way that is no effect of the library, so that there is nothing to cancel by name: "
    "--remainder grinds the opposite of its smooth part, fitted and not explained"
)
_AGREES = "scan and drawing agree within the noise: nothing to correct, nothing written"
_DIGITS = 6


def correct(
    spec: Path,
    /,
    *scans: Path,
    out: Annotated[
        Path | None, Parameter(help="Output folder, default exports/NAME/correct, NAME of the spec file.")
    ] = None,
    disc: Annotated[int | None, Parameter(help="Disc that was scanned, default as `specimen` says, else 1.")] = None,
    limit_um: Annotated[float, Parameter(help="Largest departure from the drawing that is allowed [µm].")] = 10.0,
    wheel_radius_mm: Annotated[
        float | None, Parameter(help="Radius of the grinding wheel [mm], default that of the generating pin.")
    ] = None,
    remainder: Annotated[
        bool, Parameter(negative=(), help="Cancel a smooth remainder, too: fitted to the scan, not explained.")
    ] = False,
    json: Json = False,
) -> int:
    """Write the grinding path that cancels the errors found in scans of a disc, and the scan to expect after it.

    Example: cycloid-profile correct examples/rv40e.toml scan.csv --limit-um 5

    Parameters
    ----------
    spec
        Spec file (TOML); what its [[effects]] hold of the flanks of this disc is cancelled, too.
    scans
        Profile scans of one disc (CSV).
    """
    from cycloid_profile.design.ground import built_reducer
    from cycloid_profile.discrepancy.correction import correction
    from cycloid_profile.discrepancy.diagnosis import diagnose
    from cycloid_profile.effects.registry import effect
    from cycloid_profile.errors import MeasurementError
    from cycloid_profile.measurement.files import read_measurement
    from cycloid_profile.spec.read import read_spec
    from cycloid_profile.units import UM

    if not scans:
        raise MeasurementError("profile scans", "none", "were given", "name at least one CSV file after the spec", " ")
    _check_positive("--limit-um", limit_um, "µm")
    _check_positive("--wheel-radius-mm", 1.0 if wheel_radius_mm is None else wheel_radius_mm, "mm")
    folder = output_folder(out, spec) / "correct" if out is None else out
    with progress() as tell:
        wanted = read_spec(spec)
        measured = [_scan(read_measurement(file)) for file in scans]
        tell("building the reducer")
        built = built_reducer(wanted)
        known = [effect(table) for table in wanted.effects]
        diagnosis = diagnose(built, measured, None if disc is None else [disc - 1] * len(measured), (), tell)
        which = _one_disc(diagnosis)
        if diagnosis.verdict == "unknown_effect" and not remainder:
            return _say(diagnosis, wanted.name, json, _UNKNOWN, 1)
        if diagnosis.verdict == "agrees" and built.teeth[which] is built.case.profile:
            return _say(diagnosis, wanted.name, json, _AGREES, 0)
        tell("turning the errors round")
        found = correction(
            diagnosis,
            which,
            limit_um * UM,
            wheel_radius=wheel_radius_mm,
            with_remainder=remainder and diagnosis.verdict != "agrees",
            known=known,
        )
        if found.nothing:
            sentence = "; ".join(found.left) or "nothing of what the scan shows stands above the noise as a smooth form"
            return _say(diagnosis, wanted.name, json, sentence, 1)
        points = max(m["x_mm"].size for m in measured)
        told = _write(found, diagnosis, wanted, limit_um, remainder, points, folder, tell)
    if json:
        print_json(told)
    else:
        _print(told, folder)
    return 0


def _write(
    found: Correction,
    diagnosis: Diagnosis,
    wanted: Spec,
    limit_um: float,
    asked: bool,
    points: int,
    folder: Path,
    tell: Callable[[str], None],
) -> dict[str, Any]:
    """All files, together or not at all; returns what ``correction.json`` holds."""
    import json

    from cycloid_profile.export.disc_path import DiscPath
    from cycloid_profile.export.folder import whole_or_nothing
    from cycloid_profile.export.formats import kept_promise
    from cycloid_profile.export.gcode import GcodeExporter
    from cycloid_profile.export.manifest import manifest_entry
    from cycloid_profile.export.points import ProfileCsvExporter
    from cycloid_profile.measurement.files import format_measurement
    from cycloid_profile.plot.correction import correction_plot
    from cycloid_profile.plot.style import save_png

    path = DiscPath(wanted, diagnosis.built.case.drive, found.program)
    exporters = (ProfileCsvExporter(filename="profile_corrected.csv"), GcodeExporter(filename="grinding_corrected.nc"))
    with whole_or_nothing(folder) as scratch:
        files = []
        for exporter in exporters:
            tell(f"writing {exporter.filename}")
            written = [kept_promise(file) for file in exporter.write(path, scratch)]
            files += [manifest_entry(file, wanted, scratch) for file in written]
        tell("the scan to expect")
        expected = _expected_scan(found.predicted, found.disc, points)
        (scratch / "predicted_scan.csv").write_text(format_measurement(expected), encoding="utf-8", newline="\n")
        save_png(correction_plot(found, wanted.name), scratch / "correction.png")
        others = [{"path": name} for name in ("predicted_scan.csv", "correction.png", "correction.json")]
        told = _told(found, diagnosis, wanted.name, limit_um, asked) | {"files": [*files, *others]}
        text = json.dumps(told, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
        (scratch / "correction.json").write_text(text, encoding="utf-8", newline="\n")
    return told


def _expected_scan(predicted: Built, disc: int, points: int) -> Measurement:
    from cycloid_profile.rig.simulate import Settings, simulate

    scan = simulate(predicted, "profile_scan", Settings(points=points, disc=disc))
    return replace(scan, keys=dict(scan.keys) | {"expected": "after the correction, the machine's errors still there"})


def _told(found: Correction, diagnosis: Diagnosis, name: str, limit_um: float, asked: bool) -> dict[str, Any]:
    from cycloid_profile.discrepancy.correction_limits import STEEPEST
    from cycloid_profile.effects.registry import table
    from cycloid_profile.units import DEGREE, UM

    shape, smooth = found.shape, found.remainder
    known: Sequence[Effect] = found.known
    return {
        "schema": 1,
        "name": name,
        "disc": found.disc + 1,
        "verdict": diagnosis.verdict,
        "effects": [
            {
                "name": one.candidate.name,
                "parameters": _rounded(one.parameters),
                "uncertainty": _rounded(one.uncertainty),
                "group": list(one.group),
            }
            for one in found.named
        ],
        "known_effects": [
            {"name": one.name, "parameters": {k: v for k, v in table(one).items() if k != "name"}} for one in known
        ],
        "remainder": None
        if smooth is None
        else {
            "label": smooth.label,
            "rms_um": _short(smooth.rms / UM),
            "largest_um": _short(smooth.largest / UM),
            "lobes_without_points": list(smooth.lobes_without),
        },
        "largest_um": _short(shape.largest / UM),
        "limit_um": limit_um,
        "adds_um": _short(shape.added / UM),
        "steepest_um_per_mm": _short(shape.steepest / UM),
        "limit_um_per_mm": _short(STEEPEST / UM),
        "change_of_curvature_per_mm": _short(shape.bending),
        "least_concave_radius_mm": None if shape.concave == float("inf") else _short(shape.concave),
        "lobes_alike": found.program.lobes_alike,
        "scans": [
            {
                "file": scan.name,
                "noise_um": _short(scan.noise),
                "rms_before_um": _short(scan.rms_before),
                "rms_after_um": _short(scan.rms_after),
                "lobe_1_at_deg": round(scan.turn / DEGREE, 4),
            }
            for scan in found.scans
        ],
        "rms_expected_um": _short(found.rms_expected),
        "uncertainty_um": _short(found.uncertainty / UM),
        "left_by_the_model_nm": _short(found.residual / UM * 1e3),
        "not_ground_away": list(found.left),
        "notes": [*found.cautions, *_stock(shape.added / UM), *_not_named(found, diagnosis, asked)],
    }


def _stock(added_um: float) -> list[str]:
    if added_um < 0.05:
        return []
    return [
        f"the program leaves up to {added_um:.2f} µm more on than the drawing: it is for the next disc, or for stock"
    ]


def _not_named(found: Correction, diagnosis: Diagnosis, asked: bool) -> list[str]:
    if found.remainder is not None:
        from cycloid_profile.discrepancy.remainder import in_words

        return [in_words(found.remainder)]
    if asked:
        return ["beyond what is named nothing smooth stands above the noise: no remainder was ground"]
    if diagnosis.remainder is not None:
        return ["something without a name is left over: --remainder would grind its smooth part away"]
    return []


def _print(told: dict[str, Any], folder: Path) -> None:
    cancelled = [
        (one["name"], ", ".join(f"{k} = {v:.4g}" for k, v in one["parameters"].items()), source)
        for key, source in (("effects", "found"), ("known_effects", "in the spec"))
        for one in told[key]
    ]
    if told["remainder"] is not None:
        smooth = told["remainder"]
        cancelled.append(("smooth remainder", f"at most {smooth['largest_um']:.3g} µm", smooth["label"]))
    print_table(f"{told['name']}, disc {told['disc']}: cancelled", ("effect", "parameters", "from"), cancelled)
    print()
    rows = [(s["file"], *(f"{s[k]:.4g}" for k in ("noise_um", "rms_before_um", "rms_after_um"))) for s in told["scans"]]
    print_table("gap to the drawing [µm]", ("file", "noise", "before", "after"), rows)
    print(
        f"\nat most {told['largest_um']:.3g} µm from the drawing (limit {told['limit_um']:g}); "
        f"a new scan is expected at {told['rms_expected_um']:.3g} µm rms"
    )
    if not told["lobes_alike"]:
        turns = ", ".join(f"{s['lobe_1_at_deg']:.4f}° in {s['file']}" for s in told["scans"])
        print(f"lobes differ: lobe 1 of the program is the one at {turns}; clamp the disc by it")
    for sentence in (*told["not_ground_away"], *told["notes"]):
        print(f"note: {sentence}")
    print(f"\nwritten: {folder}")


def _say(diagnosis: Diagnosis, name: str, as_json: bool, sentence: str, status: int) -> int:
    """Nothing to write: one sentence, and the status."""
    if as_json:
        print_json(
            {"schema": 1, "name": name, "verdict": diagnosis.verdict, "effects": [], "files": [], "reason": sentence}
        )
    if status:
        warn(sentence)
    elif not as_json:
        print(f"{name}: {sentence}")
    return status


def _scan(measurement: Measurement) -> Measurement:
    from cycloid_profile.errors import MeasurementError

    if measurement.kind != "profile_scan":
        raise MeasurementError(
            f"{measurement.name}: kind",
            f"'{measurement.kind}'",
            "is no scan of a disc",
            "give profile scans; diagnose takes the other kinds",
        )
    return measurement


def _one_disc(diagnosis: Diagnosis) -> int:
    from cycloid_profile.errors import MeasurementError

    discs = sorted({gap.recording.disc for gap in diagnosis.gaps})
    if len(discs) > 1:
        raise MeasurementError(
            "discs scanned",
            " and ".join(str(d + 1) for d in discs),
            "are more than one",
            "correct one disc at a time, or tell the disc with --disc",
        )
    return discs[0]


def _check_positive(option: str, value: float, unit: str) -> None:
    from cycloid_profile.errors import MeasurementError

    if not 0.0 < value < float("inf"):
        raise MeasurementError(option, f"{value:g} {unit}", "is not above zero", f"give a size above zero in {unit}")


def _rounded(values: dict[str, Any]) -> dict[str, Any]:
    return {key: _short(value) if isinstance(value, float) else value for key, value in values.items()}


def _short(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")
