"""Text of a measured file: lines of ``# key: value``, one header row, numbers."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np


def text(kind: str, keys: Mapping[str, object], columns: Mapping[str, np.ndarray]) -> str:
    """The file, seven digits after the point."""
    head = [
        f"# {key}: {value}" for key, value in {"format": "cycloid-profile measurement 1", "kind": kind, **keys}.items()
    ]
    rows = np.column_stack(list(columns.values()))
    body = "\n".join(",".join(f"{value:.7f}" for value in row) for row in rows.tolist())
    return "\n".join([*head, ",".join(columns), body]) + "\n"
