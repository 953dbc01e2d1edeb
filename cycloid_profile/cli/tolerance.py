"""``cycloid-profile tolerance``: yield of simulated reducers, and which tolerance to tighten."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from cycloid_profile.cli.output._options import (
    AllowLarge,
    Force,
    Json,
    OutFolder,
    Pdf,
    Plugins,
    Quiet,
    check_pdf,
    output_folder,
    protection_of,
    read_with_plugins,
)
from cycloid_profile.cli.output._terminal import print_places, print_tables, print_text, printed_as_json, progress

if TYPE_CHECKING:
    from cycloid_profile.design import ToleranceRecord


def tolerance(
    spec: Path,
    /,
    *,
    out: OutFolder = None,
    samples: Annotated[
        int | None, Parameter(help="Number of reducers for the backlash, default from the spec.")
    ] = None,
    loaded_samples: Annotated[
        int | None, Parameter(help="Number of reducers under load, default from the spec.")
    ] = None,
    seed: Annotated[int | None, Parameter(help="Seed of the random numbers.")] = None,
    sequence: Annotated[
        Literal["random", "latin-hypercube", "sobol"] | None, Parameter(help="Sampling sequence.")
    ] = None,
    allocate: Annotated[bool, Parameter(help="Find the cheapest tolerances that reach the required yield.")] = False,
    scheduler: Annotated[
        str | None, Parameter(help="Dask scheduler such as tcp://host:8786, default this machine.")
    ] = None,
    threads: Annotated[int | None, Parameter(help="Number of threads on this machine, default one per core.")] = None,
    json: Json = None,
    pdf: Pdf = False,
    force: Force = False,
    allow_large: AllowLarge = False,
    plugin: Plugins = (),
    quiet: Quiet = False,
) -> int:
    """Simulate reducers with random errors: distribution, yield, and which tolerance to tighten.

    Example: cycloid-profile tolerance examples/rv40e_tolerances.toml --samples 1000000 --out tolerance

    An interrupted run resumes when started again with the same spec and folder.

    Parameters
    ----------
    spec
        Spec file (TOML) with a [tolerance] table; without one, ordinary manufacturing tolerances apply.
    """
    from cycloid_profile.design import tolerance_record, with_tolerance_values
    from cycloid_profile.report import REPORT
    from cycloid_profile.report.tolerance import to_json, write_tolerance
    from cycloid_profile.tolerance.study import Cluster, Threads, Workers

    check_pdf(pdf)
    protection = protection_of(force, spec, *plugin, json=json)
    changed = {"samples": samples, "loaded_samples": loaded_samples, "seed": seed, "sequence": sequence}
    wanted = with_tolerance_values(read_with_plugins(spec, plugin), changed)
    folder = output_folder(out, spec, protection, "tolerance", writes=[REPORT])
    workers: Workers = Threads(threads) if scheduler is None else Cluster(scheduler)
    with progress(quiet, allow_large) as show_step:
        record = tolerance_record(wanted, folder / "samples", workers, allocate, show_step)
        report = write_tolerance(record, folder, show_step, protection, pdf)
    if not printed_as_json(to_json(record) | {"report": str(report)}, json, protection):
        _print_summary(record, wanted.name)
        print_places("", f"report: {report}")
    return 0


def _print_summary(record: ToleranceRecord, name: str) -> None:
    """Headline, tables and sentences of a record."""
    from cycloid_profile.report.tolerance import allocation_sentences, headline, summary_sentences, terminal_tables

    print_text(f"{name}: {headline(record)}", "")
    print_tables(terminal_tables(record))
    allocated = [] if record.allocation is None else allocation_sentences(record.allocation)[:1]
    for sentence in (*allocated, *summary_sentences(record)):
        print_text("", sentence)
