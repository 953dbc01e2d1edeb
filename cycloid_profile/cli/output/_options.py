"""Options that several commands share, and what they mean: files to read, folders to write, what is protected."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter, Token, convert

from cycloid_profile.cli.output._terminal import print_text, warn
from cycloid_profile.errors import ExportError, MeasurementError

if TYPE_CHECKING:
    from cycloid_profile.export.writing import Protection
    from cycloid_profile.measurement import Measurement
    from cycloid_profile.spec import Spec

SpecFile = Annotated[Path, Parameter(help="Spec file (TOML).")]
OutFolder = Annotated[Path | None, Parameter(help="Output folder, default exports/NAME of the spec file.")]
Json = Annotated[
    Path | None,
    Parameter(
        allow_leading_hyphen=True,
        metavar="[FILE]",
        help="Print the result as one JSON object in place of tables, or write it with --json=FILE.",
    ),
]
Quiet = Annotated[bool, Parameter(name=("--quiet", "-q"), help="Print no progress and no hints.")]
Force = Annotated[bool, Parameter(help="Replace inputs, and files that this program did not make.")]
AllowLarge = Annotated[bool, Parameter(help="Do what needs more memory, disk or time than the limits.")]

Pdf = Annotated[bool, Parameter(help="Write the report as PDF, too; needs the extra cycloid_profile[pdf].")]

Plugins = Annotated[
    tuple[str, ...],
    Parameter(help="Module or .py file with effects of your own; may be repeated."),
]

Columns = Annotated[
    tuple[str, ...],
    Parameter(
        help="Columns of a file of another program, such as x=X,y=Y,unit=mm; may be repeated, once for each header.",
    ),
]


def option_value(kind: Any, tokens: Sequence[Token]) -> Any:
    """The value that words of a command give an option of this kind.

    Raises ``ValueError`` for words that are no number of the kind: the library rounds 11.5 lobes to 12.
    """
    for token in tokens if kind in (int, float) else ():
        try:
            kind(token.value)
        except ValueError:
            wrong = "no whole number: write digits only" if kind is int else "no number: write a decimal point, no unit"
            raise ValueError(f"'{token.value}' is {wrong}") from None
    return convert(kind, tokens)


def read_files(
    files: Sequence[Path], columns: Sequence[str], spec: Spec, progress: Callable[[str], None]
) -> list[Measurement]:
    """The measured files; ``progress`` receives how those of other programs were understood."""
    from cycloid_profile.measurement import read_measurements

    measured = read_measurements(files, columns, spec.measurement.columns)
    for one in measured:
        for note in one.notes:
            progress(f"{one.name}: {note}")
    return measured


def keep_columns(files: Sequence[Path], columns: Sequence[str], quiet: bool) -> None:
    """Remember ``--columns`` next to the files after a command that succeeded, and say where unless ``quiet``."""
    from cycloid_profile.measurement import remember_columns

    kept = remember_columns(files, columns)
    if not quiet:
        warn(*(f"columns are kept in {file} for the next file" for file in kept))


def read_with_plugins(spec: Path, plugins: Sequence[str]) -> Spec:
    """The spec file, after the plug-ins whose effects it may name; raises ``PluginError`` and ``SpecError``."""
    from cycloid_profile.spec import read_spec

    if plugins:
        from cycloid_profile.effects import load_plugins

        load_plugins(plugins)
    return read_spec(spec)


def check_pdf(pdf: bool) -> None:
    """Raise ``ExportError`` where the library of ``--pdf`` is missing, before anything is computed."""
    if pdf:
        from cycloid_profile.report import require_pdf

        require_pdf()


def protection_of(force: bool, *inputs: Path | str, json: Path | None = None) -> Protection:
    """The inputs of a command and the files of others, which its outputs replace by ``force`` only.

    Raises ``ExportError`` where the file of ``--json`` is one of them, before anything is computed.
    """
    from cycloid_profile.export.writing import Protection

    protection = Protection(tuple(Path(one) for one in inputs), force)
    if json is not None and str(json) != "-":
        protection.check(json)
        if not force and json.is_file() and not json.read_bytes().lstrip().startswith(b"{"):
            remedy = "name another file, or write --json behind the files"
            raise ExportError("--json", f"'{json}'", "is a file of another kind", remedy, " ")
    return protection


def output_folder(
    out: Path | None, spec_file: Path, protection: Protection, *inner: str, writes: Sequence[str] = ()
) -> Path:
    """The folder given, or exports/NAME and ``inner`` folders with NAME of the spec file.

    Raises ``ExportError`` where that is no folder, or ``protection`` keeps one of the files ``writes`` in it, before
    anything is computed.
    """
    folder = Path("exports").joinpath(spec_file.stem, *inner) if out is None else out
    protection.check_folder(folder, writes)
    return folder


def write_spec_file(text: str, file: Path, protection: Protection) -> None:
    """Write a spec file with its JSON Schema next to it; raises ``ExportError`` where ``protection`` keeps one."""
    from cycloid_profile.export.writing import atomic_folder
    from cycloid_profile.spec import SCHEMA_FILE, spec_schema

    with atomic_folder(file.parent, protection, shared=True) as scratch:
        (scratch / file.name).write_text(text, encoding="utf-8", newline="\n")
        (scratch / SCHEMA_FILE).write_text(spec_schema(), encoding="utf-8", newline="\n")


def print_written_spec(file: Path) -> None:
    """Say where a spec file is and what to run next."""
    print_text(f"written: {file}", "", "Next:", f"  cycloid-profile build {file} --out exports/{file.stem}")


def require_files(files: Sequence[Path], what: str) -> None:
    """Raises ``MeasurementError`` where no file was given."""
    if not files:
        raise MeasurementError(what, "none", "were given", "name at least one CSV file after the spec", " ")
