"""Pictures of a diagnosis: how far the gap shrank, and for each file what was measured, predicted and is left."""

from __future__ import annotations

import re
from pathlib import PurePath
from typing import TYPE_CHECKING

from cycloid_profile.discrepancy.outcome import Diagnosis
from cycloid_profile.plot.diagnosis_loop import loop_gap
from cycloid_profile.plot.diagnosis_scan import scan_gap
from cycloid_profile.plot.diagnosis_summary import summary
from cycloid_profile.plot.diagnosis_turn import turn_gap
from cycloid_profile.plot.style import plain, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Picture = tuple[str, str, "Figure"]


def pictures(diagnosis: Diagnosis, name: str) -> list[Picture]:
    """File stem, caption and figure of every picture: the summary, then one for each file."""
    drawn = [summary(diagnosis, name)]
    stems: set[str] = set()
    for gap in diagnosis.gaps:
        stem = _stem(gap.recording.name, stems)
        draw = {"profile_scan": scan_gap, "hysteresis": loop_gap}.get(gap.recording.kind, turn_gap)
        with style():
            figure, caption = draw(diagnosis, gap)
            figure.suptitle(f"{plain(name)}, {plain(gap.recording.name)}: {gap.recording.kind.replace('_', ' ')}")
        drawn.append((stem, f"{gap.recording.name}: {caption}", figure))
    return drawn


def _stem(name: str, taken: set[str]) -> str:
    base = "gap_" + (re.sub(r"[^A-Za-z0-9]+", "_", PurePath(name).stem).strip("_").lower() or "file")
    stem = next(s for s in (base, *(f"{base}_{n}" for n in range(2, 1000))) if s not in taken)
    taken.add(stem)
    return stem
