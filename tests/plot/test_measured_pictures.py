"""Pictures of measured files and of their residuals: one for every kind, axes with units."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from cycloid_profile import plot
from cycloid_profile._display import with_unit
from cycloid_profile.design import as_built_reducer
from cycloid_profile.effects import AsBuiltReducer
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
