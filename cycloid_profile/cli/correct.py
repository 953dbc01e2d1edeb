"""``cycloid-profile correct``: the grinding path that cancels what scans of a disc show."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from cycloid_profile.cli.options import Json
from cycloid_profile.cli.terminal import output_folder, print_json, print_table, progress, warn

if TYPE_CHECKING:
    from cycloid_profile.discrepancy.outcome import Diagnosis
    from cycloid_profile.measurement.files import Measurement

_UNKNOWN = (
    "the scan differs in a way that is no effect of the library, so that there is nothing to cancel by name: "
    "--remainder grinds the opposite of its smooth part, fitted and not explained"
)
_AGREES = "scan and drawing agree within the noise: nothing to correct, nothing written"


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
    from cycloid_profile.discrepancy.correction_told import correction_told
    from cycloid_profile.discrepancy.diagnosis import diagnose
    from cycloid_profile.effects.registry import effect
    from cycloid_profile.errors import MeasurementError
    from cycloid_profile.measurement.files import read_measurement
    from cycloid_profile.report.correction_package import write_correction
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
        values = correction_told(found, diagnosis, wanted.name, limit_um, remainder)
        told = write_correction(found, values, wanted, points, folder, tell)
    if json:
        print_json(told)
    else:
        _print(told, folder)
    return 0


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
