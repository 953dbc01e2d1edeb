"""Sizes that go together, read from ``[[tolerance.correlations]]`` of a spec file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cycloid_profile.errors import SpecError
from cycloid_profile.tolerance.scatter import Correlation, Scatter
from cycloid_profile.tolerance.table_values import nearest, number, refuse_unknown

_KEYS = ("between", "value")


def correlations_of(tables: Sequence[Mapping[str, Any]], scatters: Sequence[Scatter]) -> tuple[Correlation, ...]:
    """Correlations between ``scatters``.

    Raises
    ------
    SpecError
        If a key or name is unknown, a pair does not fit together or is given twice, or all of them contradict.
    """
    names = [one.parameter if one.label == one.kind.name else one.label for one in scatters]
    found = []
    matrix = np.eye(len(scatters))
    for i, table in enumerate(tables, start=1):
        where = f"tolerance.correlations[{i}]"
        refuse_unknown(table, _KEYS, where, "a correlation")
        between = table.get("between", ())
        if not isinstance(between, list | tuple) or len(between) != 2:
            raise SpecError(f"{where}.between", repr(between), "is not two names", f"choose from {', '.join(names)}")
        for name in between:
            if name not in names:
                raise SpecError(f"{where}.between", repr(name), "is none of the tolerances", nearest(str(name), names))
        a, b = (names.index(name) for name in between)
        if a == b or len(scatters[a].choices) != len(scatters[b].choices):
            raise SpecError(
                f"{where}.between",
                f"'{between[0]}' and '{between[1]}'",
                "are not two tolerances of as many parts each",
                "give both the same 'each'",
                " ",
            )
        if "value" not in table:
            raise SpecError(f"{where}.value", "", "is not given", "give a number from -1 to 1", "")
        if matrix[a, b] != 0.0:
            raise SpecError(f"{where}.between", f"'{between[0]}' and '{between[1]}'", "is given twice",
                            "give it once", " ")  # fmt: skip
        value = number(table, "value", 0.0, where, -1.0, 1.0)
        matrix[a, b] = matrix[b, a] = value
        found.append(Correlation(a, b, value))
    least = float(np.min(np.linalg.eigvalsh(matrix))) if len(scatters) else 1.0
    if least <= 1e-12:
        raise SpecError(
            "tolerance.correlations",
            f"with a least eigenvalue of {least:.3g}",
            "are not positive definite",
            "make them smaller: what hangs on one thing must hang together",
            " ",
        )
    return tuple(found)
