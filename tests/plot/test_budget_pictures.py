"""Pictures of the published budgets: every factor and part is there, and nothing is cut off."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from cycloid_profile.articles import TEXT, BacklashSensitivity, Budget, DifferenceSetup, sensitivities
from cycloid_profile.catalog import catalog_drive, lost_motion_article
from cycloid_profile.design.from_spec import conventional_profile, drive_of, load_case
from cycloid_profile.plot.style import style
from cycloid_profile.plot.tolerance import budget as budget_figure
from cycloid_profile.plot.tolerance import sensitivities as sensitivity_figure


@pytest.fixture(scope="module")
def rows() -> tuple[BacklashSensitivity, ...]:
    """A drive without first stage and crank shafts."""
    spec = catalog_drive("printed_11")
    drive = drive_of(spec)
    case = load_case(spec, drive, conventional_profile(spec, drive))
    return sensitivities(case, DifferenceSetup(case, poses=3))


@pytest.fixture(scope="module")
def budget() -> Budget:
    return TEXT.of(lost_motion_article())


def texts_in(ax: Any) -> list[str]:
    return [text.get_text() for text in ax.texts]


def check_whole(ax: Any) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure = ax.figure
    with style():
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        box = figure.get_tightbbox(canvas.get_renderer())
    width, height = figure.get_size_inches()
    assert min(box.x0, box.y0) >= -0.02
    assert max(box.x1 - width, box.y1 - height) <= 0.02


def test_sensitivities_are_drawn_whole(rows):
    ax = sensitivity_figure(rows, name="$drive")
    check_whole(ax)
    assert sum("absent" in text for text in texts_in(ax)) == 4


def test_budget_is_drawn_whole(budget):
    ax = budget_figure(budget, name="$drive")
    check_whole(ax)
    assert texts_in(ax).count("0.784 ± 0.389") == 2
    assert "[′]" in ax.get_xlabel()


def test_parts_a_drive_lacks_are_marked(budget):
    texts = texts_in(budget_figure(replace(budget, involute=None, bearing=None), name="drive"))
    assert texts.count("drive: absent") == 2


def test_bars_are_the_rows(rows):
    ax = sensitivity_figure(rows, name="drive")
    published, corrected, measured = ax.containers
    for bars, values in (
        (published, [row.as_published for row in rows]),
        (corrected, [row.corrected for row in rows]),
        (measured, [None if row.geometry is None else row.geometry.mean for row in rows]),
    ):
        widths = [bar.get_width() for bar in bars]
        assert [width == 0.0 for width in widths] == [not value for value in values]
        assert [width > 0.0 for width in widths] == [value is not None and value > 0.0 for value in values]
