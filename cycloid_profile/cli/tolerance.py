"""``cycloid-profile tolerance``: how many reducers pass, and which tolerance to tighten."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from cycloid_profile.cli.options import Json, OutFolder
from cycloid_profile.cli.terminal import output_folder, print_json, print_table, progress

if TYPE_CHECKING:
    from cycloid_profile.design.tolerance_record import ToleranceRecord


def tolerance(
    spec: Path,
    /,
    *,
    out: OutFolder = None,
    samples: Annotated[
        int | None, Parameter(help="Reducers whose backlash is computed, default as in the spec.", show_default=False)
    ] = None,
    loaded_samples: Annotated[
        int | None, Parameter(help="Reducers that are loaded, default as in the spec.", show_default=False)
    ] = None,
    seed: Annotated[int | None, Parameter(help="Start of the random numbers.", show_default=False)] = None,
    sequence: Annotated[
        Literal["random", "latin-hypercube", "sobol"] | None,
        Parameter(help="How the samples fill the space of all errors.", show_default=False),
    ] = None,
    allocate: Annotated[
        bool, Parameter(negative=(), help="Find the cheapest tolerances that reach the yield asked for.")
    ] = False,
    scheduler: Annotated[
        str | None, Parameter(help="Dask scheduler, such as tcp://host:8786; default this machine.", show_default=False)
    ] = None,
    threads: Annotated[
        int | None, Parameter(help="Threads of this machine, default one a core.", show_default=False)
    ] = None,
    json: Json = False,
) -> int:
    """Draw reducers with their tolerances: distribution, yield, and which tolerance to tighten.

    Example: cycloid-profile tolerance examples/rv40e_tolerances.toml --samples 1000000

    A run that was stopped goes on where it was, if started again with the same spec and folder.

    Parameters
    ----------
    spec
        Spec file (TOML) with a [tolerance] table; without one, what a good workshop holds is taken.
    """
    from cycloid_profile.design.tolerance_record import tolerance_record
    from cycloid_profile.design.tolerancing import with_tolerance_values
    from cycloid_profile.report.tolerance_package import write_tolerance
    from cycloid_profile.report.tolerance_told import told
    from cycloid_profile.spec.read import read_spec
    from cycloid_profile.tolerance.workers import Cluster, Threads, Workers

    changed = {"samples": samples, "loaded_samples": loaded_samples, "seed": seed, "sequence": sequence}
    wanted = with_tolerance_values(read_spec(spec), changed)
    folder = output_folder(out, spec) / "tolerance" if out is None else out
    workers: Workers = Threads(threads) if scheduler is None else Cluster(scheduler)
    with progress() as tell:
        record = tolerance_record(wanted, folder / "samples", workers, allocate, tell)
        written = write_tolerance(record, folder, tell)
    values = told(record) | {"report": str(written)}
    if json:
        print_json(values)
        return 0
    _print(record.spec.name, record)
    print(f"\nreport: {written}")
    return 0


def _print(name: str, record: ToleranceRecord) -> None:
    from cycloid_profile.report.tolerance_advice import HALVED, allocation_section, ranking_head, ranking_rows
    from cycloid_profile.report.tolerance_package import QUANTITY_HEAD, YIELD_HEAD, headline, summary_sentences
    from cycloid_profile.report.tolerance_told import quantity_rows, yield_rows

    print(f"{name}: {headline(record)}\n")
    print_table("distribution, in brackets 95 % intervals", QUANTITY_HEAD, quantity_rows(record))
    rows = yield_rows(record)
    if rows:
        print()
        print_table("yield", YIELD_HEAD, rows)
    print()
    print_table(HALVED, ranking_head(record.advice.last),
                ranking_rows(record.advice.last))  # fmt: skip
    if record.allocation is not None:
        (table,) = allocation_section(record.allocation, name).tables
        print()
        print_table("cheapest tolerances", table.head, table.rows)
        print(f"\n{allocation_section(record.allocation, name).texts[0]}")
    for sentence in summary_sentences(record):
        print(f"\n{sentence}")
