"""Every picture is labelled: titles, labelled axes with units, nothing outside the frame."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from cycloid_profile.catalog import catalog_drive
from cycloid_profile.design import DesignRecord, design_disc
from cycloid_profile.plot import save, save_png
from cycloid_profile.plot.design.teeth import normal_removal
from cycloid_profile.plot.gallery import PICTURES, Picture
from cycloid_profile.plot.measured import draw_lobe_image, draw_residual, no_points_marks, noise_mark
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
    figure.colorbar(draw_lobe_image(ax, values, 2.5), ax=ax)
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


@pytest.mark.slow
def test_the_bytes_depend_on_neither_clock_nor_hash_seed(tmp_path: Path) -> None:
    """Clip paths, hatches and gradients have identifiers, and metadata a date: both are fixed."""
    script = (
        "import sys, numpy as np\n"
        "from pathlib import Path\n"
        "from cycloid_profile.plot import save\n"
        "from cycloid_profile.plot.measured import draw_lobe_image, draw_residual\n"
        "from cycloid_profile.plot.style import canvas\n"
        "with canvas(None, (6.0, 3.0), 1, 2) as drawn:\n"
        "    x = np.linspace(0.0, 1.0, 50)\n"
        "    draw_residual(drawn.axes[0], x, np.sin(9.0 * x), 0.1, 'µm')\n"
        "    drawn.axes[0].bar([0.5], [0.5], hatch='///', label='bar')\n"
        "    draw_lobe_image(drawn.axes[1], np.outer(x, x), 1.0)\n"
        "    drawn.legend(1)\n"
        "save(drawn.figure, Path(sys.argv[1]), 'picture')\n"
    )
    written = []
    for number, epoch in ((1, None), (2, "86400")):
        folder = tmp_path / str(number)
        folder.mkdir()
        known = {key: value for key, value in os.environ.items() if key != "SOURCE_DATE_EPOCH"}
        seeds = {"PYTHONHASHSEED": str(number)} | ({"SOURCE_DATE_EPOCH": epoch} if epoch else {})
        subprocess.run([sys.executable, "-c", script, str(folder)], check=True, env=known | seeds)
        written.append([(folder / f"picture.{kind}").read_bytes() for kind in ("png", "svg")])
    assert written[0] == written[1]
    assert b"<dc:date>" not in written[0][1]


def test_missing_cells_and_noise_are_in_the_legend() -> None:
    full = np.zeros((2, 12))
    assert no_points_marks(full) == []
    full[1, 3] = np.nan
    assert [mark.get_label() for mark in no_points_marks(full)] == ["no points"]
    ax = new_figure().subplots()
    draw_residual(ax, np.arange(4.0), np.array([0.0, 1.0, -4.0, 0.5]), 0.5, "µm")
    low, high = ax.get_ylim()
    assert low == -high  # zero is in the middle
    (band,) = ax.patches
    assert (band.get_y(), band.get_y() + band.get_height()) == (-1.0, 1.0)
    assert noise_mark().get_facecolor() == band.get_facecolor()
