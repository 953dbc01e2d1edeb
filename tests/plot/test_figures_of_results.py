"""Every figure is drawn from its result into new or given axes, and returned as axes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import cycloid_profile as cp
from cycloid_profile.design import DesignRecord
from cycloid_profile.errors import CycloidError
from cycloid_profile.plot.style import new_figure
from cycloid_profile.units import ARCMIN
from tests.spec_texts import PLAIN

DESIGN_FIGURES = {
    "profile_comparison": (2, 1), "disc": (1, 1), "deformation": (1, 1), "load_sharing": (2, 1), "load_map": (1, 2),
    "stage_load": (2, 2), "pressure_over_width": (1, 1), "convergence": (1, 2), "accuracy": (1, 2),
}  # fmt: skip


@pytest.mark.parametrize("name", DESIGN_FIGURES)
def test_axes_given_are_the_axes_returned(rv40e_record: DesignRecord, name: str) -> None:
    draw: Callable[..., Any] = getattr(cp.plot, name)
    panels = DESIGN_FIGURES[name]
    given = new_figure().subplots(*panels)
    drawn = draw(rv40e_record, given)
    assert np.asarray(drawn, dtype=object).ravel().tolist() == np.asarray(given, dtype=object).ravel().tolist()
    assert all(ax.has_data() for ax in np.asarray(drawn, dtype=object).flat)
    assert given is drawn or np.size(given) > 1
    figure = np.asarray(drawn, dtype=object).flat[0].figure
    assert figure.get_suptitle() == ""  # the heading of a figure belongs to its owner


def test_a_wrong_number_of_axes_is_refused(rv40e_record: DesignRecord) -> None:
    with pytest.raises(CycloidError, match="ax = 3 axes must be 2: give as many, or none"):
        cp.plot.accuracy(rv40e_record, new_figure().subplots(3))


def test_load_sharing_and_accuracy_are_drawn_by_themselves(rv40e_record: DesignRecord) -> None:
    top, bottom = cp.plot.load_sharing(rv40e_record.equilibrium)
    assert len(bottom.patches) == len(top.patches) == 19
    force = rv40e_record.equilibrium.force[0, 0]
    assert max(bar.get_height() for bar in bottom.patches) == pytest.approx(float(np.max(force)))
    twist, error = cp.plot.accuracy(rv40e_record.compensated_accuracy)
    assert twist.lines[0].get_label().startswith("nominal drive")
    assert "peak to peak" in error.lines[0].get_label()
    pins, pressure = cp.plot.load_map(rv40e_record.under_load)
    assert pins.get_xlim() == pressure.get_xlim() == (0.0, 360.0)


def test_every_result_has_its_figure(rv40e_record: DesignRecord) -> None:
    spec = cp.parse_spec(PLAIN)
    for result in (
        spec, rv40e_record, rv40e_record.profile, rv40e_record.equilibrium, rv40e_record.under_load,
        rv40e_record.compensated_accuracy,
    ):  # fmt: skip
        assert all(ax.has_data() for ax in cp.plot.figure_of(result).axes[:1]), type(result)
    assert cp.plot.figure_of(3.0) is None


def test_a_spec_is_shown_with_its_tooth_in_notebooks() -> None:
    page = cp.parse_spec(PLAIN)._repr_html_()
    assert "<td>plain</td>" in page
    assert "<svg" in page
    assert "one of 10 lobes" in page


def test_public_names_are_found() -> None:
    for name in cp.plot.__all__:
        assert callable(getattr(cp.plot, name)), name


def test_parts_of_the_rotation_add_up_in_their_bars(rv40e_record: DesignRecord) -> None:
    loaded = rv40e_record.under_load
    ax = cp.plot.rotation_by_part({"as ground": loaded, "again": loaded})
    ends = [max(bar.get_x() + bar.get_width() for bar in ax.patches if round(bar.get_y()) == row) for row in (0, 1)]
    mean = float(np.mean(loaded.rotation)) / ARCMIN
    np.testing.assert_allclose(ends, mean)
    assert len(cp.plot.rotation_by_part(loaded).containers) == len(loaded.rotation_by_part)
