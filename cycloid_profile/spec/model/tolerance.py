"""Keys of `[tolerance]` and `[source]`: the tolerance study, its limits, and where the numbers come from."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from cycloid_profile.spec.model.checks._table import Table, key
from cycloid_profile.spec.model.modification import EffectTable


class PublishedValue(Table, frozen=True):
    """A published value of this drive, for comparison with the computed one."""

    quantity: Annotated[str, key("What was published.", "give a text")]
    value: Annotated[float, key("Its value.", "give a number")]
    unit: Annotated[str, key("Its unit.", "give a text")] = ""
    note: Annotated[str, key("How it was found.", "give a text")] = ""


class ReferenceSpec(Table, frozen=True):
    """Where the numbers come from, and which of them are assumed."""

    reference: Annotated[str, key("Publication or maker.", "give a text")] = ""
    assumed: Annotated[tuple[str, ...], key("Keys whose values are assumed.", "give a list of texts")] = ()
    published: tuple[PublishedValue, ...] = ()


_LIMIT: dict[str, Any] = {"gt": 0, "le": 1e6}


class LimitsSpec(Table, frozen=True):
    """Acceptance limits."""

    backlash_arcmin: (
        Annotated[float, key("Backlash, crank locked, largest over a turn [arc minutes].", "give a limit", **_LIMIT)]
        | None
    ) = None
    least_backlash_arcmin: (
        Annotated[
            float,
            key("Least backlash over a turn, 0 so that none binds [arc minutes].", "give a limit", ge=-1e6, le=1e6),
        ]
        | None
    ) = None
    lost_motion_arcmin: (
        Annotated[float, key("Lost motion at 3 % of rated torque [arc minutes].", "give a limit", **_LIMIT)] | None
    ) = None
    transmission_error_arcsec: (
        Annotated[
            float, key("Transmission error at rated torque, peak to peak [arc seconds].", "give a limit", **_LIMIT)
        ]
        | None
    ) = None
    peak_pressure_mpa: (
        Annotated[float, key("Contact pressure at rated torque [MPa].", "give a limit", **_LIMIT)] | None
    ) = None


class ToleranceSpec(Table, frozen=True):
    """Random errors of parts, and acceptance limits; see docs/tolerance.md."""

    samples: Annotated[
        int, key("Reducers whose backlash is computed.", "give 100 to 1000000000", ge=100, le=1_000_000_000)
    ] = 100_000
    loaded_samples: Annotated[
        int,
        key(
            "Reducers that are loaded: lost motion, transmission error, pressure.",
            "give 0 to 100000000",
            ge=0,
            le=100_000_000,
        ),
    ] = 2_000
    seed: Annotated[int, key("Start of the random numbers.", "give a whole number", ge=0, le=2**63 - 1)] = 1
    sequence: Annotated[Literal["random", "latin-hypercube", "sobol"], key("Sampling sequence of the errors.", "")] = (
        "random"
    )
    batch_size: Annotated[
        int, key("Reducers to a batch, for errors with a batch_share.", "give 1 to 1000000", ge=1, le=1_000_000)
    ] = 100
    yield_percent: Annotated[
        float, key("Yield that the cheapest tolerances must reach [%].", "give 50 to 99.99", ge=1, le=99.99)
    ] = 99.0
    sobol_width: Annotated[
        float,
        key("Widest 95 % interval of a total Sobol index.", "give 0.005 to 1", ge=0.005, le=1.0),
    ] = 0.1
    sobol_samples: Annotated[
        int,
        key(
            "Cap on Sobol samples, rounded down to a power of two.",
            "give 2 to 65536",
            ge=2,
            le=65536,
        ),
    ] = 512
    limits: LimitsSpec = LimitsSpec()
    effects: Annotated[
        tuple[EffectTable, ...],
        key("Effects whose sizes scatter, as tables `[[tolerance.effects]]`.", "give [[tolerance.effects]]"),
    ] = ()
    correlations: Annotated[
        tuple[dict[str, Any], ...],
        key("Correlated sizes, as tables `[[tolerance.correlations]]`.", "give [[tolerance.correlations]]"),
    ] = ()
