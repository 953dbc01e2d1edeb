"""docs/theory.md: its table of the tooth of even load is that of the code.

``python tests/compensation/test_theory_page.py`` writes the table into the page.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cycloid_profile.catalog import catalog_drive
from cycloid_profile.compensation import compensate, even_load_profile
from cycloid_profile.contact.disc import Equilibrium
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.design.from_spec import conventional_profile, drive_of, load_case
from cycloid_profile.units import ARCMIN, ARCSEC, UM

PAGE = Path(__file__).parents[2] / "docs" / "theory.md"
BEGIN, END = "<!-- begin even load -->\n", "<!-- end even load -->"
NUMBER = re.compile(r"\d+(?:\.\d+)?")
SOLVERS = {"one disc": Equilibrium(), "stage": StageEquilibrium()}


def table() -> str:
    """Four teeth by two solvers on rigid and elastic discs, in Markdown."""
    lines = [
        "| disc, solver | tooth | loaded pins | force [N] | pressure [MPa] | twist [″] | rotation [″] |",
        "|---|---|---|---|---|---|---|",
    ]
    for body in ("rigid", "elastic"):
        spec = catalog_drive("rv40e").replace("load.disc_body", body)
        drive = drive_of(spec)
        case = load_case(spec, drive, conventional_profile(spec, drive))
        # The compensated tooth is that of the default solver of its body.
        compensated = compensate(case, SOLVERS["stage" if case.disc_bodies else "one disc"]).profile
        for name, solver in SOLVERS.items():
            teeth = {
                "theoretical": drive.theoretical_profile,
                "conventional": case.profile,
                "compensated": compensated,
                "even load, 0.25′": even_load_profile(case, 6.0 * UM, 0.25 * ARCMIN, solver).profile,
            }
            for tooth, profile in teeth.items():
                one = solver.solve(replace(case, profile=profile))
                twist, rotation = (float(np.mean(np.abs(each))) / ARCSEC for each in (one.twist, one.rotation))
                lines.append(
                    f"| {body}, {name} | {tooth} | {np.mean(np.sum(one.loaded, axis=-1)):.1f} | {one.max_force:.0f} "
                    f"| {one.max_pressure:.0f} | {twist:.2f} | {rotation:.2f} |"
                )
    return "\n".join(lines)


def test_table_of_the_even_load_is_that_of_the_code() -> None:
    printed, found = PAGE.read_text(encoding="utf-8").split(BEGIN)[1].split(END)[0].strip(), table()
    assert NUMBER.sub("#", printed) == NUMBER.sub("#", found)
    for shown, computed in zip(NUMBER.findall(printed), NUMBER.findall(found), strict=True):
        # One unit of the last digit, or 0.1 %: a search elsewhere may end at another rounding.
        digits = len(shown.partition(".")[2])
        assert float(shown) == pytest.approx(float(computed), rel=1e-3, abs=1.01 * 10.0**-digits)


if __name__ == "__main__":
    before, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
    PAGE.write_text(before + BEGIN + table() + "\n" + END + rest.split(END, 1)[1], encoding="utf-8")
