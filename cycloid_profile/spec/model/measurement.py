"""How measured files of other programs are read."""

from __future__ import annotations

from typing import Annotated

from cycloid_profile.spec.model.checks._table import Table, key


class MeasurementSpec(Table, frozen=True):
    """Columns of measured files of other programs, see docs/foreign-files.md."""

    columns: Annotated[
        tuple[str, ...],
        key(
            "Which column holds what, as `--columns` takes it, such as `x=X,y=Y,unit=mm`; the first that fits a header "
            "is used.",
            'give a list such as ["x=X,y=Y,unit=mm"]',
        ),
    ] = ()
