"""Every picture is labelled: titles, labelled axes with units, nothing outside the frame."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from cycloid_profile.catalog import catalog_drive
from cycloid_profile.design import DesignRecord, design_disc
from cycloid_profile.plot import save, save_png
from cycloid_profile.plot.design.teeth import normal_removal
from cycloid_profile.plot.gallery import PICTURES, Picture
from cycloid_profile.plot.measured import draw_lobe_image
from cycloid_profile.plot.style import figure_holding, new_figure
from cycloid_profile.spec import parse_spec
from tests.spec_texts import PLAIN


@pytest.fixture(scope="module")
def plain() -> DesignRecord:
    """One disc, central eccentric, no compensation, no torque given."""
    return design_disc(parse_spec(PLAIN))


@pytest.mark.parametrize("picture", PICTURES, ids=[picture.name for picture in PICTURES])
def test_axes_are_labelled_with_units(rv40e_record: DesignRecord, plain: DesignRecord, picture: Picture) -> None:
    for record in (rv40e_record, plain):
        figure = figure_holding(picture.draw(record))
        assert record.spec.name in " ".join([figure.get_suptitle(), *(ax.get_title() for ax in figure.axes)])
        for ax in figure.axes:
            if not ax.has_data() or (ax.get_label() == "<colorbar>"):
                continue
            for label in (ax.get_xlabel(), ax.get_ylabel()):
                dimensionless = ("iteration", "round", "relative error")
                shared = label == "" and len(figure.axes) == 2  # the upper of two panels on one x axis
                assert shared or "[" in label or label.startswith(dimensionless), (picture.name, label)


@pytest.mark.parametrize("picture", PICTURES, ids=[picture.name for picture in PICTURES])
def test_nothing_is_cut_off(rv40e_record: DesignRecord, picture: Picture) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure = figure_holding(picture.draw(rv40e_record))
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    box = figure.get_tightbbox(canvas.get_renderer())
    width, height = figure.get_size_inches()
    assert box.x0 >= -0.02
    assert box.y0 >= -0.02
    assert box.x1 <= width + 0.02
    assert box.y1 <= height + 0.02


def test_the_same_record_gives_the_same_bytes(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    pictures = []
    for turn in ("a", "b"):
        (tmp_path / turn).mkdir()
        files = save(PICTURES[1].draw(rv40e_record), tmp_path / turn, "picture")
        pictures.append([file.read_bytes() for file in files])
    assert pictures[0] == pictures[1]


def test_the_rare_ends_of_a_colour_map_keep_their_colours(tmp_path: Path) -> None:
    """One cell in a thousand far below zero was drawn in the dark brown that is far above: the palette had no blue."""
    from io import BytesIO

    from PIL import Image

    figure = new_figure(11.0, 10.0)
    values = 0.2 * np.random.default_rng(1).normal(size=(39, 24))
    values[8, ::7], values[30, 3] = -2.4, 2.4
    ax = figure.subplots()
    figure.colorbar(draw_lobe_image(ax, values, 2.5, 180.0), ax=ax)
    save_png(figure, tmp_path / "map.png")
    drawn = np.asarray(Image.open(BytesIO((tmp_path / "map.png").read_bytes())).convert("RGB"), dtype=int)
    whole = BytesIO()
    figure.savefig(whole, format="png", dpi=drawn.shape[1] / figure.get_figwidth())
    true = np.asarray(Image.open(whole).convert("RGB"), dtype=int)
    assert np.max(np.abs(drawn - true)) <= 24


def test_comparison_shows_the_removal_of_each_step(rv40e_record: DesignRecord) -> None:
    psi = np.linspace(-math.pi, math.pi, 181)
    conventional = normal_removal(rv40e_record, rv40e_record.conventional, psi)
    assert np.allclose(conventional, 0.006, atol=1e-12)
    compensated = normal_removal(rv40e_record, rv40e_record.profile, psi)
    assert rv40e_record.compensation is not None
    # Material is added on both flanks, δmax of it at ψ0, none at root and tip.
    assert np.min(compensated) == pytest.approx(0.006 - rv40e_record.compensation.delta_max, abs=2e-6)
    assert compensated[[0, 90, -1]] == pytest.approx(0.006, abs=1e-9)
    assert np.allclose(compensated, compensated[::-1], atol=1e-9)


def test_a_rated_torque_that_is_not_given_is_marked_as_assumed(plain: DesignRecord) -> None:
    from cycloid_profile.design import summary

    figures = summary(plain)
    assert figures["rated_torque_assumed"] is True
    assert figures["rated_torque_nm"] > 0.0
    assert figures["compensated"] == figures["conventional"]
    assert figures["compensation"]["applied"] is False


def test_printed_drive_of_the_catalogue_is_sound() -> None:
    assert design_disc(catalog_drive("printed_11")).failures == ()
