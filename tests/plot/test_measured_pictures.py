"""Pictures of measured files and of their residuals: one for every kind, axes with units."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from cycloid_profile import plot
from cycloid_profile._display import with_unit
from cycloid_profile.design import as_built_reducer
from cycloid_profile.effects import AsBuiltReducer, apply_effects, effect_from_table
from cycloid_profile.measurement import KINDS
from cycloid_profile.plot.style import figure_holding, new_figure
from cycloid_profile.rig import (
    Settings,
    hysteresis_loop,
    lost_motion_map,
    measurement_residual,
    rigidity_map,
    simulate,
    transmission_error,
)
from cycloid_profile.spec import read_spec
from cycloid_profile.units import SIGNS

RV40E = Path(__file__).parents[2] / "examples" / "rv40e.toml"


@pytest.fixture(scope="module")
def reducer() -> AsBuiltReducer:
    return as_built_reducer(read_spec(RV40E))


def labels(figure: Figure) -> str:
    return " ".join(f"{ax.get_xlabel()} {ax.get_ylabel()} {ax.get_title()}" for ax in figure.axes)


@pytest.mark.parametrize("kind", KINDS.values(), ids=str)
def test_every_kind_has_a_picture_of_its_file_and_of_its_residual(reducer: AsBuiltReducer, kind) -> None:
    measured = simulate(reducer, kind, Settings(points=320, noise=0.1))
    of_file = figure_holding(plot.measurement(measured, reducer=reducer, name="plain"))
    assert of_file.get_suptitle() == f"plain: {kind.title}"
    residual = measurement_residual(reducer, measured)
    of_residual = figure_holding(plot.measurement_residual(residual, name="plain"))
    assert with_unit(f"{residual.rms:.3g}", SIGNS[kind.unit]) + " rms" in of_residual.get_suptitle()
    for figure in (of_file, of_residual):
        assert SIGNS[kind.unit] in labels(figure)
    without_reducer = plot.figure_of(measured)
    assert without_reducer.get_suptitle() == kind.title
    assert without_reducer.axes[0].has_data()


@pytest.mark.parametrize("kind", KINDS.values(), ids=str)
def test_a_comparison_shows_measured_over_predicted(reducer: AsBuiltReducer, kind) -> None:
    residual = measurement_residual(reducer, simulate(reducer, kind, Settings(points=320, noise=0.1)))
    figure = figure_holding(plot.comparison(residual, name="plain"))
    assert "rms" in figure.get_suptitle()
    assert SIGNS[kind.unit] in labels(figure)
    if residual.predicted is not None:
        drawn = [np.asarray(line.get_xydata()).T for line in figure.axes[0].lines]
        for column in (residual.measurement.value, residual.predicted):
            assert any(np.array_equal(column, values) for curve in drawn for values in curve)


def test_order_1_is_clear_of_the_axis(reducer: AsBuiltReducer) -> None:
    residual = measurement_residual(reducer, simulate(reducer, "transmission_error", Settings(points=320, noise=0.1)))
    orders = figure_holding(plot.comparison(residual)).axes[2]
    assert (orders.get_xscale(), orders.get_yscale()) == ("log", "log")
    assert orders.get_xlim()[0] < 0.95


def test_colours_of_a_scan_are_symmetric_and_from_the_data(reducer: AsBuiltReducer) -> None:
    for size in (2.0, 20.0):
        effect = effect_from_table({"name": "disc_oval", "amplitude_um": size})
        scan = simulate(apply_effects(reducer.case, [effect]), "profile_scan", Settings(points=1600))
        figure = figure_holding(plot.comparison(measurement_residual(reducer, scan)))
        (low, high) = next(image.get_clim() for ax in figure.axes for image in ax.images)
        assert low == -high
        assert size <= high <= 1.5 * size


def test_simulated_curves_are_drawn_into_given_axes(reducer: AsBuiltReducer) -> None:
    rated = reducer.case.torque
    error = transmission_error(reducer, rated, 320)
    for draw, result, panels, texts in (
        (plot.transmission_error, error, 2, ("transmission error [″]", "at 412 N·m")),
        (plot.hysteresis_loop, hysteresis_loop(reducer, points=40), 2, ("torque [N·m]", "about zero torque")),
        (plot.angle_map, lost_motion_map(reducer, poses=24), 1, ("angle [′]", "±12.36 N·m")),
        (plot.angle_map, rigidity_map(reducer, poses=24), 1, ("torsional rigidity [N·m/′]", "N·m/′ peak to peak")),
    ):
        given = new_figure().subplots(panels)
        drawn = draw(result, given)
        assert np.array_equal(np.ravel(drawn), np.ravel(given))
        assert all(text in labels(figure_holding(given)) for text in texts)
        assert plot.figure_of(result).axes[0].has_data()
