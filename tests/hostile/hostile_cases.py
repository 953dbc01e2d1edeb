"""The corpus: hostile command lines as data, each with the status and the sentence that must come out.

A case is a command with its words, the files it finds, the expected status and a pattern of the sentence. Unless
``leaves`` names more, the folder holds afterwards what it held before, byte for byte. ``{…}`` in a word is a file of
``FILES``. A crash that is found becomes a case here.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from tests.spec_texts import PLAIN, RIGID_EXAMPLE

SPEC = RIGID_EXAMPLE
TOLERANCES = '\n[tolerance]\nsamples = 100\nloaded_samples = 0\n[[tolerance.effects]]\nname = "pin_radius_error"\n'
HEAD = "# format: cycloid-profile measurement 1\n"
SCAN = HEAD + "# kind: profile_scan\n# datum: bore\nx_mm,y_mm\n" + "62.0,0.0\n0.0,62.0\n" * 8
PRECIOUS = "x_mm,y_mm\n1.0,2.0\n"


@dataclass(frozen=True)
class Case:
    """One command line; ``files`` are written first, and ``spec`` is the content of ``spec.toml``."""

    name: str
    words: tuple[str, ...]
    says: str
    status: int = 2
    spec: str = SPEC
    files: dict[str, str] = field(default_factory=dict)
    leaves: tuple[str, ...] = ()


def changed(old: str, new: str) -> str:
    """The spec with one text replaced."""
    assert old in SPEC, old
    return SPEC.replace(old, new)


# Key, text of its line, and whether zero and negative numbers are refused, too.
NUMBERS = (
    ("pins", "pins = 40", True),
    ("pin_circle_radius_mm", "pin_circle_radius_mm = 64.0", True),
    ("pin_radius_mm", "pin_radius_mm = 3.0", True),
    ("eccentricity_mm", "eccentricity_mm = 1.3", True),
    ("disc_width_mm", "disc_width_mm = 11.5", True),
    ("discs", "discs = 2", True),
    ("count", "count = 3", True),
    ("circle_radius_mm", "\ncircle_radius_mm = 36.0", True),
    ("bearing_stiffness_n_per_mm", "bearing_stiffness_n_per_mm = 4.0e5", True),
    ("sun_teeth", "sun_teeth = 12", True),
    ("planet_teeth", "planet_teeth = 36", True),
    ("module_mm", "module_mm = 1.5", True),
    ("rated_torque_nm", "rated_torque_nm = 412.0", True),
    ("disc_share", "disc_share = 0.55", True),
    ("equidistant_um", "equidistant_um = 6.0", False),
    ("radial_moving_um", "radial_moving_um = 0.0", False),
    ("bore_radius_mm", "bore_radius_mm = 16.0", False),
    ("crank_hole_radius_mm", "crank_hole_radius_mm = 13.0", False),
    ("chord_tolerance_um", "chord_tolerance_um = 0.05", True),
)
WRONG = {"nan": "nan", "inf": "inf", "-inf": "-inf", "text": '"6,0"', "date": "1979-05-27", "table": "{ a = 1 }",
         "list": "[1, 2]", "true": "true", "digits": "9" * 5000}  # fmt: skip
OUTSIDE = {"zero": "0", "negative": "-1"}


def spec_numbers() -> Iterator[Case]:
    """Every number of the spec as something that is none, or outside its limits."""
    for key, line, bounded in NUMBERS:
        for kind, value in (WRONG | OUTSIDE if bounded else WRONG).items():
            says = "4300 digits" if kind == "digits" else key
            text = changed(line, f"{line.rsplit('=', 1)[0]}= {value}")
            yield Case(f"{key} {kind}", ("export", "spec.toml", "--list"), says, spec=text)


def spec_texts() -> Iterator[Case]:
    """Spec files that are no specs."""
    deep = "x = " + "[" * 5000 + "]" * 5000
    texts = {
        "empty": ("", "name|drive"),
        "deep nesting": (f'name = "x"\n{deep}\n', "too deeply"),
        "deep tables": (f'name = "x"\n[{".".join("a" * 3000)}]\n', "too deeply"),
        "unclosed": ('name = "x', "not valid TOML"),
        "twice": (SPEC + "[drive]\npins = 3\n", "not valid TOML"),
        "binary": ("\x00\x01\x02", "not valid TOML"),
        "json": ('{"name": "x"}', "not valid TOML"),
        "unknown key": (changed("pins = 40", "pinz = 40"), r"did you mean drive\.pins"),
        "unknown table": (SPEC + "\n[lode]\nx = 1\n", "did you mean load"),
        "unknown format": (changed('"cmm"]', '"cnn"]'), "export.formats"),
        "unknown effect": (SPEC + '\n[[effects]]\nname = "disc_runont"\n', "disc_runout"),
        "long name": (changed('name = "RV-40E"', f'name = "{"x" * 500}"'), "name"),
        "name of two lines": (changed('name = "RV-40E"', 'name = "a\\nb"'), "name"),
        "escape in name": (changed('name = "RV-40E"', 'name = "\\u001b[31m"'), "name"),
        "curtate no more": (changed("eccentricity_mm = 1.3", "eccentricity_mm = 1.7"), "short-width ratio"),
        "pins overlap": (changed("pin_radius_mm = 3.0", "pin_radius_mm = 30.0"), "pin"),
        "a million pins": (changed("pins = 40", "pins = 1000000"), "pins"),
        "huge circle": (changed("pin_circle_radius_mm = 64.0", "pin_circle_radius_mm = 1e300"), "pin_circle_radius"),
        "tiny circle": (changed("pin_circle_radius_mm = 64.0", "pin_circle_radius_mm = 1e-300"), "pin_circle_radius"),
    }
    for name, (text, says) in texts.items():
        yield Case(f"spec: {name}", ("export", "spec.toml", "--format", "csv", "--out", "out"), says, spec=text)


def places() -> Iterator[Case]:
    """Spec files that are no files."""
    for command in ("build", "accuracy", "export", "tolerance", "diagnose", "compare", "correct", "simulate"):
        more = {"simulate": ("--kind", "hysteresis"), "diagnose": ("d.csv",), "compare": ("d.csv",),
                "correct": ("d.csv",)}.get(command, ())  # fmt: skip
        for name, place, says in (
            ("missing", "nowhere.toml", "does not exist"),
            ("folder", ".", "cannot be read"),
            ("device", "/dev/zero", "no plain file"),
            ("pipe", "pipe", "no plain file"),
        ):
            yield Case(f"{command} {name} as spec", (command, place, *more), says, files={"d.csv": SCAN})
        yield Case(f"{command} unknown option", (command, "spec.toml", *more, "--nonsense"), "Unknown option")
        yield Case(f"{command} without spec", (command, *more[:2]) if command == "simulate" else (command,), "requires")


def options() -> Iterator[Case]:
    """Options with values that are none."""
    simulate = ("simulate", "spec.toml", "--kind")
    for kind in ("profile_scan", "hysteresis", "transmission_error", "lost_motion_map"):
        for option, values, says in (
            ("--torque-nm", ("nan", "inf", "-inf"), "torque"),
            ("--output-angle-deg", ("nan", "inf"), "output angle"),
            ("--points", ("0", "-1", "3", "1000000000000", "100000000"), "points"),
            ("--points", ("1e12", "many"), "points"),
            ("--noise", ("nan", "-1", "inf"), "noise"),
            ("--seed", ("-1", "x"), "seed"),
        ):
            for value in values:
                yield Case(f"{kind} {option} {value}", (*simulate, kind, f"{option}={value}"), says)
    yield Case("no torque", (*simulate, "lost_motion_map", "--torque-nm=0"), r"torque = 0 N·m is zero")
    yield Case("huge torque", (*simulate, "hysteresis", "--torque-nm=1e9", "--points=30"), "lower the torque", 1)
    yield Case("kind", (*simulate, "profile"), "profile_scan")
    yield Case("disc 0", (*simulate, "profile_scan", "--disc=0"), "disc = 0")
    yield Case("disc 3", (*simulate, "profile_scan", "--disc=3"), "disc = 3")
    yield Case("picture", (*simulate, "profile_scan", "--out", "x.png"), "name of the picture")
    plain = ("tolerance", "spec.toml")
    spec = SPEC + TOLERANCES + "amount_um = { plus_minus = 1.0 }\n"
    for words, says in (
        (("--threads=-1",), "threads = -1"),
        (("--threads=0",), "threads = 0"),
        (("--threads=99999999",), "threads = 99999999"),
        (("--loaded-samples=1",), "loaded_samples = 1"),
        (("--loaded-samples=-1",), "loaded_samples = -1"),
        (("--samples=1",), "samples = 1"),
        (("--samples=-5",), "samples = -5"),
        (("--samples=" + "9" * 30,), "samples"),
        (("--seed=-1",), "seed"),
        (("--sequence=halton",), "sobol"),
        (("--allocate",), "give at least one limit"),
    ):
        yield Case(f"tolerance {words[0][:30]}", (*plain, *words), says, spec=spec)


def large() -> Iterator[Case]:
    """Inputs that need more than the limits: what, how much, the limit and the remedy in one sentence."""
    simulate = ("simulate", "spec.toml", "--kind")
    needs = r"needs about [\d,.]+ (GB of (memory|disk)|h of one core).* \(limit [\d,.]+ .*--allow-large"
    circle = ("pin_circle_radius_mm = 64.0", "pin_circle_radius_mm = 1600.0")
    rigid = changed("pins = 40", "pins = 1000").replace(*circle)
    elastic = rigid.replace('disc_body = "rigid"', 'disc_body = "elastic"')
    for command, *words in (
        ("build",),
        ("accuracy",),
        ("export", "--format=csv"),
        ("compare", "d.csv"),
        ("diagnose", "d.csv"),
        ("inspect", "d.csv"),
        (*simulate[:1], "--kind=hysteresis"),
    ):
        files = {"d.csv": SCAN} if "d.csv" in words else {}
        yield Case(f"{command} of 1000 thin pins", (command, "spec.toml", *words), f"drive.pins = 1000 .*{needs}",
                   spec=elastic, files=files)  # fmt: skip
    for kind in ("hysteresis", "transmission_error", "lost_motion_map"):
        words = (*simulate, kind, "--points=20000")
        yield Case(f"{kind} of 1000 pins", words, f"points = 20,000 with 1000 pins {needs}", spec=rigid)
    rows = HEAD + "# kind: transmission_error\n# torque_nm: 400\noutput_angle_deg,error_arcsec\n"
    rows += "".join(f"{0.01 * i:.2f},1.0\n" for i in range(20_000))
    yield Case("compare a curve with 1000 pins", ("compare", "spec.toml", "c.csv"), rf"c\.csv: rows = 20,000.*{needs}",
               spec=rigid, files={"c.csv": rows})  # fmt: skip
    spec = SPEC + TOLERANCES + "amount_um = { plus_minus = 1.0 }\n"
    for option, value in (("--samples", 1_000_000_000), ("--loaded-samples", 100_000_000)):
        words = ("tolerance", "spec.toml", f"{option}={value}")
        says = rf"tolerance\.{option[2:].replace('-', '_')} = {value:,} {needs}"
        yield Case(f"tolerance {option}={value}", words, says, spec=spec)
    loop = (*simulate, "hysteresis", "--points=30")
    for name, size, says, status in (
        ("pin_ring_runout", "amplitude_um = 5000", "first the pin shift of 5000 µm", 1),
        ("single_pin_error", "amount_um = 5000\npin = 3", "first the pin oversize of 5000 µm", 1),
        ("coulomb_friction", "torque_nm = 10000", "angle of the loop does not change", 2),
    ):
        yield Case(f"loop of large {name}", loop, says, status, f'{SPEC}\n[[effects]]\nname = "{name}"\n{size}\n')
    turn = HEAD + "# kind: transmission_error\n# torque_nm: 400\n# noise_arcsec: {}\noutput_angle_deg,error_arcsec\n"
    turn += "".join(f"{3 * i},{math.sin(i):.3f}\n" for i in range(120))
    for noise in ("1e-9", "1e300"):
        yield Case(f"stated noise {noise}", ("diagnose", "spec.toml", "t.csv"), r"t\.csv: noise_arcsec.*check its unit",
                   files={"t.csv": turn.format(noise)})  # fmt: skip
    tight = changed("equidistant_um = 6.0", "equidistant_um = -100.0")
    yield Case(
        "pins that are 100 µm too tight",
        ("accuracy", "spec.toml"),
        "bring modification.equidistant_um and radial_moving_um nearer to zero",
        1,
        tight,
    )
    words = ("diagnose", "spec.toml", "d.csv", "--against=d.csv")
    yield Case("a file against itself", words, "rows are those of d.csv", files={"d.csv": SCAN})
    for command in ("compare", "diagnose", "correct", "inspect"):
        yield Case(f"{command} a device", (command, "spec.toml", "/dev/zero"), "is a device")


def overwriting() -> Iterator[Case]:
    """Outputs that would replace an input, or a file of others: refused, and every byte stays."""
    mine = {"mine.csv": PRECIOUS, "mine.png": "a photo", "mine.toml": "mine = 1\n", "mine.json": "{}"}
    input_ = "is an input of this command"
    foreign = "was not made by this program"
    yield Case("simulate over its spec", ("simulate", "spec.toml", "--kind=profile_scan", "--out=spec.toml"), input_)
    yield Case(
        "simulate over its spec by another way",
        ("simulate", "spec.toml", "--kind=profile_scan", "--out=../{here}/spec.toml"), input_,
    )  # fmt: skip
    for name in ("mine.csv", "mine.toml", "mine.json"):
        words = ("simulate", "spec.toml", "--kind=profile_scan", f"--out={name}")
        yield Case(f"simulate over {name}", words, foreign, files=mine)
    words = ("simulate", "spec.toml", "--kind=profile_scan", "--out=photo.csv")
    yield Case("simulate over a photo", words, foreign, files={"photo.png": "a photo"})
    for name, says in (("d.csv", input_), ("spec.toml", input_), ("held.csv", input_), ("mine.json", foreign),
                       (".", "a folder has that name")):  # fmt: skip
        words = ("diagnose", "spec.toml", "d.csv", "--held-out=held.csv", f"--json={name}")
        yield Case(f"diagnose --json={name}", words, says, files={"d.csv": SCAN, "held.csv": SCAN, **mine})
    for name in ("mine.toml", "mine.csv", "spec.toml"):
        yield Case(f"catalog over {name}", ("catalog", "rv40e", f"--out={name}"), foreign, files=mine)
    words = ("catalog", "rv40e", "--out=new.toml")
    yield Case("catalog over a schema", words, foreign, files={"cycloid-profile.schema.json": "{}"})
    for name in ("profile.csv", "manifest.json"):
        words = ("export", "spec.toml", "--format=csv", "--out=out")
        yield Case(f"export over {name}", words, foreign, spec=PLAIN, files={f"out/{name}": PRECIOUS})
    for command, name in (("build", "report.html"), ("tolerance", "report.html"), ("accuracy", "plots/accuracy.png")):
        words = (command, "spec.toml", "--out=out")
        yield Case(f"{command} over {name}", words, foreign, files={f"out/{name}": PRECIOUS})
        yield Case(f"{command} into a file", (command, "spec.toml", "--out=mine.csv"), "it is a file", files=mine)
    for command, name in (("diagnose", "report.html"), ("inspect", "inspection.html"), ("correct", "correction.html")):
        files = {"d.csv": SCAN, f"out/{name}": PRECIOUS}
        yield Case(f"{command} over {name}", (command, "spec.toml", "d.csv", "--out=out"), foreign, files=files)
    words = ("export", "spec.toml", "--format=csv", "--out=mine.csv")
    deeper = (*words[:-1], "--out=mine.csv/deeper")
    yield Case("export into a file", words, "it is a file", spec=PLAIN, files=mine)
    yield Case("export below a file", deeper, "cannot be written", spec=PLAIN, files=mine)
    for path in ("../{here}-victim.txt", "/nowhere/victim.txt", "out/../../victim.txt", "..", ""):
        entry = f'{{"path": "{path}", "format": "x", "bytes": 1, "sha256": "{"0" * 64}", "spec_sha256": "0"}}'
        text = f'{{"schema": 1, "name": "x", "files": [{entry}], "skipped": []}}'
        words = ("export", "spec.toml", "--format=csv", "--out=out")
        yield Case(f"manifest naming '{path}'", words, foreign, spec=PLAIN, files={"out/manifest.json": text})


def catalogue() -> Iterator[Case]:
    """Words of the catalogue."""
    for name in ("rv4oe", "", "../rv40e", "/etc/passwd", "rv40e.toml", "RV 40E" * 100):
        yield Case(f"catalog '{name[:20]}'", ("catalog", name), "'")
    yield Case("catalog --out alone", ("catalog", "--out=x.toml"), "needs a drive")
    yield Case("no such command", ("bild", "spec.toml"), "build")


CASES = tuple(
    case
    for table in (spec_numbers, spec_texts, places, options, large, overwriting, catalogue)
    for case in table()
)  # fmt: skip


def identifier(case: Case) -> str:
    """Name of a case for a report of tests."""
    return re.sub(r"[^\w.=-]+", "-", case.name)
