"""``cycloid-profile tolerance``: yield of simulated reducers, and which tolerance to tighten."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from cycloid_profile.cli._terminal import (
    Json,
    OutFolder,
    Plugins,
    output_folder,
    print_json,
    print_tables,
    progress,
    read_with_plugins,
)


def tolerance(
    spec: Path,
    /,
    *,
    out: OutFolder = None,
    samples: Annotated[
        int | None, Parameter(help="Number of reducers for the backlash, default from the spec.", show_default=False)
    ] = None,
    loaded_samples: Annotated[
        int | None, Parameter(help="Number of reducers under load, default from the spec.", show_default=False)
    ] = None,
    seed: Annotated[int | None, Parameter(help="Seed of the random numbers.", show_default=False)] = None,
    sequence: Annotated[
        Literal["random", "latin-hypercube", "sobol"] | None, Parameter(help="Sampling sequence.", show_default=False)
    ] = None,
    allocate: Annotated[
        bool, Parameter(negative=(), help="Find the cheapest tolerances that reach the required yield.")
    ] = False,
    scheduler: Annotated[
        str | None, Parameter(help="Dask scheduler such as tcp://host:8786, default this machine.", show_default=False)
    ] = None,
    threads: Annotated[
        int | None, Parameter(help="Number of threads on this machine, default one per core.", show_default=False)
    ] = None,
    json: Json = False,
    plugin: Plugins = (),
) -> int:
    """Simulate reducers with random errors: distribution, yield, and which tolerance to tighten.

    Example: cycloid-profile tolerance examples/rv40e_tolerances.toml --samples 1000000

    An interrupted run resumes when started again with the same spec and folder.

    Parameters
    ----------
    spec
        Spec file (TOML) with a [tolerance] table; without one, ordinary manufacturing tolerances apply.
    """
    from cycloid_profile.design import tolerance_record, with_tolerance_values
    from cycloid_profile.report.tolerance import (
        allocation_sentences,
        headline,
        summary_sentences,
        terminal_tables,
        to_json,
        write_tolerance,
    )
    from cycloid_profile.tolerance.study import Cluster, Threads, Workers

    changed = {"samples": samples, "loaded_samples": loaded_samples, "seed": seed, "sequence": sequence}
    wanted = with_tolerance_values(read_with_plugins(spec, plugin), changed)
    folder = output_folder(out, spec, "tolerance")
    workers: Workers = Threads(threads) if scheduler is None else Cluster(scheduler)
    with progress() as show_step:
        record = tolerance_record(wanted, folder / "samples", workers, allocate, show_step)
        report = write_tolerance(record, folder, show_step)
    if json:
        print_json(to_json(record) | {"report": str(report)})
        return 0
    print(f"{wanted.name}: {headline(record)}\n")
    print_tables(terminal_tables(record))
    allocated = [] if record.allocation is None else allocation_sentences(record.allocation)[:1]
    for sentence in (*allocated, *summary_sentences(record)):
        print(f"\n{sentence}")
    print(f"\nreport: {report}")
    return 0
