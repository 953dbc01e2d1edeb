"""Pictures of the published budgets: every factor and part is there, and nothing is cut off."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from cycloid_profile.catalog.drives import catalog_drive
from cycloid_profile.catalog.published import lost_motion_article
from cycloid_profile.design.from_spec import conventional_profile, drive_of, load_case
from cycloid_profile.plot.budget import budget_plot, sensitivity_plot
from cycloid_profile.plot.style import style
from cycloid_profile.tolerance.exact_sensitivities import Bench
from cycloid_profile.tolerance.published_budget import TEXT, Budget
from cycloid_profile.tolerance.published_sensitivities import Sensitivity, sensitivities


@pytest.fixture(scope="module")
def rows() -> tuple[Sensitivity, ...]:
    """A drive without first stage and crank shafts."""
    spec = catalog_drive("printed_11")
    drive = drive_of(spec)
    case = load_case(spec, drive, conventional_profile(spec, drive))
    return sensitivities(case, Bench(case, poses=3))


@pytest.fixture(scope="module")
def budget() -> Budget:
    return TEXT.of(lost_motion_article())


def said(figure: Any) -> list[str]:
    (ax,) = figure.axes
    return [text.get_text() for text in ax.texts]


def check_whole(figure: Any) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    with style():
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        box = figure.get_tightbbox(canvas.get_renderer())
    width, height = figure.get_size_inches()
    assert min(box.x0, box.y0) >= -0.02
    assert max(box.x1 - width, box.y1 - height) <= 0.02


def test_sensitivities_are_drawn_whole(rows):
    figure = sensitivity_plot(rows, "$drive")
    check_whole(figure)
    assert sum("absent" in text for text in said(figure)) == 4


def test_budget_is_drawn_whole(budget):
    figure = budget_plot(budget, "$drive")
    check_whole(figure)
    assert said(figure).count("0.784 ± 0.389") == 2
    assert "[′]" in figure.axes[0].get_xlabel()


def test_parts_a_drive_lacks_are_marked(budget):
    texts = said(budget_plot(replace(budget, involute=None, bearing=None), "drive"))
    assert texts.count("drive: absent") == 2


def test_bars_are_the_rows(rows):
    (ax,) = sensitivity_plot(rows, "drive").axes
    published, corrected, measured = ax.containers
    for bars, values in (
        (published, [row.as_published for row in rows]),
        (corrected, [row.corrected for row in rows]),
        (measured, [None if row.geometry is None else row.geometry.mean for row in rows]),
    ):
        widths = [bar.get_width() for bar in bars]
        assert [width == 0.0 for width in widths] == [not value for value in values]
        assert [width > 0.0 for width in widths] == [value is not None and value > 0.0 for value in values]
